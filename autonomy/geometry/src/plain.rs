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

/// As [`isometry_from_pose`], for poses made by [`pose_from_isometry`]: every bit stays as it was. None if the quaternion is no unit.
pub fn isometry_from_unit_pose(pose: &Pose) -> Option<Isometry> {
    let q = pose.orientation;
    let quaternion = Quaternion::new(q.w, q.x, q.y, q.z);
    let is_unit = (quaternion.norm() - 1.0).abs() < 1e-9;
    let translation = Translation3::from(vec_from_plain(pose.position));
    (is_unit && pose.position.is_finite())
        .then(|| Isometry::from_parts(translation, Rotation::new_unchecked(quaternion)))
}

/// nalgebra pose to plain.
pub fn pose_from_isometry(iso: &Isometry) -> Pose {
    let q = iso.rotation.quaternion();
    Pose {
        position: vec_to_plain(&iso.translation.vector),
        orientation: Quat { w: q.w, x: q.i, y: q.j, z: q.k },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_pose_keeps_every_bit() {
        // Its norm is off by rounding, which normalising would change.
        let mut orientation = Quat { w: 0.8, x: 0.1, y: -0.5, z: 0.316_227_766_016_837_9 };
        orientation.w += 4.0 * f64::EPSILON;
        let pose = Pose { position: Vec3::new(1.0, 2.0, 3.0), orientation };
        assert_eq!(isometry_from_unit_pose(&pose).as_ref().map(pose_from_isometry), Some(pose));
        assert_ne!(isometry_from_pose(&pose).as_ref().map(pose_from_isometry), Some(pose));
        let long = Quat { w: 1.0, ..orientation };
        assert_eq!(isometry_from_unit_pose(&Pose { orientation: long, ..pose }), None);
        let nowhere = Pose { position: Vec3::new(f64::NAN, 0.0, 0.0), ..pose };
        assert_eq!(isometry_from_unit_pose(&nowhere), None);
    }
}
