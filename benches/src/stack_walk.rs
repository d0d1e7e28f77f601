//! Runs the whole stack on a simulated walk, faster than real time, in one thread. Jobs run as soon as the stack starts them.

use crate::thread_ms;
use anyhow::{Context, Result, bail, ensure};
use geometry::{Isometry, isometry_from_pose, se3};
use messages::{
    BootRecord, Command, CommandKind, Drive, FinishedMap, Input, Job, JobId, Principal, PriorMap,
    Publication, StackEffect, TICK_PERIOD,
};
use sim::{RouteFollower, SimConfig, SimulatedSite, Simulator, SiteRoute};
use stack::{ComputeJob, Stack};
use std::collections::VecDeque;
use std::sync::Arc;
use uuid::Uuid;
use vocab::{ClientId, CommandId, MapId, Pose, SessionId, Span, Stamp};

/// Parameters of a simulated walk.
#[derive(Clone, Copy, Debug)]
pub struct WalkPlan {
    /// Seed of the simulation.
    pub seed: u64,
    /// LiDAR columns per sweep.
    pub columns: u32,
    /// Number of people who walk on the site.
    pub people: u32,
    /// Whether the ground truth is kept for [`StackWalk::finish`], which takes about 64 B per millisecond.
    pub keep_ground_truth: bool,
}

/// The kind of input of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepKind {
    /// A tick, a command, or the boot record.
    Other,
    /// A message of a sensor.
    Sensor,
    /// The result of a job.
    JobResult,
}

/// Callback after every step: the kind of its input, its CPU time (milliseconds) and its effects.
pub type StepObserver<'a> = &'a mut dyn FnMut(StepKind, f64, &[StackEffect]);

/// A job that the stack has started.
#[derive(Clone, Copy, Debug)]
enum PendingJob {
    /// A computation of the stack.
    ComputeJob(JobId),
    /// Reading a saved map.
    Map(JobId),
}

/// A robot with the whole stack that walks a route of its site repeatedly.
pub struct StackWalk {
    simulator: Simulator,
    route: SiteRoute,
    walker: RouteFollower,
    stack: Stack,
    effects: Vec<StackEffect>,
    jobs: VecDeque<PendingJob>,
    finished: Option<Arc<FinishedMap>>,
    ground_truth: Option<Vec<(Stamp, Isometry)>>,
    /// Number of times that the route was walked to its end.
    rounds: u32,
    /// The result of reading a saved map.
    prior_map: Option<Arc<PriorMap>>,
    /// The drive command of the stack, if the robot follows it instead of its route.
    stack_drive: Option<Drive>,
    /// Number of commands sent to the stack.
    commands: u128,
}

/// How far a robot walks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WalkExtent {
    /// Until the simulated time since the start reaches this.
    Time(Span),
    /// To the end of its route.
    Round,
}

/// A robot that has not reached the end of its route by then is stuck.
const LONGEST_ROUND: Span = Span::from_millis(7_200_000);
/// How often is looked whether a round has ended.
const ROUND_STEP: Span = Span::from_millis(1_000);

impl StackWalk {
    /// A robot that maps its site while it walks a route of it, usually `round`.
    ///
    /// # Errors
    /// When the site has no such route.
    pub fn new(
        site: &Arc<SimulatedSite>,
        route: &str,
        plan: &WalkPlan,
        observer: StepObserver<'_>,
    ) -> Result<Self> {
        let mut walk = Self::prepared(site, route, plan)?;
        walk.boot(Some(SessionId(Uuid::from_u128(1))), observer);
        Ok(walk)
    }

    /// A robot that is localised in a prior map of its site while it walks a route. Without a `pose_prior` it has to localise globally first.
    ///
    /// # Errors
    /// When the site has no such route.
    pub fn localised(
        site: &Arc<SimulatedSite>,
        route: &str,
        plan: &WalkPlan,
        prior_map: Arc<PriorMap>,
        pose_prior: Option<Pose>,
        observer: StepObserver<'_>,
    ) -> Result<Self> {
        let mut walk = Self::prepared(site, route, plan)?;
        let map = prior_map.map;
        walk.prior_map = Some(prior_map);
        walk.boot(None, observer);
        walk.send(
            [
                CommandKind::TakeControl { name: "bench".to_owned() },
                CommandKind::Localise { map, at: pose_prior },
            ],
            observer,
        );
        Ok(walk)
    }

