//! What a visit saw.

use crate::UprightBox;
use geometry::Vector3;

/// What a sensor saw from one place.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorView {
    /// Place of the sensor, metres, map frame.
    pub sensor: Vector3,
    /// The points it saw, metres, map frame. All are finite.
    pub points: Vec<[f32; 3]>,
}

impl SensorView {
    /// The view without the rays that would end elsewhere today: those that ended where something was, and those that went through where something is. Boxes count `margin_m` metres
    /// larger on all sides. Linear in the points times the boxes.
    pub fn without_changed(&self, was: &[UprightBox], is: &[UprightBox], margin_m: f64) -> Self {
        let tells = |point: &&[f32; 3]| {
            let at = Vector3::from(point.map(f64::from));
            let (offset, range_m) = (at - self.sensor, (at - self.sensor).norm());
            let goes_through = |place: &UprightBox| {
                let crossed = place.wider(margin_m).crossed_by(&self.sensor, &(offset / range_m));
                crossed.is_some_and(|[enters_m, _]| enters_m < range_m)
            };
            !was.iter().any(|place| place.holds(&at, margin_m)) && !is.iter().any(goes_through)
        };
        Self { sensor: self.sensor, points: self.points.iter().filter(tells).copied().collect() }
    }
}

/// What a visit saw, in the order in which it was seen. Both visits of a comparison have the same map frame, with the third axis up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Visit {
    /// The views.
    pub views: Vec<SensorView>,
}

impl Visit {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.views.iter().map(|view| view.points.len()).sum()
    }

    /// Whether it saw nothing.
    pub fn is_empty(&self) -> bool {
        self.views.iter().all(|view| view.points.is_empty())
    }

    /// Its points whose distance from their sensor is within a range, metres.
    pub(crate) fn points_within(&self, min_m: f64, max_m: f64) -> impl Iterator<Item = [f32; 3]> {
        self.views.iter().flat_map(move |view| {
            let is_within = move |point: &&[f32; 3]| {
                let range_m = (Vector3::from(point.map(f64::from)) - view.sensor).norm();
                (min_m..=max_m).contains(&range_m)
            };
            view.points.iter().filter(is_within).copied()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_view_forgets_the_rays_that_would_end_elsewhere_today() {
        let at = |x: f64| UprightBox { centre_m: Vector3::new(x, 0.0, 0.5), size_m: [0.6; 3], yaw_rad: 0.0 };
        let points = vec![[2.72, 0.0, 0.5], [5.0, 0.0, 0.5], [5.0, 2.0, 0.5], [-5.0, 0.0, 0.5]];
        let view = SensorView { sensor: Vector3::new(0.0, 0.0, 0.5), points };
        let left = |was: &[UprightBox], is: &[UprightBox]| -> Vec<f32> {
            view.without_changed(was, is, 0.1).points.iter().map(|point| point[0] + point[1]).collect()
        };
        assert_eq!(left(&[], &[]), [2.72, 5.0, 7.0, -5.0]);
        assert_eq!(left(&[at(3.0)], &[]), [5.0, 7.0, -5.0], "what was there is gone");
        assert_eq!(
            left(&[], &[at(3.0)]),
            [7.0, -5.0],
            "what is there now stands in front of the rest, and another ray ended in it"
        );
        assert_eq!(left(&[], &[at(6.0)]), [2.72, 5.0, 7.0, -5.0], "behind all rays");
    }
}
