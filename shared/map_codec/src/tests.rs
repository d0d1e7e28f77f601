//! Tests of round trips with their error bounds, of the levels' properties, and of malformed bytes.

use crate::chunk::{HEADER_LEN, PACKING_STORED};
use crate::*;
use proptest::prelude::*;
use std::collections::BTreeSet;
use vocab::{Pose, Quat, Vec3};

/// Points as a LiDAR in a 30 x 20 x 6 m hall would see them, with intensities, in firing order.
fn hall(count: usize) -> (Vec<[f32; 3]>, Vec<f32>) {
    (0..count)
        .map(|i| {
            let azimuth = (i / 32) as f32 * 32.0 / count as f32 * std::f32::consts::TAU;
            let elevation = (-16.0 + (i % 32) as f32).to_radians();
            let ray = [azimuth.cos() * elevation.cos(), azimuth.sin() * elevation.cos(), elevation.sin()];
            let range = [15.0_f32, 10.0, 3.0].iter().zip(ray).map(|(half, r)| half / r.abs().max(1e-6));
            let range = range.fold(f32::INFINITY, f32::min);
            (ray.map(|r| r * range), (range * 7.0) % 255.0)
        })
        .unzip()
}

fn sorted(chunk: &PointChunk) -> Vec<GpuPoint> {
    let mut points = chunk.points.clone();
    points.sort();
    points
}

fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f32>().sqrt()
}

fn any_points() -> impl Strategy<Value = Vec<[f32; 3]>> {
    prop::collection::vec(prop::array::uniform3(-400.0_f32..400.0), 0..200)
}

proptest! {
    #[test]
    fn interleaving_is_invertible_and_monotonic_per_axis(a: [u16; 3]) {
        prop_assert_eq!(morton::split(morton::interleave(a)), a);
        let next = [a[0].saturating_add(1), a[1], a[2]];
        prop_assert!(morton::interleave(next) >= morton::interleave(a));
    }

    #[test]
    fn quantised_points_are_within_half_a_step(xyz in any_points(), resolution in 0.001_f32..0.5) {
        let chunk = quantise(&xyz, &[], resolution);
        prop_assert_eq!(chunk.points.len(), xyz.len());
        prop_assert!(chunk.step >= resolution);
        // The resolution of f32 at 800 m is 0.06 mm.
        let bound = chunk.step * 0.5 + 1.2e-4;
        for (point, original) in chunk.points.iter().zip(&xyz) {
            let back = chunk.position(point);
            for axis in 0..3 {
                prop_assert!((back[axis] - original[axis]).abs() <= bound);
            }
        }
    }

    #[test]
    fn encoded_chunks_decode_to_the_same_points(
        raw in prop::collection::vec(any::<([u16; 3], u8)>(), 0..300), level: u8, step in 1e-3_f32..1.0,
    ) {
        let points = raw.iter().map(|(position, intensity)| {
            GpuPoint { position: *position, intensity: *intensity, spare: 0 }
        });
        let chunk = PointChunk {
            origin: [1.5, -2.0, 3.0], step, intensity_unit: 2.0, spacing: 0.1, level, points: points.collect(),
        };
        let back = decode(&encode(&chunk)).unwrap();
        prop_assert_eq!(sorted(&back), sorted(&chunk));
        prop_assert_eq!(PointChunk { points: chunk.points.clone(), ..back }, chunk);
    }

    #[test]
    fn damaged_chunks_give_points_or_errors(
        at in 0..4000_usize, bit in 0..8_u32, cut in 0..4000_usize, count: u32,
    ) {
        let (xyz, intensity) = hall(2000);
        let good = encode_scan(&xyz, &intensity, 0.01);
        let mut flipped = good.clone();
        flipped[at % good.len()] ^= 1 << bit;
        if let Ok(chunk) = decode(&flipped) {
            prop_assert!(chunk.points.len() * 7 <= flipped.len() * MAX_EXPANSION);
        }
        prop_assert!(decode(&good[..cut % good.len()]).is_err());
        let mut recounted = good.clone();
        recounted[8..12].copy_from_slice(&count.to_le_bytes());
        prop_assert!(count == 2000 || decode(&recounted).is_err());
    }

    #[test]
    fn any_bytes_after_a_valid_header_cause_no_panic(tail: Vec<u8>, packing in 0..3_u8, count in 0..5000_u32) {
        let mut bytes = encode_scan(&[[0.0; 3]], &[], 0.01);
        bytes.truncate(HEADER_LEN);
        bytes[5] = packing;
        bytes[8..12].copy_from_slice(&count.to_le_bytes());
        bytes[12..16].copy_from_slice(&(tail.len() as u32).to_le_bytes());
        bytes.extend_from_slice(&tail);
        if let Ok(chunk) = decode(&bytes) {
            prop_assert_eq!(chunk.points.len(), count as usize);
        }
    }

    #[test]
    fn every_level_has_at_most_one_point_in_a_cell_and_covers_all_finest_cells(xyz in any_points()) {
        let options = SplitConfig { spacings_m: vec![40.0, 10.0, 2.5], ..SplitConfig::default() };
        let levels = LevelSplitter::new(options).push(&Pose::IDENTITY, &xyz, &[]);
        let cell = |p: [f32; 3], spacing: f32| p.map(|c| (c / spacing).floor() as i32);
        for level in &levels {
            let cells: BTreeSet<_> = level.xyz.iter().map(|p| cell(*p, level.spacing)).collect();
            prop_assert_eq!(cells.len(), level.xyz.len());
        }
        let kept: BTreeSet<_> = levels.iter().flat_map(|l| &l.xyz).map(|p| cell(*p, 2.5)).collect();
        let given: BTreeSet<_> = xyz.iter().map(|p| cell(*p, 2.5)).collect();
        prop_assert_eq!(kept, given);
    }

    #[test]
    fn a_baked_map_covers_its_points_and_adds_none(xyz in any_points()) {
        let options = BakeConfig { finest_spacing_m: 0.5, resolution_m: 0.02, min_node_points: 8 };
        let tiles = bake(&xyz, &[], &options);
        let baked: Vec<[f32; 3]> = tiles.iter().flat_map(|tile| {
            let chunk = decode(&tile.bytes).unwrap();
            assert_eq!(chunk.points.len(), tile.points as usize);
            assert!(chunk.step <= 0.02 && chunk.spacing == tile.spacing && chunk.level == tile.node.level);
            chunk.points.iter().map(|p| chunk.position(p)).collect::<Vec<_>>()
        }).collect();
        prop_assert!(baked.len() <= xyz.len());
        // Half a step on each axis, and f32 at 800 m.
        let bound = 0.01 * 3.0_f32.sqrt() + 3e-4;
        for point in &baked {
            prop_assert!(xyz.iter().any(|p| distance(*p, *point) <= bound));
        }
        let spacing = 0.5 * 3.0_f32.sqrt() + bound;
        for point in &xyz {
            prop_assert!(baked.iter().any(|p| distance(*p, *point) <= spacing));
        }
        let names: BTreeSet<_> = tiles.iter().map(|tile| tile.node).collect();
        prop_assert!(names.iter().all(|n| n.parent().is_none_or(|parent| names.contains(&parent))));
        prop_assert!(tiles.is_sorted_by_key(|tile| tile.node));
    }
}