    fn prepared(site: &Arc<SimulatedSite>, route: &str, plan: &WalkPlan) -> Result<Self> {
        let route = site.route(route).cloned().with_context(|| format!("the site has no route {route}"))?;
        let config = SimConfig {
            lidar_columns: plan.columns,
            people: plan.people,
            start: Some(route.start),
            ..SimConfig::new(Arc::clone(site), plan.seed)
        };
        Ok(Self {
            simulator: Simulator::new(config),
            walker: RouteFollower::new(route.clone()),
            route,
            stack: Stack::new(),
            effects: Vec::new(),
            jobs: VecDeque::new(),
            finished: None,
            ground_truth: plan.keep_ground_truth.then(Vec::new),
            rounds: 0,
            prior_map: None,
            stack_drive: None,
            commands: 0,
        })
    }

    fn boot(&mut self, session: Option<SessionId>, observer: StepObserver<'_>) {
        let boot = BootRecord { start_mapping: session, ..self.simulator.boot() };
        self.step(self.simulator.now(), StepKind::Other, Input::Boot(Box::new(boot)), observer);
    }

    fn send<const N: usize>(&mut self, commands: [CommandKind; N], observer: StepObserver<'_>) {
        let (now, by) = (self.simulator.now(), ClientId(Uuid::from_u128(1)));
        for kind in commands {
            self.commands += 1;
            let id = CommandId(Uuid::from_u128(self.commands));
            let command = Command { id, by: Principal::operator(by), kind };
            self.step(now, StepKind::Other, Input::Command(command), observer);
            self.run_jobs(now, observer);
        }
    }

    /// The ground truth so far, if it is kept.
    pub fn ground_truth(&self) -> GroundTruthTrack {
        GroundTruthTrack(self.ground_truth.clone().unwrap_or_default())
    }

    /// Walks until the simulated time since the start reaches `until`.
    ///
    /// # Errors
    /// When the simulator's truth is not a valid pose.
    pub fn walk_until(&mut self, until: Span, observer: StepObserver<'_>) -> Result<()> {
        let mut events = Vec::new();
        while self.simulator.elapsed() < until {
            let drive = self.drive();
            self.simulator.command(drive);
            self.simulator.advance(self.simulator.now() + TICK_PERIOD, &mut events);
            let states = self.simulator.take_ground_truth();
            if let Some(kept) = &mut self.ground_truth {
                for truth in states {
                    let pose = isometry_from_pose(&truth.site_from_base).context("a true pose is no pose")?;
                    kept.push((truth.stamp, pose));
                }
            }
            for event in events.drain(..) {
                self.step(event.at, StepKind::Sensor, Input::Sensor(event.sensor), observer);
                self.run_jobs(event.at, observer);
            }
            self.step(self.simulator.now(), StepKind::Other, Input::Tick, observer);
        }
        Ok(())
    }

    /// Walks until a time, or to the end of the route.
    ///
    /// # Errors
    /// When the simulator's truth is not a valid pose, or a round takes longer than [`LONGEST_ROUND`].
    pub fn walk(&mut self, extent: WalkExtent, observer: StepObserver<'_>) -> Result<()> {
        match extent {
            WalkExtent::Time(until) => self.walk_until(until, observer),
            WalkExtent::Round => {
                while self.rounds == 0 {
                    ensure!(
                        self.simulator.elapsed() < LONGEST_ROUND,
                        "the robot does not reach the end of its route"
                    );
                    self.walk_until(self.simulator.elapsed() + ROUND_STEP, observer)?;
                }
                Ok(())
            }
        }
    }

    /// Sets whether the robot follows the drive commands of its stack from now on, or its route.
    pub fn follow_stack(&mut self, follows: bool) {
        self.stack_drive = follows.then(Drive::default);
    }

    /// Sends the stack a command.
    pub fn send_command(&mut self, kind: CommandKind, observer: StepObserver<'_>) {
        self.send([kind], observer);
    }

    /// The simulator, for its clock and its faults.
    pub fn simulator(&mut self) -> &mut Simulator {
        &mut self.simulator
    }

    /// Number of times that the route was walked to its end.
    pub fn rounds(&self) -> u32 {
        self.rounds
    }

    /// The true pose of the base in the site.
    ///
    /// # Errors
    /// When the simulator's truth is not a valid pose.
    pub fn site_from_base(&self) -> Result<Isometry> {
        isometry_from_pose(&self.simulator.truth().site_from_base).context("a true pose is no pose")
    }

    /// Ends the walk and returns the map, with the ground truth if it was kept.
    ///
    /// # Errors
    /// When the stack makes no map.
    pub fn finish(mut self, observer: StepObserver<'_>) -> Result<(Arc<FinishedMap>, GroundTruthTrack)> {
        let map = MapId(Uuid::from_u128(1));
        let finish = CommandKind::FinishMapping { map, name: "bench".to_owned() };
        self.send([CommandKind::TakeControl { name: "bench".to_owned() }, finish], observer);
        let Some(finished) = self.finished else { bail!("the stack made no map") };
        Ok((finished, GroundTruthTrack(self.ground_truth.unwrap_or_default())))
    }

