//! Calibration files: mounting of the sensors and the robot itself, for recordings without them.

use crate::failure::Failure;
use crate::robot_file::RobotFile;
use geometry::Isometry;
use messages::BootRecord;
use serde::Deserialize;
use std::path::Path;
use vocab::{Pose, Quat, Vec3};

/// A pose in a calibration file.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct CalibrationTransform {
    translation_m: [f64; 3],
    quaternion_xyzw: [f64; 4],
}

impl CalibrationTransform {
    /// Converts it; an error if it is not finite or its quaternion is not a rotation.
    pub fn isometry(&self) -> Result<Isometry, Failure> {
        isometry(self.translation_m, self.quaternion_xyzw)
    }
}

/// Makes a pose of a position in metres and a quaternion x, y, z, w.
pub fn isometry(position: [f64; 3], [x, y, z, w]: [f64; 4]) -> Result<Isometry, Failure> {
    let pose = Pose { position: Vec3::from(position), orientation: Quat { w, x, y, z } };
    geometry::isometry_from_pose(&pose).ok_or_else(|| Failure::usage(crate::texts::INVALID_QUATERNION))
}

/// Mounting of the sensors on the base, and the robot. Missing entries stay as in the recording.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    base_from_lidar: Option<CalibrationTransform>,
    base_from_imu: Option<CalibrationTransform>,
    base_from_external: Option<CalibrationTransform>,
    standing_height_m: Option<f64>,
    #[serde(default)]
    robot: RobotFile,
}

impl Calibration {
    /// Reads a JSON file.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let bytes = std::fs::read(path).map_err(|error| Failure::unreadable(path, error))?;
        serde_json::from_slice(&bytes).map_err(|error| Failure::unreadable(path, error))
    }

    /// Replaces the given entries of the recording's mounting and robot.
    pub fn apply(&self, boot: &mut BootRecord) -> Result<(), Failure> {
        self.robot.apply(&mut boot.profile)?;
        let mounting = &mut boot.mounting;
        for (given, known) in [
            (self.base_from_lidar, &mut mounting.base_from_lidar),
            (self.base_from_imu, &mut mounting.base_from_imu),
            (self.base_from_external, &mut mounting.base_from_external),
        ] {
            if let Some(transform) = given {
                *known = Some(geometry::pose_from_isometry(&transform.isometry()?));
            }
        }
        mounting.standing_height_m = self.standing_height_m.or(mounting.standing_height_m);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn given_entries_replace_the_recordings_and_the_others_stay() {
        let text = r#"{"base_from_imu": {"translation_m": [1, 2, 3], "quaternion_xyzw": [0, 0, 2, 0]}}"#;
        let calibration: Calibration = serde_json::from_str(text).expect("JSON");
        let mut boot = BootRecord::default();
        boot.mounting.base_from_lidar = Some(Pose::IDENTITY);
        calibration.apply(&mut boot).expect("a rotation");
        assert_eq!(boot.mounting.base_from_lidar, Some(Pose::IDENTITY));
        let imu = boot.mounting.base_from_imu.expect("given");
        assert_eq!(imu.position, Vec3::new(1.0, 2.0, 3.0));
        assert!((imu.orientation.z.abs() - 1.0).abs() < 1e-12, "normalised");

        let no_rotation = text.replace("[0, 0, 2, 0]", "[0, 0, 0, 0]");
        let calibration: Calibration = serde_json::from_str(&no_rotation).expect("JSON");
        assert!(calibration.apply(&mut boot).is_err());
        assert!(
            serde_json::from_str::<Calibration>(r#"{"base_from_lidr": null}"#).is_err(),
            "a misspelt name is an error"
        );
    }
}
