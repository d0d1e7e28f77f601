//! Converts a recording to the .npz file of the other programs: all data in the IMU's frame, times in seconds from the first truth.
//!
//! Arrays: `points` (rows x y z, seconds in the sweep, ring, column), `counts` and `starts` per scan, `imu_t`, `gyro`,
//! `acc`, `leg_velocity`, `truth_t`, `truth` (4x4 each, of the IMU). The recording is read twice, so that the memory for
//! the points is constant.

use anyhow::{Context, Result, bail};
use geometry::{Isometry, isometry_from_pose};
use messages::{Scan, Sensor};
use recorder::{Recording, TopicSelection};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use vocab::{Pose, Stamp};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// Columns of a full-resolution sweep.
const COLUMNS: f64 = 2000.0;
/// Duration of a sweep, seconds.
const SWEEP: f64 = 0.1;

/// All data except the points.
#[derive(Default)]
struct Small {
    counts: Vec<f64>,
    starts: Vec<f64>,
    imu_t: Vec<f64>,
    gyro: Vec<f64>,
    acc: Vec<f64>,
    leg_velocity: Vec<f64>,
}

/// Writes `recording` as an .npz file at `out`.
pub fn convert(recording: &Path, out: &Path) -> Result<()> {
    let open = || Recording::open(recording, &TopicSelection::default());
    let first = open()?;
    let truth = first.truth()?.unwrap_or_default();
    let Some(&(origin, _)) = truth.first() else { bail!("{} has no truth", recording.display()) };
    let mounting = first.mounting();
    let pose = |pose: Option<Pose>| {
        isometry_from_pose(&pose.unwrap_or_default()).context("a mounting is not a pose")
    };
    let (base_from_lidar, base_from_imu) = (pose(mounting.base_from_lidar)?, pose(mounting.base_from_imu)?);
    let imu_from_lidar = base_from_imu.inverse() * base_from_lidar;

    let mut small = Small::default();
    for input in first.inputs() {
        small.add(origin, &input?.1);
    }
    let file = File::create(out).with_context(|| format!("{} cannot be written", out.display()))?;
    let mut archive = Archive { zip: ZipWriter::new(BufWriter::new(file)) };
    small.write(&mut archive)?;
    archive.truth(origin, &truth, &base_from_imu)?;
    let points = small.counts.iter().sum::<f64>() as usize;
    archive.begin("points", "<f4", &[points, 6])?;
    for input in open()?.inputs() {
        if let Sensor::Scan(scan) = input?.1 {
            archive.scan(&scan, &imu_from_lidar)?;
        }
    }
    archive.zip.finish()?.flush()?;
    Ok(())
}

impl Small {
    fn add(&mut self, origin: Stamp, sensor: &Sensor) {
        let seconds = (sensor.stamp() - origin).secs_f64();
        match sensor {
            Sensor::Scan(scan) => {
                self.counts.push(scan.xyz.len() as f64);
                self.starts.push(seconds);
            }
            Sensor::Imu(imu) => {
                self.imu_t.push(seconds);
                self.gyro.extend(imu.angular_velocity.to_array());
                self.acc.extend(imu.specific_force.to_array());
            }
            Sensor::Legs(legs) => {
                self.leg_velocity.push(seconds);
                self.leg_velocity.extend(legs.base_velocity.linear.to_array());
            }
            Sensor::Odometry(_) | Sensor::Battery(_) => {}
        }
    }

    fn write(&self, archive: &mut Archive) -> Result<()> {
        let counts: Vec<i64> = self.counts.iter().map(|&count| count as i64).collect();
        archive.begin("counts", "<i8", &[counts.len()])?;
        for count in &counts {
            archive.zip.write_all(&count.to_le_bytes())?;
        }
        archive.doubles("starts", &self.starts, None)?;
        archive.doubles("imu_t", &self.imu_t, None)?;
        archive.doubles("gyro", &self.gyro, Some(3))?;
        archive.doubles("acc", &self.acc, Some(3))?;
        archive.doubles("leg_velocity", &self.leg_velocity, Some(4))
    }
}

struct Archive {
    zip: ZipWriter<BufWriter<File>>,
}

impl Archive {
    /// Begins an array; its bytes follow. Format: NumPy's .npy, version 1.0.
    fn begin(&mut self, name: &str, kind: &str, shape: &[usize]) -> Result<()> {
        let options =
            SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored).large_file(true);
        self.zip.start_file(format!("{name}.npy"), options)?;
        let shape: String = shape.iter().map(|length| format!("{length},")).collect();
        let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({shape}), }}");
        // Magic, version and length take 10 bytes. The header is padded to a multiple of 64 bytes and ends in a newline.
        let padding = (64 - (10 + header.len() + 1) % 64) % 64;
        header.extend(std::iter::repeat_n(' ', padding));
        header.push('\n');
        self.zip.write_all(b"\x93NUMPY\x01\x00")?;
        self.zip.write_all(&u16::try_from(header.len())?.to_le_bytes())?;
        Ok(self.zip.write_all(header.as_bytes())?)
    }

    fn doubles(&mut self, name: &str, values: &[f64], width: Option<usize>) -> Result<()> {
        match width {
            None => self.begin(name, "<f8", &[values.len()])?,
            Some(width) => self.begin(name, "<f8", &[values.len() / width, width])?,
        }
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        Ok(self.zip.write_all(&bytes)?)
    }

    fn truth(&mut self, origin: Stamp, truth: &[(Stamp, Pose)], base_from_imu: &Isometry) -> Result<()> {
        let times: Vec<f64> = truth.iter().map(|(stamp, _)| (*stamp - origin).secs_f64()).collect();
        self.doubles("truth_t", &times, None)?;
        self.begin("truth", "<f8", &[truth.len(), 4, 4])?;
        for (_, pose) in truth {
            let site_from_base = isometry_from_pose(pose).context("a true pose is not a pose")?;
            let matrix = (site_from_base * base_from_imu).to_homogeneous();
            for value in matrix.transpose().iter() {
                self.zip.write_all(&value.to_le_bytes())?;
            }
        }
        Ok(())
    }

    fn scan(&mut self, scan: &Scan, imu_from_lidar: &Isometry) -> Result<()> {
        let mut bytes = Vec::with_capacity(scan.xyz.len() * 24);
        for (index, point) in scan.xyz.iter().enumerate() {
            let point = imu_from_lidar * nalgebra::Point3::from(point.map(f64::from));
            let seconds = f64::from(scan.offset_ns.get(index).copied().unwrap_or(0)) * 1e-9;
            let column = (seconds / SWEEP * COLUMNS).clamp(0.0, COLUMNS - 1.0).floor();
            let ring = f64::from(scan.ring.get(index).copied().unwrap_or(0));
            for value in [point.x, point.y, point.z, seconds, ring, column] {
                bytes.extend((value as f32).to_le_bytes());
            }
        }
        Ok(self.zip.write_all(&bytes)?)
    }
}
