//! Recovery of a localised robot after faults: its LiDAR is covered while it walks, and it is carried away. After it was carried, it
//! executes the relocalisation behaviour, as on the way to a goal.

use crate::POSITION_TOLERANCE_M;
use crate::mapped_site::MappedSite;
use crate::stack_walk::{StackWalk, WalkPlan};
use anyhow::{Context, Result};
use geometry::{Isometry, Rng, RngTree, Vector3, isometry_from_pose, pose_from_isometry};
use messages::{CommandKind, GoalKind, LocalisationState, Publication, StackEffect, TICK_PERIOD};
use sim::{ScheduledFault, SimulatedSite, Start};
use std::sync::Arc;
use uuid::Uuid;
use vocab::{GoalId, Pose, Span, Vec3};

/// A recovery that takes longer than this counts as failed, seconds.
const MAX_WAIT_S: f64 = 60.0;
/// Time for which the LiDAR is covered.
const COVERED_FOR: Span = Span::from_millis(20_000);
/// Greatest distance over which the robot is carried, metres.
const MAX_CARRY_DISTANCE_M: f64 = 25.0;
/// Time for which the robot is carried.
const CARRIED_FOR: Span = Span::from_millis(12_000);
/// Time for which the robot walks its route between two faults.
const WALK_BETWEEN: Span = Span::from_millis(15_000);
/// Interval at which a recovering robot is checked.
const CHECK_INTERVAL: Span = Span::from_millis(100);

/// Parameters of a walk with faults.
#[derive(Clone, Copy, Debug)]
pub struct FaultPlan {
    /// Number of times that the LiDAR is covered, and that the robot is carried away and back.
    pub faults: u32,
    /// Seed of the walk, of the changes of the site and of the places.
    pub seed: u64,
    /// LiDAR columns per sweep.
    pub columns: u32,
    /// Number of people who walk on the site.
    pub people: u32,
    /// Share of the furniture that is moved or removed.
    pub changed_share: f64,
    /// Least distance over which the robot is carried, metres.
    pub carry_distance_min_m: f64,
    /// Whether a line is printed for each place to which the robot was carried.
    pub verbose: bool,
}

/// The recoveries of a walk.
#[derive(Clone, Debug, Default)]
pub struct FaultRecoveries {
    /// Recoveries after the LiDAR was covered.
    pub covered: Vec<Recovery>,
    /// Recoveries after the robot was carried.
    pub carried: Vec<Recovery>,
    /// Number of scans after which a pose was claimed.
    pub claimed_scans: u64,
    /// Number of those with a wrong pose.
    pub wrong_scans: u64,
}

/// One fault and its recovery.
#[derive(Clone, Copy, Debug)]
pub struct Recovery {
    /// Straight-line distance between the positions before and after the fault, metres.
    pub distance_m: f64,
    /// Time from the end of the fault until the robot claims its right pose, seconds; infinite if that takes over a minute.
    pub duration_s: f64,
}

/// Localisation state that the stack published.
#[derive(Default)]
struct PublishedState {
    state: LocalisationState,
    map_from_base: Pose,
    /// Whether a scan was processed since the last reset.
    has_new_scan: bool,
    /// Number of goals that have ended. The next goal gets an identity of its own, because the stack ignores a goal that has had its outcome.
    ended_goals: u128,
}

impl PublishedState {
    fn update(&mut self, effects: &[StackEffect]) {
        for effect in effects {
            match effect {
                StackEffect::Publish(Publication::Localisation(state)) => self.state = *state,
                StackEffect::Publish(Publication::Estimate(estimate)) => {
                    self.map_from_base = estimate.map_from_base;
                }
                StackEffect::Publish(Publication::Goal(goal)) => {
                    self.ended_goals += u128::from(goal.status.is_outcome());
                }
                StackEffect::Publish(Publication::Scan(_)) => self.has_new_scan = true,
                _ => {}
            }
        }
    }

    /// Whether the robot claims to know its pose.
    fn claims_pose(&self) -> bool {
        matches!(self.state, LocalisationState::Localised { degradation: None, .. })
    }
}

