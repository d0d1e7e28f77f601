//! Headings of poses that stand upright.

use vocab::Quat;

/// Heading of a pose, rad from the map's x axis, counter-clockwise.
pub(crate) fn heading_rad(q: &Quat) -> f64 {
    (2.0 * (q.w * q.z + q.x * q.y)).atan2(1.0 - 2.0 * (q.y * q.y + q.z * q.z))
}

/// Heading of a pose, degrees, rounded so that no minus stands before a zero.
pub(crate) fn heading_deg(q: &Quat) -> f64 {
    (heading_rad(q).to_degrees() * 100.0).round() / 100.0 + 0.0
}

/// The upright orientation of a heading, rad.
pub(crate) fn orientation_of(heading_rad: f64) -> Quat {
    let (z, w) = (0.5 * heading_rad).sin_cos();
    Quat { x: 0.0, y: 0.0, z, w }
}
