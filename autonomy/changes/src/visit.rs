//! What a visit saw.

use geometry::Vector3;

/// What a sensor saw from one place.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorView {
    /// Place of the sensor, metres, map frame.
    pub sensor: Vector3,
    /// The points it saw, metres, map frame. All are finite.
    pub points: Vec<[f32; 3]>,
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
