//! The whole stack on a simulated walk, faster than time, in one thread: sensors in, loops verified as soon as they are asked for.

use crate::thread_ms;
use anyhow::{Context, Result, bail};
use geometry::{Isometry, isometry_from_pose, se3};
use messages::{
    BootRecord, Command, CommandKind, Drive, FinishedMap, Input, Job, JobDone, JobResult, Principal,
    PriorMap, Publication, StackEffect,
};
use sim::{Route, RouteFollower, SimConfig, Simulator, Site};
use stack::{ComputeJob, Stack};
use std::collections::VecDeque;
use std::sync::Arc;
use uuid::Uuid;
use vocab::{ClientId, CommandId, MapId, Pose, SessionId, Span, Stamp};

/// The stack ticks at 20 Hz, and the robot is commanded as often.
const TICK: Span = Span::from_millis(50);

/// Where to walk, and who walks about.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// Seed of the simulation.
    pub seed: u64,
    /// LiDAR columns per sweep.
    pub columns: u32,
    /// People walking about.
    pub people: u32,
    /// Whether the way that was truly walked is kept for [`StackWalk::finish`]: 64 B a millisecond or so.
    pub keep_truth: bool,
}

/// What a step was for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepOf {
    /// Passing time, a command, or the boot record.
    Other,
    /// Anything a sensor said.
    Sensor,
    /// The result of looking at a pair of keyframes, or at a visit.
    Verified,
}

/// One step: what it was for, the CPU time it took (milliseconds), and what it said.
pub type Heard<'a> = &'a mut dyn FnMut(StepOf, f64, &[StackEffect]);

/// A job that is to be done.
#[derive(Clone, Copy, Debug)]
enum Waiting {
    /// What the stack hands out.
    ComputeJob(u64),
    /// Reading a saved map.
    Map(u64),
}

/// A robot that walks a route of its site again and again while it maps.
pub struct StackWalk {
    simulator: Simulator,
    route: Route,
    walker: RouteFollower,
    stack: Stack,
    effects: Vec<StackEffect>,
    jobs: VecDeque<Waiting>,
    finished: Option<Arc<FinishedMap>>,
    truth: Option<Vec<(Stamp, Isometry)>>,
    rounds: u32,
    /// What reading a saved map gives.
    known: Option<Arc<PriorMap>>,
    /// What the stack wants of the legs, if the robot is to do that instead of walking its route.
    obeys: Option<Drive>,
    orders: u128,
}

impl StackWalk {
    /// Ready to walk a route of `site`, `round` mostly, and to map it.
    ///
    /// # Errors
    /// When the site has no such route.
    pub fn new(site: &Arc<Site>, route: &str, plan: &Plan, heard: Heard<'_>) -> Result<Self> {
        let mut walk = Self::prepared(site, route, plan)?;
        walk.boot(Some(SessionId(Uuid::from_u128(1))), heard);
        Ok(walk)
    }

    /// Ready to walk a route of `site` by a map that is known of it; the robot has to find itself in it first, unless somebody says where
    /// in the map it is.
    ///
    /// # Errors
    /// When the site has no such route.
    pub fn localised(
        site: &Arc<Site>,
        route: &str,
        plan: &Plan,
        known: Arc<PriorMap>,
        told: Option<Pose>,
        heard: Heard<'_>,
    ) -> Result<Self> {
        let mut walk = Self::prepared(site, route, plan)?;
        let map = known.map;
        walk.known = Some(known);
        walk.boot(None, heard);
        walk.order(
            [CommandKind::TakeControl { name: "bench".to_owned() }, CommandKind::Localise { map, at: told }],
            heard,
        );
        Ok(walk)
    }

