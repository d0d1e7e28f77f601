//! What the keyframes of a saved map saw, as localisation uses it.

use crate::failure::Failure;
use geometry::{Isometry, isometry_from_pose};
use mapping::Place;
use points::Downsampler;
use std::path::Path;
use store::map_clouds_and_sensors;

/// Those keyframes of the map in a folder that are wanted, by number, each with its pose in the map. Linear in the map's points.
pub fn places(map: &Path, wanted: impl Fn(usize) -> bool) -> Result<Vec<(Isometry, Place)>, Failure> {
    let (mut places, mut downsampler) = (Vec::new(), Downsampler::default());
    for read in map_clouds_and_sensors(map).map_err(Failure::usage)? {
        let (cloud, sensor) = read.map_err(Failure::usage)?;
        if wanted(cloud.keyframe.0 as usize) {
            let pose = isometry_from_pose(&cloud.map_from_keyframe).unwrap_or_else(Isometry::identity);
            places.push((pose, Place::new(&cloud.xyz, &pose.rotation, sensor, &mut downsampler)));
        }
    }
    Ok(places)
}
