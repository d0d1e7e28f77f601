//! A few points of an object, spread evenly over what was seen of it, with the normals of its surface.

use geometry::{Matrix3, Vector3};

/// Points that are looked at, at most: every second, third and so on of more. The time of the choice is their number times that of the chosen ones.
const MAX_POINTS: usize = 1_024;
/// Points of which normals are computed: of a LiDAR's rings, the nearest neighbours of a point are on its own ring, so they are searched among points that are spread evenly.
const EVEN_POINTS: usize = 192;
/// Neighbours of a point that give its normal, with itself.
const NEIGHBOURS: usize = 9;
/// Least number of points.
const MIN_POINTS: usize = 10;
/// Objects whose points are nearer to their middle than this, metres, have no shape.
const MIN_RADIUS_M: f64 = 1e-3;

/// A point of the surface of an object, from the middle of its points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfacePoint {
    pub(crate) at_m: Vector3,
    /// Normal of the surface, in either direction.
    pub(crate) normal: Vector3,
    /// Share of the spread of its neighbours that is in the plane: from 0 along a line or all round to 1.
    pub(crate) planarity: f64,
}

/// Points spread evenly over an object, those farthest from all earlier ones first.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceSample {
    pub(crate) points: Vec<SurfacePoint>,
    /// All points that are looked at, from the same middle, metres.
    pub(crate) all_m: Vec<Vector3>,
    /// Greatest distance of a point from the middle, metres.
    pub(crate) radius_m: f64,
    /// Eigenvalues of the covariance of the points, the greatest first, m².
    pub(crate) spread_m2: [f64; 3],
    /// Eigenvectors in the same order.
    pub(crate) axes: [Vector3; 3],
}

impl SurfaceSample {
    /// The sample of an object; none if it has too few points or no extent. Linear in the points.
    pub(crate) fn new(points: &[[f32; 3]]) -> Option<Self> {
        let step = points.len().div_ceil(MAX_POINTS).max(1);
        let points: Vec<Vector3> =
            points.iter().step_by(step).map(|point| Vector3::from(point.map(f64::from))).collect();
        let is_finite = points.iter().all(|point| point.iter().all(|at| at.is_finite()));
        if points.len() < MIN_POINTS || !is_finite {
            return None;
        }
        let even = spread_evenly(&points);
        let middle = even.iter().sum::<Vector3>() / even.len() as f64;
        let even: Vec<Vector3> = even.iter().map(|point| point - middle).collect();
        let radius_m = even.iter().map(Vector3::norm).fold(0.0, f64::max);
        if radius_m < MIN_RADIUS_M {
            return None;
        }
        let (spread_m2, axes) = principal(&even);
        Some(Self {
            all_m: points.iter().map(|point| point - middle).collect(),
            points: even.iter().map(|at| surface_point(at, &even)).collect(),
            radius_m,
            spread_m2,
            axes,
        })
    }
}

/// Points, each the farthest from all before it; the first is the farthest from the middle (Gonzalez, *Clustering to minimize the maximum intercluster distance*, 1985). So density does not
/// matter.
fn spread_evenly(points: &[Vector3]) -> Vec<Vector3> {
    let middle = points.iter().sum::<Vector3>() / points.len() as f64;
    let farthest = |distances: &[f64]| {
        let best = |best: usize, place: usize| if distances[place] > distances[best] { place } else { best };
        (0..distances.len()).fold(0, best)
    };
    let mut next = farthest(&points.iter().map(|point| (point - middle).norm_squared()).collect::<Vec<_>>());
    let mut nearest = vec![f64::INFINITY; points.len()];
    let mut chosen = Vec::with_capacity(EVEN_POINTS);
    while chosen.len() < EVEN_POINTS.min(points.len()) {
        let point = points[next];
        chosen.push(point);
        for (distance, other) in nearest.iter_mut().zip(points) {
            *distance = distance.min((other - point).norm_squared());
        }
        next = farthest(&nearest);
    }
    chosen
}

/// Eigenvalues and eigenvectors of the covariance of points, the greatest first.
fn principal(points: &[Vector3]) -> ([f64; 3], [Vector3; 3]) {
    let middle = points.iter().sum::<Vector3>() / points.len() as f64;
    let square = |point: &Vector3| (point - middle) * (point - middle).transpose();
    let covariance = points.iter().map(square).sum::<Matrix3>() / points.len() as f64;
    let eigen = covariance.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    (
        order.map(|axis| eigen.eigenvalues[axis].max(0.0)),
        order.map(|axis| eigen.eigenvectors.column(axis).into_owned()),
    )
}

fn surface_point(at: &Vector3, points: &[Vector3]) -> SurfacePoint {
    let mut near: Vec<(f64, usize)> =
        points.iter().enumerate().map(|(place, point)| ((point - at).norm_squared(), place)).collect();
    let count = NEIGHBOURS.min(near.len());
    near.select_nth_unstable_by(count - 1, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    near.truncate(count);
    // In one order, because sums depend on it.
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let near: Vec<Vector3> = near.iter().map(|(_, place)| points[*place]).collect();
    let (spread, axes) = principal(&near);
    // Dimensionality features: Demantké and others, *Dimensionality based scale selection in 3D lidar point clouds*, 2011.
    let sigma = spread.map(f64::sqrt);
    let planarity = if sigma[0] > 0.0 { (sigma[1] - sigma[2]) / sigma[0] } else { 0.0 };
    SurfacePoint { at_m: *at, normal: axes[2], planarity }
}
