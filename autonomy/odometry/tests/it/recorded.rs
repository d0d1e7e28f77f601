//! Tests on real recordings, where they are available.

use crate::support::{aligned_error, poses};
use geometry::{Isometry, Rotation, Vector3, so3};
use odometry::{Odometry, OdometryConfig, ScanView};
use std::path::PathBuf;
use vocab::Stamp;

/// Path of a file or folder of the shared data. `None`, with a printed line, if it is not there.
fn data(path: &str) -> Option<PathBuf> {
    let root = std::env::var_os("AUTOINSPECT_DATA").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    let full = root.join(path);
    if full.exists() {
        return Some(full);
    }
    println!("skipped: {} is not there", full.display());
    None
}

fn text(path: PathBuf) -> Vec<Vec<f64>> {
    let numbers = |line: &str| line.split([' ', ',']).filter_map(|word| word.trim().parse().ok()).collect();
    std::fs::read_to_string(path).unwrap().lines().map(numbers).collect()
}

/// Points of a binary PCD with float32 x y z first.
fn pcd(path: PathBuf) -> Vec<[f32; 3]> {
    let bytes = std::fs::read(path).unwrap();
    let marker = b"DATA binary\n";
    let body = bytes.windows(marker.len()).position(|window| window == marker).unwrap() + marker.len();
    let header = String::from_utf8_lossy(&bytes[..body]).into_owned();
    let count: usize =
        header.lines().find_map(|line| line.strip_prefix("POINTS ")).unwrap().trim().parse().unwrap();
    let step = (bytes.len() - body) / count;
    bytes[body..].chunks_exact(step).map(|record| floats(record)[..3].try_into().unwrap()).collect()
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks_exact(4).map(|four| f32::from_le_bytes(four.try_into().unwrap())).collect()
}

#[test]
fn keyframes_of_a_car_one_metre_apart_are_tracked_by_the_lidar_alone() {
    let Some(folder) = data("kaist03-keyframes") else { return };
    let times = text(folder.join("times.txt"));
    let mut odometry = Odometry::new(OdometryConfig::default());
    let mut out = Vec::new();
    for index in 0..21 {
        let xyz = pcd(folder.join(format!("Scans/{index:06}.pcd")));
        let stamp = Stamp::from_secs_f64(times[index][0]);
        odometry.insert_scan(ScanView { stamp, xyz: &xyz, intensity: &[], offset_ns: &[] }, &mut out);
    }
    odometry.flush(&mut out);
    let found: Vec<Vector3> =
        poses(&out).iter().map(|p| p.odom_from_base_at_scan.translation.vector).collect();
    let truth: Vec<Vector3> = text(folder.join("optimized_poses.txt"))[..21]
        .iter()
        .map(|row| Vector3::new(row[3], row[7], row[11]))
        .collect();
    assert_eq!(found.len(), 21);
    let error = aligned_error(&found, &truth);
    println!("kaist03-keyframes: {error:.4} m");
    assert!(error < 0.10, "{error}");
}

/// The IMU alone predicts the rotations between the poses of a LiDAR-inertial trajectory.
#[test]
fn a_hand_held_imu_predicts_the_rotations_of_its_trajectory() {
    let Some(folder) = data("imu-handheld") else { return };
    let imu = text(folder.join("imu.txt"));
    let trajectory = text(folder.join("traj.txt"));
    let rotation =
        |row: &[f64]| Rotation::from_quaternion(nalgebra::Quaternion::new(row[7], row[4], row[5], row[6]));
    let mut odometry = Odometry::new(OdometryConfig::default());
    let mut out = Vec::new();
    let mut fed = 0;
    let mut previous: Option<(Rotation, Rotation)> = None;
    let (mut squares, mut count) = (0.0, 0);
    for row in &trajectory[10..600] {
        while imu[fed][0] <= row[0] + 0.005 {
            let r = &imu[fed];
            let (force, gyro) = (Vector3::new(r[1], r[2], r[3]), Vector3::new(r[4], r[5], r[6]));
            odometry.insert_imu(Stamp::from_secs_f64(r[0]), gyro, force, &mut out);
            fed += 1;
        }
        let predicted = odometry.predict(Stamp::from_secs_f64(row[0])).odom_from_base.rotation;
        let measured = rotation(row);
        if let Some((predicted_before, measured_before)) = previous.replace((predicted, measured)) {
            let difference = so3::log(
                &((predicted_before.inverse() * predicted).inverse()
                    * (measured_before.inverse() * measured)),
            );
            squares += difference.norm_squared();
            count += 1;
        }
    }
    let error = (squares / f64::from(count)).sqrt();
    println!("imu-handheld: {:.3} degrees in 0.1 s", error.to_degrees());
    assert!(error < 0.01, "{error}");
}

