//! What the robot is told to do with its legs: nothing, what a hand says, or walk to a point.
//!
//! Goals are points of the map; terrain and paths are kept in the odometry's frame, in which nothing jumps unless odometry begins anew:
//! then all is forgotten. When a loop
//! closure moves the map, the obstacles round the robot stay where they are, and the way to the goal is planned anew.

use geometry::{Isometry, Vector3, vec_to_plain};
use messages::{Drive, MotionState};
use navigation::{Follower, FollowerConfig, RobotShape, Terrain, plan};
use vocab::{ClientId, Span, Stamp, Twist, Vec3};

/// Silence after which driving by hand stops.
const TELEOPERATION_SILENCE: Span = Span::from_millis(500);
/// A walk is planned anew this often, because the terrain has been seen better.
const REPLAN_EVERY: Span = Span::from_millis(1_000);
/// And as soon as its goal has moved by this, metres, because a loop was closed.
const GOAL_MOVED: f64 = 0.05;
/// A way that stays blocked for this long ends the walk.
const GIVE_UP_AFTER: Span = Span::from_millis(8_000);
/// Fastest that a hand may drive: m/s forward, m/s sideways, rad/s.
const HAND_LIMITS: (f64, f64, f64) = (1.2, 0.5, 1.0);
/// Points farther than this teach the terrain nothing, metres.
const TERRAIN_RANGE: f64 = 12.0;
/// Side of a terrain cell, metres.
const TERRAIN_CELL: f64 = 0.1;

/// State of motion with what it needs to go on.
#[derive(Debug)]
pub(crate) struct Motion {
    mode: Mode,
    terrain: Terrain,
    published: Option<MotionState>,
}

/// Where everything is at an instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frames {
    pub map_from_odom: Isometry,
    pub odom_from_base: Isometry,
}

impl Frames {
    /// Base in the map.
    pub fn map_from_base(&self) -> Isometry {
        self.map_from_odom * self.odom_from_base
    }

    fn to_map(self, point: &Vector3) -> Vector3 {
        self.map_from_odom.rotation * point + self.map_from_odom.translation.vector
    }

    fn to_odom(self, point: &Vector3) -> Vector3 {
        self.map_from_odom.rotation.inverse() * (point - self.map_from_odom.translation.vector)
    }
}

#[derive(Debug)]
enum Mode {
    Idle,
    Stopped { by: Option<ClientId> },
    Teleoperated { velocity: Twist, since: Stamp },
    Walking(Box<Walk>),
    Blocked { goal: Vector3, reason: String },
}

#[derive(Debug)]
struct Walk {
    /// Map frame.
    goal: Vector3,
    /// Where the goal was in the odometry's frame when the way was planned.
    planned_to: Vector3,
    /// In the odometry's frame.
    follower: Follower,
    planned: Stamp,
    /// Since when no way has been found, if so.
    stuck: Option<Stamp>,
}

impl Motion {
    /// A robot that stands.
    pub fn new(standing_height: Option<f64>) -> Self {
        let shape = RobotShape::default();
        let shape = RobotShape { standing_height: standing_height.unwrap_or(shape.standing_height), ..shape };
        Self { mode: Mode::Idle, terrain: Terrain::new(TERRAIN_CELL, shape), published: None }
    }

    /// Learns where one can walk. `points` in the base frame, metres.
    pub fn observe(&mut self, odom_from_base: &Isometry, points: &[[f32; 3]]) {
        self.terrain.observe(odom_from_base, points, TERRAIN_RANGE);
    }

    /// A new map: what was known of the ground is looked at anew, and walks to points of the old map end. Returns what is to be
    /// said to the robot, if it walked.
    pub fn forget_map(&mut self) -> Option<Drive> {
        self.terrain = Terrain::new(self.terrain.cell_size(), *self.terrain.shape());
        self.forget_goal()
    }

    /// The map's frame is another one from now on, so that goals in it mean nothing any more. Returns what is to be said to the
    /// robot, if it walked.
    pub fn forget_goal(&mut self) -> Option<Drive> {
        let walked = matches!(self.mode, Mode::Walking(_));
        if walked || matches!(self.mode, Mode::Blocked { .. }) {
            self.mode = Mode::Idle;
        }
        walked.then(Drive::default)
    }

    /// Stops and stays stopped.
    pub fn stop(&mut self, by: Option<ClientId>) {
        self.mode = Mode::Stopped { by };
    }

