//! Walks into docks, by a robot that moves exactly as commanded and sees the marker of the dock.

use crate::docking::{DockGoal, DockingBehaviour, DockingConfig};
use crate::tests::room;
use crate::{Behaviour, BehaviourContext, BehaviourOutcome, Frames};
use geometry::{Isometry, RngTree, Rotation, Vector3, pose_from_isometry};
use localisation::ExplorationHint;
use messages::{GoalFailure, SpeedLimits};
use navigation::{DockMarker, ElevationMap, MotionGuard, MotionGuardConfig, RobotShape};
use std::f64::consts::PI;
use std::task::Poll;
use vocab::{Span, Stamp, Twist};

const HEIGHT_M: f64 = 0.5;

fn pose(x: f64, y: f64, heading: f64) -> Isometry {
    let rotation = Rotation::from_euler_angles(0.0, 0.0, heading);
    Isometry::from_parts(Vector3::new(x, y, HEIGHT_M).into(), rotation)
}

/// A dock whose robot is to stand at the origin, by the map.
struct Rig {
    behaviour: DockingBehaviour,
    /// The docked base, x away from the dock; none: the dock is gone.
    dock: Option<Isometry>,
    odom_from_base: Isometry,
    is_facing: bool,
    now: Stamp,
}

impl Rig {
    fn new(limits: SpeedLimits, is_facing: bool, dock: Option<Isometry>, base: Isometry) -> Self {
        let heading = if is_facing { PI } else { 0.0 };
        let goal = DockGoal {
            map_from_docked: pose_from_isometry(&pose(0.0, 0.0, heading)),
            is_facing,
            max_speed_m_s: None,
        };
        let behaviour =
            DockingBehaviour::new(DockingConfig::default(), &limits, HEIGHT_M, Stamp::EPOCH, &goal);
        Self {
            behaviour: behaviour.unwrap_or_else(|| panic!("no pose")),
            dock,
            odom_from_base: base * pose(0.0, 0.0, heading).rotation,
            is_facing,
            now: Stamp::EPOCH,
        }
    }

    /// Points on the marker, 3 cm apart, with noise.
    fn marker(&self, number: u64) -> Vec<[f32; 3]> {
        let mut rng = RngTree::new(number).rng();
        let DockMarker { ridge_m, half_width_m, depth_m, .. } = DockMarker::default();
        let base_from_odom = self.odom_from_base.inverse();
        let Some(dock) = self.dock else { return room() };
        let mut points = Vec::new();
        for step in -11..=11_i32 {
            for row in 0..6 {
                let share = f64::from(step) / 11.0;
                let x = -ridge_m - depth_m * share.abs() + 0.01 * rng.normal();
                let z = 0.8 + 0.05 * f64::from(row) - HEIGHT_M;
                let local = Vector3::new(x, half_width_m * share, z);
                let at = |pose: &Isometry, v: Vector3| pose.rotation * v + pose.translation.vector;
                let point = at(&base_from_odom, at(&dock, local));
                points.push([point.x as f32, point.y as f32, point.z as f32]);
            }
        }
        points
    }

    fn run(&mut self) -> BehaviourOutcome {
        let elevation_map = ElevationMap::new(
            0.1,
            RobotShape { radius_m: 0.38, standing_height_m: HEIGHT_M, clearance_m: 0.9, step_m: 0.2 },
        );
        let hint = ExplorationHint::default();
        let guard = MotionGuard::new(
            MotionGuardConfig::default(),
            &elevation_map,
            &self.odom_from_base.translation.vector,
            0.9,
        );
        for tick in 0..2_000_u64 {
            self.now += Span::from_millis(50);
            if tick % 2 == 0 {
                let points = self.marker(tick);
                self.behaviour.observe_scan(self.now, &self.odom_from_base, &points);
            }
            let mut context = BehaviourContext {
                at: self.now,
                frames: Frames { map_from_odom: Isometry::identity(), odom_from_base: self.odom_from_base },
                elevation_map: &elevation_map,
                guard: &guard,
                sees_ground: true,
                is_localised: true,
                exploration_hint: &hint,
                velocity: Twist::default(),
            };
            if let Poll::Ready(outcome) = self.behaviour.update(&mut context) {
                return outcome;
            }
            let Twist { linear, angular } = context.velocity;
            assert!(linear.x.abs() <= 0.9 && linear.y.abs() <= 0.25 && angular.z.abs() <= 0.9);
            let step = Vector3::new(linear.x, linear.y, 0.0) * 0.05;
            let turn = Rotation::from_euler_angles(0.0, 0.0, angular.z * 0.05);
            self.odom_from_base *= Isometry::from_parts(step.into(), turn);
        }
        panic!("it does not end, at {}", self.odom_from_base)
    }

    /// Distance and heading from the docked pose.
    fn error(&self) -> (f64, f64) {
        let heading = if self.is_facing { PI } else { 0.0 };
        let docked = self.dock.unwrap_or_else(|| panic!("no dock")) * pose(0.0, 0.0, heading).rotation;
        let error = docked.inverse() * self.odom_from_base;
        (error.translation.vector.xy().norm(), error.rotation.angle())
    }
}

const STRAFING: SpeedLimits = SpeedLimits { forward_m_s: 0.9, sideways_m_s: 0.25, turn_rad_s: 0.9 };
const STEERING: SpeedLimits = SpeedLimits { sideways_m_s: 0.0, ..STRAFING };

#[test]
fn the_robot_walks_into_a_dock_that_was_moved() {
    for limits in [STRAFING, STEERING] {
        for is_facing in [false, true] {
            for (x, y, heading) in [(0.0, 0.0, 0.0), (0.1, 0.12, 0.14), (-0.15, -0.1, -0.14)] {
                let mut rig = Rig::new(limits, is_facing, Some(pose(x, y, heading)), pose(1.2, 0.05, 0.05));
                assert_eq!(rig.run(), Ok(()), "{limits:?} {x} {y}");
                let (off_m, off_rad) = rig.error();
                assert!(off_m < 0.02 && off_rad < 0.04, "{off_m} m, {off_rad} rad, {limits:?} {x} {y}");
            }
        }
    }
}

#[test]
fn a_dock_that_is_gone_is_not_seen() {
    let mut rig = Rig::new(STRAFING, false, None, pose(1.2, 0.0, 0.0));
    assert_eq!(rig.run(), Err(GoalFailure::DockNotSeen));
    assert!((4.9..5.3).contains(&(rig.now - Stamp::EPOCH).secs_f64()));
    let mut rig = Rig::new(STRAFING, false, Some(pose(0.0, 1.0, 0.0)), pose(1.2, 0.0, 0.0));
    assert_eq!(rig.run(), Err(GoalFailure::DockNotSeen), "it is a metre from its place");
}