/// Clouds of a fast-turning LiDAR with published corrections. A motion with eight knots per sweep, much coarser than the odometry's pose table,
/// leaves errors of millimetres.
#[test]
fn a_fast_turning_sweep_is_corrected() {
    let Some(folder) = data("deskew-newer06") else { return };
    for scan in 0..2 {
        let points = |name: &str| -> Vec<Vector3> {
            floats(&std::fs::read(folder.join(format!("{name}_{scan:02}.bin"))).unwrap())
                .chunks_exact(3)
                .map(|p| Vector3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2])))
                .collect()
        };
        let times = floats(&std::fs::read(folder.join(format!("times_{scan:02}.bin"))).unwrap());
        let imu_from_lidar =
            Isometry::new(Vector3::new(-0.006, 0.012, -0.029), Vector3::z() * std::f64::consts::PI);
        let (raw, deskewed) = (points("raw"), points("deskewed"));
        let knots = fit_knots(&raw, &deskewed, &times, &imu_from_lidar);
        let error = median_error(&raw, &deskewed, &times, &imu_from_lidar, &knots);
        println!("deskew-newer06 scan {scan}: median {:.1} mm", error * 1e3);
        assert!(error < 0.015, "{error}");
    }
}

/// Poses at eight instants (ends included) that move the raw points onto the corrected ones: each is the best rigid motion of the
/// points nearest in time.
fn fit_knots(
    raw: &[Vector3],
    deskewed: &[Vector3],
    times: &[f32],
    imu_from_lidar: &Isometry,
) -> Vec<(Stamp, Isometry)> {
    let knots = 8;
    (0..knots)
        .map(|knot| {
            let at = 0.1 * f64::from(knot) / f64::from(knots - 1);
            let near: Vec<usize> =
                (0..raw.len()).filter(|&i| (f64::from(times[i]) - at).abs() < 0.003).collect();
            let pairs: Vec<(Vector3, Vector3)> = near
                .iter()
                .map(|&i| (deskewed[i], imu_from_lidar.transform_point(&raw[i].into()).coords))
                .collect();
            (Stamp::from_secs_f64(at), geometry::umeyama(&pairs, false).unwrap().truth_from_estimate)
        })
        .collect()
}

fn median_error(
    raw: &[Vector3],
    deskewed: &[Vector3],
    times: &[f32],
    imu_from_lidar: &Isometry,
    knots: &[(Stamp, Isometry)],
) -> f64 {
    let xyz: Vec<[f32; 3]> = raw.iter().map(|p| [p.x as f32, p.y as f32, p.z as f32]).collect();
    let offset_ns: Vec<i32> = times.iter().map(|t| (f64::from(*t) * 1e9) as i32).collect();
    let view = ScanView { stamp: Stamp::EPOCH, xyz: &xyz, intensity: &[], offset_ns: &offset_ns };
    let (moved, end) = odometry::deskew(&view, knots, imu_from_lidar);
    let mut errors: Vec<f64> = moved
        .iter()
        .zip(deskewed)
        .map(|(p, truth)| {
            let point = Vector3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]));
            (end.transform_point(&point.into()).coords - truth).norm()
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    errors[errors.len() / 2]
}
