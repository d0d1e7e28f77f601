//! No parser panics, whatever the bytes: wholly random ones, and valid files with bytes changed or cut.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may stop at the first surprise, and prints what it saw"
)]

use formats::cdr::Encoding;
use formats::ros::{
    BatteryState, Imu, Odometry, PointCloud2, PoseStamped, RosMessage, TfMessage, write_scan,
};
use formats::{g2o, kitti, pcd, ply, rosbag1, rosbag2, tum};
use messages::Scan;
use proptest::prelude::*;
use std::io::Cursor;

fn feed_all(bytes: &[u8]) {
    for table in [pcd::read(bytes), ply::read(bytes), kitti::read(bytes)].into_iter().flatten() {
        let _ = table.to_scan(None);
    }
    let mut file = Cursor::new(bytes);
    if let Ok(index) = rosbag1::read_index(&mut file) {
        for chunk in &index.chunks {
            let _ = rosbag1::read_chunk(&mut file, chunk.position);
        }
    }
    for encoding in [Encoding::Cdr, Encoding::Ros1] {
        if let Ok(cloud) = PointCloud2::from_bytes(encoding, bytes) {
            let _ = cloud.table.to_scan(Some(cloud.header.stamp));
        }
        let _ = Imu::from_bytes(encoding, bytes);
        let _ = Odometry::from_bytes(encoding, bytes);
        let _ = TfMessage::from_bytes(encoding, bytes);
        let _ = BatteryState::from_bytes(encoding, bytes);
        let _ = PoseStamped::from_bytes(encoding, bytes);
    }
    let text = String::from_utf8_lossy(bytes);
    let _ = (tum::read(&text), g2o::read(&text), rosbag2::read_metadata(&text));
}

fn scan() -> Scan {
    Scan {
        xyz: (0..40).map(|i| [i as f32, 1.0, -2.0]).collect(),
        offset_ns: (0..40).map(|i| i - 3).collect(),
        ring: (0..40).collect(),
        intensity: vec![0.5; 40],
        ..Scan::default()
    }
}

/// One valid file or message of every kind that this crate can write.
fn valid() -> Vec<Vec<u8>> {
    let scan = scan();
    let mut files = vec![Vec::new(); 5];
    pcd::write(&mut files[0], [0.0; 3], &scan.xyz, &scan.intensity).unwrap();
    ply::write(&mut files[1], &scan.xyz, &scan.intensity).unwrap();
    write_scan(&scan, "lidar", Encoding::Cdr, &mut files[2]);
    write_scan(&scan, "lidar", Encoding::Ros1, &mut files[3]);
    TfMessage { transforms: vec![Default::default(); 3] }.to_bytes(Encoding::Cdr, &mut files[4]);
    files.push(b"1 2 3 4 0 0 0 1\n".repeat(3));
    files.push(b"VERTEX_SE2 0 1 2 3\nEDGE_SE2 0 1 1 0 0 1 2 3 4 5 6\n".to_vec());
    files
}

#[test]
fn scans_come_back_in_both_encodings() {
    for encoding in [Encoding::Cdr, Encoding::Ros1] {
        let mut bytes = Vec::new();
        write_scan(&scan(), "lidar", encoding, &mut bytes);
        let cloud = PointCloud2::from_bytes(encoding, &bytes).unwrap();
        assert_eq!(cloud.table.to_scan(Some(cloud.header.stamp)).unwrap().0, scan());
    }
}

#[test]
fn valid_files_cut_at_every_byte_never_panic() {
    for file in valid() {
        for cut in 0..=file.len() {
            feed_all(&file[..cut]);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        feed_all(&bytes);
    }

    #[test]
    fn random_bytes_behind_a_magic_never_panic(
        bytes in prop::collection::vec(any::<u8>(), 0..200),
        magic in prop::sample::select(vec![
            "# .PCD v0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 5\nDATA ascii\n",
            "# .PCD v0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 5\nDATA binary_compressed\n",
            "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nend_header\n",
            "#ROSBAG V2.0\n",
        ]),
    ) {
        feed_all(&[magic.as_bytes(), &bytes].concat());
    }

    #[test]
    fn valid_files_with_bytes_changed_never_panic(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6)
    ) {
        for mut file in valid() {
            for (index, value) in &changes {
                let at = index.index(file.len());
                file[at] = *value;
            }
            feed_all(&file);
        }
    }
}