    fn prepared(site: &Arc<Site>, route: &str, plan: &Plan) -> Result<Self> {
        let route = site.route(route).cloned().with_context(|| format!("the site has no route {route}"))?;
        let config = SimConfig {
            lidar_columns: plan.columns,
            people: plan.people,
            start: Some(route.start),
            ..SimConfig::new(site.name(), plan.seed)
        };
        Ok(Self {
            simulator: Simulator::on(Arc::clone(site), config),
            walker: RouteFollower::new(route.clone()),
            route,
            stack: Stack::new(),
            effects: Vec::new(),
            jobs: VecDeque::new(),
            finished: None,
            truth: plan.keep_truth.then(Vec::new),
            rounds: 0,
            known: None,
            obeys: None,
            orders: 0,
        })
    }

    fn boot(&mut self, session: Option<SessionId>, heard: Heard<'_>) {
        let boot = BootRecord { start_mapping: session, ..self.simulator.boot() };
        self.step(self.simulator.now(), StepOf::Other, Input::Boot(Box::new(boot)), heard);
    }

    fn order<const N: usize>(&mut self, orders: [CommandKind; N], heard: Heard<'_>) {
        let (now, by) = (self.simulator.now(), ClientId(Uuid::from_u128(1)));
        for order in orders {
            self.orders += 1;
            let command = Command {
                id: CommandId(Uuid::from_u128(self.orders)),
                by: Principal::operator(by),
                kind: order,
            };
            self.step(now, StepOf::Other, Input::Command(command), heard);
            self.work(now, heard);
        }
    }

    /// The way that was truly walked so far, as far as it was kept.
    pub fn truth(&self) -> Truth {
        Truth(self.truth.clone().unwrap_or_default())
    }

    /// Walks until so long after the start.
    ///
    /// # Errors
    /// When the simulator's truth is no pose.
    pub fn walk(&mut self, until: Span, heard: Heard<'_>) -> Result<()> {
        let mut events = Vec::new();
        while self.simulator.elapsed() < until {
            let drive = self.drive();
            self.simulator.command(drive);
            self.simulator.advance(self.simulator.now() + TICK, &mut events);
            let truths = self.simulator.take_ground_truth();
            if let Some(kept) = &mut self.truth {
                for truth in truths {
                    let pose = isometry_from_pose(&truth.site_from_base).context("a true pose is no pose")?;
                    kept.push((truth.stamp, pose));
                }
            }
            for event in events.drain(..) {
                self.step(event.at, StepOf::Sensor, Input::Sensor(event.sensor), heard);
                self.work(event.at, heard);
            }
            self.step(self.simulator.now(), StepOf::Other, Input::Tick, heard);
        }
        Ok(())
    }

    /// From now on the robot does what its stack wants, which is to stand until it is told otherwise; or it walks its route.
    pub fn obey_stack(&mut self, obeys: bool) {
        self.obeys = obeys.then(Drive::default);
    }

    /// Gives the stack an order.
    pub fn give(&mut self, order: CommandKind, heard: Heard<'_>) {
        self.order([order], heard);
    }

    /// The simulator, for its clock and what goes wrong in it.
    pub fn simulator(&mut self) -> &mut Simulator {
        &mut self.simulator
    }

    /// Rounds walked to their end.
    pub fn rounds(&self) -> u32 {
        self.rounds
    }

    /// Where the base truly is in the site.
    ///
    /// # Errors
    /// When the simulator's truth is no pose.
    pub fn site_from_base(&self) -> Result<Isometry> {
        isometry_from_pose(&self.simulator.truth().site_from_base).context("a true pose is no pose")
    }

    /// Ends the walk and hands the map over, with the truth if it was kept.
    ///
    /// # Errors
    /// When the stack makes none.
    pub fn finish(mut self, heard: Heard<'_>) -> Result<(Arc<FinishedMap>, Truth)> {
        let map = MapId(Uuid::from_u128(1));
        let finish = CommandKind::FinishMapping { map, name: "bench".to_owned() };
        self.order([CommandKind::TakeControl { name: "bench".to_owned() }, finish], heard);
        let Some(finished) = self.finished else { bail!("the stack made no map") };
        Ok((finished, Truth(self.truth.unwrap_or_default())))
    }

