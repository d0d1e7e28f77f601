//! Walking into a dock by what the scans show of it: look, go to a pose ahead of the dock that was found, then straight in, slowly.
//!
//! The map says only where to look. The dock found by [`DockDetector`] is kept in the odometry frame, which does not jump, and every further detection corrects
//! it. Where the dock is not seen for a while, the robot goes on by odometry. Whether it is charged is for others to say.

use crate::{Behaviour, BehaviourContext, BehaviourOutcome, PoseControlConfig};
use geometry::{Isometry, Rotation, Vector3, isometry_from_pose};
use messages::{GoalFailure, GoalProgress, SpeedLimits, WaitReason};
use navigation::{DockDetector, DockDetectorConfig, DockScans};
use site_model::PoseTolerance;
use std::f64::consts::PI;
use std::task::Poll;
use vocab::{Pose, Span, Stamp, Twist, Vec3};

/// Parameters of [`DockingBehaviour`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DockingConfig {
    /// The search for a dock at its place on the map.
    pub search: DockDetectorConfig,
    /// A dock that was found is looked for again within this distance of where it was, along each axis, metres. Chosen: five times [`Self::staging_across_m`], and a
    /// fifth of the distance of the first search, so that a detection takes less time and nothing else is taken for the dock.
    pub track_m: f64,
    /// And within this difference of heading, radians. Chosen: less than half of that of the first search; what is turned farther is something else.
    pub track_rad: f64,
    /// Scans of this time are looked at together. Noise averages out; odometry drifts by a millimetre in it. Chosen: ten sweeps at 10 Hz.
    pub scan_age: Span,
    /// Scans that are needed for the first detection. Chosen: half a second at 10 Hz, over which noise averages out.
    pub min_scans: usize,
    /// Time between two detections. A detection takes some milliseconds. Chosen: three sweeps at 10 Hz bring new points, and at [`Self::speed_m_s`] the robot goes 4.5 cm
    /// meanwhile.
    pub detection_period: Span,
    /// The robot stands and looks for the dock for this time. Chosen: sixteen detections. A dock that is not found by then is hidden or gone, and people wait.
    pub look_time: Span,
    /// Share by which a further detection corrects the dock that is known. Chosen: half averages the noise of detections. With 1 the dock jumps with each of them; with
    /// less, an error of the first one stays for longer.
    pub correction_share: f64,
    /// Distance from the dock within which it is not corrected any more, metres. The last steps follow odometry, without the noise of detections. Chosen: at
    /// [`Self::speed_m_s`] the robot needs 0.4 s for it, less than [`Self::scan_age`].
    pub blind_m: f64,
    /// Time without a detection, farther away than that, after which the dock counts as lost. Chosen: thirteen detections in a row have failed then, so it is no person
    /// who walks past.
    pub lost_time: Span,
    /// Distance ahead of the docked pose at which the robot aligns itself, metres. Chosen: from there the robot needs 3 s at [`Self::speed_m_s`], in which errors across
    /// fall to a fortieth at the gain of [`PoseControlConfig`].
    pub staging_m: f64,
    /// The same for a robot that cannot walk sideways: it needs the way to steer. Chosen: with [`Self::steering_gain_rad_per_m`] an error across falls by a factor of e
    /// on each third of a metre.
    pub steering_staging_m: f64,
    /// Errors with which the robot may go in: across, metres. Chosen: two thirds of what contacts allow for.
    pub staging_across_m: f64,
    /// And of the heading, radians. Chosen: 1.7 degrees, somewhat more than half of what contacts allow for.
    pub staging_yaw_rad: f64,
    /// And along the line, metres. Chosen: along the line the robot walks anyway, so it need not be exact.
    pub staging_along_m: f64,
    /// On the way in, the robot goes on only with errors below this multiple of those. Above 1, so that noise does not stop it. Chosen: twice the errors are still
    /// corrected on the way in.
    pub entering_ratio: f64,
    /// Pose in which contacts touch. Those of common docks allow for 3 cm and 3 degrees.
    pub contact: PoseTolerance,
    /// Share of it within which the robot ends. The rest is for the errors of detection. Chosen: a third. With more, fewer dockings charge; with less, the robot moves to
    /// and fro at the end for longer.
    pub contact_share: f64,
    /// Share of it beyond which a robot that has come to rest in the pose moves again. Between `contact_share` and 1. Chosen: below 1, so that the robot moves before the
    /// contacts part.
    pub settled_share: f64,
    /// Greatest speed while aligning, m/s. Chosen: about a quarter of the walking speed, so that the robot stops within some centimetres.
    pub staging_speed_m_s: f64,
    /// Greatest speed into the dock, m/s. Chosen: slow, because the walk ends at the contacts. Less makes docking longer.
    pub speed_m_s: f64,
    /// Greatest turning speed, rad/s. Chosen: a turn by the 15 degrees of the search takes half a second, so more gains nothing.
    pub max_turn_rad_s: f64,
    /// Gains, and when the robot has come to rest.
    pub control: PoseControlConfig,
    /// Heading for each metre of lateral error, rad/m, of a robot that cannot walk sideways. Chosen: an error across falls by a factor of e on each third of a metre of
    /// walk. More makes the robot swing round the line.
    pub steering_gain_rad_per_m: f64,
    /// Greatest such heading, radians. Chosen: 20 degrees, less than the slope of the plates of the marker (30 degrees), so that the robot sees the front of both.
    pub max_steering_rad: f64,
    /// Distance from the dock from which steering does not lead back to the line any more, metres. Such a robot backs out and tries again. Chosen: a quarter of the third
    /// of a metre over which an error falls by a factor of e.
    pub min_steering_distance_m: f64,
    /// Speed from which the robot takes the whole of that heading, m/s. A slower one turns less, and one that stands turns onto the line. Chosen: about half of
    /// [`Self::speed_m_s`].
    pub full_steering_speed_m_s: f64,
    /// A robot whose greatest sideways speed is below this does not walk sideways, m/s. Chosen: more slowly, errors of a few centimetres take longer than a second.
    pub min_sideways_m_s: f64,
    /// Time for the whole walk. Chosen: the walk from the staging pose takes 3 s at [`Self::speed_m_s`], and aligning and looking take some seconds each.
    pub time_limit: Span,
}

