//! One keyframe's cloud, and which clouds of a map are wanted: shared by everything that reads and writes clouds.

use vocab::{KeyframeId, Pose, Stamp};

/// A keyframe of a map and its current pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KeyframePose {
    pub(crate) id: KeyframeId,
    pub(crate) stamp: Stamp,
    pub(crate) map_from_keyframe: Pose,
}

/// The points that one keyframe adds to a map.
#[derive(Clone, Debug, PartialEq)]
pub struct MapCloud {
    /// The keyframe.
    pub keyframe: KeyframeId,
    /// Its pose in the map.
    pub map_from_keyframe: Pose,
    /// Metres, keyframe's frame.
    pub xyz: Vec<[f32; 3]>,
    /// Sensor units, one for each point.
    pub intensity: Vec<f32>,
}

impl MapCloud {
    /// Drops the points with these indices, which ascend.
    pub fn drop_points(&mut self, indices: &[u32]) {
        drop_places(&mut self.xyz, indices);
        drop_places(&mut self.intensity, indices);
    }
}

/// Drops the values at these places, which ascend.
pub(crate) fn drop_places<T>(values: &mut Vec<T>, places: &[u32]) {
    let mut dropped = places.iter().peekable();
    let mut kept = (0..).map(|place: u32| dropped.next_if_eq(&&place).is_none());
    values.retain(|_| kept.next().unwrap_or(true));
}

/// Which points of a map's clouds are wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CloudSelection {
    /// Edge of the cells in which only the point that was seen first is kept, metres; 0 keeps every point.
    pub spacing_m: f32,
    /// Whether to keep points of people and other moving objects, which neighbouring keyframes saw through.
    pub include_dynamic: bool,
}

impl CloudSelection {
    /// Every point.
    pub const ALL: Self = Self { spacing_m: 0.0, include_dynamic: true };
}
