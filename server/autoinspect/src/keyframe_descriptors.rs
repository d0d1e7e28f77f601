//! Reads descriptors of a saved map's keyframes, for localisation.

use crate::failure::Failure;
use geometry::Isometry;
use mapping::{KeyframeDescriptor, KeyframeDescriptorParts};
use messages::PriorKeyframe;
use std::path::Path;
use store::{SavedMap, keyframe_descriptors};

/// Descriptors of the keyframes for which `wanted` (by number) is true, each with its pose in the map. Cost: linear in the keyframes.
pub fn read_keyframe_descriptors(
    map: &Path,
    wanted: impl Fn(usize) -> bool,
) -> Result<Vec<(Isometry, KeyframeDescriptor)>, Failure> {
    let saved = SavedMap::read(map).map_err(Failure::usage)?;
    let known = keyframe_descriptors(map, saved.poses.len()).map_err(Failure::usage)?;
    let whole = known.len() == saved.poses.len();
    let all = saved.poses.into_iter().zip(known).enumerate().filter(|(number, _)| wanted(*number));
    let places = all.map(|(_, (pose, PriorKeyframe { lidar, points, ranges, views }))| {
        Some((
            pose,
            KeyframeDescriptor::from_parts(KeyframeDescriptorParts { points, ranges, views }, lidar)?,
        ))
    });
    places
        .collect::<Option<Vec<_>>>()
        .filter(|_| whole)
        .ok_or_else(|| Failure::usage(crate::texts::missing_clouds(map)))
}