#[test]
fn a_scan_needs_less_than_three_bytes_for_each_point() {
    let (xyz, intensity) = hall(64_000);
    let bytes = encode_scan(&xyz, &intensity, 0.01);
    assert!(bytes.len() < 64_000 * 3, "{} bytes for 64,000 points", bytes.len());
    let chunk = decode(&bytes).unwrap();
    assert_eq!(sorted(&chunk), sorted(&quantise(&xyz, &intensity, 0.01)));
    assert_eq!((chunk.step, chunk.intensity_unit), (0.01, 1.0));
}

#[test]
fn unusable_points_and_options_cause_no_panic() {
    let xyz = [[f32::NAN, 0.0, 0.0], [1.0, f32::INFINITY, 0.0], [0.0, 0.0, -1e30], [1.0, 2.0, 3.0]];
    for resolution in [0.01, f32::NAN, 0.0, -1.0, f32::INFINITY] {
        let chunk = decode(&encode_scan(&xyz, &[f32::NAN, -3.0], resolution)).unwrap();
        assert_eq!(chunk.points.len(), 1);
        assert_eq!(chunk.position(&chunk.points[0]), [1.0, 2.0, 3.0]);
    }
    assert!(decode(&encode_scan(&[], &[], 0.01)).unwrap().points.is_empty());
    let options = SplitConfig { spacings_m: vec![f32::NAN, 0.0, -1.0, 0.5], ..SplitConfig::default() };
    let levels = LevelSplitter::new(options).push(&Pose::IDENTITY, &xyz, &[]);
    assert_eq!(levels.iter().map(|l| (l.level, l.xyz.len())).collect::<Vec<_>>(), [(3, 1)]);
    assert!(bake(&xyz[..3], &[], &BakeConfig::default()).is_empty());
    assert_eq!(bake(&xyz, &[], &BakeConfig::default()).len(), 1);
}

