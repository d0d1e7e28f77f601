//! Runs the stack in a saved map without a robot: feeds a boot record, the command to localise, sensor messages and ticks, and runs its jobs.

use crate::inputs::{InputReader, Ticks};
use crate::output;
use crate::process::thread_cpu_time;
use messages::{
    BootRecord, Command, CommandKind, CorrectedScan, Input, Job, JobId, LocalisationState, Principal,
    PriorMap, Publication, Sensor, Severity, StackEffect,
};
use stack::{ComputeJob, Stack};
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;
use uuid::Uuid;
use vocab::{ClientId, CommandId, Pose, Stamp};

/// Feeds a recording to a stack that localises.
pub struct OfflineLocaliser<'a> {
    stack: Stack,
    known: Arc<PriorMap>,
    initial: Option<Pose>,
    now: Option<Stamp>,
    ticks: Ticks,
    effects: Vec<StackEffect>,
    /// Jobs to run, and whether each reads the map.
    jobs: VecDeque<(JobId, bool)>,
    state: LocalisationState,
    first_scan: Option<Stamp>,
    since_scan: Duration,
    run: LocalisationRun,
    /// Called with every scan that is localised with full confidence.
    on_scan: &'a mut dyn FnMut(&CorrectedScan),
}

/// The result of a recording.
#[derive(Debug, Default)]
pub struct LocalisationRun {
    pub scans: u64,
    /// Pose of the base in the map at every localised scan.
    pub trajectory: Vec<(Stamp, Pose)>,
    /// Number of localised scans with low confidence.
    pub low_confidence: u64,
    /// Number of times that tracking was lost.
    pub lost: u64,
    /// Time from the first scan to the first localised one, seconds.
    pub found_after: Option<f64>,
    /// CPU time of the stack from one scan to the next, seconds.
    pub scan_seconds: Vec<f64>,
    /// CPU time of global searches.
    pub search_time: Duration,
}

impl<'a> OfflineLocaliser<'a> {
    /// Localises in the map `known`, from the pose `initial` (base in the map) if it is given. `on_scan` is called with every scan that is localised with full
    /// confidence.
    pub fn new(
        known: Arc<PriorMap>,
        initial: Option<Pose>,
        on_scan: &'a mut dyn FnMut(&CorrectedScan),
    ) -> Self {
        Self {
            stack: Stack::new(),
            known,
            initial,
            now: None,
            ticks: Ticks::default(),
            effects: Vec::new(),
            jobs: VecDeque::new(),
            state: LocalisationState::Idle,
            first_scan: None,
            since_scan: Duration::ZERO,
            run: LocalisationRun::default(),
            on_scan,
        }
    }

    /// Feeds all inputs. `duration` (seconds) is for the progress bar.
    pub fn run(mut self, boot: BootRecord, reader: InputReader, duration: f64) -> LocalisationRun {
        let bar = output::progress_bar(duration);
        let (mut boot, mut first) = (Some(boot), None);
        for message in &reader.messages {
            let (at, sensor) = match message {
                Ok(message) => message,
                Err(error) => {
                    output::print_note(&error.to_string());
                    continue;
                }
            };
            let first = *first.get_or_insert(at);
            if let Some(boot) = boot.take() {
                self.begin(at, boot);
            }
            while let Some(tick) = self.ticks.before(at) {
                self.feed(tick, Input::Tick);
            }
            if let Sensor::Scan(_) = &sensor {
                self.run.scans += 1;
                self.first_scan.get_or_insert(at);
            }
            self.feed(at, Input::Sensor(sensor));
            bar.set_position((at - first).secs_f64() as u64);
        }
        bar.finish_and_clear();
        reader.finish();
        self.run
    }

    fn begin(&mut self, at: Stamp, boot: BootRecord) {
        self.feed(at, Input::Boot(Box::new(boot)));
        let by = ClientId(Uuid::from_u128(1));
        let orders = [
            CommandKind::TakeControl { name: "autoinspect localise".to_owned() },
            CommandKind::Localise { map: self.known.map, at: self.initial },
        ];
        for (number, order) in (1..).zip(orders) {
            let id = CommandId(Uuid::from_u128(number));
            self.feed(at, Input::Command(Command { id, by: Principal::operator(by), kind: order }));
        }
    }

    /// Steps the stack, then runs the jobs that it has started. Their results come before the next input.
    fn feed(&mut self, at: Stamp, input: Input) {
        self.step(at, input);
        while let Some((job, reads)) = self.jobs.pop_front() {
            let start = thread_cpu_time();
            let done = if reads {
                job.map_read(Arc::clone(&self.known))
            } else {
                self.stack.take_compute_job(job).map_or_else(|| job.not_done(), ComputeJob::run)
            };
            self.run.search_time += thread_cpu_time() - start;
            // The map is converted before the step that gets it, as on the robot's compute lane.
            let preparation = self.stack.map_preparation(job);
            if let Some(prepared) = preparation.and_then(|preparation| preparation.run(&done)) {
                self.stack.supply_prepared_map(prepared);
            }
            self.step(at, Input::JobDone(done));
        }
    }

    fn step(&mut self, at: Stamp, input: Input) {
        // The clock never goes back, even if two recordings overlap.
        let at = self.now.map_or(at, |now| now.max(at));
        self.now = Some(at);
        let start = thread_cpu_time();
        self.stack.step(at, input, &mut self.effects);
        self.since_scan += thread_cpu_time() - start;
        for effect in std::mem::take(&mut self.effects) {
            self.handle_effect(effect);
        }
    }

    fn handle_effect(&mut self, effect: StackEffect) {
        match effect {
            StackEffect::StartJob { job, work: Job::ReadMap(_) } => self.jobs.push_back((job, true)),
            StackEffect::StartJob { job, work: Job::Relocalise(_) } => self.jobs.push_back((job, false)),
            StackEffect::Publish(Publication::Localisation(state)) => self.handle_state(state),
            StackEffect::Publish(Publication::Scan(scan)) => {
                self.run.scan_seconds.push(std::mem::take(&mut self.since_scan).as_secs_f64());
                if let LocalisationState::Localised { degradation, .. } = self.state {
                    match degradation {
                        None => (self.on_scan)(&scan),
                        Some(_) => self.run.low_confidence += 1,
                    }
                    self.run.trajectory.push((scan.stamp, scan.map_from_base));
                }
            }
            StackEffect::Publish(Publication::Notice(notice)) if notice.severity >= Severity::Warning => {
                output::print_note(&notice.text);
            }
            StackEffect::Answer { refused: Some(reason), .. } => output::print_note(&reason),
            _ => {}
        }
    }

    fn handle_state(&mut self, state: LocalisationState) {
        let known = |state: &LocalisationState| matches!(state, LocalisationState::Localised { .. });
        if known(&self.state) && !known(&state) {
            self.run.lost += 1;
        }
        if known(&state) && self.run.found_after.is_none() {
            let waited = self.first_scan.zip(self.now).map(|(first, now)| (now - first).secs_f64());
            self.run.found_after = waited;
        }
        self.state = state;
    }
}
