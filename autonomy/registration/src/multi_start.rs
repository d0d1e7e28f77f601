//! Registration without a good initial pose: Gauss-Newton from many rotated starts, on a few hundred points. The start that ends
//! with the best fit wins.

use crate::gauss_newton::{GaussNewtonConfig, gauss_newton};
use crate::linearise::{MatchingConfig, NormalEquations, linearise_from_viewpoint};
use geometry::{Isometry, Vector3, se3, so3};
use nalgebra::Translation3;
use points::SurfaceMap;

/// Parameters of [`multi_start`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MultiStartConfig {
    /// Greatest rotation of a start about the vertical of the map, radians. Chosen: 63 degrees; the number of starts is in proportion to it, and a robot that is turned
    /// farther during a gap loses its track.
    pub max_yaw_rad: f64,
    /// Rotation of the tilted starts about the two horizontal axes, radians. Chosen: 17 degrees, a ramp or a flight of stairs.
    pub max_tilt_rad: f64,
    /// Difference of yaw between neighbouring starts, radians. Chosen: 8 degrees, from half of which the iteration converges.
    pub yaw_step_rad: f64,
    /// Gauss-Newton iterations from each start. Chosen: it bounds the time; the best start is refined further.
    pub max_iterations: usize,
}

impl Default for MultiStartConfig {
    fn default() -> Self {
        Self { max_yaw_rad: 1.1, max_tilt_rad: 0.3, yaw_step_rad: 0.14, max_iterations: 6 }
    }
}

/// A pose and how well the scan fits the map there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Pose of the body in the map.
    pub map_from_body: Isometry,
    /// Score of [`score`]: 0 (no point fits) to 1 (every point lies on its surface).
    pub score: f64,
}

/// How well a scan fits a map at a pose, 0 to 1: the mean over all points of 1 for a perfect match, one half for a residual of the
/// kernel's width, 0 for a point without a surface (docs/maths/odometry.md, equation 19). `points` are in the body frame, metres. The
/// viewpoint is the origin of the body.
pub fn score(
    map: &impl SurfaceMap,
    points: &[[f32; 3]],
    map_from_body: &Isometry,
    matching: &MatchingConfig,
) -> f64 {
    score_from_viewpoint(map, points, &Vector3::zeros(), map_from_body, matching)
}

/// As [`score`], for points that were seen from a viewpoint (body frame, metres).
pub fn score_from_viewpoint(
    map: &impl SurfaceMap,
    points: &[[f32; 3]],
    viewpoint: &Vector3,
    map_from_body: &Isometry,
    matching: &MatchingConfig,
) -> f64 {
    let equations = linearise_from_viewpoint(map, points, map_from_body, viewpoint, matching);
    score_of(&equations, points.len(), matching)
}

fn score_of(equations: &NormalEquations, points: usize, matching: &MatchingConfig) -> f64 {
    let max_cost = f64::from(matching.kernel_width).powi(2);
    (equations.matched as f64 - equations.cost / max_cost) / points.max(1) as f64
}

/// Damped Gauss-Newton from an initial pose, without a prior. The matching narrows linearly to `matching`; all parameters but the
/// number of iterations are those of [`GaussNewtonConfig::default`]. `points` are in the body frame, metres. The viewpoint is the origin of
/// the body.
pub fn refine(
    map: &impl SurfaceMap,
    points: &[[f32; 3]],
    initial: &Isometry,
    matching: &MatchingConfig,
    max_iterations: usize,
) -> Fit {
    refine_from_viewpoint(map, points, &Vector3::zeros(), initial, matching, max_iterations)
}

/// As [`refine`], for points that were seen from a viewpoint (body frame, metres).
pub fn refine_from_viewpoint(
    map: &impl SurfaceMap,
    points: &[[f32; 3]],
    viewpoint: &Vector3,
    initial: &Isometry,
    matching: &MatchingConfig,
    max_iterations: usize,
) -> Fit {
    let config = GaussNewtonConfig { max_iterations, ..GaussNewtonConfig::default() };
    let pose = gauss_newton(*initial, matching, &config, |pose, widened| {
        let equations = linearise_from_viewpoint(map, points, pose, viewpoint, widened);
        let step = config.solve(&equations.information, &equations.gradient)?;
        Some((se3::retract(pose, &step), step.norm()))
    });
    Fit { map_from_body: pose, score: score_from_viewpoint(map, points, viewpoint, &pose, matching) }
}

/// Refines rotated starts about every one of the `initial` poses and returns the best fit; `None` without initial poses.
pub fn multi_start(
    map: &impl SurfaceMap,
    points: &[[f32; 3]],
    initial: &[Isometry],
    matching: &MatchingConfig,
    config: &MultiStartConfig,
) -> Option<Fit> {
    let mut best: Option<Fit> = None;
    for pose in initial {
        for yaw in yaws(config) {
            for (roll, pitch) in tilts(config) {
                let turn = so3::exp(&(Vector3::z() * yaw)) * so3::exp(&Vector3::new(roll, pitch, 0.0));
                let start =
                    Isometry::from_parts(Translation3::from(pose.translation.vector), turn * pose.rotation);
                let found = refine(map, points, &start, matching, config.max_iterations);
                if best.is_none_or(|held| found.score > held.score) {
                    best = Some(found);
                }
            }
        }
    }
    best
}

/// Multiples of the yaw step within the limit, both ways.
fn yaws(config: &MultiStartConfig) -> impl Iterator<Item = f64> {
    let count = (config.max_yaw_rad / config.yaw_step_rad).floor() as i32;
    let step = config.yaw_step_rad;
    (-count..=count).map(move |index| f64::from(index) * step)
}

/// Roll and pitch: level, and tilted both ways about each horizontal axis.
fn tilts(config: &MultiStartConfig) -> impl Iterator<Item = (f64, f64)> {
    let tilt = config.max_tilt_rad;
    let all = [(0.0, 0.0), (tilt, 0.0), (-tilt, 0.0), (0.0, tilt), (0.0, -tilt)];
    all.into_iter().take(if tilt > 0.0 { 5 } else { 1 })
}