/// A walk on another day with injected faults.
struct FaultyWalk<'a> {
    walk: StackWalk,
    published: PublishedState,
    mapped: &'a MappedSite,
    plan: FaultPlan,
    /// Number of scans after which a pose was claimed.
    claimed_scans: u64,
    /// Number of those with a wrong pose.
    wrong_scans: u64,
    rng: Rng,
}

impl FaultyWalk<'_> {
    /// Continues for `duration`, one tick after the other. Returns whether the robot claimed its right pose after the last scan and still does.
    fn advance(&mut self, duration: Span) -> Result<bool> {
        let until = self.walk.simulator().elapsed() + duration;
        let mut is_right = false;
        while self.walk.simulator().elapsed() < until {
            let next = self.walk.simulator().elapsed() + TICK_PERIOD;
            let published = &mut self.published;
            self.walk.walk_until(next, &mut |_, _, effects| published.update(effects))?;
            if std::mem::take(&mut self.published.has_new_scan) && self.published.claims_pose() {
                is_right = self.position_error_m()? < POSITION_TOLERANCE_M;
                self.claimed_scans += 1;
                self.wrong_scans += u64::from(!is_right);
            }
        }
        Ok(is_right && self.published.claims_pose())
    }

    fn position_error_m(&self) -> Result<f64> {
        let map_from_base =
            isometry_from_pose(&self.published.map_from_base).context("the stack published no pose")?;
        let site_from_base: Isometry = self.mapped.site_from_map * map_from_base;
        Ok((site_from_base.translation.vector - self.true_position()?).norm())
    }

    /// Waits until the robot claims its right pose; returns the time that takes, seconds. A robot in the state `Relocalising` is sent the
    /// goal `Relocalise`, which the stack starts by itself only on the way to a goal.
    fn wait_for_recovery(&mut self) -> Result<f64> {
        let mut waited_s = 0.0;
        while waited_s < MAX_WAIT_S {
            if matches!(self.published.state, LocalisationState::Relocalising { .. }) {
                let published = &mut self.published;
                // A robot that already executes this goal ignores the command.
                let goal = GoalId(Uuid::from_u128(published.ended_goals + 1));
                let command = CommandKind::StartGoal { goal, kind: GoalKind::Relocalise };
                self.walk.send_command(command, &mut |_, _, effects| published.update(effects));
            }
            let is_right = self.advance(CHECK_INTERVAL)?;
            waited_s += 0.1;
            if is_right {
                return Ok(waited_s);
            }
        }
        Ok(f64::INFINITY)
    }

    /// Covers the LiDAR while the robot walks.
    fn cover(&mut self) -> Result<Recovery> {
        let (from, before) = (self.walk.simulator().elapsed(), self.true_position()?);
        let until = from + COVERED_FOR;
        self.walk.simulator().inject_fault(ScheduledFault::BlindLidar { from, until });
        self.advance(COVERED_FOR)?;
        let distance_m = (self.true_position()? - before).norm();
        Ok(Recovery { distance_m, duration_s: self.wait_for_recovery()? })
    }

    /// True position of the base in the site, metres.
    fn true_position(&self) -> Result<Vector3> {
        Ok(self.walk.site_from_base()?.translation.vector)
    }

    /// Carries the robot to another pose and back. Returns two recoveries, or none if there is no other pose.
    fn carry_there_and_back(&mut self) -> Result<Vec<Recovery>> {
        let here = self.walk.site_from_base()?;
        let Some(there) = self.other_place(&here.translation.vector) else { return Ok(Vec::new()) };
        self.walk.follow_stack(true);
        let back = start(&here.translation.vector, here.rotation.euler_angles().2);
        let mut recoveries = Vec::new();
        for to in [there, back] {
            let before = self.true_position()?;
            self.walk.simulator().carry(to, CARRIED_FOR);
            self.advance(CARRIED_FOR)?;
            let distance_m = (self.true_position()? - before).norm();
            let duration_s = self.wait_for_recovery()?;
            recoveries.push(Recovery { distance_m, duration_s });
            if self.plan.verbose {
                self.print_recovery(&to, duration_s)?;
            }
            let published = &mut self.published;
            for command in [CommandKind::StopMotion, CommandKind::AllowMotion] {
                self.walk.send_command(command, &mut |_, _, effects| published.update(effects));
            }
        }
        self.return_to_route(back)?;
        self.walk.follow_stack(false);
        Ok(recoveries)
    }

    /// Carries the robot back to its route, because it may have walked off while it relocalised, and sends it its pose.
    fn return_to_route(&mut self, route: Start) -> Result<()> {
        self.walk.simulator().carry(route, CARRIED_FOR);
        self.advance(CARRIED_FOR)?;
        let map_from_base = self.mapped.site_from_map.inverse() * self.walk.site_from_base()?;
        let (map, at) = (self.mapped.prior_map.map, Some(pose_from_isometry(&map_from_base)));
        let published = &mut self.published;
        self.walk.send_command(CommandKind::Localise { map, at }, &mut |_, _, effects| {
            published.update(effects);
        });
        self.wait_for_recovery()?;
        Ok(())
    }

    #[allow(clippy::print_stdout, reason = "part of the table of a benchmark")]
    /// Prints the position at which the robot was put down, the duration of the recovery, and the present position.
    fn print_recovery(&self, to: &Start, duration_s: f64) -> Result<()> {
        let (error_m, now) = (self.position_error_m()?, self.true_position()?);
        let Vec3 { x, y, z } = to.position;
        let place = format!("{x:.1},{y:.1},{z:.1}");
        println!("{place:>20}{duration_s:>11.1} s{error_m:>9.3} m off at {:.1},{:.1}", now.x, now.y);
        Ok(())
    }

    /// A random keyframe of the map on the same floor, at the distance over which the robot is carried.
    fn other_place(&mut self, here: &Vector3) -> Option<Start> {
        let keyframes = self.mapped.localisation_map.keyframes();
        let places = keyframes.iter().map(|(pose, _)| (self.mapped.site_from_map * *pose).translation.vector);
        let site = Arc::clone(self.walk.simulator().site());
        let least_m = self.plan.carry_distance_min_m;
        let fits = |place: &Vector3| {
            let distance = (place - here).xy().norm();
            let feet = place - Vector3::z() * (here.z - floor_height(&site, here));
            (least_m..MAX_CARRY_DISTANCE_M).contains(&distance)
                && (place.z - here.z).abs() < 0.2
                && site.has_room(&feet)
        };
        let places: Vec<Vector3> = places.filter(fits).collect();
        let index = (self.rng.uniform() * places.len() as f64) as usize;
        let place = places.get(index)?;
        Some(start(place, self.rng.range(0.0, std::f64::consts::TAU)))
    }
}

