//! Finds a charging dock in scans, by the marker that stands on it: two vertical plates that form a ridge towards the robot.
//!
//! The points of a horizontal slice through the plates are compared with the outline of the marker: first on a grid of poses around the expected one, then by
//! least squares from the best of them (point-to-line ICP with Tukey weights; docs/maths/docking.md). What was found must look like a whole marker, both plates with their ends, or it
//! is none: walls, corners and people are not.

use crate::dock_config::DockDetectorConfig;
use crate::dock_outline::{Observation, Outline, Pose2};
use geometry::{Isometry, Matrix3, Vector3};

/// A dock that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DockDetection {
    /// Level pose of the docked base in the frame of the points, x away from the dock, at the height of the expected pose.
    pub frame_from_dock: Isometry,
    /// Root mean square of the distances of its points from the plates, metres.
    pub residual_m: f64,
    /// Number of points on the plates.
    pub points: usize,
    /// Covariance of the pose in its own frame: x, y (m), heading (rad).
    pub covariance: Matrix3,
}

/// Why no dock was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DockNotFound {
    /// There are hardly any points where the marker should be.
    FewPoints,
    /// Nothing has its shape.
    NoMatch,
    /// Something may be the marker, but too much of it is hidden.
    PartlyHidden,
    /// Several places look like it.
    Ambiguous,
}

/// The detector. It has no state: the same points give the same result.
#[derive(Clone, Copy, Debug, Default)]
pub struct DockDetector {
    config: DockDetectorConfig,
}

impl DockDetector {
    /// A detector of that marker.
    pub fn new(config: DockDetectorConfig) -> Self {
        Self { config }
    }

    /// The parameters.
    pub fn config(&self) -> &DockDetectorConfig {
        &self.config
    }

    /// Heights above the floor between which points are on the plates, metres.
    pub fn slice_m(&self) -> (f64, f64) {
        let DockDetectorConfig { marker, edge_margin_m, .. } = &self.config;
        (marker.bottom_m + edge_margin_m, marker.top_m - edge_margin_m)
    }

    /// Finds the dock among the points of the slice. `frame_from_expected` is where the docked base is expected, x away from the dock. Points and poses are in one
    /// level frame, metres.
    ///
    /// # Errors
    /// Why there is none.
    pub fn detect(
        &self,
        points: &[[f64; 2]],
        frame_from_expected: &Isometry,
    ) -> Result<DockDetection, DockNotFound> {
        let expected = Pose2::from_isometry(frame_from_expected);
        let outline = Outline::new(&self.config.marker);
        let reach_m =
            std::f64::consts::SQRT_2 * self.config.search_m + outline.length_m() + self.config.reach_margin_m;
        let middle = outline.middle();
        let is_near = |point: &[f64; 2]| (point[0] - middle[0]).hypot(point[1] - middle[1]) <= reach_m;
        let near: Vec<[f64; 2]> =
            points.iter().map(|point| expected.inverse_apply(*point)).filter(is_near).collect();
        if near.len() < self.config.min_points {
            return Err(DockNotFound::FewPoints);
        }
        let near = every(&near, self.config.max_points);
        let mut found: Vec<(Pose2, Observation)> = Vec::new();
        let mut reason = DockNotFound::NoMatch;
        for start in self.candidates(&outline, &near) {
            let Some(pose) = outline.refine(&near, start, &self.config) else { continue };
            if !self.is_in_window(&pose) {
                continue;
            }
            let seen = outline.observe(&near, &pose, &self.config);
            match self.check_shape(&seen) {
                Ok(()) => found.push((pose, seen)),
                Err(DockNotFound::PartlyHidden) => reason = DockNotFound::PartlyHidden,
                Err(_) => {}
            }
        }
        let best = found.iter().max_by_key(|(_, seen)| seen.points).ok_or(reason)?;
        let is_another = |pose: &Pose2| pose.distance_m(&best.0) > self.config.separation_m;
        if found.iter().any(|(pose, _)| is_another(pose)) {
            return Err(DockNotFound::Ambiguous);
        }
        let (pose, seen) = best;
        Ok(DockDetection {
            frame_from_dock: expected.then(pose).to_isometry(frame_from_expected.translation.vector.z),
            residual_m: seen.residual_m,
            points: seen.points,
            covariance: seen.covariance,
        })
    }

