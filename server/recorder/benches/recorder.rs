//! Time to prepare, to record and to read a full-resolution sweep (64,000 points, 10 Hz), and its compressed size.
//!
//! `cargo bench -p recorder`

#![allow(clippy::print_stdout, reason = "a bench may panic at an error, and prints its results")]

use divan::Bencher;
use divan::counter::BytesCount;
use formats::cdr::Encoding;
use formats::ros::{PointCloud2, write_scan};
use messages::{Input, Mounting, Scan, Sensor};
use recorder::{ChunkCompression, Recording, RecordingMeta, RecordingWriter, TopicSelection, WriterConfig};
use std::path::Path;
use std::sync::Arc;
use vocab::{Span, Stamp};

fn main() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("size.mcap");
    let mut sizes =
        [ChunkCompression::None, ChunkCompression::Zstd, ChunkCompression::Lz4].map(|compression| {
            write(&path, &ten_scans(), compression);
            (compression, std::fs::metadata(&path).expect("written above").len())
        });
    let (_, unpacked) = sizes[0];
    for (compression, size) in &mut sizes {
        println!("{compression:?}: {} bytes a scan ({:.2} to 1)", *size / 10, unpacked as f64 / *size as f64);
    }
    write(&path, &quantised(&ten_scans()), ChunkCompression::Zstd);
    let size = std::fs::metadata(&path).expect("written above").len();
    println!("range images: {} bytes a scan ({:.2} to 1)", size / 10, unpacked as f64 / size as f64);
    divan::main();
}

/// The same scans as a link hands them to the stack.
fn quantised(inputs: &[Input]) -> Vec<Input> {
    let mut inputs = inputs.to_vec();
    for input in &mut inputs {
        if let Input::Sensor(Sensor::Scan(scan)) = input {
            scan_codec::quantise(Arc::make_mut(scan));
        }
    }
    inputs
}

/// What a link does with every scan.
#[divan::bench]
fn quantise_scan(bencher: Bencher) {
    bencher.with_inputs(|| sweep(Stamp::EPOCH)).bench_local_refs(scan_codec::quantise);
}

#[divan::bench]
fn encode_range_image(bencher: Bencher) {
    let (mut scan, mut bytes) = (sweep(Stamp::EPOCH), Vec::new());
    scan_codec::quantise(&mut scan);
    bencher.bench_local(|| {
        bytes.clear();
        assert!(scan_codec::encode(&scan, &mut bytes));
        bytes.len()
    });
}

#[divan::bench]
fn decode_range_image(bencher: Bencher) {
    let (mut scan, mut bytes) = (sweep(Stamp::EPOCH), Vec::new());
    scan_codec::quantise(&mut scan);
    assert!(scan_codec::encode(&scan, &mut bytes));
    bencher.bench_local(|| scan_codec::decode(&bytes).expect("written above"));
}

/// A 32-channel sweep of a hall of 60 x 40 x 8 m with 1 cm of range noise, like the simulator's.
fn sweep(stamp: Stamp) -> Scan {
    const POINTS: usize = 64_000;
    let mut scan = Scan { stamp, ..Scan::default() };
    let mut noise = 0x2545_f491_4f6c_dd1d_u64;
    for i in 0..POINTS {
        let (column, ring) = (i / 32, i % 32);
        let azimuth = column as f32 / 2000.0 * std::f32::consts::TAU;
        let elevation = (ring as f32 - 16.0).to_radians();
        let direction = [azimuth.cos() * elevation.cos(), azimuth.sin() * elevation.cos(), elevation.sin()];
        let walls = [30.0, 20.0, if direction[2] < 0.0 { 0.6 } else { 7.4 }];
        let hit = direction.iter().zip(walls).map(|(d, w)| w / d.abs().max(1e-6)).fold(f32::MAX, f32::min);
        noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let range = hit + ((noise >> 40) as f32 / (1 << 24) as f32 - 0.5) * 0.035;
        scan.xyz.push(direction.map(|d| d * range));
        scan.intensity.push((40 + (noise >> 61)) as f32);
        scan.offset_ns.push(column as i32 * 50_000);
        scan.ring.push(ring as u16);
    }
    scan
}

#[divan::bench]
fn encode_scan(bencher: Bencher) {
    let (scan, mut bytes) = (sweep(Stamp::EPOCH), Vec::new());
    bencher.bench_local(|| {
        bytes.clear();
        write_scan(&scan, "lidar", Encoding::Cdr, &mut bytes);
        bytes.len()
    });
}

#[divan::bench]
fn decode_scan(bencher: Bencher) {
    let mut bytes = Vec::new();
    write_scan(&sweep(Stamp::EPOCH), "lidar", Encoding::Cdr, &mut bytes);
    bencher.counter(BytesCount::of_slice(&bytes)).bench_local(|| {
        let cloud = PointCloud2::from_bytes(Encoding::Cdr, &bytes).expect("written above");
        cloud.table.to_scan(Some(cloud.header.stamp)).expect("written above")
    });
}

/// Writes and reads one second of scans: the time of one scan is a tenth.
#[divan::bench(args = [ChunkCompression::None, ChunkCompression::Zstd, ChunkCompression::Lz4], sample_count = 20)]
fn record_ten_scans(bencher: Bencher, compression: ChunkCompression) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scans = ten_scans();
    bencher.bench_local(|| write(&folder.path().join("bench.mcap"), &scans, compression));
}

#[divan::bench(sample_count = 10)]
fn read_ten_scans(bencher: Bencher) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("bench.mcap");
    write(&path, &ten_scans(), ChunkCompression::Zstd);
    let recording = Recording::open(&path, &TopicSelection::default()).expect("written above");
    bencher.bench_local(|| recording.inputs().count());
}

fn ten_scans() -> Vec<Input> {
    let stamp = |tenth: i64| Stamp::EPOCH + Span::from_millis(100 * tenth);
    (0..10).map(|tenth| Input::Sensor(Sensor::Scan(Arc::new(sweep(stamp(tenth)))))).collect()
}

fn write(path: &Path, inputs: &[Input], compression: ChunkCompression) {
    let meta = RecordingMeta::default();
    let mut writer = RecordingWriter::create_with(
        path,
        &meta,
        &Mounting::default(),
        &WriterConfig { compression, ..WriterConfig::default() },
    )
    .expect("the temporary folder is writable");
    for (tenth, input) in inputs.iter().enumerate() {
        let at = Stamp::EPOCH + Span::from_millis(100 * tenth as i64);
        writer.input(at, input).expect("the disk has space");
    }
    writer.finish().expect("the disk has space");
}
