//! Saved maps as places are looked up in them.

use crate::failure::Failure;
use geometry::{Isometry, isometry_from_pose};
use mapping::Chart;
use store::{SavedMap, map_clouds_and_sensors};

/// The keyframes of a map with what they saw.
pub fn chart_of(map: &SavedMap) -> Result<Chart, Failure> {
    let mut chart = Chart::default();
    for read in map_clouds_and_sensors(&map.path).map_err(Failure::usage)? {
        let (cloud, sensor) = read.map_err(Failure::usage)?;
        let pose = isometry_from_pose(&cloud.map_from_keyframe).unwrap_or_else(Isometry::identity);
        chart.push(&pose, &cloud.xyz, sensor);
    }
    if chart.len() != map.poses.len() {
        return Err(Failure::usage(format!(
            "{} has {} keyframes but clouds of {}; make the map again",
            map.path.display(),
            map.poses.len(),
            chart.len()
        )));
    }
    Ok(chart)
}