    /// Lifts a stop.
    pub fn allow(&mut self) {
        if matches!(self.mode, Mode::Stopped { .. }) {
            self.mode = Mode::Idle;
        }
    }

    /// Drives by hand.
    pub fn teleoperate(&mut self, at: Stamp, velocity: Twist) -> Result<(), String> {
        self.refuse_while_stopped()?;
        if !velocity.linear.is_finite() || !velocity.angular.is_finite() {
            return Err("That velocity is not a number. Reload the page and try again.".to_owned());
        }
        self.mode = Mode::Teleoperated { velocity: limited(&velocity), since: at };
        Ok(())
    }

    /// Walks to `goal`, map frame, metres.
    pub fn walk_to(&mut self, at: Stamp, frames: &Frames, goal: Vector3) -> Result<(), String> {
        self.refuse_while_stopped()?;
        if !goal.iter().all(|c| c.is_finite()) {
            return Err("That point is not on the map. Choose another.".to_owned());
        }
        let planned_to = frames.to_odom(&goal);
        let from = &frames.odom_from_base.translation.vector;
        let path = plan(&self.terrain, from, &planned_to).map_err(|e| e.to_string())?;
        let follower = Follower::new(FollowerConfig::default(), path);
        self.mode = Mode::Walking(Box::new(Walk { goal, planned_to, follower, planned: at, stuck: None }));
        Ok(())
    }

    /// The command for now, if anything must be said to the robot: while it moves, and once when it stops.
    pub fn tick(&mut self, at: Stamp, frames: &Frames) -> Option<Drive> {
        match &mut self.mode {
            Mode::Idle | Mode::Blocked { .. } => None,
            Mode::Stopped { .. } => Some(Drive::default()),
            Mode::Teleoperated { velocity, since } => {
                if at - *since > TELEOPERATION_SILENCE {
                    self.mode = Mode::Idle;
                    return Some(Drive::default());
                }
                Some(Drive { velocity: *velocity })
            }
            Mode::Walking(walk) => {
                let goal = frames.to_odom(&walk.goal);
                if at - walk.planned > REPLAN_EVERY || (goal - walk.planned_to).norm() > GOAL_MOVED {
                    walk.replan(at, &self.terrain, &frames.odom_from_base, goal);
                }
                let next = walk.drive(at, &frames.odom_from_base);
                let (drive, mode) = match next {
                    Step::Go(drive) => return Some(drive),
                    Step::Arrived => (Drive::default(), Mode::Idle),
                    Step::GaveUp => {
                        let reason =
                            "The way has stayed blocked. Choose another point or drive round by hand.";
                        (Drive::default(), Mode::Blocked { goal: walk.goal, reason: reason.to_owned() })
                    }
                };
                self.mode = mode;
                Some(drive)
            }
        }
    }

    /// The state, if it changed enough since it was last said.
    pub fn changed(&mut self, frames: &Frames) -> Option<MotionState> {
        let state = self.state(frames);
        if self.published.as_ref() == Some(&state) {
            return None;
        }
        self.published = Some(state.clone());
        Some(state)
    }

    fn state(&self, frames: &Frames) -> MotionState {
        match &self.mode {
            Mode::Idle => MotionState::Idle,
            Mode::Stopped { by } => MotionState::Stopped { by: *by },
            Mode::Teleoperated { .. } => MotionState::Teleoperated,
            Mode::Blocked { goal, reason } => {
                MotionState::Blocked { goal: vec_to_plain(goal), reason: reason.clone() }
            }
            Mode::Walking(walk) => MotionState::Walking {
                goal: vec_to_plain(&walk.goal),
                path: walk.follower.path().iter().map(|point| vec_to_plain(&frames.to_map(point))).collect(),
                // Told in steps of 10 cm: it changes with every breath otherwise.
                remaining: (walk.follower.remaining(&frames.odom_from_base) * 10.0).round() / 10.0,
            },
        }
    }

    fn refuse_while_stopped(&self) -> Result<(), String> {
        if matches!(self.mode, Mode::Stopped { .. }) {
            return Err("Motion is stopped. Press \"Allow motion\" first.".to_owned());
        }
        Ok(())
    }
}

enum Step {
    Go(Drive),
    Arrived,
    GaveUp,
}