    /// The next drive command. At its end the route begins again.
    fn drive(&mut self) -> Drive {
        if let Some(drive) = self.stack_drive {
            return drive;
        }
        let truth = self.simulator.truth();
        self.walker.drive(&truth).unwrap_or_else(|| {
            self.rounds += 1;
            self.walker = RouteFollower::new(self.route.clone());
            self.walker.drive(&truth).unwrap_or_default()
        })
    }

    fn run_jobs(&mut self, at: Stamp, observer: StepObserver<'_>) {
        while let Some(pending) = self.jobs.pop_front() {
            let done = match (pending, &self.prior_map) {
                (PendingJob::ComputeJob(job), _) => {
                    self.stack.take_compute_job(job).map_or_else(|| job.not_done(), ComputeJob::run)
                }
                (PendingJob::Map(job), Some(map)) => job.map_read(Arc::clone(map)),
                (PendingJob::Map(job), None) => job.failed("there is no map"),
            };
            let preparation = self.stack.map_preparation(done.id());
            if let Some(prepared) = preparation.and_then(|preparation| preparation.run(&done)) {
                self.stack.supply_prepared_map(prepared);
            }
            self.step(at, StepKind::JobResult, Input::JobDone(done), observer);
        }
    }

    fn step(&mut self, at: Stamp, kind: StepKind, input: Input, observer: StepObserver<'_>) {
        let before = thread_ms();
        self.stack.step(at, input, &mut self.effects);
        observer(kind, thread_ms() - before, &self.effects);
        for effect in self.effects.drain(..) {
            match effect {
                StackEffect::StartJob { work: Job::SaveMap(finished), .. } => self.finished = Some(finished),
                StackEffect::StartJob { job, work: Job::ReadMap(_) | Job::LoadMap { .. } } => {
                    self.jobs.push_back(PendingJob::Map(job));
                }
                StackEffect::StartJob { job, .. } => self.jobs.push_back(PendingJob::ComputeJob(job)),
                StackEffect::Drive(drive) => self.stack_drive = self.stack_drive.map(|_| drive),
                _ => {}
            }
        }
    }
}

/// The true poses of the base during a walk.
pub struct GroundTruthTrack(Vec<(Stamp, Isometry)>);

impl GroundTruthTrack {
    /// The poses at intervals of at least `spacing_m` metres.
    pub fn sample(&self, spacing_m: f64) -> Vec<(Stamp, Isometry)> {
        let mut kept: Vec<(Stamp, Isometry)> = Vec::new();
        for entry in &self.0 {
            let moved = |last: &(Stamp, Isometry)| {
                (last.1.translation.vector - entry.1.translation.vector).norm() >= spacing_m
            };
            if kept.last().is_none_or(moved) {
                kept.push(*entry);
            }
        }
        kept
    }

    /// The pose of the base in the site at an instant of the walk, interpolated; the first or last pose outside the walk.
    pub fn interpolate(&self, stamp: Stamp) -> Option<Isometry> {
        let last = self.0.len().checked_sub(1)?;
        let after = self.0.partition_point(|entry| entry.0 < stamp).clamp(1.min(last), last);
        let (before, after) = (&self.0[after.saturating_sub(1)], &self.0[after]);
        let between = (after.0 - before.0).secs_f64();
        let fraction = if between > 0.0 { (stamp - before.0).secs_f64() / between } else { 0.0 };
        Some(se3::interpolate(&before.1, &after.1, fraction.clamp(0.0, 1.0)))
    }
}

/// Whether a step published an estimate. A step on a sensor's message does so when it takes a scan.
pub fn has_estimate(effects: &[StackEffect]) -> bool {
    effects.iter().any(|effect| matches!(effect, StackEffect::Publish(Publication::Estimate(_))))
}

/// The confirmed revisits of mapped areas in a step.
pub fn reanchorings(effects: &[StackEffect]) -> impl Iterator<Item = &messages::Reanchored> {
    effects.iter().filter_map(|effect| match effect {
        StackEffect::Publish(Publication::Reanchored(reanchored)) => Some(reanchored),
        _ => None,
    })
}

/// Whether a step made a keyframe.
pub fn made_keyframe(effects: &[StackEffect]) -> bool {
    effects.iter().any(|effect| matches!(effect, StackEffect::Publish(Publication::Keyframe(_))))
}
