//! Whether a robot can walk straight from one place to another, and how much room there is to both sides.

use crate::floor::Floor;
use crate::path::Path;
use geometry::Vector3;
use nalgebra::Vector2;

/// Free room along a line, metres, at most the distance that was searched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FreeWidth {
    /// To the nearest obstacle on the left.
    pub left_m: f64,
    /// To the nearest obstacle on the right.
    pub right_m: f64,
}

/// Heights of the ground along a line.
struct Profile {
    heights: Vec<f64>,
    /// Longest stretch without ground for the feet, metres.
    gap_m: f64,
}

/// A line between two places, seen from above.
struct Line {
    from: Vector3,
    to: Vector3,
    along: Vector2<f64>,
    length_m: f64,
}

impl Line {
    fn new(from: &Vector3, to: &Vector3) -> Self {
        let span = to.xy() - from.xy();
        let length_m = span.norm();
        let along = if length_m > 1e-6 { span / length_m } else { Vector2::x() };
        Self { from: *from, to: *to, along, length_m }
    }

    fn at(&self, distance_m: f64) -> Vector2<f64> {
        self.from.xy() + self.along * distance_m
    }

    fn left(&self) -> Vector2<f64> {
        Vector2::new(-self.along.y, self.along.x)
    }

    fn steps(&self, step_m: f64) -> usize {
        (self.length_m / step_m).ceil().max(1.0) as usize
    }
}

impl Floor {
    /// The ground along a line, checked as wide as the feet need it. None if the line ends on another floor.
    fn profile(&self, line: &Line) -> Option<Profile> {
        let step_m = self.config.line_step_m;
        let steps = line.steps(step_m);
        let side = line.left() * self.half_stance_m();
        let mut height = line.from.z;
        let mut profile = Profile { heights: Vec::with_capacity(steps + 1), gap_m: 0.0 };
        let mut gap_m = 0.0;
        for step in 0..=steps {
            let at = line.at(line.length_m * step as f64 / steps as f64);
            let found = self.ground(at.x, at.y, height);
            height = found.unwrap_or(height);
            let has_sides =
                [at + side, at - side].iter().all(|foot| self.ground(foot.x, foot.y, height).is_some());
            gap_m = if found.is_some() && has_sides { 0.0 } else { gap_m + step_m };
            profile.gap_m = profile.gap_m.max(gap_m);
            profile.heights.push(height);
        }
        ((height - line.to.z).abs() <= self.config.max_line_end_height_m).then_some(profile)
    }

    /// Free room along a line up to `reach_m` to both sides; `min_points` points in the height of the body (docs/maths/topomap.md, equation 2) make an
    /// obstacle. Linear in the points around it.
    fn room_along(&self, line: &Line, heights: &[f64], reach_m: f64, min_points: usize) -> FreeWidth {
        let last = heights.len() - 1;
        let tread = (self.config.tread_m / self.config.line_step_m).round() as usize;
        let highest = |place: usize| {
            let near = place.saturating_sub(tread)..=(place + tread).min(last);
            heights[near].iter().copied().fold(f64::NEG_INFINITY, f64::max)
        };
        let low: Vec<f64> = (0..=last).map(|place| highest(place) + self.robot.step_m).collect();
        let mut sides: [Vec<f64>; 2] = [Vec::new(), Vec::new()];
        for point in self.obstacles_around(&line.from, &line.to, reach_m) {
            let [x, y, z] = point.map(f64::from);
            let offset = Vector2::new(x, y) - line.from.xy();
            let (along_m, left_m) = (offset.dot(&line.along), offset.dot(&line.left()));
            let beyond_m = (-along_m).max(along_m - line.length_m).max(0.0);
            let distance_m = left_m.hypot(beyond_m);
            if distance_m > reach_m {
                continue;
            }
            let share = (along_m / line.length_m.max(1e-6)).clamp(0.0, 1.0);
            let place = (share * last as f64).round() as usize;
            if z > low[place] && z < heights[place] + self.robot.clearance_m {
                sides[usize::from(left_m < 0.0)].push(distance_m);
            }
        }
        let [left_m, right_m] = sides.map(|mut distances| {
            if min_points == 0 || distances.len() < min_points {
                return reach_m;
            }
            *distances.select_nth_unstable_by(min_points - 1, f64::total_cmp).1
        });
        FreeWidth { left_m, right_m }
    }

