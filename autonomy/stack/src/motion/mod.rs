//! What the robot is told to do with its legs: nothing, what a hand says, walk to a point, or look about.
//!
//! Goals are points of the map; terrain and paths are kept in the odometry's frame, in which nothing jumps unless odometry begins anew:
//! then all is forgotten. When a loop
//! closure moves the map, the obstacles round the robot stay where they are, and the way to the goal is planned anew.
//!
//! A robot that sees nothing does not walk by itself: it waits. One that loses its place in a saved map on its way looks about, and
//! goes on once it knows where it is.

mod look;
mod walk;

use geometry::{Isometry, Vector3, vec_to_plain};
use localisation::ExplorationHint;
use look::Look;
use messages::{Drive, MotionState};
use navigation::{RobotShape, Terrain, Velocity};
use vocab::{ClientId, Span, Stamp, Twist, Vec3};
use walk::{Step, Walk};

/// Silence after which driving by hand stops.
const TELEOPERATION_SILENCE: Span = Span::from_millis(500);
/// Without having seen the ground for so long, the robot does not walk by itself: slow LiDARs turn twice a second.
const BLIND_AFTER: Span = Span::from_millis(1_200);
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
    /// When the ground was seen last.
    seen: Option<Stamp>,
    /// Whether the robot waits to see again.
    waits: bool,
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
    Looking(Box<Look>),
    Blocked { goal: Vector3, reason: String },
}

impl Motion {
    /// A robot that stands.
    pub fn new(standing_height: Option<f64>) -> Self {
        let shape = RobotShape::default();
        let shape = RobotShape { standing_height: standing_height.unwrap_or(shape.standing_height), ..shape };
        Self {
            mode: Mode::Idle,
            terrain: Terrain::new(TERRAIN_CELL, shape),
            seen: None,
            waits: false,
            published: None,
        }
    }

    /// Learns where one can walk. `points` and the `sensor` that saw them in the base frame, metres.
    pub fn observe(&mut self, at: Stamp, odom_from_base: &Isometry, sensor: [f32; 3], points: &[[f32; 3]]) {
        self.seen = Some(at);
        self.terrain.insert_scan(odom_from_base, sensor, points, TERRAIN_RANGE);
    }

    /// A new map: what was known of the ground is looked at anew, and walks to points of the old map end. Returns what is to be
    /// said to the robot, if it walked.
    pub fn forget_map(&mut self) -> Option<Drive> {
        self.forget_ground();
        self.forget_goal()
    }

    fn forget_ground(&mut self) {
        self.terrain = Terrain::new(self.terrain.cell_size(), *self.terrain.shape());
        self.seen = None;
    }

    /// The map's frame is another one from now on, so that goals in it mean nothing any more. Returns what is to be said to the
    /// robot, if it walked.
    pub fn forget_goal(&mut self) -> Option<Drive> {
        let walked = matches!(self.mode, Mode::Walking(_) | Mode::Looking(_));
        if walked || matches!(self.mode, Mode::Blocked { .. }) {
            self.mode = Mode::Idle;
        }
        walked.then(Drive::default)
    }

    /// The odometry's frame is another one from now on, while the map stays: what was known of the ground is looked at anew, and a robot
    /// that walked has to find out first where it is. Returns what is to be said to the robot, if it walked.
    pub fn begin_anew(&mut self, at: Stamp) -> Option<Drive> {
        self.forget_ground();
        if let Mode::Looking(look) = &self.mode {
            self.mode = Mode::Looking(Box::new(Look::new(at, look.goal)));
            return Some(Drive::default());
        }
        self.lose_place(at)
    }

    /// The place in the map is not known any more: a robot that walked to a point of it stops, and looks about. Returns what is to be
    /// said to it then.
    pub fn lose_place(&mut self, at: Stamp) -> Option<Drive> {
        match &self.mode {
            Mode::Walking(walk) => {
                self.mode = Mode::Looking(Box::new(Look::new(at, Some(walk.goal))));
                Some(Drive::default())
            }
            Mode::Blocked { .. } => {
                self.mode = Mode::Idle;
                None
            }
            _ => None,
        }
    }

