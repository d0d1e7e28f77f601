//! Compares the map with batch statistics and with known planes.

use super::*;
use geometry::{RngTree, Vector3};

fn wall(seed: u64, n: usize, noise: f64) -> Vec<[f64; 3]> {
    let mut rng = RngTree::new(seed).child("wall").rng();
    (0..n).map(|_| [3.0 + noise * rng.normal(), rng.range(-4.0, 4.0), rng.range(0.0, 3.0)]).collect()
}

#[test]
fn a_wall_is_found_at_its_distance_with_its_normal() {
    let mut map = GaussianMap::new(GaussianMapConfig::default());
    for point in wall(1, 20_000, 0.01) {
        map.insert(&point);
    }
    for y in [-3.1, -0.4, 2.2] {
        for off in [-0.2, 0.0, 0.15] {
            let Some(Surface::Plane { normal, distance, variance }) =
                map.find_surface(&[3.0 + off, y, 1.7], 0.1)
            else {
                panic!("no plane at {y}")
            };
            let signed = distance * normal[0].signum();
            assert!((f64::from(signed) - off).abs() < 0.003, "{signed} {off}");
            assert!(
                normal[0].abs() > 0.999 && (variance.sqrt() - 0.01).abs() < 0.003,
                "{normal:?} {variance}"
            );
        }
    }
}

#[test]
fn the_two_sides_of_a_thin_partition_are_separate_surfaces() {
    let mut map = GaussianMap::new(GaussianMapConfig::default());
    for point in wall(2, 20_000, 0.01) {
        map.insert(&point);
    }
    for mut point in wall(3, 20_000, 0.01) {
        point[0] += 0.15;
        map.insert(&point);
    }
    let mut found = 0;
    for y in [-3.1, -2.2, -0.4, 0.9, 2.2, 3.3] {
        for (x, z) in [(3.0, 1.2), (3.15, 1.2), (3.0, 2.2), (3.15, 2.2)] {
            if let Some(Surface::Plane { distance, .. }) = map.find_surface(&[x, y, z], 0.05) {
                found += usize::from(distance.abs() < 0.005);
            }
        }
    }
    assert!(found >= 20, "{found} of 24");
}

/// A board of 60 x 60 cm stands 6 cm before a wall. Its points are within the gate of the wall's plane, but belong to its own.
#[test]
fn a_surface_before_a_plane_is_not_taken_for_that_plane() {
    let mut map = GaussianMap::new(GaussianMapConfig::default());
    for point in wall(11, 20_000, 0.005) {
        map.insert(&point);
    }
    let mut rng = RngTree::new(12).child("board").rng();
    for _ in 0..4_000 {
        map.insert(&[3.0 - 0.06 + 0.005 * rng.normal(), rng.range(0.4, 1.0), rng.range(1.0, 1.6)]);
    }
    for (y, z) in [(0.5, 1.1), (0.7, 1.3), (0.9, 1.5)] {
        for (x, surface) in [(2.94, "board"), (3.0, "wall")] {
            let found = map.find_surface(&[x, y, z], 0.1);
            let Some(Surface::Plane { distance, .. }) = found else { panic!("{surface}: {found:?}") };
            assert!(distance.abs() < 0.005, "{surface} at {y}, {z}: {distance}");
        }
    }
}

#[test]
fn a_person_walking_past_does_not_move_the_wall() {
    let mut map = GaussianMap::new(GaussianMapConfig::default());
    for point in wall(4, 8_000, 0.01) {
        map.insert(&point);
    }
    let mut rng = RngTree::new(9).child("person").rng();
    for _ in 0..20_000 {
        map.insert(&[2.6 + 0.1 * rng.normal(), 0.3 * rng.normal(), rng.range(0.0, 1.8)]);
    }
    let Some(Surface::Plane { distance, .. }) = map.find_surface(&[3.0, 0.0, 1.0], 0.1) else {
        panic!("wall gone")
    };
    assert!(distance.abs() < 0.005, "{distance}");
}

/// Mean and covariance of a distribution agree with the two-pass formulas.
#[test]
fn a_distribution_has_the_batch_mean_and_covariance() {
    let mut rng = RngTree::new(6).child("bush").rng();
    let config = GaussianMapConfig { max_depth: 0, max_points: 2_000, ..GaussianMapConfig::default() };
    let mut map = GaussianMap::new(config);
    // All points lie in one root cube. The grid is shifted by `grid_offset_m`.
    let centre = Vector3::from([1.0; 3]) - Vector3::from(config.grid_offset_m);
    let points: Vec<Vector3> = (0..1_500)
        .map(|_| centre + Vector3::from_fn(|_, _| rng.normal() * 0.2).map(|c| c.clamp(-0.9, 0.9)))
        .collect();
    for point in &points {
        map.insert(&[point.x, point.y, point.z]);
    }
    let mean = points.iter().sum::<Vector3>() / points.len() as f64;
    let query = centre + Vector3::new(0.1, -0.2, 0.3);
    let Some(Surface::Distribution { offset, covariance }) =
        map.find_surface(&[query.x, query.y, query.z], 0.1)
    else {
        panic!("no cell")
    };
    assert!((Vector3::from(offset.map(f64::from)) - (query - mean)).norm() < 1e-5);
    let mut index = 0;
    for row in 0..3 {
        for column in row..3 {
            let batch = points.iter().map(|p| (p[row] - mean[row]) * (p[column] - mean[column])).sum::<f64>()
                / points.len() as f64;
            assert!((f64::from(covariance[index]) - batch).abs() < 1e-5);
            index += 1;
        }
    }
}

