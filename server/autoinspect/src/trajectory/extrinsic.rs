//! Pose between the estimated frame and the frame of the ground truth.

use crate::calibration::{CalibrationTransform, isometry};
use crate::failure::Failure;
use geometry::Isometry;
use serde::Deserialize;
use std::path::Path;

/// A calibration file: the pose of the IMU (the frame of the ground truth) in the LiDAR, and the offset of their clocks.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct Extrinsic {
    #[serde(rename = "T_lidar_imu")]
    lidar_from_imu: CalibrationTransform,
    /// Added to the estimate's stamps to get the truth's, seconds.
    pub time_offset_s: Option<f64>,
}

impl Extrinsic {
    /// Reads a JSON file with `T_lidar_imu` (`translation_m`, `quaternion_xyzw`) and, if known, `time_offset_s`.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let bytes = std::fs::read(path).map_err(|error| Failure::unreadable(path, error))?;
        serde_json::from_slice(&bytes).map_err(|error| Failure::unreadable(path, error))
    }

    /// Pose of the ground truth's frame in the estimated frame.
    pub fn estimated_from_known(&self) -> Result<Isometry, Failure> {
        self.lidar_from_imu.isometry()
    }
}

/// Parses `X,Y,Z,QX,QY,QZ,QW`.
pub fn parse_frame(text: &str) -> Result<Isometry, Failure> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    match numbers.as_deref() {
        Ok([x, y, z, qx, qy, qz, qw]) => isometry([*x, *y, *z], [*qx, *qy, *qz, *qw]),
        _ => Err(Failure::usage(crate::texts::invalid_frame(text))),
    }
}
