//! Vectors of the contract in the renderer's type.

use glam::DVec3;
use vocab::Vec3;

/// A vector in the renderer's type.
pub(crate) fn vector(plain: Vec3) -> DVec3 {
    DVec3::from_array(plain.to_array())
}