#[test]
fn removed_cubes_return_no_surface_and_their_memory_is_reused() {
    let mut map = GaussianMap::new(GaussianMapConfig::default());
    let mut bytes = 0;
    for lap in 0..6 {
        let at = f64::from(lap) * 200.0;
        for mut point in wall(7, 10_000, 0.3) {
            point[0] += at;
            map.insert(&point);
        }
        map.retain_within(&[at, 0.0, 0.0], 50.0);
        assert!(map.find_surface(&[at - 197.0, 0.0, 1.0], 0.1).is_none());
        assert!(map.find_surface(&[at + 3.0, 0.0, 1.0], 0.1).is_some());
        if lap == 1 {
            bytes = map.bytes();
        }
    }
    assert_eq!(map.bytes(), bytes, "memory grew");
}

#[test]
fn equal_points_give_equal_bits() {
    let build = || {
        let mut map = GaussianMap::new(GaussianMapConfig::default());
        for point in wall(8, 5_000, 0.02) {
            map.insert(&point);
        }
        map.surfels()
    };
    assert_eq!(build(), build());
}

#[test]
fn the_viewpoint_selects_the_side_of_a_thin_wall() {
    let (inside, outside) = ([-3.0, 0.0, 1.0], [3.0, 0.0, 1.0]);
    let mut map = GaussianMap::new(GaussianMapConfig { min_points: 6, ..GaussianMapConfig::default() });
    for (from, wall) in [(inside, 0.0), (outside, 0.2)] {
        for y in -10..=10_i8 {
            for z in 0..=20_u8 {
                map.insert_from_viewpoint(&[wall, 0.1 * f64::from(y), 0.1 * f64::from(z)], &from);
            }
        }
    }
    for (from, wall, other) in [(inside, 0.0, 0.2), (outside, 0.2, 0.0)] {
        for y in -8..=8_i8 {
            let at = |x: f64| [x, 0.1 * f64::from(y) + 0.03, 1.04];
            let distance = |x: f64| match map.find_surface_facing(&at(x), &from, 0.1) {
                Some(Surface::Plane { distance, .. }) => distance.abs(),
                _ => f32::INFINITY,
            };
            assert!(distance(wall) < 0.02, "{y}: {}", distance(wall));
            assert!(distance(other) > 0.15, "{y}: its other side is 0.2 m away: {}", distance(other));
        }
    }
}

/// Share of the places on the treads of a stair at which the upper face is found within a centimetre from above, after the lower faces were seen
/// first.
fn found_upper_faces(other_side_depth: u8) -> f64 {
    let mut map = GaussianMap::new(GaussianMapConfig { other_side_depth, ..GaussianMapConfig::default() });
    let treads = (0..8_u8).map(|step| (0.29 * f64::from(step), 0.17 * f64::from(step)));
    let points = |along: f64, height: f64| {
        (0..15_u8).flat_map(move |x| {
            (0..60_u8).map(move |y| [along + 0.02 * f64::from(x), 0.02 * f64::from(y), height])
        })
    };
    for (below, face) in [(-2.0, -0.05), (2.0, 0.0)] {
        for (along, height) in treads.clone() {
            for point in points(along, height + face) {
                map.insert_from_viewpoint(&point, &[along - 1.0, 0.6, height + below]);
            }
        }
    }
    let (mut found, mut all) = (0, 0);
    for (along, height) in treads {
        for point in points(along, height).step_by(7) {
            let surface = map.find_surface_facing(&point, &[along - 1.0, 0.6, height + 2.0], 0.1);
            all += 1;
            found += usize::from(
                matches!(surface, Some(Surface::Plane { distance, .. }) if distance.abs() < 0.01),
            );
        }
    }
    found as f64 / f64::from(all)
}

#[test]
fn both_faces_of_a_tread_are_found_although_the_lower_one_was_seen_first() {
    let (with, without) = (found_upper_faces(1), found_upper_faces(0));
    assert!(with > 0.7 && with > without + 0.5, "{with} of the upper faces, {without} without another level");
}
