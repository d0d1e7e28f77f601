//! The floor on which a robot stands, found in one scan.

use geometry::Vector3;

/// Parameters of [`estimate_base_height`]: the floor is the horizontal slice below the base with the most points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FloorDetectionConfig {
    /// Least depth of the floor below the base, metres. Chosen: the base of the lowest legged robots is higher.
    pub min_depth_m: f64,
    /// Greatest depth of the floor below the base, metres: that of a LiDAR carried by hand.
    pub max_depth_m: f64,
    /// Height of a slice, metres. Chosen: the noise of a LiDAR and a floor that is not quite level stay within a slice.
    pub slice_m: f64,
    /// Least horizontal range of the points that count, metres: the robot sees itself and people next to it. Chosen: about twice the radius of the robot's footprint.
    pub min_range_m: f64,
    /// Greatest horizontal range of the points that count, metres. Chosen: farther away, a tilt of a degree moves the floor by more than a slice.
    pub max_range_m: f64,
    /// Least number of points in the slice of the floor. Chosen: fewer may be a table.
    pub min_points: usize,
    /// Least share of the points within range in the slice of the floor. Chosen: a LiDAR that sees a floor has more of it.
    pub min_share: f64,
}

impl Default for FloorDetectionConfig {
    fn default() -> Self {
        Self {
            min_depth_m: 0.15,
            max_depth_m: 2.45,
            slice_m: 0.1,
            min_range_m: 0.8,
            max_range_m: 8.0,
            min_points: 20,
            min_share: 0.05,
        }
    }
}

/// Height of the base over the floor that a scan shows, metres; none if it shows none. The floor is where most points below the base are.
/// `levelled` are the scan's points relative to the base, z up, metres. Linear in the points.
pub fn estimate_base_height(
    levelled: impl IntoIterator<Item = Vector3>,
    config: &FloorDetectionConfig,
) -> Option<f64> {
    let near =
        levelled.into_iter().filter(|at| (config.min_range_m..=config.max_range_m).contains(&at.xy().norm()));
    let mut near_count = 0_usize;
    let mut slices = vec![0_usize; ((config.max_depth_m - config.min_depth_m) / config.slice_m) as usize + 1];
    let mut depths = Vec::new();
    for at in near {
        near_count += 1;
        let slice = (-at.z - config.min_depth_m) / config.slice_m;
        if slice >= 0.0 && (slice as usize) < slices.len() {
            slices[slice as usize] += 1;
            depths.push(-at.z);
        }
    }
    let fullest = (0..slices.len()).rev().max_by_key(|slice| slices[*slice])?;
    if slices[fullest] < config.min_points || (slices[fullest] as f64) < config.min_share * near_count as f64
    {
        return None;
    }
    // A floor may lie on the border of two slices, so its mean is taken over twice the height of one.
    let middle = config.min_depth_m + (fullest as f64 + 0.5) * config.slice_m;
    depths.retain(|depth| (depth - middle).abs() <= config.slice_m);
    Some(depths.iter().sum::<f64>() / depths.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Rotation, so3};

    fn base_height(points: &[[f32; 3]], level_from_base: &Rotation) -> Option<f64> {
        let levelled = points.iter().map(|point| level_from_base * Vector3::from(point.map(f64::from)));
        estimate_base_height(levelled, &FloorDetectionConfig::default())
    }

    /// A floor this far below the base, a table over a part of it, and a wall.
    fn room(depth_m: f32) -> Vec<[f32; 3]> {
        let grid = |from: i32, to: i32| (from..to).flat_map(move |x| (from..to).map(move |y| [x, y]));
        let mut points: Vec<[f32; 3]> =
            grid(-20, 20).map(|[x, y]| [0.2 * x as f32, 0.2 * y as f32, -depth_m]).collect();
        points.extend(grid(8, 14).map(|[x, y]| [0.2 * x as f32, 0.2 * y as f32, 0.75 - depth_m]));
        points.extend(grid(0, 25).map(|[y, z]| [4.0, 0.1 * y as f32, 0.1 * z as f32 - depth_m]));
        points
    }

    #[test]
    fn the_floor_is_found_at_any_height_and_tilt_of_the_base() {
        for depth_m in [0.3_f32, 0.55, 1.4] {
            let Some(found) = base_height(&room(depth_m), &Rotation::identity()) else {
                panic!("the floor is there")
            };
            assert!((found - f64::from(depth_m)).abs() < 0.05, "{found} of {depth_m}");
            let turn = so3::exp(&Vector3::new(0.3, -0.2, 1.0));
            let tilted: Vec<[f32; 3]> = room(depth_m)
                .iter()
                .map(|point| (turn.inverse() * Vector3::from(point.map(f64::from))).map(|c| c as f32).into())
                .collect();
            let Some(again) = base_height(&tilted, &turn) else { panic!("the floor is there") };
            assert!((again - found).abs() < 1e-3, "{again} {found}");
        }
        assert_eq!(base_height(&[], &Rotation::identity()), None);
        let wall: Vec<[f32; 3]> = (0..200).map(|i| [4.0, 0.02 * i as f32, 0.01 * i as f32]).collect();
        assert_eq!(base_height(&wall, &Rotation::identity()), None);
    }
}
