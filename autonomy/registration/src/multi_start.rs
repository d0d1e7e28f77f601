//! Finding the pose of a scan when the guess is too far off to converge: a few Gauss-Newton steps from each of many
//! turned starts, on a few hundred points; the start that ends with the best fit wins.

use crate::linearise::{MatchingConfig, linearise};
use geometry::{Isometry, Matrix6, Vector3, se3, so3};
use nalgebra::Translation3;
use points::SurfaceMap;

/// Where to look.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MultiStartConfig {
    /// Greatest turn about the vertical of the map, radians.
    pub max_yaw_rad: f64,
    /// Greatest turn about the two other axes, radians.
    pub max_tilt_rad: f64,
    /// Distance between starts, radians.
    pub step: f64,
    /// Gauss-Newton steps from each start.
    pub iterations: usize,
}

impl Default for MultiStartConfig {
    fn default() -> Self {
        Self { max_yaw_rad: 1.1, max_tilt_rad: 0.3, step: 0.14, iterations: 6 }
    }
}

/// A pose and how well the scan fits there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Body in the map.
    pub map_from_body: Isometry,
    /// 0 (nothing fits) to 1 (every point lies on its surface).
    pub score: f64,
}

/// Share of the points that fit the map at a pose, weighted by how well: 0 to 1.
pub fn score(
    map: &impl SurfaceMap,
    points: &[[f32; 3]],
    map_from_body: &Isometry,
    options: &MatchingConfig,
) -> f64 {
    let at = linearise(map, points, map_from_body, options);
    fit(&at, points.len(), options)
}

/// A perfect match counts 1, a match at the kernel's width a half, none 0.
fn fit(at: &crate::NormalEquations, points: usize, options: &MatchingConfig) -> f64 {
    let worst = f64::from(options.kernel_width).powi(2);
    (at.matched as f64 - at.cost / worst) / points.max(1) as f64
}

/// Plain Gauss-Newton from a guess, with wide gates first.
pub fn refine(
    map: &impl SurfaceMap,
    points: &[[f32; 3]],
    guess: &Isometry,
    options: &MatchingConfig,
    iterations: usize,
) -> Fit {
    let mut pose = *guess;
    for iteration in 0..iterations {
        // From five times the final width down to it.
        let wide = 1.0 + 4.0 * (1.0 - (iteration + 1) as f32 / iterations as f32);
        let loose = MatchingConfig {
            kernel_width: options.kernel_width * wide,
            gate_m: options.gate_m * wide,
            ..*options
        };
        let at = linearise(map, points, &pose, &loose);
        // A little damping keeps directions that nothing holds where they are.
        let damped = at.information + Matrix6::identity() * (at.information.trace() * 1e-6 + 1e-9);
        let Some(factor) = damped.cholesky() else { break };
        let step = factor.solve(&-at.gradient);
        pose = se3::retract(&pose, &step);
        if step.norm() < 1e-5 {
            break;
        }
    }
    Fit { map_from_body: pose, score: score(map, points, &pose, options) }
}

/// Tries turned starts about every position in `positions` (map frame) and gives the best fit.
pub fn multi_start(
    map: &impl SurfaceMap,
    points: &[[f32; 3]],
    guesses: &[Isometry],
    matching: &MatchingConfig,
    options: &MultiStartConfig,
) -> Option<Fit> {
    let steps = |limit: f64| {
        let count = (limit / options.step).floor() as i32;
        (-count..=count).map(move |index| f64::from(index) * options.step)
    };
    let mut best: Option<Fit> = None;
    for guess in guesses {
        for yaw in steps(options.max_yaw_rad) {
            for (roll, pitch) in tilts(options) {
                let turn = so3::exp(&(Vector3::z() * yaw)) * so3::exp(&Vector3::new(roll, pitch, 0.0));
                let start =
                    Isometry::from_parts(Translation3::from(guess.translation.vector), turn * guess.rotation);
                let found = refine(map, points, &start, matching, options.iterations);
                if best.is_none_or(|held| found.score > held.score) {
                    best = Some(found);
                }
            }
        }
    }
    best
}

/// No tilt, and one each way along both axes.
fn tilts(options: &MultiStartConfig) -> impl Iterator<Item = (f64, f64)> {
    let t = options.max_tilt_rad;
    let all = [(0.0, 0.0), (t, 0.0), (-t, 0.0), (0.0, t), (0.0, -t)];
    all.into_iter().take(if t > 0.0 { 5 } else { 1 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::RngTree;
    use points::{GaussianMap, GaussianMapConfig};

    /// A room with a column and a cupboard: 8 x 6 x 3 m.
    fn room(seed: u64, points: usize) -> Vec<Vector3> {
        let mut rng = RngTree::new(seed).child("room").rng();
        (0..points)
            .map(|index| {
                let (a, b, n) = (rng.uniform(), rng.uniform(), rng.normal() * 0.01);
                match index % 9 {
                    0 | 1 => Vector3::new(8.0 * a - 4.0, 6.0 * b - 3.0, -0.5 + n),
                    2 => Vector3::new(8.0 * a - 4.0, 6.0 * b - 3.0, 2.5 + n),
                    3 => Vector3::new(4.0 + n, 6.0 * a - 3.0, 3.0 * b - 0.5),
                    4 => Vector3::new(-4.0 + n, 6.0 * a - 3.0, 3.0 * b - 0.5),
                    5 => Vector3::new(8.0 * a - 4.0, 3.0 + n, 3.0 * b - 0.5),
                    6 => Vector3::new(8.0 * a - 4.0, -3.0 + n, 3.0 * b - 0.5),
                    7 => Vector3::new(2.0 + n, a - 2.0, 3.0 * b - 0.5),
                    _ => Vector3::new(-4.0 + 1.5 * a, 1.6 + n, 2.0 * b - 0.5),
                }
            })
            .collect()
    }

    #[test]
    fn a_scan_turned_by_fifty_degrees_and_moved_by_half_a_metre_is_found() {
        let mut map = GaussianMap::new(GaussianMapConfig::default());
        for p in room(1, 40_000) {
            map.insert(&[p.x, p.y, p.z]);
        }
        let truth = Isometry::new(Vector3::new(0.4, -0.3, 0.1), Vector3::new(0.05, -0.08, 0.85));
        let scan: Vec<[f32; 3]> = room(2, 600)
            .iter()
            .map(|p| truth.inverse_transform_point(&(*p).into()))
            .map(|p| [p.x as f32, p.y as f32, p.z as f32])
            .collect();
        let matching = MatchingConfig { gate_m: 0.2, noise_m: 0.03, ..MatchingConfig::default() };
        let alone = refine(&map, &scan, &Isometry::identity(), &matching, 20);
        let found =
            multi_start(&map, &scan, &[Isometry::identity()], &matching, &MultiStartConfig::default());
        let Some(found) = found else { panic!("nothing found") };
        assert!(found.score > 0.8 && found.score > alone.score, "{} {}", found.score, alone.score);
        assert!(se3::local(&truth, &found.map_from_body).norm() < 0.05, "{}", found.map_from_body);
    }
}
