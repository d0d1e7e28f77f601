//! E57 (ASTM E2807): one scan for each keyframe, with its pose, as survey programs expect of a scanner's stations.

use e57::{
    E57Writer, IntensityLimits, Quaternion, Record, RecordDataType, RecordName, RecordValue, Transform,
    Translation,
};
use std::io::{self, Read, Seek, Write};
use vocab::Pose;

/// A file being written; complete once [`E57File::finish`] has returned.
pub struct E57File<T: Read + Write + Seek> {
    writer: E57Writer<T>,
    id: u128,
    scans: u128,
}

impl<T: Read + Write + Seek> E57File<T> {
    /// Begins a file in `out`, which is both read and written. `id` names the file for good.
    ///
    /// # Errors
    /// When `out` fails.
    pub fn new(out: T, id: u128) -> io::Result<Self> {
        let writer = E57Writer::new(out, &guid(id)).map_err(io::Error::other)?;
        Ok(Self { writer, id, scans: 0 })
    }

    /// Adds a scan: points (metres) in the frame whose pose in the map is `map_from_scan`, and their intensity (sensor
    /// units; what is missing is 0).
    ///
    /// # Errors
    /// When the file fails.
    pub fn add(
        &mut self,
        name: &str,
        map_from_scan: &Pose,
        xyz: &[[f32; 3]],
        intensity: &[f32],
    ) -> io::Result<()> {
        self.scans += 1;
        let id = guid(self.id.wrapping_add(self.scans));
        let most = intensity.iter().copied().fold(1.0, f32::max);
        let mut scan = self.writer.add_pointcloud(&id, prototype()).map_err(io::Error::other)?;
        scan.set_name(Some(name.to_owned()));
        scan.set_transform(Some(transform(map_from_scan)));
        scan.set_intensity_limits(Some(IntensityLimits {
            intensity_min: Some(RecordValue::Single(0.0)),
            intensity_max: Some(RecordValue::Single(most)),
        }));
        let intensities = intensity.iter().copied().chain(std::iter::repeat(0.0));
        for (point, intensity) in xyz.iter().zip(intensities) {
            let values = point.iter().copied().chain([intensity]).map(RecordValue::Single);
            scan.add_point(values.collect()).map_err(io::Error::other)?;
        }
        scan.finalize().map_err(io::Error::other)
    }

    /// Completes the file.
    ///
    /// # Errors
    /// When the file fails.
    pub fn finish(mut self) -> io::Result<()> {
        self.writer.finalize().map_err(io::Error::other)
    }
}

fn prototype() -> Vec<Record> {
    let intensity = Record { name: RecordName::Intensity, data_type: RecordDataType::F32 };
    vec![Record::CARTESIAN_X_F32, Record::CARTESIAN_Y_F32, Record::CARTESIAN_Z_F32, intensity]
}

fn transform(map_from_scan: &Pose) -> Transform {
    let (position, q) = (map_from_scan.position, map_from_scan.orientation);
    // The same rotation, with the scalar part that the standard asks for.
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    Transform {
        rotation: Quaternion { w: sign * q.w, x: sign * q.x, y: sign * q.y, z: sign * q.z },
        translation: Translation { x: position.x, y: position.y, z: position.z },
    }
}

/// As the standard writes them.
fn guid(id: u128) -> String {
    let hex = format!("{id:032x}");
    format!("{{{}-{}-{}-{}-{}}}", &hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..])
}

#[cfg(test)]
mod tests {
    use super::*;
    use e57::E57Reader;
    use std::fs::OpenOptions;
    use vocab::{Quat, Vec3};

    #[test]
    fn scans_read_back_with_their_poses() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.e57");
        let file = OpenOptions::new().read(true).write(true).create_new(true).open(&path).unwrap();
        // A quarter turn to the left, written with the other sign.
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let pose = Pose {
            position: Vec3::new(10.0, 20.0, 0.5),
            orientation: Quat { w: -half, x: 0.0, y: 0.0, z: -half },
        };
        let mut written = E57File::new(file, 7).unwrap();
        written.add("keyframe 0", &Pose::IDENTITY, &[[1.0, 2.0, 3.0]], &[40.0]).unwrap();
        written.add("keyframe 1", &pose, &[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[]).unwrap();
        written.finish().unwrap();

        let mut reader = E57Reader::from_file(&path).unwrap();
        let scans = reader.pointclouds();
        assert_eq!(scans.iter().map(|scan| scan.records).collect::<Vec<_>>(), [1, 2]);
        assert_eq!(scans[1].name.as_deref(), Some("keyframe 1"));
        assert!(scans[1].transform.as_ref().is_some_and(|t| t.rotation.w > 0.0));
        // The reader moves points by the scan's pose.
        let points: Vec<_> = reader.pointcloud_simple(&scans[1]).unwrap().map(Result::unwrap).collect();
        let e57::CartesianCoordinate::Valid { x, y, z } = points[0].cartesian else { panic!("a point") };
        for (read, truth) in [x, y, z].into_iter().zip([10.0, 21.0, 0.5]) {
            assert!((read - truth).abs() < 1e-6, "{x} {y} {z}");
        }
    }
}