    /// Whether there is ground all along a line.
    pub fn has_ground(&self, from: &Vector3, to: &Vector3) -> bool {
        let profile = self.profile(&Line::new(from, to));
        profile.is_some_and(|profile| profile.gap_m <= self.config.max_ground_gap_m)
    }

    /// Whether there is ground all along a line, and no obstacle of at least `min_points` points within `clearance_m`.
    fn is_passable(&self, from: &Vector3, to: &Vector3, clearance_m: f64, min_points: usize) -> bool {
        let line = Line::new(from, to);
        let Some(profile) = self.profile(&line) else { return false };
        if profile.gap_m > self.config.max_ground_gap_m {
            return false;
        }
        let room = self.room_along(&line, &profile.heights, clearance_m, min_points);
        room.left_m.min(room.right_m) >= clearance_m
    }

    /// Free room along a line up to `reach_m` to both sides; none if it ends on another floor.
    pub fn room(&self, from: &Vector3, to: &Vector3, reach_m: f64) -> Option<FreeWidth> {
        let line = Line::new(from, to);
        let profile = self.profile(&line)?;
        Some(self.room_along(&line, &profile.heights, reach_m, self.config.min_obstacle_points))
    }

    /// How far from a line the robot may walk to both sides, metres: there is ground, and no obstacle within the radius in which it turns.
    pub fn corridor(&self, from: &Vector3, to: &Vector3) -> site_model::Corridor {
        let (line, max_m) = (Line::new(from, to), self.config.max_corridor_m);
        let none = site_model::Corridor { left_m: 0.0, right_m: 0.0 };
        let Some(profile) = self.profile(&line) else { return none };
        let reach_m = max_m + self.robot.radius_m;
        let room = self.room_along(&line, &profile.heights, reach_m, self.config.min_obstacle_points);
        let width = |side: f64, free_m: f64| {
            let free_m = (free_m - self.robot.radius_m).clamp(0.0, max_m);
            let ground_m = self.ground_beside(&line, &profile.heights, side, free_m);
            // Whole centimetres, because the points are no more accurate.
            (100.0 * free_m.min(ground_m)).floor() / 100.0
        };
        site_model::Corridor { left_m: width(1.0, room.left_m), right_m: width(-1.0, room.right_m) }
    }

    /// How far there is ground on one side of a line, metres, up to `max_m`. The feet need [`Floor::half_stance_m`] of it.
    fn ground_beside(&self, line: &Line, heights: &[f64], side: f64, max_m: f64) -> f64 {
        let last = heights.len() - 1;
        let step_m = self.config.line_step_m;
        let mut reached_m = max_m;
        for (place, height) in heights.iter().enumerate() {
            let middle = line.at(line.length_m * place as f64 / last.max(1) as f64);
            let (mut out_m, mut level) = (0.0, *height);
            while out_m < reached_m {
                let at = middle + line.left() * (side * (out_m + step_m + self.half_stance_m()));
                let Some(ground) = self.ground(at.x, at.y, level) else { break };
                level = ground;
                out_m += step_m;
            }
            reached_m = reached_m.min(out_m);
        }
        reached_m
    }
}

/// Decides which straight lines are paths.
pub(crate) struct Passage<'a> {
    pub floor: &'a Floor,
    pub path: &'a Path,
}

impl Passage<'_> {
    /// Whether a robot can walk straight from one place to another. Where it has walked along the line, the width of its body has to be free, and the
    /// circle in which it turns elsewhere.
    pub fn is_free(&self, from: &Vector3, to: &Vector3) -> bool {
        let (robot, config) = (&self.floor.robot, &self.floor.config);
        // Points are known to the middle of a voxel.
        let turning_m = robot.radius_m + config.voxel_m / 2.0;
        let is_passable = |clearance_m, min_points| self.floor.is_passable(from, to, clearance_m, min_points);
        is_passable(turning_m, config.min_obstacle_points)
            || (self.is_walked(from, to)
                && is_passable(self.floor.half_width_m(), config.min_blocking_points))
    }

    /// Whether the robot has walked along a line.
    fn is_walked(&self, from: &Vector3, to: &Vector3) -> bool {
        let steps = ((to - from).norm() / self.floor.config.sample_m).ceil().max(1.0) as usize;
        (0..=steps).all(|step| {
            let at = from.lerp(to, step as f64 / steps as f64);
            self.path.is_near(&at, self.floor.config.walked_within_m)
        })
    }
}
