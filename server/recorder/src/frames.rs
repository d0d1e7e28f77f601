//! The mounting of the sensors on the robot, from the static transforms of a recording.

use formats::ros::TransformStamped;
use geometry::{isometry_from_pose, pose_from_isometry};
use messages::Mounting;
use std::collections::BTreeSet;
use vocab::Pose;

/// Frames in which the sensors of a recording measure.
pub(crate) struct SensorFrames {
    pub lidar: Option<String>,
    pub imu: Option<String>,
    pub external: Option<String>,
}

/// Common names of the base frame, the preferred one first.
const BASE_NAMES: [&str; 5] = ["base_link", "base", "body", "trunk", "base_footprint"];

/// Poses of the sensors in the base. The base is the first of [`BASE_NAMES`] that occurs in a transform, else the
/// LiDAR.
pub(crate) fn mounting(transforms: &[TransformStamped], sensors: &SensorFrames) -> Mounting {
    let mentioned = |name: &&&str| {
        transforms.iter().any(|transform| {
            same_frame(&transform.header.frame_id, name) || same_frame(&transform.child_frame_id, name)
        })
    };
    let named = BASE_NAMES.iter().find(mentioned).map(|name| (*name).to_owned());
    let Some(base) = named.or_else(|| sensors.lidar.clone()) else { return Mounting::default() };
    let find = |frame: &Option<String>| frame.as_ref().and_then(|frame| look_up(transforms, &base, frame));
    Mounting {
        base_from_lidar: find(&sensors.lidar),
        base_from_imu: find(&sensors.imu),
        base_from_external: find(&sensors.external),
        standing_height_m: None,
    }
}

/// Pose of `child` in `parent` along a chain of transforms, or `None` if no chain connects them.
fn look_up(transforms: &[TransformStamped], parent: &str, child: &str) -> Option<Pose> {
    let mut reached = vec![(parent, geometry::Isometry::identity())];
    let mut seen = BTreeSet::from([plain(parent)]);
    while let Some((frame, parent_from_frame)) = reached.pop() {
        if same_frame(frame, child) {
            return Some(pose_from_isometry(&parent_from_frame));
        }
        for transform in transforms {
            let (upper, lower) = (transform.header.frame_id.as_str(), transform.child_frame_id.as_str());
            let Some(upper_from_lower) = isometry_from_pose(&transform.parent_from_child) else { continue };
            if same_frame(upper, frame) && seen.insert(plain(lower)) {
                reached.push((lower, parent_from_frame * upper_from_lower));
            } else if same_frame(lower, frame) && seen.insert(plain(upper)) {
                reached.push((upper, parent_from_frame * upper_from_lower.inverse()));
            }
        }
    }
    None
}

/// The frame's name without the leading slash, which ROS 1 writes only for some frames.
fn plain(frame: &str) -> &str {
    frame.trim_start_matches('/')
}

fn same_frame(a: &str, b: &str) -> bool {
    plain(a) == plain(b)
}