/// Height of the floor under the base, site frame, metres.
fn floor_height(site: &SimulatedSite, base: &Vector3) -> f64 {
    base.z - site.cast_ray(base, &-Vector3::z(), 2.0).map_or(0.0, |(down, _)| down)
}

fn start(place: &Vector3, yaw: f64) -> Start {
    Start { position: Vec3::new(place.x, place.y, place.z), yaw }
}

/// Walks on another day with faults.
///
/// # Errors
/// When the site has no round.
pub fn walk_with_faults(mapped: &MappedSite, plan: &FaultPlan) -> Result<FaultRecoveries> {
    let seed = plan.seed;
    let site = Arc::new(mapped.site.on_another_day(seed, plan.changed_share));
    let walk_plan = WalkPlan { seed, columns: plan.columns, people: plan.people, keep_ground_truth: false };
    let mut published = PublishedState::default();
    let prior_map = Arc::clone(&mapped.prior_map);
    let mut observer = |_, _, effects: &[StackEffect]| published.update(effects);
    let walk = StackWalk::localised(&site, "round", &walk_plan, prior_map, None, &mut observer)?;
    let rng = RngTree::new(seed).child("carried").rng();
    let mut walk = FaultyWalk { walk, published, mapped, plan: *plan, claimed_scans: 0, wrong_scans: 0, rng };
    let (mut covered, mut carried) = (Vec::new(), Vec::new());
    for _ in 0..plan.faults {
        walk.advance(WALK_BETWEEN)?;
        covered.push(walk.cover()?);
        walk.advance(WALK_BETWEEN)?;
        carried.extend(walk.carry_there_and_back()?);
    }
    Ok(FaultRecoveries { covered, carried, claimed_scans: walk.claimed_scans, wrong_scans: walk.wrong_scans })
}