impl Default for DockingConfig {
    fn default() -> Self {
        Self {
            search: DockDetectorConfig::default(),
            track_m: 0.10,
            track_rad: 6.0_f64.to_radians(),
            scan_age: Span::from_millis(1_000),
            min_scans: 5,
            detection_period: Span::from_millis(300),
            look_time: Span::from_millis(5_000),
            correction_share: 0.5,
            blind_m: 0.06,
            lost_time: Span::from_millis(4_000),
            staging_m: 0.45,
            steering_staging_m: 1.0,
            staging_across_m: 0.02,
            staging_yaw_rad: 0.03,
            staging_along_m: 0.05,
            entering_ratio: 2.0,
            contact: PoseTolerance { along_m: 0.03, across_m: 0.03, yaw_rad: 0.0524 },
            contact_share: 0.35,
            settled_share: 0.8,
            staging_speed_m_s: 0.25,
            speed_m_s: 0.15,
            max_turn_rad_s: 0.5,
            control: PoseControlConfig::default(),
            steering_gain_rad_per_m: 3.0,
            max_steering_rad: 0.35,
            min_steering_distance_m: 0.08,
            full_steering_speed_m_s: 0.08,
            min_sideways_m_s: 0.05,
            time_limit: Span::from_millis(60_000),
        }
    }
}

/// A dock that the robot is to walk into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DockGoal {
    /// The docked base, as the map has it.
    pub map_from_docked: Pose,
    /// Whether the robot walks in forward, so that it looks at the dock. Otherwise it walks in backward.
    pub is_facing: bool,
    /// Greatest speed, m/s; none: that of the configuration.
    pub max_speed_m_s: Option<f64>,
}

