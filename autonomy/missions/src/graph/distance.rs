//! The straight distance between two places.

use vocab::Vec3;

/// Metres.
pub(super) fn distance_m(a: Vec3, b: Vec3) -> f64 {
    let (x, y, z) = (a.x - b.x, a.y - b.y, a.z - b.z);
    (x * x + y * y + z * z).sqrt()
}
