//! Compares two versions of a map by the localisation of robots in them.

use super::distance_trigger::DistanceTrigger;
use crate::failure::Failure;
use crate::inputs::{self, InputArgs, InputReader};
use crate::keyframe_descriptors::read_keyframe_descriptors;
use crate::localise::offline_localiser::OfflineLocaliser;
use crate::texts;
use geometry::isometry_from_pose;
use localisation::{AdaptiveVoxelFilter, GlobalLocaliser, LocalisationMap};
use messages::CorrectedScan;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Parameters of [`find_regression`]: the greatest permitted losses of a new version.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegressionConfig {
    /// Loss of localised scans, as a share of all scans. Chosen: half a per cent, a few scans of a walk.
    pub localised_share: f64,
    /// Loss of fit, and also increase of contradiction, both from 0 to 1. Chosen as a round number near zero: a patch must not make a map worse, and with 0, noise would
    /// reject it.
    pub fit: f64,
}

impl Default for RegressionConfig {
    fn default() -> Self {
        Self { localised_share: 0.005, fit: 0.002 }
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

/// Localises the robot of each recording in a map.
///
/// # Errors
/// When the map or a recording cannot be read.
pub fn measure_fitness(map: &Path, inputs: &InputArgs, recordings: &[PathBuf]) -> Result<Fitness, Failure> {
    let localisation_map = LocalisationMap::new(read_keyframe_descriptors(map, |_| true)?);
    let localiser = GlobalLocaliser::new(Arc::new(localisation_map));
    let known = Arc::new(runtime::known_map(map).map_err(Failure::usage)?);
    let (mut fitness, mut compared) = (Fitness::default(), 0.0);
    for path in recordings {
        let opened = inputs.open_these(std::slice::from_ref(path))?;
        let (boot, duration) = (inputs.boot(&opened)?, inputs::duration(&opened));
        let (mut distance_trigger, mut voxel_filter) =
            (DistanceTrigger::default(), AdaptiveVoxelFilter::default());
        let mut on_scan = |scan: &CorrectedScan| {
            let Some(pose) = isometry_from_pose(&scan.map_from_base) else { return };
            let points = voxel_filter.filter(&scan.cloud.xyz);
            if distance_trigger.is_due(&pose) {
                let found = localiser.refine_pose(&points, &pose);
                fitness.fit += found.fit;
                fitness.contradicted += found.violation_share;
                compared += 1.0;
            }
        };
        let offline_localiser = OfflineLocaliser::new(Arc::clone(&known), None, &mut on_scan);
        let run = offline_localiser.run(boot, InputReader::start(opened)?, duration);
        fitness.scans += run.scans;
        fitness.localised += run.trajectory.len() as u64;
        fitness.low_confidence += run.low_confidence;
        fitness.lost += run.lost;
    }
    fitness.fit /= f64::max(compared, 1.0);
    fitness.contradicted /= f64::max(compared, 1.0);
    Ok(fitness)
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
    (after.contradicted > before.contradicted + config.fit)
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