/// A walk into a dock.
#[derive(Debug)]
pub struct DockingBehaviour {
    config: DockingConfig,
    limits: SpeedLimits,
    standing_height_m: f64,
    map_from_dock: Isometry,
    is_facing: bool,
    scans: DockScans,
    began: Stamp,
    phase: Phase,
    /// Where the dock was seen, once it was.
    dock: Option<SeenDock>,
    last_detection: Option<Stamp>,
    /// The dock's expected place in the odometry frame, by the map.
    odom_from_expected: Option<Isometry>,
    is_blind: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// The robot stands and looks for the dock.
    Looking { since: Option<Stamp> },
    /// It aligns itself ahead of the dock.
    Staging,
    /// It walks in.
    Entering,
    /// It stands in the pose.
    Settling { since: Stamp },
}

/// A dock, with x away from it.
#[derive(Clone, Copy, Debug)]
struct SeenDock {
    odom_from_dock: Isometry,
    seen: Stamp,
}

/// The robot in the frame of the dock: how far it is out, to the left of the line into the dock, and turned from the heading of the docked robot.
#[derive(Clone, Copy, Debug)]
struct Offset {
    out_m: f64,
    across_m: f64,
    turned_rad: f64,
}

impl DockingBehaviour {
    /// Walks into a dock. `standing_height_m` is the height of the base above the floor. None if the dock's pose is no pose.
    pub fn new(
        mut config: DockingConfig,
        limits: &SpeedLimits,
        standing_height_m: f64,
        at: Stamp,
        goal: &DockGoal,
    ) -> Option<Self> {
        let map_from_docked = isometry_from_pose(&goal.map_from_docked)?;
        if let Some(speed_m_s) = goal.max_speed_m_s.filter(|speed| *speed > 0.0) {
            config.staging_speed_m_s = config.staging_speed_m_s.min(speed_m_s);
            config.speed_m_s = config.speed_m_s.min(speed_m_s);
        }
        Some(Self {
            config,
            limits: *limits,
            standing_height_m,
            map_from_dock: map_from_docked * dock_from_heading(goal.is_facing),
            is_facing: goal.is_facing,
            scans: DockScans::default(),
            began: at,
            phase: Phase::Looking { since: None },
            dock: None,
            last_detection: None,
            odom_from_expected: None,
            is_blind: false,
        })
    }

    /// The known dock, or where the map has it, in the odometry frame.
    fn expected(&self) -> Option<Isometry> {
        self.dock.map(|dock| dock.odom_from_dock).or(self.odom_from_expected)
    }

    fn detector(&self) -> DockDetector {
        let search = self.config.search;
        DockDetector::new(match self.dock {
            None => search,
            Some(_) => DockDetectorConfig {
                search_m: self.config.track_m,
                search_rad: self.config.track_rad,
                ..search
            },
        })
    }

    /// Looks at the recent scans. Whether the dock was found in them.
    fn detect(&mut self, at: Stamp) -> bool {
        let Some(expected) = self.expected() else { return false };
        self.last_detection = Some(at);
        let Ok(found) = self.detector().detect(&self.scans.points(), &expected) else { return false };
        let share = self.dock.map_or(1.0, |_| self.config.correction_share);
        let odom_from_dock = blend(&expected, &found.frame_from_dock, share);
        self.dock = Some(SeenDock { odom_from_dock, seen: at });
        true
    }

    fn offset(&self, odom_from_base: &Isometry) -> Option<Offset> {
        let dock_from_base = self.dock?.odom_from_dock.inverse() * odom_from_base;
        let place = dock_from_base.translation.vector;
        let ahead =
            dock_from_base.rotation * dock_from_heading(self.is_facing).rotation.inverse() * Vector3::x();
        Some(Offset { out_m: place.x, across_m: place.y, turned_rad: ahead.y.atan2(ahead.x) })
    }

    fn can_walk_sideways(&self) -> bool {
        self.limits.sideways_m_s >= self.config.min_sideways_m_s
    }

    fn staging_m(&self) -> f64 {
        if self.can_walk_sideways() { self.config.staging_m } else { self.config.steering_staging_m }
    }

