//! Conversion between nalgebra types and the plain vectors and poses of messages.

use crate::{Isometry, Rotation, Vector3};
use nalgebra::{Quaternion, Translation3};
use vocab::{Pose, Quat, Vec3};

/// Plain vector to nalgebra.
pub fn vec_from_plain(v: Vec3) -> Vector3 {
    Vector3::new(v.x, v.y, v.z)
}

/// nalgebra vector to plain.
pub fn vec_to_plain(v: &Vector3) -> Vec3 {
    Vec3::new(v.x, v.y, v.z)
}

/// Plain pose to nalgebra; the quaternion is normalised. `None` if a component is not finite or the quaternion is shorter than
/// 0.001, so that its direction is rounding noise.
pub fn isometry_from_pose(pose: &Pose) -> Option<Isometry> {
    let q = pose.orientation;
    let quaternion = Quaternion::new(q.w, q.x, q.y, q.z);
    let norm = quaternion.norm();
    if !pose.position.is_finite() || !norm.is_finite() || norm < 1e-3 {
        return None;
    }
    Some(Isometry::from_parts(
        Translation3::from(vec_from_plain(pose.position)),
        Rotation::from_quaternion(quaternion),
    ))
}

/// nalgebra pose to plain.
pub fn pose_from_isometry(iso: &Isometry) -> Pose {
    let q = iso.rotation.quaternion();
    Pose {
        position: vec_to_plain(&iso.translation.vector),
        orientation: Quat { w: q.w, x: q.i, y: q.j, z: q.k },
    }
}
