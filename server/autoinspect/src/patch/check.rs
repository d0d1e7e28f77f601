//! Whether a robot is localised by one version of a map as well as by another.

use super::DistanceTrigger;
use crate::failure::Failure;
use crate::inputs::{self, InputArgs, Reader};
use crate::keyframe_descriptors::read_keyframe_descriptors;
use crate::localise::offline_localiser::OfflineLocaliser;
use geometry::isometry_from_pose;
use localisation::{AdaptiveVoxelFilter, GlobalLocaliser, LocalisationMap};
use messages::CorrectedScan;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What a version may be worse by: share of scans, and of what they see.
const LOCALISED: f64 = 0.005;
const FITTING: f64 = 0.002;

/// How well robots are localised in a map.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Fitness {
    pub scans: u64,
    /// Scans whose place is known.
    pub localised: u64,
    /// Of those, scans at which something spoke against it.
    pub doubted: u64,
    /// How often the place was lost.
    pub lost: u64,
    /// How well what was seen fits the map's surfaces, 0 to 1, and share of what stands where its keyframes saw through, in the mean
    /// over scans a metre apart.
    pub fit: f64,
    pub contradicted: f64,
}

/// Localises the robot of each recording in a map.
pub fn fitness(map: &Path, inputs: &InputArgs, recordings: &[PathBuf]) -> Result<Fitness, Failure> {
    let localisation_map = LocalisationMap::new(read_keyframe_descriptors(map, |_| true)?);
    let localiser = GlobalLocaliser::new(Arc::new(localisation_map));
    let known = Arc::new(runtime::known_map(map).map_err(Failure::usage)?);
    let (mut fitness, mut compared) = (Fitness::default(), 0.0);
    for path in recordings {
        let opened = inputs.open_these(std::slice::from_ref(path))?;
        let (boot, duration) = (inputs.boot(&opened)?, inputs::duration(&opened));
        let (mut look_trigger, mut filter) = (DistanceTrigger::default(), AdaptiveVoxelFilter::default());
        let mut witness = |scan: &CorrectedScan| {
            let Some(pose) = isometry_from_pose(&scan.map_from_base) else { return };
            let points = filter.filter(&scan.cloud.xyz);
            if look_trigger.is_due(&pose) {
                let found = localiser.refine_pose(&points, &pose);
                fitness.fit += found.fit;
                fitness.contradicted += found.violation_share;
                compared += 1.0;
            }
        };
        let walk = OfflineLocaliser::new(Arc::clone(&known), None, &mut witness);
        let walked = walk.run(boot, Reader::start(opened)?, duration);
        fitness.scans += walked.scans;
        fitness.localised += walked.trajectory.len() as u64;
        fitness.doubted += walked.doubted;
        fitness.lost += walked.lost;
    }
    fitness.fit /= f64::max(compared, 1.0);
    fitness.contradicted /= f64::max(compared, 1.0);
    Ok(fitness)
}

/// Why a robot is better off with the version before, if it is.
pub fn worse(before: &Fitness, after: &Fitness) -> Option<String> {
    let sure = |fitness: &Fitness| (fitness.localised - fitness.doubted) as f64 / fitness.scans.max(1) as f64;
    if after.lost > before.lost {
        return Some(format!(
            "in it the robot loses its place {} time(s), {} before",
            after.lost, before.lost
        ));
    }
    if sure(after) < sure(before) - LOCALISED {
        let [after, before] = [after, before].map(|fitness| 100.0 * sure(fitness));
        return Some(format!(
            "in it the place is known after {after:.1} % of the scans, {before:.1} % before"
        ));
    }
    if after.fit < before.fit - FITTING {
        let (after, before) = (after.fit, before.fit);
        return Some(format!("what is seen fits it by {after:.3}, {before:.3} before"));
    }
    (after.contradicted > before.contradicted + FITTING).then(|| {
        let (after, before) = (after.contradicted, before.contradicted);
        format!("what is seen contradicts it by {after:.3}, {before:.3} before")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_version_by_which_the_robot_is_worse_off_is_told_why() {
        let before =
            Fitness { scans: 1_000, localised: 980, doubted: 10, lost: 1, fit: 0.85, contradicted: 0.01 };
        let reason = |after: Fitness| worse(&before, &after).unwrap_or_default();
        assert_eq!(reason(before), "");
        assert_eq!(reason(Fitness { lost: 0, fit: 0.9, contradicted: 0.0, ..before }), "");
        assert!(reason(Fitness { lost: 2, ..before }).contains("loses its place 2 time(s)"));
        assert!(reason(Fitness { localised: 970, ..before }).contains("96.0 % of the scans, 97.0 %"));
        assert!(reason(Fitness { doubted: 20, ..before }).contains("96.0 %"));
        assert!(reason(Fitness { fit: 0.84, ..before }).contains("fits it by 0.840, 0.850"));
        assert!(reason(Fitness { contradicted: 0.02, ..before }).contains("contradicts it by 0.020"));
    }
}
