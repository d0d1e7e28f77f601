//! Errors in the file of a robot's profile.

/// A self filter whose corners are not in order.
pub const SELF_FILTER_IS_NO_BOX: &str =
    "self_filter is no box; give min_m and max_m with three numbers each, the first smaller than the second";

/// A camera head with numbers that no camera has.
pub const CAMERA_HEAD_IS_NONE: &str = "camera_head has numbers that no camera has; give a pan of 0 to 180 degrees, tilts from -90 to 90 degrees with the lower one first, a zoom of at least 1 and a field of view below 180 degrees";

/// An entry of a robot's profile that has to be positive.
pub fn robot_entry_not_positive(entry: &str, value: f64) -> String {
    format!("{entry} of the robot is {value}; give a number greater than 0")
}