    /// The next command; the round begins again where it ended.
    fn drive(&mut self) -> Drive {
        if let Some(drive) = self.obeys {
            return drive;
        }
        let truth = self.simulator.truth();
        self.walker.drive(&truth).unwrap_or_else(|| {
            self.rounds += 1;
            self.walker = RouteFollower::new(self.route.clone());
            self.walker.drive(&truth).unwrap_or_default()
        })
    }

    fn work(&mut self, at: Stamp, heard: Heard<'_>) {
        while let Some(waiting) = self.jobs.pop_front() {
            let (job, result) = match (waiting, &self.known) {
                (Waiting::ComputeJob(job), _) => {
                    (job, self.stack.take_compute_job(job).map_or_else(JobResult::not_done, ComputeJob::run))
                }
                (Waiting::Map(job), Some(known)) => (job, JobResult::MapLoaded(Arc::clone(known))),
                (Waiting::Map(job), None) => {
                    (job, JobResult::Failed { reason: "there is no map".to_owned() })
                }
            };
            self.step(at, StepOf::Verified, Input::JobDone(JobDone { job, result }), heard);
        }
    }

    fn step(&mut self, at: Stamp, of: StepOf, input: Input, heard: Heard<'_>) {
        let before = thread_ms();
        self.stack.step(at, input, &mut self.effects);
        heard(of, thread_ms() - before, &self.effects);
        for effect in self.effects.drain(..) {
            match effect {
                StackEffect::StartJob {
                    job,
                    work:
                        Job::VerifyLoop(_)
                        | Job::CompareRevisit(_)
                        | Job::SearchMap(_)
                        | Job::Relocalise(_)
                        | Job::PlanDisambiguation(_),
                } => self.jobs.push_back(Waiting::ComputeJob(job)),
                StackEffect::StartJob { job, work: Job::ReadMap(_) } => {
                    self.jobs.push_back(Waiting::Map(job));
                }
                StackEffect::Drive(drive) => self.obeys = self.obeys.map(|_| drive),
                StackEffect::StartJob { work: Job::SaveMap(finished), .. } => self.finished = Some(finished),
                _ => {}
            }
        }
    }
}

/// Where the robot really was, for the score.
pub struct Truth(Vec<(Stamp, Isometry)>);

impl Truth {
    /// Every so many metres of the walk.
    pub fn every(&self, metres: f64) -> Vec<(Stamp, Isometry)> {
        let mut kept: Vec<(Stamp, Isometry)> = Vec::new();
        for entry in &self.0 {
            let moved = |last: &(Stamp, Isometry)| {
                (last.1.translation.vector - entry.1.translation.vector).norm() >= metres
            };
            if kept.last().is_none_or(moved) {
                kept.push(*entry);
            }
        }
        kept
    }

    /// The base in the site at a moment of the walk; at its ends before and after.
    pub fn at(&self, stamp: Stamp) -> Option<Isometry> {
        let last = self.0.len().checked_sub(1)?;
        let after = self.0.partition_point(|entry| entry.0 < stamp).clamp(1.min(last), last);
        let (before, after) = (&self.0[after.saturating_sub(1)], &self.0[after]);
        let between = (after.0 - before.0).secs_f64();
        let fraction = if between > 0.0 { (stamp - before.0).secs_f64() / between } else { 0.0 };
        Some(se3::interpolate(&before.1, &after.1, fraction.clamp(0.0, 1.0)))
    }
}

/// Whether a step gave an estimate from a sweep.
pub fn located(effects: &[StackEffect]) -> bool {
    effects.iter().any(|effect| matches!(effect, StackEffect::Publish(Publication::Estimate(_))))
}

/// What became of walks over known ground in a step.
pub fn ties(effects: &[StackEffect]) -> impl Iterator<Item = &messages::Reanchored> {
    effects.iter().filter_map(|effect| match effect {
        StackEffect::Publish(Publication::Reanchored(tied)) => Some(tied),
        _ => None,
    })
}

/// Whether a step made a keyframe.
pub fn made_keyframe(effects: &[StackEffect]) -> bool {
    effects.iter().any(|effect| matches!(effect, StackEffect::Publish(Publication::Keyframe(_))))
}
