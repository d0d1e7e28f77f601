//! What the keyframes of a saved map saw, as localisation uses it.

use crate::failure::Failure;
use geometry::Isometry;
use mapping::{KeyframeDescriptor, KeyframeDescriptorParts};
use messages::PriorKeyframe;
use std::path::Path;
use store::{SavedMap, keyframe_descriptors};

/// Those keyframes of the map in a folder that are wanted, by number, each with its pose in the map. Linear in its keyframes.
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
    places.collect::<Option<Vec<_>>>().filter(|_| whole).ok_or_else(|| {
        let text = format!("{} misses clouds of some of its keyframes; make the map again", map.display());
        Failure::usage(text)
    })
}
