//! Compares the fast structures of this crate with slow and simple implementations, on random inputs.
#![allow(clippy::unwrap_used, reason = "a test stops at what it did not expect")]

use geometry::{Matrix3, RngTree, Vector3, so3};
use nalgebra::SymmetricEigen;
use points::hash::{CellKey, CellTable};
use points::symmetric::principal_axes;
use points::{Downsampler, FreeSpaceImage, GaussianMap, GaussianMapConfig, Occupancy, RangeImage, Surface};
use proptest::prelude::*;
use std::collections::BTreeMap;

fn direction() -> impl Strategy<Value = Vector3> {
    [-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64]
        .prop_map(Vector3::from)
        .prop_filter("no direction", |v| v.norm() > 0.1)
        .prop_map(|v| v.normalize())
}

/// An operation on a table of cells.
#[derive(Clone, Copy, Debug)]
enum Operation {
    Insert([i64; 3], u32),
    Remove([i64; 3]),
    Get([i64; 3]),
}

fn operation() -> impl Strategy<Value = Operation> {
    // There are few cells, so that the same one occurs often. One in 21 lies far away.
    let cell = || prop_oneof![20 => [-4..4_i64, -4..4_i64, -4..4_i64], 1 => [-2_000_000..2_000_000_i64, 0..1_i64, 0..1_i64]];
    prop_oneof![
        (cell(), any::<u32>()).prop_map(|(cell, value)| Operation::Insert(cell, value)),
        cell().prop_map(Operation::Remove),
        cell().prop_map(Operation::Get),
    ]
}

/// Number of columns and rows of a range image, and their size in radians, as in its format.
const COLUMNS: i32 = 180;
const ROWS: i32 = 32;
const COLUMN_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;
const ROW_RAD: f64 = 3.0 * std::f64::consts::PI / 180.0;

/// A point of known cell and range about the origin.
#[derive(Clone, Copy, Debug)]
struct Ray {
    column: i32,
    row: i32,
    range_m: f64,
    xyz: [f32; 3],
}

fn ray(columns: std::ops::Range<i32>, rows: std::ops::Range<i32>) -> impl Strategy<Value = Ray> {
    (columns, rows, 0.1..0.9_f64, 0.1..0.9_f64, 0.5..40.0_f64).prop_map(|(column, row, u, v, range_m)| {
        let azimuth = -std::f64::consts::PI + (f64::from(column) + u) * COLUMN_RAD;
        let elevation = -48.0_f64.to_radians() + (f64::from(row) + v) * ROW_RAD;
        let horizontal = range_m * elevation.cos();
        let xyz = [horizontal * azimuth.cos(), horizontal * azimuth.sin(), range_m * elevation.sin()];
        Ray { column: column.rem_euclid(COLUMNS), row, range_m, xyz: xyz.map(|c| c as f32) }
    })
}

/// Ranges of the rays in the nine cells about a query's. `None` if its own cell has no ray.
fn ranges_about(rays: &[Ray], query: &Ray) -> Option<Vec<f64>> {
    let is_in_own = |ray: &Ray| (ray.column, ray.row) == (query.column, query.row);
    // The image stores only the nearest range of each cell. So the farthest of these ranges is an upper bound of the image's.
    rays.iter().any(is_in_own).then(|| ranges_of_cells_about(rays, query))
}

