//! Errors of `autoinspect trajectory`.

use std::path::Path;

/// A trajectory without poses.
pub fn no_poses(path: &Path) -> String {
    format!("{} holds no poses with their times", path.display())
}

/// A line of a KITTI file that is not a pose.
pub fn invalid_kitti_line(path: &Path, line: usize) -> String {
    format!("{} line {line}: twelve numbers of a pose expected", path.display())
}

/// A recording without ground truth.
pub fn no_truth(path: &Path) -> String {
    format!("{} does not say where the robot really was", path.display())
}

/// Trajectories that share too few instants.
pub fn too_few_common_instants(count: usize) -> String {
    format!(
        "the two trajectories share {count} instants, too few to compare; check --offset and that both are of the same run"
    )
}

/// Positions that do not determine an alignment.
pub const COLLINEAR_POSITIONS: &str =
    "all positions lie on one line, so they cannot be aligned; use --align first";

/// A frame that cannot be parsed.
pub fn invalid_frame(text: &str) -> String {
    format!("'{text}' is not a frame; write X,Y,Z,QX,QY,QZ,QW (metres, quaternion)")
}

/// A quaternion that is not a rotation.
pub const INVALID_QUATERNION: &str = "a frame's quaternion is zero or not finite";
