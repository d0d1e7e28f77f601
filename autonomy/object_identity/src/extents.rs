//! The sides of the box round an object, in whichever direction it lies.

use crate::sample::SurfaceSample;
use geometry::Vector3;

/// Points whose normals are tried as directions of a side.
const TRIED_NORMALS: usize = 32;
/// Cosine of the angle within which normals are of parallel surfaces: 20 degrees, twice the error of a normal of nine points.
const PARALLEL: f64 = 0.94;
/// A point within this distance of a side is on it, metres: two standard deviations of the noise of a LiDAR. Source: `changes::BoxFitConfig`.
const ON_SIDE_M: f64 = 0.02;
/// Share of the points at each end of an axis that are left out, because noise reaches beyond the sides. Source: `changes::BoxFitConfig`.
const TRIMMED_SHARE: f64 = 0.01;

/// Lengths of the sides of the box round a sample that has most points near its sides, metres, the longest first. One side lies on a surface, or along a principal axis. The smallest box would not do: round
/// two sides of a box, those along the sides and along the diagonal have one volume. Source of the criterion: Zhang and others, *Efficient L-Shape Fitting for Vehicle Detection Using
/// Laser Scanners*, 2017 ("closeness"), here in three dimensions. `O(n log n)`.
pub(crate) fn box_sides_m(sample: &SurfaceSample) -> [f64; 3] {
    let normals = (0..sample.points.len().min(TRIED_NORMALS)).map(|place| mean_normal(sample, place));
    let boxes = normals.chain(sample.axes).filter_map(|normal| box_along(sample, &normal));
    let best = boxes.max_by(|a, b| a.closeness.total_cmp(&b.closeness));
    let mut sides = best.map_or([0.0; 3], |best| best.axes.map(|axis| trimmed_range_m(&sample.all_m, &axis)));
    sides.sort_by(|a, b| b.total_cmp(a));
    sides
}

/// The mean of the normals of all surfaces that are parallel to that at a point.
fn mean_normal(sample: &SurfaceSample, place: usize) -> Vector3 {
    let own = sample.points[place].normal;
    let mut sum = Vector3::zeros();
    for point in &sample.points {
        let cosine = own.dot(&point.normal);
        if cosine.abs() >= PARALLEL {
            sum += point.normal * (cosine.signum() * point.planarity);
        }
    }
    sum.try_normalize(1e-9).unwrap_or(own)
}

/// A box round the points of a sample.
struct TurnedBox {
    axes: [Vector3; 3],
    /// Sum over the points of the inverse of their distance from the nearest side.
    closeness: f64,
}

/// The box of which one side is perpendicular to a direction that has most points near its sides; none of points on a line along it.
fn box_along(sample: &SurfaceSample, normal: &Vector3) -> Option<TurnedBox> {
    // Any two directions across: the box does not depend on them.
    let helper = if normal.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
    let across = normal.cross(&helper).normalize();
    let other = normal.cross(&across);
    let flat: Vec<[f64; 2]> =
        sample.points.iter().map(|point| [point.at_m.dot(&across), point.at_m.dot(&other)]).collect();
    let along = from_ends_m(sample.points.iter().map(|point| point.at_m.dot(normal)).collect());
    let hull = convex_hull(flat.clone());
    let edges = hull.iter().enumerate().filter_map(|(place, from)| {
        let to = hull[(place + 1) % hull.len()];
        let edge = [to[0] - from[0], to[1] - from[1]];
        let length_m = edge[0].hypot(edge[1]);
        let [x, y] = edge.map(|at| at / length_m);
        let beside = [
            from_ends_m(flat.iter().map(|at| x * at[0] + y * at[1]).collect()),
            from_ends_m(flat.iter().map(|at| x * at[1] - y * at[0]).collect()),
        ];
        let nearest_m = |point: usize| along[point].min(beside[0][point]).min(beside[1][point]);
        let closeness: f64 = (0..flat.len()).map(|point| nearest_m(point).max(ON_SIDE_M).recip()).sum();
        let axes = [*normal, across * x + other * y, other * x - across * y];
        (length_m > 0.0).then_some(TurnedBox { axes, closeness })
    });
    edges.max_by(|a, b| a.closeness.total_cmp(&b.closeness))
}

/// Distances of values from the nearer end of their range.
fn from_ends_m(mut values: Vec<f64>) -> Vec<f64> {
    let ends = |[low, high]: [f64; 2], at: &f64| [low.min(*at), high.max(*at)];
    let [low, high] = values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], ends);
    for value in &mut values {
        *value = (*value - low).min(high - *value);
    }
    values
}

fn trimmed_range_m(points: &[Vector3], axis: &Vector3) -> f64 {
    let mut along: Vec<f64> = points.iter().map(|point| point.dot(axis)).collect();
    along.sort_by(f64::total_cmp);
    let trimmed = (along.len() as f64 * TRIMMED_SHARE) as usize;
    along[along.len() - 1 - trimmed] - along[trimmed]
}

/// The corners of the convex hull of points in a plane, anticlockwise (Andrew's monotone chain, 1979).
fn convex_hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let is_left = |a: &[f64; 2], b: &[f64; 2], c: &[f64; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0
    };
    let chain = |points: &mut dyn Iterator<Item = &[f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && !is_left(&a, &b, point)
            {
                chain.pop();
            }
            chain.push(*point);
        }
        chain.pop();
        chain
    };
    let mut hull = chain(&mut points.iter());
    hull.extend(chain(&mut points.iter().rev()));
    hull
}
