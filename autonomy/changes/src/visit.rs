//! What a visit saw.

use geometry::Vector3;

/// What a sensor saw from one place.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// Place of the sensor, metres, map frame.
    pub sensor: Vector3,
    /// The points it saw, metres, map frame. All are finite.
    pub points: Vec<[f32; 3]>,
}

/// What a visit saw, in the order in which it was seen. Both visits of a comparison have the same map frame, with the third axis up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Visit {
    /// The looks.
    pub looks: Vec<Look>,
}

impl Visit {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.looks.iter().map(|look| look.points.len()).sum()
    }

    /// Whether it saw nothing.
    pub fn is_empty(&self) -> bool {
        self.looks.iter().all(|look| look.points.is_empty())
    }

    /// Its points whose distance from their sensor is within a range, metres.
    pub(crate) fn points_within(&self, min_m: f64, max_m: f64) -> impl Iterator<Item = [f32; 3]> {
        self.looks.iter().flat_map(move |look| {
            let is_within = move |point: &&[f32; 3]| {
                let range_m = (Vector3::from(point.map(f64::from)) - look.sensor).norm();
                (min_m..=max_m).contains(&range_m)
            };
            look.points.iter().filter(is_within).copied()
        })
    }
}
