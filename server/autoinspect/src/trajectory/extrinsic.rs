//! From the frame that was estimated to the frame whose truth is known.

use crate::failure::Failure;
use geometry::Isometry;
use serde::Deserialize;
use std::path::Path;
use vocab::{Pose, Quat, Vec3};

/// A calibration file: the pose of the IMU (whose truth is known) in the LiDAR, and the offset of their clocks.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct Extrinsic {
    #[serde(rename = "T_lidar_imu")]
    lidar_from_imu: Transform,
    /// Estimate's stamp plus this is the truth's instant, seconds.
    pub time_offset_s: Option<f64>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
struct Transform {
    translation_m: [f64; 3],
    quaternion_xyzw: [f64; 4],
}

impl Extrinsic {
    /// Reads a JSON file with `T_lidar_imu` (`translation_m`, `quaternion_xyzw`) and, if known, `time_offset_s`.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let bytes = std::fs::read(path).map_err(|error| Failure::unreadable(path, error))?;
        serde_json::from_slice(&bytes).map_err(|error| Failure::unreadable(path, error))
    }

    /// Pose of the frame whose truth is known in the frame that was estimated.
    pub fn estimated_from_known(&self) -> Result<Isometry, Failure> {
        let [x, y, z, w] = self.lidar_from_imu.quaternion_xyzw;
        isometry(self.lidar_from_imu.translation_m, [x, y, z, w])
    }
}

/// From `X,Y,Z,QX,QY,QZ,QW`.
pub fn parse_frame(text: &str) -> Result<Isometry, Failure> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    match numbers.as_deref() {
        Ok([x, y, z, qx, qy, qz, qw]) => isometry([*x, *y, *z], [*qx, *qy, *qz, *qw]),
        _ => Err(Failure::usage(format!(
            "'{text}' is not a frame; write X,Y,Z,QX,QY,QZ,QW (metres, quaternion)"
        ))),
    }
}

fn isometry(position: [f64; 3], [x, y, z, w]: [f64; 4]) -> Result<Isometry, Failure> {
    let pose = Pose { position: Vec3::from(position), orientation: Quat { w, x, y, z } };
    geometry::isometry_from_pose(&pose)
        .ok_or_else(|| Failure::usage("the frame's quaternion is zero or not finite".to_owned()))
}
