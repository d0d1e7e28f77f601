//! Selection of the usable points of a scan.

use vocab::Aabb;

/// Appends to `kept` the indices of the points whose distance from the origin lies between two ranges (metres, borders included).
/// Points that are not finite are dropped.
pub fn select_in_range(xyz: &[[f32; 3]], min_range_m: f32, max_range_m: f32, kept: &mut Vec<u32>) {
    let (min_squared, max_squared) = (min_range_m * min_range_m, max_range_m * max_range_m);
    for (index, point) in xyz.iter().enumerate() {
        let squared = norm_squared(point);
        // NaN fails both comparisons.
        if squared >= min_squared && squared <= max_squared {
            kept.push(index as u32);
        }
    }
}

/// Whether a point lies in a box, borders included.
#[inline]
pub fn contains(aabb: &Aabb, point: &[f32; 3]) -> bool {
    (0..3).all(|axis| point[axis] >= aabb.min[axis] && point[axis] <= aabb.max[axis])
}

/// Squared distance from the origin, square metres.
#[inline]
pub fn norm_squared(point: &[f32; 3]) -> f32 {
    point[0] * point[0] + point[1] * point[1] + point[2] * point[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_too_near_too_far_or_not_finite_are_dropped() {
        let points =
            [[0.1, 0.0, 0.0], [2.0, 0.0, 0.0], [200.0, 0.0, 0.0], [f32::NAN, 1.0, 1.0], [0.0, 3.0, 0.0]];
        let mut kept = Vec::new();
        select_in_range(&points, 0.5, 100.0, &mut kept);
        assert_eq!(kept, [1, 4]);
    }

    #[test]
    fn a_box_contains_its_borders() {
        let aabb = Aabb { min: [-1.0, 2.5, -1.0], max: [1.0, 3.5, 1.0] };
        assert!(contains(&aabb, &[0.0, 3.0, 0.0]) && contains(&aabb, &[1.0, 2.5, -1.0]));
        assert!(!contains(&aabb, &[0.0, 2.0, 0.0]) && !contains(&aabb, &[0.0, f32::NAN, 0.0]));
    }
}
