//! Recovery of a localised robot after faults: its LiDAR is covered while it walks, and it is carried away. After it was carried, it
//! executes the relocalisation behaviour, as on the way to a goal.

use crate::arguments::Arguments;
use crate::mapped_site::MappedSite;
use anyhow::{Context, Result};
use benches::quantile;
use benches::stack_walk::{StackWalk, WalkPlan};
use geometry::{Isometry, Rng, RngTree, Vector3, isometry_from_pose, pose_from_isometry};
use messages::{CommandKind, GoalKind, LocalisationState, Publication, StackEffect, TICK_PERIOD};
use sim::{ScheduledFault, Site, Start};
use std::sync::Arc;
use uuid::Uuid;
use vocab::{GoalId, Pose, Span, Vec3};

/// Limit of the duration of a recovery, seconds.
const RECOVERY_MAX_S: f64 = 15.0;
/// A recovery that takes longer than this counts as failed, seconds.
const WAIT_MAX_S: f64 = 60.0;
/// A claimed position is wrong if it is farther than this from the truth, metres.
const POSITION_TOLERANCE_M: f64 = 0.2;
/// Time for which the LiDAR is covered.
const COVERED_FOR: Span = Span::from_millis(20_000);
/// Least distance over which the robot is carried, metres.
const CARRY_DISTANCE_MIN_M: f64 = 15.0;
/// Greatest distance over which the robot is carried, metres.
const CARRY_DISTANCE_MAX_M: f64 = 25.0;
/// Time for which the robot is carried.
const CARRIED_FOR: Span = Span::from_millis(12_000);
/// Time for which the robot walks its route between two faults.
const WALK_BETWEEN: Span = Span::from_millis(15_000);
/// Interval at which a recovering robot is checked.
const CHECK_INTERVAL: Span = Span::from_millis(100);

/// Prints the names of the columns. For each kind of fault: the number of faults; the least distance over which the robot moved or was carried
/// meanwhile (straight line, metres); the number of recoveries within the bar; their median and greatest duration. Then the number of scans
/// after which the robot claimed a pose, and the number of those with a wrong pose.
pub fn print_header() {
    println!(
        "{:<8}{:>12}{:>8}{:>9}{:>11}{:>11}{:>9}",
        "site", "fault", "number", "least m", "in 15 s", "median s", "worst s"
    );
}

/// One fault and its recovery.
struct Recovery {
    /// Straight-line distance between the positions before and after the fault, metres.
    distance_m: f64,
    /// Time from the end of the fault until the robot claims its right pose, seconds.
    duration_s: f64,
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
    /// Number of scans after which a pose was claimed.
    claimed_scans: u64,
    /// Number of those with a wrong pose.
    wrong_scans: u64,
    rng: Rng,
    verbose: bool,
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
        while waited_s < WAIT_MAX_S {
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
            if self.verbose {
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
        let fits = |place: &Vector3| {
            let distance = (place - here).xy().norm();
            let feet = place - Vector3::z() * (here.z - floor_height(&site, here));
            (CARRY_DISTANCE_MIN_M..CARRY_DISTANCE_MAX_M).contains(&distance)
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
fn floor_height(site: &Site, base: &Vector3) -> f64 {
    base.z - site.cast_ray(base, &-Vector3::z(), 2.0).map_or(0.0, |(down, _)| down)
}

fn start(place: &Vector3, yaw: f64) -> Start {
    Start { position: Vec3::new(place.x, place.y, place.z), yaw }
}

/// Walks on another day with faults; returns whether every recovery took at most 15 s and no wrong pose was claimed.
pub fn run(mapped: &MappedSite, arguments: &Arguments) -> Result<bool> {
    let seed = 100 * arguments.seed + 77;
    let site = Arc::new(Site::with_changes(mapped.site.name(), seed, arguments.changed_share));
    let plan =
        WalkPlan { seed, columns: arguments.columns, people: arguments.day_people, keep_ground_truth: false };
    let mut published = PublishedState::default();
    let prior_map = Arc::clone(&mapped.prior_map);
    let mut observer = |_, _, effects: &[StackEffect]| published.update(effects);
    let walk = StackWalk::localised(&site, "round", &plan, prior_map, None, &mut observer)?;
    let rng = RngTree::new(seed).child("carried").rng();
    let mut walk = FaultyWalk {
        walk,
        published,
        mapped,
        claimed_scans: 0,
        wrong_scans: 0,
        rng,
        verbose: arguments.verbose,
    };
    let (mut covered, mut carried) = (Vec::new(), Vec::new());
    for _ in 0..arguments.fault_recoveries {
        walk.advance(WALK_BETWEEN)?;
        covered.push(walk.cover()?);
        walk.advance(WALK_BETWEEN)?;
        carried.extend(walk.carry_there_and_back()?);
    }
    for (fault, recoveries) in [("covered", &covered), ("carried", &carried)] {
        print_recoveries(mapped, fault, recoveries);
    }
    println!(
        "{:<8}{:>12}{:>8}{:>20}",
        mapped.site.name(),
        "wrong scans",
        walk.claimed_scans,
        walk.wrong_scans
    );
    let in_time = covered.iter().chain(&carried).all(|recovery| recovery.duration_s <= RECOVERY_MAX_S);
    Ok(in_time && walk.wrong_scans == 0)
}

fn print_recoveries(mapped: &MappedSite, fault: &str, recoveries: &[Recovery]) {
    let mut durations: Vec<f64> = recoveries.iter().map(|recovery| recovery.duration_s).collect();
    durations.sort_by(f64::total_cmp);
    let in_time = durations.iter().filter(|seconds| **seconds <= RECOVERY_MAX_S).count();
    let least_m = recoveries.iter().map(|recovery| recovery.distance_m).fold(f64::INFINITY, f64::min);
    println!(
        "{:<8}{:>12}{:>8}{:>9.1}{:>11}{:>11.1}{:>9.1}",
        mapped.site.name(),
        fault,
        durations.len(),
        least_m,
        in_time,
        quantile(&durations, 0.5),
        quantile(&durations, 1.0)
    );
}
