//! Which points of a scan are worth keeping.

use vocab::Aabb;

/// Keeps the indices of the points between two distances from the origin (metres) that lie outside `hidden`, the box
/// the robot's own body fills. Points that are not finite are dropped.
pub fn in_range(xyz: &[[f32; 3]], min: f32, max: f32, hidden: Option<&Aabb>, out: &mut Vec<u32>) {
    let (min, max) = (min * min, max * max);
    for (index, point) in xyz.iter().enumerate() {
        let squared = norm_squared(point);
        // A NaN fails both comparisons.
        if squared >= min && squared <= max && !hidden.is_some_and(|aabb| contains(aabb, point)) {
            out.push(index as u32);
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
    fn near_far_hidden_and_broken_points_go() {
        let points =
            [[0.1, 0.0, 0.0], [2.0, 0.0, 0.0], [200.0, 0.0, 0.0], [f32::NAN, 1.0, 1.0], [0.0, 3.0, 0.0]];
        let hidden = Aabb { min: [-1.0, 2.5, -1.0], max: [1.0, 3.5, 1.0] };
        let mut kept = Vec::new();
        in_range(&points, 0.5, 100.0, Some(&hidden), &mut kept);
        assert_eq!(kept, [1]);
        kept.clear();
        in_range(&points, 0.5, 100.0, None, &mut kept);
        assert_eq!(kept, [1, 4]);
    }
}
