//! The walk, and the minutes it is cut into.

use crate::Arguments;
use crate::plot::Minute;
use anyhow::{Context, Result};
use messages::{EdgeKind, Effect, Input, Job, JobDone, JobResult, Publication, Sensor};
use rustix::time::{ClockId, clock_gettime};
use sim::{Route, RouteWalker, SimConfig, Simulator, Site};
use stack::{Stack, Work};
use std::collections::VecDeque;
use std::sync::Arc;
use vocab::{SessionId, Span, Stamp};

/// The stack ticks at 20 Hz, and the robot is commanded as often.
const TICK: Span = Span::from_millis(50);

/// Walks the round for so many minutes and hands over each minute when it has passed.
pub fn walk(arguments: &Arguments, mut passed: impl FnMut(Minute)) -> Result<()> {
    let site = Arc::new(Site::new(arguments.site));
    let route = site.route("round").cloned().context("the site has no round")?;
    let mut simulator = Simulator::on(
        site,
        SimConfig {
            lidar_columns: arguments.columns,
            people: arguments.people,
            start: Some(route.start),
            ..SimConfig::new(arguments.site, arguments.seed)
        },
    );
    let mut measured = Measured::new(&simulator);
    let mut walker = RouteWalker::new(route.clone());
    let mut events = Vec::new();
    for number in 1..=arguments.minutes {
        let end = Span::from_secs_f64(60.0 * f64::from(number));
        while simulator.elapsed() < end {
            simulator.command(command(&mut walker, &route, &simulator));
            simulator.advance(simulator.now() + TICK, &mut events);
            simulator.take_truths();
            for event in events.drain(..) {
                measured.sensor(event.at, event.sensor);
            }
            measured.step(simulator.now(), Input::Tick);
        }
        passed(measured.minute(number)?);
    }
    Ok(())
}

/// The next command; the round begins again where it ended.
fn command(walker: &mut RouteWalker, route: &Route, simulator: &Simulator) -> messages::Drive {
    let truth = simulator.truth();
    walker.drive(&truth).unwrap_or_else(|| {
        *walker = RouteWalker::new(route.clone());
        walker.drive(&truth).unwrap_or_default()
    })
}

/// What a step gave, and its CPU time.
#[derive(Default)]
struct Said {
    located: bool,
    keyframe: bool,
    ms: f64,
}

/// A stack and what its steps cost.
#[derive(Default)]
struct Measured {
    stack: Stack,
    effects: Vec<Effect>,
    scan_ms: Vec<f64>,
    /// Of steps that made a keyframe, and of those that took a loop in.
    keyframe_ms: Vec<f64>,
    loop_ms: Vec<f64>,
    jobs: VecDeque<u64>,
    keyframes: u64,
    loops: usize,
}

impl Measured {
    fn new(simulator: &Simulator) -> Self {
        let mut boot = simulator.boot();
        boot.start_mapping = Some(SessionId(uuid::Uuid::from_u128(1)));
        let mut measured = Self::default();
        measured.step(simulator.now(), Input::Boot(Box::new(boot)));
        measured
    }

    /// A sweep is worked on when the IMU has passed its end, so any sensor's step may be the dear one.
    fn sensor(&mut self, at: Stamp, sensor: Sensor) {
        let said = self.step(at, Input::Sensor(sensor));
        if said.located {
            self.scan_ms.push(said.ms);
        }
        if said.keyframe {
            self.keyframes += 1;
            self.keyframe_ms.push(said.ms);
        }
        while let Some(job) = self.jobs.pop_front() {
            let result = self.stack.take_work(job).map_or(JobResult::LoopNotVerified, Work::run);
            let said = self.step(at, Input::JobDone(JobDone { job, result }));
            self.loop_ms.push(said.ms);
        }
    }

    fn step(&mut self, at: Stamp, input: Input) -> Said {
        let before = thread_ms();
        self.stack.step(at, input, &mut self.effects);
        let mut said = Said { ms: thread_ms() - before, ..Said::default() };
        for effect in self.effects.drain(..) {
            match effect {
                Effect::Publish(Publication::Estimate(_)) => said.located = true,
                Effect::Publish(Publication::Keyframe(_)) => said.keyframe = true,
                Effect::Publish(Publication::Graph(graph)) => {
                    self.loops = graph.edges.iter().filter(|edge| edge.kind == EdgeKind::Loop).count();
                }
                Effect::StartJob { job, work: Job::VerifyLoop(_) } => self.jobs.push_back(job),
                _ => {}
            }
        }
        said
    }

    fn minute(&mut self, number: u32) -> Result<Minute> {
        let mut times = std::mem::take(&mut self.scan_ms);
        times.sort_by(f64::total_cmp);
        let last = times.len().checked_sub(1).context("no scan was used for a whole minute")?;
        let median = |mut times: Vec<f64>| {
            times.sort_by(f64::total_cmp);
            (
                times.get(times.len() / 2).copied().unwrap_or_default(),
                times.last().copied().unwrap_or_default(),
            )
        };
        Ok(Minute {
            number,
            scans: times.len(),
            mean_ms: times.iter().sum::<f64>() / times.len() as f64,
            p99_ms: times[(times.len() * 99 / 100).min(last)],
            resident_mb: resident_mb()?,
            keyframes: self.keyframes,
            keyframe_ms: median(std::mem::take(&mut self.keyframe_ms)),
            loop_ms: median(std::mem::take(&mut self.loop_ms)),
            loops: self.loops,
        })
    }
}

/// CPU time of this thread, milliseconds.
fn thread_ms() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 * 1e-6
}

/// Resident memory of this process, megabytes.
fn resident_mb() -> Result<f64> {
    let statm =
        std::fs::read_to_string("/proc/self/statm").context("memory is read from /proc/self/statm")?;
    let pages: f64 = statm.split(' ').nth(1).and_then(|pages| pages.parse().ok()).context("statm is odd")?;
    Ok(pages * rustix::param::page_size() as f64 * 1e-6)
}