    /// Walks about a little, to see more, until the place in the map is known.
    pub fn look_about(&mut self, at: Stamp) -> Result<(), String> {
        self.refuse_while_stopped()?;
        if !matches!(self.mode, Mode::Looking(_)) {
            self.mode = Mode::Looking(Box::new(Look::new(at, None)));
        }
        Ok(())
    }

    /// The place in the map is known: a robot that looks about on its way somewhere goes on. Says whether there is one.
    pub fn go_on(&mut self, at: Stamp, frames: &Frames) -> bool {
        let Mode::Looking(look) = &self.mode else { return false };
        let Some(goal) = look.goal else { return false };
        self.mode = Mode::Walking(Box::new(Walk::resume(at, &self.terrain, frames, goal)));
        true
    }

    /// The place in the map is known: a robot that looks about for nothing else stops. Returns what is to be said to it then.
    pub fn end_look(&mut self) -> Option<Drive> {
        let ends = matches!(&self.mode, Mode::Looking(look) if look.goal.is_none());
        ends.then(|| {
            self.mode = Mode::Idle;
            Drive::default()
        })
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
        let walk = Walk::plan(at, &self.terrain, frames, goal).map_err(|e| e.to_string())?;
        self.mode = Mode::Walking(Box::new(walk));
        Ok(())
    }

    /// The command for now, if anything must be said to the robot: while it moves, and once when it stops. Whoever looks about goes by the
    /// hint.
    pub fn tick(&mut self, at: Stamp, frames: &Frames, exploration_hint: &ExplorationHint) -> Option<Drive> {
        let by_itself = matches!(self.mode, Mode::Walking(_) | Mode::Looking(_));
        self.waits = by_itself && self.seen.is_none_or(|seen| at - seen > BLIND_AFTER);
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
            Mode::Walking(walk) if self.waits => {
                walk.wait(at);
                Some(Drive::default())
            }
            Mode::Walking(walk) => {
                let goal = walk.goal;
                let step = walk.tick(at, &self.terrain, frames);
                self.move_on(step, Some(goal))
            }
            Mode::Looking(look) if self.waits => {
                look.wait(at);
                Some(Drive::default())
            }
            Mode::Looking(look) => {
                let goal = look.goal;
                let step = look.tick(at, &self.terrain, &frames.odom_from_base, exploration_hint);
                self.move_on(step, goal)
            }
        }
    }

    fn move_on(&mut self, step: Step, goal: Option<Vector3>) -> Option<Drive> {
        match step {
            Step::Go(velocity) => return Some(drive(velocity)),
            Step::Arrived => self.mode = Mode::Idle,
            Step::GaveUp(reason) => {
                self.mode = match goal {
                    Some(goal) => Mode::Blocked { goal, reason: reason.to_owned() },
                    None => Mode::Idle,
                };
            }
        }
        Some(Drive::default())
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
            Mode::Walking(walk) if self.waits => MotionState::Waiting { goal: vec_to_plain(&walk.goal) },
            Mode::Looking(look) => MotionState::Looking { goal: look.goal.map(|goal| vec_to_plain(&goal)) },
            Mode::Walking(walk) => MotionState::Walking {
                goal: vec_to_plain(&walk.goal),
                path: walk.path().iter().map(|point| vec_to_plain(&frames.to_map(point))).collect(),
                // Told in steps of 10 cm: it changes with every breath otherwise.
                remaining: (walk.remaining(&frames.odom_from_base) * 10.0).round() / 10.0,
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

fn drive(velocity: Velocity) -> Drive {
    Drive {
        velocity: Twist {
            linear: Vec3::new(velocity.forward, 0.0, 0.0),
            angular: Vec3::new(0.0, 0.0, velocity.turn),
        },
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
mod tests;
