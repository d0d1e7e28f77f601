//! Times of encoding, decoding, splitting and baking: `cargo bench -p map_codec`.
//!
//! The input is synthetic: a LiDAR of 32 channels in a hall of 30 x 20 x 6 m, with 1 cm of range noise and with intensities.

#![allow(clippy::print_stdout, reason = "a bench reports on standard output")]

use divan::Bencher;
use divan::counter::ItemsCount;
use map_codec::{BakeConfig, LevelSplitter, SplitConfig, bake, decode, encode_scan};
use vocab::Pose;

fn main() {
    let (xyz, intensity) = scan(64_000, [0.0; 3]);
    for resolution in [0.01, 0.02] {
        let bytes = encode_scan(&xyz, &intensity, resolution).len();
        println!("scan at {resolution} m: {:.2} bytes a point", bytes as f64 / xyz.len() as f64);
    }
    let (xyz, intensity) = walk();
    let tiles = bake(&xyz, &intensity, &BakeConfig::default());
    let bytes: usize = tiles.iter().map(|t| t.bytes.len()).sum();
    let points: u32 = tiles.iter().map(|t| t.points).sum();
    let each = bytes as f64 / f64::from(points);
    println!("baked map: {} tiles, {points} points, {each:.2} bytes a point", tiles.len());
    divan::main();
}

/// One sweep from the position `eye` in the hall, metres.
fn scan(count: usize, eye: [f32; 3]) -> (Vec<[f32; 3]>, Vec<f32>) {
    let mut state = 1_u32;
    let mut noise = move || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (state >> 8) as f32 / (1 << 24) as f32 - 0.5
    };
    (0..count)
        .map(|i| {
            let azimuth = (i / 32) as f32 * 32.0 / count as f32 * std::f32::consts::TAU;
            let elevation = (-16.0 + (i % 32) as f32).to_radians();
            let ray = [azimuth.cos() * elevation.cos(), azimuth.sin() * elevation.cos(), elevation.sin()];
            let range = (0..3)
                .map(|axis| {
                    ([15.0, 10.0, 3.0][axis] - ray[axis].signum() * eye[axis]) / ray[axis].abs().max(1e-6)
                })
                .fold(f32::INFINITY, f32::min);
            let noisy = range + 0.035 * noise();
            let reflectivity = 60.0 + 40.0 * (ray[2] * range * 3.0).sin() + 20.0 * noise();
            (std::array::from_fn(|axis| eye[axis] + ray[axis] * noisy), reflectivity.round())
        })
        .unzip()
}

/// Fifty sweeps along the hall, map frame.
fn walk() -> (Vec<[f32; 3]>, Vec<f32>) {
    let sweeps = (0..50).map(|i| scan(40_000, [-12.0 + 0.5 * i as f32, -3.0 + 0.1 * i as f32, -1.0]));
    sweeps.fold(Default::default(), |mut all: (Vec<_>, Vec<_>), (xyz, intensity)| {
        all.0.extend(xyz);
        all.1.extend(intensity);
        all
    })
}

#[divan::bench]
fn encode_scan_64k(bencher: Bencher) {
    let (xyz, intensity) = scan(64_000, [0.0; 3]);
    bencher.counter(ItemsCount::new(xyz.len())).bench(|| encode_scan(&xyz, &intensity, 0.01));
}

#[divan::bench]
fn decode_scan_64k(bencher: Bencher) {
    let (xyz, intensity) = scan(64_000, [0.0; 3]);
    let bytes = encode_scan(&xyz, &intensity, 0.01);
    bencher.counter(ItemsCount::new(xyz.len())).bench(|| decode(&bytes));
}

#[divan::bench]
fn split_first_keyframe(bencher: Bencher) {
    let (xyz, intensity) = scan(64_000, [0.0; 3]);
    bencher
        .counter(ItemsCount::new(xyz.len()))
        .with_inputs(|| LevelSplitter::new(SplitConfig::default()))
        .bench_values(|mut splitter| splitter.push(&Pose::IDENTITY, &xyz, &intensity));
}

#[divan::bench(sample_count = 5)]
fn bake_two_million(bencher: Bencher) {
    let (xyz, intensity) = walk();
    bencher.counter(ItemsCount::new(xyz.len())).bench(|| bake(&xyz, &intensity, &BakeConfig::default()));
}