/// Ranges of the rays in the nine cells about a query's.
fn ranges_of_cells_about(rays: &[Ray], query: &Ray) -> Vec<f64> {
    let is_near = |ray: &&Ray| {
        let around = (ray.column - query.column).rem_euclid(COLUMNS);
        around.min(COLUMNS - around) <= 1 && (ray.row - query.row).abs() <= 1
    };
    rays.iter().filter(is_near).map(|ray| ray.range_m).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_table_behaves_as_an_ordered_map(operations in prop::collection::vec(operation(), 1..600)) {
        let (mut table, mut twin) = (CellTable::with_capacity(8), BTreeMap::new());
        for operation in operations {
            match operation {
                Operation::Insert(cell, value) => {
                    let key = CellKey::new(cell);
                    let is_new = !twin.contains_key(&key);
                    prop_assert_eq!(table.get_or_insert(key, value), (*twin.entry(key).or_insert(value), is_new));
                }
                Operation::Remove(cell) => {
                    prop_assert_eq!(table.remove(CellKey::new(cell)), twin.remove(&CellKey::new(cell)));
                }
                Operation::Get(cell) => {
                    prop_assert_eq!(table.get(CellKey::new(cell)), twin.get(&CellKey::new(cell)).copied());
                }
            }
            prop_assert_eq!(table.len(), twin.len());
        }
        for (key, value) in twin {
            prop_assert_eq!(table.get(key), Some(value));
        }
    }

    #[test]
    fn centroids_are_the_means_of_the_voxels(seed in any::<u64>(), voxel_m in 0.1..2.0_f32, count in 0..3_000_usize) {
        let mut rng = RngTree::new(seed).rng();
        let xyz: Vec<[f32; 3]> =
            (0..count).map(|_| std::array::from_fn(|_| (rng.normal() * 4.0) as f32)).collect();
        let attributes: Vec<f32> = xyz.iter().map(|p| p[2] * 0.5).collect();
        let mut centroids = Vec::new();
        Downsampler::default().downsample(&xyz, &attributes, voxel_m, &mut centroids);

        let mut order = Vec::new();
        let mut twin: BTreeMap<[i64; 3], Vec<usize>> = BTreeMap::new();
        for (index, point) in xyz.iter().enumerate() {
            let voxel = point.map(|c| (c * (1.0 / voxel_m)).floor() as i64);
            if !twin.contains_key(&voxel) {
                order.push(voxel);
            }
            twin.entry(voxel).or_default().push(index);
        }
        prop_assert_eq!(centroids.len(), order.len());
        for (centroid, voxel) in centroids.iter().zip(order) {
            let members = &twin[&voxel];
            prop_assert_eq!(members.len(), centroid.count as usize);
            let mean = |value: &dyn Fn(usize) -> f32| {
                members.iter().map(|&index| f64::from(value(index))).sum::<f64>() / members.len() as f64
            };
            for axis in 0..3 {
                prop_assert!((mean(&|index| xyz[index][axis]) - f64::from(centroid.xyz[axis])).abs() < 1e-4);
            }
            prop_assert!((mean(&|index| attributes[index]) - f64::from(centroid.attribute)).abs() < 1e-4);
        }
    }

    #[test]
    fn the_closed_form_eigenvalues_are_those_of_the_iterative_decomposition(
        axis in direction(), angle in 0.0..3.0_f64,
        smallest in 0.0..1e-3_f64, gap in 1e-3..0.1_f64, rest in 0.0..0.3_f64,
    ) {
        let rotation = so3::exp(&(axis * angle)).to_rotation_matrix().into_inner();
        let diagonal = Vector3::new(smallest, smallest + gap, smallest + gap + rest);
        let matrix = rotation * Matrix3::from_diagonal(&diagonal) * rotation.transpose();
        let packed = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|(i, j)| matrix[(i, j)] as f32);
        let axes = principal_axes(&packed).unwrap();
        let eigen = SymmetricEigen::new(matrix);
        let mut values: Vec<f64> = eigen.eigenvalues.iter().copied().collect();
        values.sort_by(f64::total_cmp);
        for (found, value) in axes.variances.iter().zip(values) {
            prop_assert!((f64::from(*found) - value).abs() < 1e-6);
        }
        let normal = Vector3::from(axes.normal.map(f64::from));
        prop_assert!((normal.norm() - 1.0).abs() < 1e-6);
        prop_assert!(normal.dot(&rotation.column(0).into_owned()).abs() > 1.0 - 1e-4);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    /// Without planes and children, every cube must hold the batch mean and covariance of its points.
    #[test]
    fn every_cube_has_the_statistics_of_an_ordered_map_of_points(seed in any::<u64>(), count in 100..4_000_usize) {
        let config = GaussianMapConfig { max_depth: 0, plane_thickness_m: 0.0,
            min_distribution_width_share: 0.0, max_points: 5_000, ..GaussianMapConfig::default() };
        let (mut map, mut twin) = (GaussianMap::new(config), BTreeMap::<[i64; 3], Vec<Vector3>>::new());
        let mut rng = RngTree::new(seed).rng();
        for _ in 0..count {
            let point = [rng.range(-4.0, 4.0), rng.range(-4.0, 4.0), rng.range(-1.0, 2.0)];
            map.insert(&point);
            twin.entry(config.root_cell(&point)).or_default().push(point.into());
        }
        prop_assert_eq!(map.len(), twin.len());
        for points in twin.values().filter(|points| points.len() >= usize::from(config.min_points)) {
            let mean = points.iter().sum::<Vector3>() / points.len() as f64;
            let covariance: Matrix3 =
                points.iter().map(|p| (p - mean) * (p - mean).transpose()).sum::<Matrix3>() / points.len() as f64;
            let query = points[0];
            let Some(Surface::Distribution { offset, covariance: found }) = map.find_surface(query.as_ref(), 0.0)
            else {
                return Err(TestCaseError::fail(format!("no distribution of {} points", points.len())));
            };
            prop_assert!((Vector3::from(offset.map(f64::from)) - (query - mean)).norm() < 1e-4);
            for (index, (row, column)) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().enumerate() {
                prop_assert!((f64::from(found[index]) - covariance[(row, column)]).abs() < 1e-4);
            }
        }
    }

    /// A plane of any orientation must be found with the right distance, normal and variance.
    #[test]
    fn a_plane_of_any_orientation_is_found(seed in any::<u64>(), normal in direction(), offset in -3.0..3.0_f64) {
        let mut rng = RngTree::new(seed).rng();
        let mut map = GaussianMap::new(GaussianMapConfig::default());
        let along = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
        let across = normal.cross(&along);
        let noise_m = 0.008;
        let mut point = |extent_m: f64, height_m: f64| {
            along * rng.range(-extent_m, extent_m) + across * rng.range(-extent_m, extent_m)
                + normal * (offset + height_m + noise_m * if height_m == 0.0 { rng.normal() } else { 0.0 })
        };
        for _ in 0..20_000 {
            map.insert(point(3.0, 0.0).as_ref());
        }
        let mut good = 0;
        for index in 0..200 {
            let height_m = (f64::from(index) - 99.5) * 8e-4;
            let query = point(2.5, height_m);
            if let Some(Surface::Plane { normal: found, distance, variance }) = map.find_surface(query.as_ref(), 0.1) {
                let found = Vector3::from(found.map(f64::from));
                let signed = f64::from(distance) * found.dot(&normal).signum();
                good += usize::from(
                    (signed - height_m).abs() < 0.006
                        && found.dot(&normal).abs() > 0.999
                        && f64::from(variance).sqrt() < 1.5 * noise_m,
                );
            }
        }
        // Cut corners of cubes may hold too few points, so 180 of 200 queries must succeed.
        prop_assert!(good >= 180, "{good} of 200");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Compares the image with a search through all rays, at the seam between the last column and the first. The image stores whole centimetres,
    /// so nothing is asserted within 2 cm of a threshold.
    #[test]
    fn the_free_space_check_agrees_with_a_search_through_all_rays(
        rays in prop::collection::vec(ray(177..183, 3..9), 1..60), query in ray(177..183, 3..9),
    ) {
        let image = RangeImage::new(rays.iter().map(|ray| &ray.xyz), [0.0; 3]);
        let found = image.classify(&query.xyz);
        let Some(ranges) = ranges_about(&rays, &query) else {
            prop_assert_eq!(found, Occupancy::Unobserved);
            prop_assert!(!image.observes(&query.xyz));
            return Ok(());
        };
        let nearest = ranges.iter().copied().fold(f64::INFINITY, f64::min);
        let farthest = ranges.iter().copied().fold(0.0, f64::max);
        let margin = 0.3 + 0.05 * query.range_m;
        if query.range_m < nearest - margin - 0.02 {
            prop_assert_eq!(found, Occupancy::Free);
        } else if (nearest - margin + 0.02..nearest + margin - 0.02).contains(&query.range_m) {
            prop_assert_eq!(found, Occupancy::Occupied);
            prop_assert!(image.observes(&query.xyz));
        } else if query.range_m > nearest + margin + 0.02 {
            prop_assert_eq!(found, Occupancy::Occluded);
        }
        if query.range_m < nearest - margin - 0.02 || query.range_m > farthest + margin + 0.02 {
            prop_assert!(!image.observes(&query.xyz));
        }
    }

    /// Compares the image with a search through all rays; those with an even number end on the ground.
    #[test]
    fn the_ground_hides_nothing_and_shows_how_long_rays_are(
        rays in prop::collection::vec(ray(177..183, 3..9), 1..60), query in ray(177..183, 3..9),
    ) {
        let is_ground = |xyz: &[f32; 3]| rays.iter().position(|ray| ray.xyz == *xyz).is_some_and(|index| index % 2 == 0);
        let image = FreeSpaceImage::new(rays.iter().map(|ray| &ray.xyz), [0.0; 3], is_ground);
        let found = image.classify(&query.xyz);
        let own = |row: i32| {
            let of_cell = rays.iter().filter(move |ray| (ray.column, ray.row) == (query.column, row));
            of_cell.map(|ray| ray.range_m).reduce(f64::max)
        };
        let (Some(_), Some(own_m), Some(_)) = (own(query.row - 1), own(query.row), own(query.row + 1)) else {
            prop_assert_eq!(found, Occupancy::Unobserved);
            return Ok(());
        };
        let objects: Vec<_> = rays.iter().filter(|ray| !is_ground(&ray.xyz)).cloned().collect();
        let nearest_m = ranges_of_cells_about(&objects, &query).into_iter().fold(f64::INFINITY, f64::min);
        let margin_m = 0.3 + 0.05 * query.range_m;
        let (range_m, slack_m) = (query.range_m, 0.02);
        if range_m > nearest_m + margin_m + slack_m {
            prop_assert_eq!(found, Occupancy::Occluded);
        } else if range_m < nearest_m - margin_m - slack_m {
            if range_m < own_m - margin_m - slack_m {
                prop_assert_eq!(found, Occupancy::Free);
            } else if range_m > own_m - margin_m + slack_m {
                prop_assert_eq!(found, Occupancy::Occluded);
            }
        } else if (nearest_m - margin_m + slack_m..nearest_m + margin_m - slack_m).contains(&range_m) {
            prop_assert_eq!(found, Occupancy::Occupied);
        }
    }

    #[test]
    fn points_above_the_top_row_are_unobserved(rays in prop::collection::vec(ray(178..182, 28..36), 1..40)) {
        let image = RangeImage::new(rays.iter().map(|ray| &ray.xyz), [0.0; 3]);
        for ray in &rays {
            let found = image.classify(&ray.xyz);
            if ray.row < ROWS {
                prop_assert!(found == Occupancy::Occupied || found == Occupancy::Occluded, "{:?}", found);
            } else {
                prop_assert_eq!(found, Occupancy::Unobserved);
            }
        }
    }
}
