//! The least uncertainty of a registration, which odometry edges, loops and finished maps share.

/// What the registration of scans in maps of scans leaves however many points agree: vibration, motion correction and cells of some
/// centimetres. It is the least deviation of an odometry edge and of a loop, the deviation of the tilt between two keyframes, and that of
/// neighbouring keyframes of a finished map.
///
/// The graph weighs these measurements against each other, so that one value serves all. With 1 mrad for odometry and tilt, loops bent what
/// odometry had mapped well (docs/benchmarks/sites.md).
pub struct RegistrationFloor;

impl RegistrationFloor {
    /// Standard deviation of the rotation, radians.
    pub const ROTATION_STD_RAD: f64 = 5e-4;
    /// Standard deviation of the translation, metres.
    pub const TRANSLATION_STD_M: f64 = 5e-3;
}