    fn is_aligned(&self, offset: &Offset) -> bool {
        offset.across_m.abs() <= self.config.staging_across_m
            && offset.turned_rad.abs() <= self.config.staging_yaw_rad
    }

    fn is_docked(&self, offset: &Offset, share: f64) -> bool {
        let PoseTolerance { along_m, across_m, yaw_rad } = self.config.contact;
        (offset.out_m / along_m).hypot(offset.across_m / across_m) <= share
            && offset.turned_rad.abs() <= yaw_rad * share
    }

    /// The next phase at this offset.
    fn advance(&mut self, at: Stamp, offset: &Offset) {
        let is_out = offset.out_m >= self.staging_m() - self.config.staging_along_m;
        self.phase = match self.phase {
            Phase::Staging if self.can_walk_sideways() => match self.is_aligned(offset) {
                true if (offset.out_m - self.staging_m()).abs() <= self.config.staging_along_m => {
                    Phase::Entering
                }
                _ => Phase::Staging,
            },
            // What is left of the lateral error is steered out on the way in.
            Phase::Staging if is_out => Phase::Entering,
            Phase::Entering if self.is_docked(offset, self.config.contact_share) => {
                Phase::Settling { since: at }
            }
            Phase::Entering if !self.can_walk_sideways() && self.is_beside(offset) => Phase::Staging,
            Phase::Settling { .. } if !self.is_docked(offset, self.config.settled_share) => Phase::Entering,
            phase => phase,
        };
    }

    /// Whether a robot that steers has come so near that it cannot get onto the line any more.
    fn is_beside(&self, offset: &Offset) -> bool {
        offset.out_m < self.config.min_steering_distance_m
            && offset.across_m.abs() > self.config.contact.across_m * self.config.contact_share
    }

    /// Velocity of the base in its own frame.
    fn velocity(&self, offset: &Offset) -> Twist {
        let config = &self.config;
        let (target_m, speed_m_s) = match self.phase {
            Phase::Staging => (self.staging_m(), config.staging_speed_m_s),
            _ => (0.0, config.speed_m_s),
        };
        let forward_m_s = speed_m_s.min(self.limits.forward_m_s);
        let mut out_m_s =
            (config.control.position_gain_per_s * (target_m - offset.out_m)).clamp(-forward_m_s, forward_m_s);
        let max_turn = config.max_turn_rad_s.min(self.limits.turn_rad_s);
        let turn =
            |error_rad: f64| (config.control.heading_gain_per_s * error_rad).clamp(-max_turn, max_turn);
        let sign = if self.is_facing { -1.0 } else { 1.0 };
        if !self.can_walk_sideways() {
            // Walking out or in at an angle to the line leads back to it. A robot that stands turns onto the line's heading.
            let steer = (config.steering_gain_rad_per_m * offset.across_m)
                .clamp(-config.max_steering_rad, config.max_steering_rad);
            let wanted_rad =
                -steer * out_m_s.signum() * (out_m_s.abs() / config.full_steering_speed_m_s).min(1.0);
            let turn = turn(wanted_rad - offset.turned_rad);
            return twist(sign * out_m_s, 0.0, turn);
        }
        let sideways = config.staging_speed_m_s.min(self.limits.sideways_m_s);
        let across_m_s = (-config.control.position_gain_per_s * offset.across_m).clamp(-sideways, sideways);
        // Nearer to the dock the robot goes in only while it is on the line.
        let is_off = offset.across_m.abs() > config.entering_ratio * config.staging_across_m
            || offset.turned_rad.abs() > config.entering_ratio * config.staging_yaw_rad;
        if self.phase == Phase::Entering && is_off {
            out_m_s = out_m_s.max(0.0);
        }
        let (sin, cos) = offset.turned_rad.sin_cos();
        let (forward, left) = (cos * out_m_s + sin * across_m_s, cos * across_m_s - sin * out_m_s);
        twist(sign * forward, sign * left, turn(-offset.turned_rad))
    }
}

