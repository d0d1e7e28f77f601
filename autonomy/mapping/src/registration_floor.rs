//! The least uncertainty of a registration, which odometry edges, loops and finished maps share.

/// What the registration of scans in maps of scans leaves however many points agree: vibration, motion correction and cells of some
/// centimetres. It is the least deviation of an odometry edge and of a loop, the deviation of the tilt between two keyframes, and that of
/// neighbouring keyframes of a finished map.
///
/// The graph weighs these measurements against each other, so that one value serves all. With 1 mrad for odometry and tilt, loops bent what
/// odometry had mapped well (docs/benchmarks/sites.md).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegistrationFloor {
    /// Standard deviation of the rotation, radians.
    pub rotation_std_rad: f64,
    /// Standard deviation of the translation, metres.
    pub translation_std_m: f64,
}

impl Default for RegistrationFloor {
    fn default() -> Self {
        Self { rotation_std_rad: 5e-4, translation_std_m: 5e-3 }
    }
}