impl Walk {
    /// To `goal`, which is where the walk's goal is now in the odometry's frame.
    fn replan(&mut self, at: Stamp, terrain: &Terrain, odom_from_base: &Isometry, goal: Vector3) {
        (self.planned, self.planned_to) = (at, goal);
        match plan(terrain, &odom_from_base.translation.vector, &goal) {
            Ok(path) => {
                self.follower = Follower::new(FollowerConfig::default(), path);
                self.stuck = None;
            }
            Err(_) => self.stuck = self.stuck.or(Some(at)),
        }
    }

    fn drive(&self, at: Stamp, odom_from_base: &Isometry) -> Step {
        if let Some(since) = self.stuck {
            // Waits for people to pass.
            return if at - since > GIVE_UP_AFTER { Step::GaveUp } else { Step::Go(Drive::default()) };
        }
        match self.follower.velocity(odom_from_base) {
            None => Step::Arrived,
            Some(velocity) => Step::Go(Drive {
                velocity: Twist {
                    linear: Vec3::new(velocity.forward, 0.0, 0.0),
                    angular: Vec3::new(0.0, 0.0, velocity.turn),
                },
            }),
        }
    }
}

fn limited(velocity: &Twist) -> Twist {
    let (forward, sideways, turn) = HAND_LIMITS;
    Twist {
        linear: Vec3::new(
            velocity.linear.x.clamp(-forward, forward),
            velocity.linear.y.clamp(-sideways, sideways),
            0.0,
        ),
        angular: Vec3::new(0.0, 0.0, velocity.angular.z.clamp(-turn, turn)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shifted(x: f64, y: f64) -> Isometry {
        Isometry::translation(x, y, 0.0)
    }

    /// A robot on a level floor with a post 1.5 m ahead.
    fn on_a_floor() -> Motion {
        let mut motion = Motion::new(Some(0.5));
        let mut points: Vec<[f32; 3]> = Vec::new();
        for x in -40..=40_i8 {
            points.extend((-40..=40_i8).map(|y| [0.1 * f32::from(x), 0.1 * f32::from(y), -0.5]));
        }
        points.extend((0..20_u8).flat_map(|z| [[1.5, 0.0, 0.05 * f32::from(z) - 0.4]; 3]));
        for _ in 0..20 {
            motion.observe(&Isometry::identity(), &points);
        }
        motion
    }

    /// Where the way ends and how near it passes to the post, by the published state.
    fn way(motion: &mut Motion, frames: &Frames, post: (f64, f64)) -> ((f64, f64), f64) {
        let Some(MotionState::Walking { path, .. }) = motion.changed(frames) else { panic!("does not walk") };
        let mut nearest = f64::INFINITY;
        for pair in path.windows(2) {
            for step in 0..=20 {
                let share = f64::from(step) / 20.0;
                let [x, y] =
                    [(pair[0].x, pair[1].x), (pair[0].y, pair[1].y)].map(|(a, b)| a + share * (b - a));
                nearest = nearest.min((x - post.0).hypot(y - post.1));
            }
        }
        path.last().map(|end| ((end.x, end.y), nearest)).unwrap_or(((f64::NAN, f64::NAN), nearest))
    }

    #[test]
    fn a_map_that_moves_leaves_obstacles_where_they_are_and_the_goal_where_it_is_on_the_map() {
        let mut motion = on_a_floor();
        let mut frames = Frames { map_from_odom: shifted(10.0, 0.0), odom_from_base: Isometry::identity() };
        assert_eq!(motion.walk_to(Stamp::EPOCH, &frames, Vector3::new(13.0, 0.0, -0.5)), Ok(()));
        let (end, nearest) = way(&mut motion, &frames, (11.5, 0.0));
        assert!((end.0 - 13.0).hypot(end.1) < 0.15 && nearest > 0.2, "{end:?} {nearest}");
        // A loop moves the map by 0.6 m under the robot. The same instant: no time for planning as a matter of course.
        frames.map_from_odom = shifted(10.0, 0.6);
        assert!(motion.tick(Stamp::EPOCH, &frames).is_some_and(|drive| drive.velocity.linear.x >= 0.0));
        let (end, nearest) = way(&mut motion, &frames, (11.5, 0.6));
        assert!((end.0 - 13.0).hypot(end.1) < 0.15 && nearest > 0.2, "{end:?} {nearest}");
        let Mode::Walking(walk) = &motion.mode else { panic!("does not walk") };
        assert!(walk.stuck.is_none() && (walk.planned_to.y + 0.6).abs() < 1e-9, "{walk:?}");
    }
}
