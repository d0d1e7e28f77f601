//! The outline of a dock's marker in the plane, and how points compare with it.

use crate::dock_config::{DockDetectorConfig, DockMarker};
use geometry::{Isometry, Matrix3, Rotation, Vector3};
use registration::{MatchingConfig, gauss_newton};

/// A pose in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pose2 {
    pub x: f64,
    pub y: f64,
    sin: f64,
    cos: f64,
}

impl Pose2 {
    pub fn new(x: f64, y: f64, heading: f64) -> Self {
        let (sin, cos) = heading.sin_cos();
        Self { x, y, sin, cos }
    }

    pub fn from_isometry(pose: &Isometry) -> Self {
        let ahead = pose.rotation * Vector3::x();
        Self::new(pose.translation.vector.x, pose.translation.vector.y, ahead.y.atan2(ahead.x))
    }

    pub fn to_isometry(self, z: f64) -> Isometry {
        let heading = Rotation::from_euler_angles(0.0, 0.0, self.heading());
        Isometry::from_parts(Vector3::new(self.x, self.y, z).into(), heading)
    }

    pub fn heading(&self) -> f64 {
        self.sin.atan2(self.cos)
    }

    pub fn distance_m(&self, other: &Self) -> f64 {
        (self.x - other.x).hypot(self.y - other.y)
    }

    /// A pose that is given in this one, in the frame of this one.
    pub fn then(&self, other: &Self) -> Self {
        let x = self.x + self.cos * other.x - self.sin * other.y;
        let y = self.y + self.sin * other.x + self.cos * other.y;
        Self::new(x, y, self.heading() + other.heading())
    }

    /// A point in the frame of this pose.
    pub fn inverse_apply(&self, point: [f64; 2]) -> [f64; 2] {
        let (x, y) = (point[0] - self.x, point[1] - self.y);
        [self.cos * x + self.sin * y, self.cos * y - self.sin * x]
    }
}

/// What of a marker is seen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Observation {
    /// Points on the plates.
    pub points: usize,
    /// Root mean square of their distances, metres.
    pub residual_m: f64,
    /// Seen share of the sections: left, right. 0 where the outermost is not seen.
    pub seen_share: [f64; 2],
    /// Greatest mean distance of the points of a section from its plate, metres.
    pub section_error_m: f64,
    /// Density of points on the lines beyond the ends of the plates, by that on the plates. The greater of both sides.
    pub beyond_share: f64,
    /// Share of the points that are before or behind the plates, of all near them.
    pub beside_share: f64,
    /// Covariance of the pose in its own frame: x, y (m), heading (rad).
    pub covariance: Matrix3,
}

/// Both plates, seen from above. The right one is the left one mirrored.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outline {
    ridge_m: f64,
    /// Unit vector along the left plate, away from the ridge.
    along: [f64; 2],
    length_m: f64,
}

/// Where a point is by the plate on its side.
struct Nearest {
    /// Distance from the ridge along the plate's line, metres.
    along_m: f64,
    /// Signed distance from that line, positive in front, metres.
    off_m: f64,
    /// Normal of the plate, towards the front.
    normal: [f64; 2],
}

impl Outline {
    pub fn new(marker: &DockMarker) -> Self {
        let length_m = marker.depth_m.hypot(marker.half_width_m).max(1e-6);
        let along = [-marker.depth_m / length_m, marker.half_width_m / length_m];
        Self { ridge_m: marker.ridge_m, along, length_m }
    }

    /// Length of a plate, metres.
    pub fn length_m(&self) -> f64 {
        self.length_m
    }

    /// The middle between the ridge and the line between the ends, docked base frame.
    pub fn middle(&self) -> [f64; 2] {
        [-self.ridge_m + self.along[0] * self.length_m / 2.0, 0.0]
    }

    /// `point` is in the frame of the docked base.
    fn nearest(&self, point: [f64; 2]) -> Nearest {
        let side = if point[1] < 0.0 { -1.0 } else { 1.0 };
        let (x, y) = (point[0] + self.ridge_m, point[1].abs());
        let [ax, ay] = self.along;
        Nearest { along_m: ax * x + ay * y, off_m: ay * x - ax * y, normal: [ay, -ax * side] }
    }

    /// How well points fit a pose: each adds at most 1, and nothing beyond `reach_m`.
    pub fn score(&self, points: &[[f64; 2]], pose: &Pose2, reach_m: f64) -> f64 {
        let one = |point: &[f64; 2]| {
            let nearest = self.nearest(pose.inverse_apply(*point));
            let over_m = (nearest.along_m - self.length_m).max(-nearest.along_m).max(0.0);
            let share = (nearest.off_m.powi(2) + over_m.powi(2)) / reach_m.powi(2);
            (1.0 - share).max(0.0)
        };
        points.iter().map(one).sum()
    }