#[test]
fn a_map_larger_than_the_lattice_gets_a_coarser_lattice() {
    let xyz = [[-1000.0, 0.0, 0.0], [1000.0, 5.0, 5.0]];
    let chunk = quantise(&xyz, &[], 0.01);
    assert_eq!(chunk.step, 0.04);
    let tiles = bake(&[[-1e6, 0.0, 0.0], [1e6, 0.0, 0.0]], &[], &BakeConfig::default());
    assert!(tiles.iter().map(|t| t.points).sum::<u32>() == 2);
}

#[test]
fn a_short_chunk_cannot_allocate_many_points() {
    let same = vec![[1.0_f32; 3]; 1_000_000];
    let stored = encode_scan(&same, &[], 0.01);
    assert_eq!(stored[5], PACKING_STORED);
    assert_eq!(decode(&stored).unwrap().points.len(), 1_000_000);
    let mut absurd = encode_scan(&same[..10], &[], 0.01);
    absurd[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(matches!(decode(&absurd), Err(ChunkDecodeError::TooManyPoints { .. })));
}

#[test]
fn headers_are_checked_field_by_field() {
    let good = encode_scan(&hall(100).0, &[], 0.01);
    let damaged = |at: usize, with: &[u8]| {
        let mut bytes = good.clone();
        bytes[at..at + with.len()].copy_from_slice(with);
        decode(&bytes).unwrap_err()
    };
    assert!(matches!(damaged(0, b"LASF"), ChunkDecodeError::Magic));
    assert!(matches!(damaged(4, &[2]), ChunkDecodeError::Version { found: 2 }));
    assert!(matches!(damaged(5, &[9]), ChunkDecodeError::Packing { found: 9 }));
    assert!(matches!(damaged(12, &[0; 4]), ChunkDecodeError::PayloadLength { announced: 0, .. }));
    assert!(matches!(damaged(16, &f32::NAN.to_le_bytes()), ChunkDecodeError::Lattice));
    assert!(matches!(damaged(28, &f32::MAX.to_le_bytes()), ChunkDecodeError::Lattice));
    assert!(matches!(damaged(32, &0.0_f32.to_le_bytes()), ChunkDecodeError::Lattice));
    assert!(matches!(decode(b"AIPC"), Err(ChunkDecodeError::Short { present: 4 })));
    // Packed bytes that are read as unpacked ones have the wrong length.
    assert!(matches!(damaged(5, &[PACKING_STORED]), ChunkDecodeError::PlaneLength { .. }));
}

#[test]
fn a_keyframe_adds_only_points_that_its_submap_does_not_have() {
    let (xyz, intensity) = hall(20_000);
    let options = SplitConfig { max_submap_keyframes: 3, ..SplitConfig::default() };
    let mut splitter = LevelSplitter::new(options);
    let points = |levels: Vec<LevelPoints>| levels.iter().map(|l| l.xyz.len()).sum::<usize>();
    let first = points(splitter.push(&Pose::IDENTITY, &xyz, &intensity));
    assert!(first > 5_000);
    assert_eq!(points(splitter.push(&Pose::IDENTITY, &xyz, &intensity)), 0);

    // The same hall from a robot that has turned by 90 degrees and moved sideways: (x, y) becomes (y, -x).
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let turned =
        Pose { position: Vec3::new(0.0, 1.0, 0.0), orientation: Quat { w: half, x: 0.0, y: 0.0, z: half } };
    let seen: Vec<[f32; 3]> = xyz.iter().map(|[x, y, z]| [y - 1.0, -x, *z]).collect();
    let again = points(splitter.push(&turned, &seen, &intensity));
    assert!(again < first / 20, "{again} of {first} points were drawn twice");

    // The fourth keyframe starts a new submap, in which all points are new.
    assert_eq!(points(splitter.push(&Pose::IDENTITY, &xyz, &intensity)), first);
}

#[test]
fn level_tiles_contain_their_level_and_spacing() {
    let (xyz, intensity) = hall(5_000);
    let levels = LevelSplitter::new(SplitConfig::default()).push(&Pose::IDENTITY, &xyz, &intensity);
    for level in levels {
        let chunk = decode(&level.encode(0.02)).unwrap();
        assert_eq!((chunk.level, chunk.spacing), (level.level, level.spacing));
        assert_eq!(chunk.points.len(), level.xyz.len());
    }
}

#[test]
fn baking_twice_gives_the_same_bytes() {
    let (xyz, intensity) = hall(30_000);
    let tiles = bake(&xyz, &intensity, &BakeConfig::default());
    assert!(tiles.len() > 1 && tiles[0].node == NodeId::ROOT);
    assert_eq!(tiles, bake(&xyz, &intensity, &BakeConfig::default()));
}
