//! What the rays of one scan passed through, where the ground does not hide what stands on it.
//!
//! Seen from a robot, rays that end on the ground are neighbours of rays that pass just above it. In a [`RangeImage`] the ground therefore hides everything that is low and
//! some metres away, because a cell and those about it span nine degrees. Here the ground hides nothing, and only what stands does.

use crate::range_image::{Occupancy, RangeImage};

/// The nearest objects and the ends of the farthest rays about a sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeSpaceImage {
    /// The nearest return of an object in each cell.
    objects: RangeImage,
    /// The farthest return in each cell, of the ground too.
    farthest: RangeImage,
}

impl FreeSpaceImage {
    /// The image of a motion-corrected cloud (base frame, metres) seen from `sensor` (base frame, metres). `is_ground`: whether a point is of the ground. Points that are not
    /// finite or outside the image are skipped. Linear in the points.
    pub fn new<'a>(
        points: impl Iterator<Item = &'a [f32; 3]> + Clone,
        sensor: [f32; 3],
        is_ground: impl Fn(&[f32; 3]) -> bool,
    ) -> Self {
        let objects = RangeImage::new(points.clone().filter(|point| !is_ground(point)), sensor);
        Self { objects, farthest: RangeImage::of_farthest(points, sensor) }
    }

    /// Classifies a point (base frame, metres). [`Occupancy::Free`]: a ray of its own cell ended behind it, on ground or an object, and no object is before it or near it.
    /// [`Occupancy::Unobserved`] also at the upper and lower edge of the field of view: inside it, rays passed above and below the point, so that an object thicker than the
    /// distance between two rays would have been hit.
    pub fn classify(&self, point: &[f32; 3]) -> Occupancy {
        let Some((column, row, range_m)) = self.farthest.project(point) else { return Occupancy::Unobserved };
        let below = row.checked_sub(1).and_then(|below| self.farthest.range_at(column, below));
        let own = self.farthest.range_at(column, row);
        let (Some(_), Some(own_m), Some(_)) = (below, own, self.farthest.range_at(column, row + 1)) else {
            return Occupancy::Unobserved;
        };
        let margin_m = self.farthest.margin_m(range_m);
        let nearest_m =
            self.objects.ranges_about(column, row).map_or(f32::INFINITY, |(nearest_m, _)| nearest_m);
        if range_m > nearest_m + margin_m {
            Occupancy::Occluded
        } else if range_m >= nearest_m - margin_m {
            Occupancy::Occupied
        } else if range_m < own_m - margin_m {
            Occupancy::Free
        } else {
            // All rays of the cell ended on the ground before the point.
            Occupancy::Occluded
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SENSOR: [f32; 3] = [0.0, 0.0, 0.75];
    const BOX_M: f32 = 5.0;

    /// A floor, a wall 9 m ahead, and at the sides boxes of this height 5 m ahead. Beams are a degree apart.
    fn scan(box_height_m: f32) -> Vec<[f32; 3]> {
        let mut points = Vec::new();
        for degrees in -60..60_i8 {
            for beam in -16..=15_i8 {
                let (up, flat) = f32::from(beam).to_radians().sin_cos();
                let (y, x) = f32::from(degrees).to_radians().sin_cos();
                let is_box = degrees.abs() > 5;
                let slope = up / flat;
                let floor_m = if slope < 0.0 { -SENSOR[2] / slope } else { f32::INFINITY };
                let is_hit = is_box && floor_m > BOX_M && SENSOR[2] + BOX_M * slope < box_height_m;
                let range_m = if is_hit { BOX_M } else { floor_m.min(9.0) };
                points.push([range_m * x, range_m * y, SENSOR[2] + range_m * slope]);
            }
        }
        points
    }

    fn is_floor(point: &[f32; 3]) -> bool {
        point[2] < 0.1
    }

    #[test]
    fn the_floor_before_a_low_thing_does_not_hide_it_and_a_box_does() {
        let points = scan(0.5);
        let image = FreeSpaceImage::new(points.iter(), SENSOR, is_floor);
        let plain = RangeImage::new(&points, SENSOR);
        for height_m in [0.3, 0.4] {
            let low = [BOX_M, 0.0, height_m];
            assert_eq!(image.classify(&low), Occupancy::Free, "{height_m}");
            assert_ne!(plain.classify(&low), Occupancy::Free, "{height_m}: else the image is not needed");
            let (y, x) = 30.0_f32.to_radians().sin_cos();
            assert_eq!(image.classify(&[BOX_M * x, BOX_M * y, height_m]), Occupancy::Occupied, "{height_m}");
            assert_eq!(image.classify(&[7.0 * x, 7.0 * y, 0.2]), Occupancy::Occluded, "{height_m}");
        }
    }

    #[test]
    fn what_is_below_the_floor_or_at_the_edge_of_the_field_of_view_is_not_free() {
        let points = scan(0.5);
        let image = FreeSpaceImage::new(points.iter(), SENSOR, is_floor);
        assert_eq!(image.classify(&[6.0, 0.0, -0.4]), Occupancy::Occluded, "below the floor");
        let (up, flat) = 16.0_f32.to_radians().sin_cos();
        assert_eq!(
            image.classify(&[4.0 * flat, 0.0, SENSOR[2] + 4.0 * up]),
            Occupancy::Unobserved,
            "beside the highest rays"
        );
        assert_eq!(image.classify(&[1.0, 0.0, 0.1]), Occupancy::Unobserved, "below the lowest ray");
        assert_eq!(image.classify(&[-4.0, 0.0, 0.5]), Occupancy::Unobserved, "no ray went there");
        assert_eq!(image.classify(&[f32::NAN, 0.0, 0.5]), Occupancy::Unobserved);
    }
}
