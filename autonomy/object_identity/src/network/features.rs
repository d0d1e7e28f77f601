//! What the network is given of a view of an object.

use crate::extents::box_sides_m;
use crate::sample::{SurfacePoint, SurfaceSample};

/// Numbers of a pair of points.
pub(super) const PAIR_FEATURES: usize = 8;
/// Numbers of the whole object.
pub(super) const WHOLE_FEATURES: usize = 6;
/// Points of which pairs are made, and one in how many pairs is taken: 260 pairs.
const PAIRED_POINTS: usize = 40;
const TAKEN_PAIRS: usize = 3;

/// Numbers of the pairs of points of a view, and of the whole. None depends on how the object is turned.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewFeatures {
    pub(super) pairs: Vec<[f32; PAIR_FEATURES]>,
    pub(super) whole: [f32; WHOLE_FEATURES],
}

impl ViewFeatures {
    /// The features of an object with these points, metres, in any frame; none where [`crate::ObjectDescriptor::describe`] gives none.
    pub fn new(points: &[[f32; 3]]) -> Option<Self> {
        SurfaceSample::new(points).map(|sample| Self::of(&sample))
    }

    pub(super) fn of(sample: &SurfaceSample) -> Self {
        let points = &sample.points[..sample.points.len().min(PAIRED_POINTS)];
        let places = (0..points.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
        let taken = places.filter(|(a, b)| (a + b) % TAKEN_PAIRS == 0);
        let pairs = taken.map(|(a, b)| of_pair(&points[a], &points[b], sample.radius_m).map(|x| x as f32));
        let sides = box_sides_m(sample).map(|side_m| (side_m + 0.05).ln());
        let sigma = sample.spread_m2.map(|spread| spread.sqrt() / sample.radius_m);
        let whole = [sides[0], sides[1], sides[2], sigma[0], sigma[1], sigma[2]].map(|x| x as f32);
        Self { pairs: pairs.collect(), whole }
    }
}

/// Distance, absolute and of the radius, angles between normals and the line, and how flat and how far from the middle both places are: point pair features (Drost and others, *Model globally,
/// match locally*, 2010) without directions of the normals, which are not known.
fn of_pair(a: &SurfacePoint, b: &SurfacePoint, radius_m: f64) -> [f64; PAIR_FEATURES] {
    let offset = a.at_m - b.at_m;
    let distance_m = offset.norm();
    let along = offset / distance_m.max(1e-9);
    let angles = [a.normal.dot(&along).abs(), b.normal.dot(&along).abs()];
    let middles = [a.at_m.norm() / radius_m, b.at_m.norm() / radius_m];
    [
        (distance_m + 0.05).ln(),
        distance_m / radius_m,
        angles[0].min(angles[1]),
        angles[0].max(angles[1]),
        a.normal.dot(&b.normal).abs(),
        middles[0].min(middles[1]),
        middles[0].max(middles[1]),
        a.planarity.min(b.planarity),
    ]
}