    /// The pose that fits best by least squares, from a start that is nearly right (docs/maths/docking.md, equations 1 and 2). `None` if the points
    /// do not determine it.
    pub fn refine(&self, points: &[[f64; 2]], start: Pose2, config: &DockDetectorConfig) -> Option<Pose2> {
        let matching = MatchingConfig { gate_m: config.inlier_m as f32, ..MatchingConfig::default() };
        let mut is_determined = true;
        let pose = gauss_newton(start, &matching, &config.refinement, |pose, matching| {
            let step = self.step(points, pose, f64::from(matching.gate_m));
            is_determined = step.is_some();
            let step = step?;
            Some((pose.then(&Pose2::new(step.x, step.y, step.z)), step.norm()))
        });
        is_determined.then_some(pose)
    }

    /// The step of the weighted least squares over the points within the gate (docs/maths/docking.md, equation 1). `None` if the points do not
    /// determine it.
    fn step(&self, points: &[[f64; 2]], pose: &Pose2, gate_m: f64) -> Option<Vector3> {
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for point in points {
            let local = pose.inverse_apply(*point);
            let Some((nearest, row)) = self.row(local, gate_m) else { continue };
            let weight = (1.0 - (nearest.off_m / gate_m).powi(2)).powi(2);
            normal += row * row.transpose() * weight;
            right += row * (nearest.off_m * weight);
        }
        Some(normal.cholesky()?.solve(&right))
    }

    /// The plate's point next to a point within `gate_m`, and the derivative of the distance by a step of the pose, negated: `J` of
    /// docs/maths/docking.md, equation 1.
    fn row(&self, local: [f64; 2], gate_m: f64) -> Option<(Nearest, Vector3)> {
        let nearest = self.nearest(local);
        let is_on = (0.0..=self.length_m).contains(&nearest.along_m) && nearest.off_m.abs() < gate_m;
        let [nx, ny] = nearest.normal;
        let row = Vector3::new(nx, ny, ny * local[0] - nx * local[1]);
        is_on.then_some((nearest, row))
    }

    /// What of the marker is seen, if it is in that pose.
    pub fn observe(&self, points: &[[f64; 2]], pose: &Pose2, config: &DockDetectorConfig) -> Observation {
        let sections = config.sections.max(1);
        // Number of points and sum of their distances.
        let mut seen = [vec![(0_usize, 0.0_f64); sections], vec![(0, 0.0); sections]];
        let (mut on, mut beyond, mut squares, mut normal) =
            ([0_usize; 2], [0_usize; 2], 0.0, Matrix3::zeros());
        let mut beside = 0_usize;
        for point in points {
            let local = pose.inverse_apply(*point);
            let side = usize::from(local[1] < 0.0);
            if let Some((nearest, row)) = self.row(local, config.inlier_m) {
                let section = (nearest.along_m / self.length_m * sections as f64) as usize;
                let (count, sum_m) = &mut seen[side][section.min(sections - 1)];
                (*count, *sum_m) = (*count + 1, *sum_m + nearest.off_m);
                on[side] += 1;
                squares += nearest.off_m.powi(2);
                normal += row * row.transpose();
            } else {
                let nearest = self.nearest(local);
                // A point of the plate's end may lie a little beyond it, by the noise.
                let from = self.length_m + config.inlier_m;
                let is_beyond = (from..from + config.beyond_m).contains(&nearest.along_m)
                    && nearest.off_m.abs() < config.inlier_m;
                beyond[side] += usize::from(is_beyond);
                let is_beside =
                    (0.0..self.length_m).contains(&nearest.along_m) && nearest.off_m.abs() < config.beside_m;
                beside += usize::from(is_beside);
            }
        }
        let count = on[0] + on[1];
        let variance = squares / count.max(1) as f64;
        let density = |count: usize, length_m: f64| count as f64 / length_m;
        let beyond_share =
            |side: usize| density(beyond[side], config.beyond_m) / density(on[side].max(1), self.length_m);
        let covariance = normal
            .try_inverse()
            .map_or(Matrix3::identity(), |inverse| inverse * variance.max(config.min_noise_m.powi(2)));
        let share = |seen: &[(usize, f64)]| match seen.last() {
            Some((1.., _)) => seen.iter().filter(|(count, _)| *count > 0).count() as f64 / sections as f64,
            _ => 0.0,
        };
        // The mean of few points is mostly noise.
        let full = seen.iter().flatten().filter(|(count, _)| *count >= config.min_section_points);
        let section_error_m = full.map(|(count, sum_m)| (sum_m / *count as f64).abs()).fold(0.0, f64::max);
        Observation {
            points: count,
            residual_m: variance.sqrt(),
            seen_share: [share(&seen[0]), share(&seen[1])],
            section_error_m,
            beyond_share: beyond_share(0).max(beyond_share(1)),
            beside_share: beside as f64 / (count + beside).max(1) as f64,
            covariance,
        }
    }
}
