//! What the robot is told to do with its legs: nothing, what a hand says, or walk to a point.

use geometry::{Isometry, Vector3, vec_to_plain};
use messages::{Drive, MotionState};
use navigation::{Follower, FollowerConfig, RobotShape, Terrain, plan};
use vocab::{ClientId, Span, Stamp, Twist, Vec3};

/// Silence after which driving by hand stops.
const TELEOPERATION_SILENCE: Span = Span::from_millis(500);
/// A walk is planned anew this often, because the terrain has been seen better.
const REPLAN_EVERY: Span = Span::from_millis(1_000);
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
    goal: Vector3,
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
    pub fn observe(&mut self, map_from_base: &Isometry, points: &[[f32; 3]]) {
        self.terrain.observe(map_from_base, points, TERRAIN_RANGE);
    }

    /// A new map frame: what was known of the old one is worth nothing, and walks in it end.
    pub fn forget_map(&mut self) {
        self.terrain = Terrain::new(self.terrain.cell_size(), *self.terrain.shape());
        if matches!(self.mode, Mode::Walking(_) | Mode::Blocked { .. }) {
            self.mode = Mode::Idle;
        }
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
    pub fn walk_to(&mut self, at: Stamp, map_from_base: &Isometry, goal: Vector3) -> Result<(), String> {
        self.refuse_while_stopped()?;
        if !goal.iter().all(|c| c.is_finite()) {
            return Err("That point is not on the map. Choose another.".to_owned());
        }
        let path =
            plan(&self.terrain, &map_from_base.translation.vector, &goal).map_err(|e| e.to_string())?;
        let follower = Follower::new(FollowerConfig::default(), path);
        self.mode = Mode::Walking(Box::new(Walk { goal, follower, planned: at, stuck: None }));
        Ok(())
    }

    /// The command for now, if anything must be said to the robot: while it moves, and once when it stops.
    pub fn tick(&mut self, at: Stamp, map_from_base: &Isometry) -> Option<Drive> {
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
                if at - walk.planned > REPLAN_EVERY {
                    walk.replan(at, &self.terrain, map_from_base);
                }
                let next = walk.drive(at, map_from_base);
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
    pub fn changed(&mut self, map_from_base: &Isometry) -> Option<MotionState> {
        let state = self.state(map_from_base);
        if self.published.as_ref() == Some(&state) {
            return None;
        }
        self.published = Some(state.clone());
        Some(state)
    }

    fn state(&self, map_from_base: &Isometry) -> MotionState {
        match &self.mode {
            Mode::Idle => MotionState::Idle,
            Mode::Stopped { by } => MotionState::Stopped { by: *by },
            Mode::Teleoperated { .. } => MotionState::Teleoperated,
            Mode::Blocked { goal, reason } => {
                MotionState::Blocked { goal: vec_to_plain(goal), reason: reason.clone() }
            }
            Mode::Walking(walk) => MotionState::Walking {
                goal: vec_to_plain(&walk.goal),
                path: walk.follower.path().iter().map(vec_to_plain).collect(),
                // Told in steps of 10 cm: it changes with every breath otherwise.
                remaining: (walk.follower.remaining(map_from_base) * 10.0).round() / 10.0,
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
    fn replan(&mut self, at: Stamp, terrain: &Terrain, map_from_base: &Isometry) {
        self.planned = at;
        match plan(terrain, &map_from_base.translation.vector, &self.goal) {
            Ok(path) => {
                self.follower = Follower::new(FollowerConfig::default(), path);
                self.stuck = None;
            }
            Err(_) => self.stuck = self.stuck.or(Some(at)),
        }
    }

    fn drive(&self, at: Stamp, map_from_base: &Isometry) -> Step {
        if let Some(since) = self.stuck {
            // Waits for people to pass.
            return if at - since > GIVE_UP_AFTER { Step::GaveUp } else { Step::Go(Drive::default()) };
        }
        match self.follower.velocity(map_from_base) {
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
