//! Whether localisation in a new version of a map is worse than in the old one.

use crate::texts;
use serde::Serialize;

/// Parameters of [`find_regression`]: the greatest permitted losses of a new version.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegressionConfig {
    /// Loss of localised scans, as a share of all scans. Chosen: half a per cent, a few scans of a walk.
    pub localised_share: f64,
    /// Loss of fit, 0 to 1. Chosen as a round number near zero: a patch must not make a map worse, and with 0, noise would
    /// reject it.
    pub fit: f64,
    /// Increase of contradiction, 0 to 1. Chosen: as the loss of fit.
    pub contradicted: f64,
}

impl Default for RegressionConfig {
    fn default() -> Self {
        Self { localised_share: 0.005, fit: 0.002, contradicted: 0.002 }
    }
}

/// Quality of localisation in a map.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Fitness {
    pub scans: u64,
    /// Number of localised scans.
    pub localised: u64,
    /// Number of those with low confidence.
    #[serde(rename = "doubted")]
    pub low_confidence: u64,
    /// Number of times that tracking was lost.
    pub lost: u64,
    /// Fit of the scans' points with the map's surfaces, 0 to 1; mean over scans 1 m apart.
    pub fit: f64,
    /// Share of the points that lie in free space of the map's keyframes; mean over the same scans.
    pub contradicted: f64,
}

/// The reason why localisation is worse in the new version, if it is.
pub fn find_regression(before: &Fitness, after: &Fitness, config: &RegressionConfig) -> Option<String> {
    let confident =
        |fitness: &Fitness| (fitness.localised - fitness.low_confidence) as f64 / fitness.scans.max(1) as f64;
    if after.lost > before.lost {
        return Some(texts::loses_more(after.lost, before.lost));
    }
    if confident(after) < confident(before) - config.localised_share {
        let [after, before] = [after, before].map(|fitness| 100.0 * confident(fitness));
        return Some(texts::localises_less(after, before));
    }
    if after.fit < before.fit - config.fit {
        return Some(texts::fits_less(after.fit, before.fit));
    }
    (after.contradicted > before.contradicted + config.contradicted)
        .then(|| texts::contradicts_more(after.contradicted, before.contradicted))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_regression_is_found_and_described() {
        let before = Fitness {
            scans: 1_000,
            localised: 980,
            low_confidence: 10,
            lost: 1,
            fit: 0.85,
            contradicted: 0.01,
        };
        let reason = |after: Fitness| {
            find_regression(&before, &after, &RegressionConfig::default()).unwrap_or_default()
        };
        assert_eq!(reason(before), "");
        assert_eq!(reason(Fitness { lost: 0, fit: 0.9, contradicted: 0.0, ..before }), "");
        assert!(reason(Fitness { lost: 2, ..before }).contains("loses its place 2 time(s)"));
        assert!(reason(Fitness { localised: 970, ..before }).contains("96.0 % of the scans, 97.0 %"));
        assert!(reason(Fitness { low_confidence: 20, ..before }).contains("96.0 %"));
        assert!(reason(Fitness { fit: 0.84, ..before }).contains("fit it by 0.840, 0.850"));
        assert!(reason(Fitness { contradicted: 0.02, ..before }).contains("contradict it by 0.020"));
    }
}