    /// The best poses of the grid, at most [`DockDetectorConfig::max_starts`], apart from each other.
    fn candidates(&self, outline: &Outline, near: &[[f64; 2]]) -> Vec<Pose2> {
        let DockDetectorConfig { search_m, search_rad, step_m, step_rad, score_reach_steps, .. } =
            self.config;
        let few = every(near, self.config.max_grid_points);
        let (steps, turns) = ((search_m / step_m).round() as i32, (search_rad / step_rad).round() as i32);
        let mut scored = Vec::new();
        for turn in -turns..=turns {
            for x in -steps..=steps {
                for y in -steps..=steps {
                    let heading = f64::from(turn) * step_rad;
                    let pose = Pose2::new(f64::from(x) * step_m, f64::from(y) * step_m, heading);
                    let score = outline.score(&few, &pose, score_reach_steps * step_m);
                    if score > 0.0 {
                        scored.push((score, pose));
                    }
                }
            }
        }
        scored.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        let mut chosen: Vec<Pose2> = Vec::new();
        for (_, pose) in scored {
            if chosen.iter().all(|other| other.distance_m(&pose) > self.config.separation_m) {
                chosen.push(pose);
            }
            if chosen.len() == self.config.max_starts {
                break;
            }
        }
        chosen
    }

    fn is_in_window(&self, pose: &Pose2) -> bool {
        let DockDetectorConfig { search_m, search_rad, step_m, step_rad, .. } = self.config;
        pose.x.abs() <= search_m + step_m
            && pose.y.abs() <= search_m + step_m
            && pose.heading().abs() <= search_rad + step_rad
    }

    /// Whether what was seen is a marker.
    fn check_shape(&self, seen: &Observation) -> Result<(), DockNotFound> {
        let config = &self.config;
        let deviation = |axis: usize| seen.covariance[(axis, axis)].max(0.0).sqrt();
        let is_exact = seen.residual_m <= config.max_residual_m
            && seen.beyond_share <= config.max_beyond_share
            && seen.beside_share <= config.max_beside_share
            && seen.section_error_m <= config.max_section_error_m
            && deviation(0) <= config.max_deviation_m
            && deviation(1) <= config.max_deviation_m
            && deviation(2) <= config.max_deviation_rad;
        if !is_exact || seen.points < config.min_points {
            return Err(DockNotFound::NoMatch);
        }
        let [left, right] = seen.seen_share;
        if left.min(right) < config.min_seen_share {
            // One whole plate may be the rest of a marker.
            let is_half = left.max(right) >= config.min_seen_share;
            return Err(if is_half { DockNotFound::PartlyHidden } else { DockNotFound::NoMatch });
        }
        Ok(())
    }
}

/// At most that many of the points, evenly.
fn every(points: &[[f64; 2]], max_count: usize) -> Vec<[f64; 2]> {
    let step = points.len().div_ceil(max_count.max(1)).max(1);
    points.iter().copied().step_by(step).collect()
}

/// The points of recent scans in the slice of the marker, around where a dock is expected.
#[derive(Clone, Debug, Default)]
pub struct DockScans {
    scans: std::collections::VecDeque<(f64, Vec<[f64; 2]>)>,
}

impl DockScans {
    /// Adds a scan that was made at `seconds`, and forgets those older than `age_s`. `points` are in the base frame, and what is kept is in the frame of
    /// `frame_from_base`, whose z axis points up. The robot stands `standing_height` above the floor.
    pub fn insert(
        &mut self,
        (seconds, age_s): (f64, f64),
        detector: &DockDetector,
        frame_from_base: &Isometry,
        standing_height: f64,
        frame_from_expected: &Isometry,
        points: &[[f32; 3]],
    ) {
        let DockDetectorConfig { marker, search_m, .. } = detector.config();
        let reach_m =
            std::f64::consts::SQRT_2 * search_m + marker.ridge_m + marker.half_width_m + marker.depth_m;
        let expected = frame_from_expected.translation.vector;
        let floor = frame_from_base.translation.vector.z - standing_height;
        let (low_m, high_m) = detector.slice_m();
        let in_slice = points.iter().filter_map(|point| {
            let point = frame_from_base * nalgebra::Point3::from(Vector3::from(point.map(f64::from)));
            let is_inside = (low_m..=high_m).contains(&(point.z - floor))
                && (point.x - expected.x).hypot(point.y - expected.y) <= reach_m;
            is_inside.then_some([point.x, point.y])
        });
        self.scans.push_back((seconds, in_slice.collect()));
        while self.scans.front().is_some_and(|(then, _)| *then < seconds - age_s) {
            self.scans.pop_front();
        }
    }

    /// Number of scans.
    pub fn len(&self) -> usize {
        self.scans.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.scans.is_empty()
    }

    /// Forgets all scans.
    pub fn clear(&mut self) {
        self.scans.clear();
    }

    /// All points.
    pub fn points(&self) -> Vec<[f64; 2]> {
        self.scans.iter().flat_map(|(_, points)| points).copied().collect()
    }
}
