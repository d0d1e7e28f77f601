//! Measures how well robots are localised in a map.

use super::distance_trigger::DistanceTrigger;
use crate::failure::Failure;
use crate::inputs::{self, InputArgs, InputReader};
use crate::keyframe_descriptors::read_keyframe_descriptors;
use crate::localise::offline_localiser::OfflineLocaliser;
use crate::map_version::Fitness;
use geometry::isometry_from_pose;
use localisation::{AdaptiveVoxelFilter, GlobalLocaliser, LocalisationMap};
use messages::CorrectedScan;
use std::path::{Path, PathBuf};
use std::sync::Arc;

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