impl Behaviour for DockingBehaviour {
    fn update(&mut self, context: &mut BehaviourContext<'_>) -> Poll<BehaviourOutcome> {
        let at = context.at;
        let frames = context.frames;
        if self.odom_from_expected.is_none() || matches!(self.phase, Phase::Looking { .. }) {
            self.odom_from_expected = Some(level(&(frames.map_from_odom.inverse() * self.map_from_dock)));
        }
        if at - self.began >= self.config.time_limit {
            return Poll::Ready(Err(GoalFailure::PathBlocked));
        }
        self.is_blind = !context.sees_ground;
        if self.is_blind {
            return Poll::Pending;
        }
        let is_due = self.last_detection.is_none_or(|last| at - last >= self.config.detection_period);
        if let Phase::Looking { since } = &mut self.phase {
            let began = *since.get_or_insert(at);
            let is_found = is_due && self.scans.len() >= self.config.min_scans && self.detect(at);
            if !is_found {
                let is_late = at - began >= self.config.look_time;
                return if is_late { Poll::Ready(Err(GoalFailure::DockNotSeen)) } else { Poll::Pending };
            }
            self.phase = Phase::Staging;
        }
        let Some(offset) = self.offset(&frames.odom_from_base) else { return Poll::Pending };
        let is_near = matches!(self.phase, Phase::Settling { .. })
            || (self.phase == Phase::Entering && offset.out_m < self.config.blind_m);
        if is_due && !is_near {
            self.detect(at);
        }
        let Some(offset) = self.offset(&frames.odom_from_base) else { return Poll::Pending };
        let is_lost = self.dock.is_some_and(|dock| at - dock.seen >= self.config.lost_time);
        if is_lost && !is_near {
            return Poll::Ready(Err(GoalFailure::DockNotSeen));
        }
        self.advance(at, &offset);
        match self.phase {
            Phase::Settling { since } if at - since >= self.config.control.settle_time => Poll::Ready(Ok(())),
            Phase::Settling { .. } => Poll::Pending,
            _ => {
                context.velocity = self.velocity(&offset);
                Poll::Pending
            }
        }
    }

    fn observe_scan(&mut self, at: Stamp, odom_from_base: &Isometry, points: &[[f32; 3]]) {
        let Some(expected) = self.expected() else { return };
        let times = ((at - self.began).secs_f64(), self.config.scan_age.secs_f64());
        let detector = self.detector();
        self.scans.insert(times, &detector, odom_from_base, self.standing_height_m, &expected, points);
    }

    fn progress(&self, odom_from_base: &Isometry) -> GoalProgress {
        let expected =
            self.expected().map(|dock| (dock.inverse() * odom_from_base).translation.vector.xy().norm());
        let rounded = expected.map(|distance_m| (10.0 * distance_m).round() / 10.0);
        GoalProgress { remaining_m: rounded, waits_for: self.is_blind.then_some(WaitReason::Sight) }
    }
}

/// The heading of the docked robot in the frame of the dock, whose x points away from it.
fn dock_from_heading(is_facing: bool) -> Isometry {
    let turn = if is_facing { PI } else { 0.0 };
    Isometry::from_parts(Vector3::zeros().into(), Rotation::from_euler_angles(0.0, 0.0, turn))
}

/// The pose without roll and pitch.
fn level(pose: &Isometry) -> Isometry {
    let ahead = pose.rotation * Vector3::x();
    let heading = Rotation::from_euler_angles(0.0, 0.0, ahead.y.atan2(ahead.x));
    Isometry::from_parts(pose.translation, heading)
}

/// The pose at a share of the way between two.
fn blend(from: &Isometry, to: &Isometry, share: f64) -> Isometry {
    let position = from.translation.vector.lerp(&to.translation.vector, share);
    Isometry::from_parts(position.into(), from.rotation.slerp(&to.rotation, share))
}

fn twist(forward: f64, left: f64, turn: f64) -> Twist {
    Twist { linear: Vec3::new(forward, left, 0.0), angular: Vec3::new(0.0, 0.0, turn) }
}
