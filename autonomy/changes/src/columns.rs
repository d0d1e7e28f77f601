//! Points sorted by the upright columns that they are in, so that those near a box are found without looking at all.

use crate::UprightBox;

/// Side of a column, metres. Chosen: about the size of an object with what is around it.
const SIDE_M: f64 = 1.0;

/// Points in columns.
pub(crate) struct Columns {
    /// Sorted by column.
    points: Vec<([i32; 2], [f32; 3])>,
}

impl Columns {
    /// `O(n log n)`. The order of the points of a column stays.
    pub(crate) fn new(points: impl IntoIterator<Item = [f32; 3]>) -> Self {
        let of_point = |point: [f32; 3]| ([column(point[0].into()), column(point[1].into())], point);
        let mut points: Vec<_> = points.into_iter().map(of_point).collect();
        points.sort_by_key(|(column, _)| *column);
        Self { points }
    }

    /// All points whose horizontal distance from the sides of a box is at most `margin_m` metres, and some others. Linear in the columns and the points there.
    pub(crate) fn around(&self, place: &UprightBox, margin_m: f64) -> impl Iterator<Item = &[f32; 3]> {
        let reach_m = place.size_m[0].hypot(place.size_m[1]) / 2.0 + margin_m;
        let [x, y] = [place.centre_m.x, place.centre_m.y]
            .map(|middle_m| (column(middle_m - reach_m), column(middle_m + reach_m)));
        (x.0..=x.1).flat_map(move |x| {
            // The columns of one x stand one after the other.
            let first = self.points.partition_point(|(column, _)| *column < [x, y.0]);
            let rest = &self.points[first..];
            rest.iter().take_while(move |(column, _)| *column <= [x, y.1]).map(|(_, point)| point)
        })
    }
}

fn column(at_m: f64) -> i32 {
    (at_m / SIDE_M).floor() as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Vector3;

    #[test]
    fn all_points_near_a_box_are_found_and_few_of_the_others() {
        let points = (-40..40).flat_map(|x| (-40..40).map(move |y| [x as f32 * 0.25, y as f32 * 0.25, 0.0]));
        let points: Vec<[f32; 3]> = points.collect();
        let columns = Columns::new(points.iter().copied());
        let place =
            UprightBox { centre_m: Vector3::new(-0.7, 3.1, 0.2), size_m: [1.5, 0.4, 0.5], yaw_rad: 0.8 };
        let is_near = |point: &&[f32; 3]| place.holds(&Vector3::from(point.map(f64::from)), 0.3);
        let found = columns.around(&place, 0.3).filter(is_near).count();
        assert_eq!(found, points.iter().filter(is_near).count());
        assert!(found > 0 && columns.around(&place, 0.3).count() < 300);
    }
}
