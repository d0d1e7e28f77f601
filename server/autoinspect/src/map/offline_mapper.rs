//! Runs the stack without a robot: feeds a boot record, sensor messages, ticks on the recording's clock, and at the end the command to save.

use crate::failure::Failure;
use crate::inputs::{InputReader, Message, Ticks};
use crate::process::thread_cpu_time;
use crate::{output, texts};
use lockstep::Digest;
use messages::{
    BootRecord, Command, CommandKind, FinishedMap, Input, Job, JobId, Principal, Publication, Sensor,
    Severity, StackEffect,
};
use ports::Journal;
use stack::{ComputeJob, Stack};
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use uuid::Uuid;
use vocab::{ClientId, CommandId, MapId, SessionId, Stamp};

/// The one session of an offline run.
pub const SESSION: SessionId = SessionId(Uuid::from_u128(1));

/// Parameters of an [`OfflineMapper`].
#[derive(Clone, Copy, Debug)]
struct OfflineMapperConfig {
    /// Largest number of warnings that are printed while running; all are counted. Chosen: they leave the terminal readable.
    max_warnings_shown: usize,
}

impl Default for OfflineMapperConfig {
    fn default() -> Self {
        Self { max_warnings_shown: 5 }
    }
}

/// The result of a recording.
pub struct MappingRun {
    pub finished: Arc<FinishedMap>,
    pub scans: u64,
    pub points: u64,
    pub dropped_points: u64,
    pub unreadable: u64,
    /// CPU time of the stack from one corrected scan to the next, including all inputs between them, seconds.
    pub scan_seconds: Vec<f64>,
    pub read_time: Duration,
    pub step_time: Duration,
    /// CPU time of loop verification.
    pub loop_time: Duration,
    pub cloud_time: Duration,
    /// Warnings of the stack, in order.
    pub notices: Vec<String>,
    /// Fingerprint of all effects, if a journal was written.
    pub fingerprint: Option<String>,
    pub first: Option<Stamp>,
    pub last: Option<Stamp>,
}

/// Feeds recordings to a stack that maps.
pub struct OfflineMapper {
    config: OfflineMapperConfig,
    stack: Stack,
    clouds: PathBuf,
    journal: Option<Box<dyn Journal>>,
    digest: Digest,
    now: Option<Stamp>,
    ticks: Ticks,
    effects: Vec<StackEffect>,
    /// Jobs that were started and have not run yet.
    jobs: VecDeque<JobId>,
    mapped: MappingCounters,
}

/// Counters while running.
#[derive(Default)]
struct MappingCounters {
    finished: Option<Arc<FinishedMap>>,
    refused: Option<String>,
    scans: u64,
    points: u64,
    unreadable: u64,
    scan_seconds: Vec<f64>,
    /// CPU time since the last corrected scan. A scan is processed when the samples that cover its sweep have arrived,
    /// which is after the scan itself.
    since_scan: Duration,
    step_time: Duration,
    loop_time: Duration,
    cloud_time: Duration,
    notices: Vec<String>,
    first: Option<Stamp>,
}

impl OfflineMapper {
    /// Keyframe clouds go to the folder `clouds`, inputs to `journal` if there is one.
    pub fn new(clouds: PathBuf, journal: Option<Box<dyn Journal>>) -> Self {
        Self {
            config: OfflineMapperConfig::default(),
            stack: Stack::new(),
            clouds,
            journal,
            digest: Digest::default(),
            now: None,
            ticks: Ticks::default(),
            effects: Vec::new(),
            jobs: VecDeque::new(),
            mapped: MappingCounters::default(),
        }
    }

    /// Feeds all inputs and requests the map. `duration` (seconds) is for the progress bar.
    pub fn run(
        mut self,
        boot: BootRecord,
        reader: InputReader,
        name: String,
        duration: f64,
    ) -> Result<MappingRun, Failure> {
        let bar = output::progress_bar(duration);
        let mut boot = Some(boot);
        for message in &reader.messages {
            let Some((at, sensor)) = self.readable(message) else {
                continue;
            };
            if let Some(boot) = boot.take() {
                (self.now, self.mapped.first) = (Some(at), Some(at));
                self.feed(at, Input::Boot(Box::new(boot)))?;
            }
            self.sensor(at, sensor)?;
            if let (Some(first), Some(now)) = (self.mapped.first, self.now) {
                bar.set_position((now - first).secs_f64() as u64);
                bar.set_message(format!("{} scans", self.mapped.scans));
            }
        }
        bar.finish_and_clear();
        let read = reader.finish();
        self.finish(name)?;
        let MappingCounters { finished, refused, notices, .. } = &mut self.mapped;
        let Some(finished) = finished.take() else {
            let reason = refused.take().or_else(|| notices.pop());
            let reason = reason.unwrap_or_else(|| texts::NO_USABLE_MESSAGE.to_owned());
            return Err(Failure::usage(texts::no_map_made(&reason)));
        };
        if let Some(journal) = self.journal.take() {
            journal.finish().map_err(Failure::failed)?;
        }
        Ok(MappingRun {
            finished,
            scans: self.mapped.scans,
            points: self.mapped.points,
            dropped_points: read.dropped_points,
            unreadable: self.mapped.unreadable,
            scan_seconds: self.mapped.scan_seconds,
            read_time: read.time,
            step_time: self.mapped.step_time,
            loop_time: self.mapped.loop_time,
            cloud_time: self.mapped.cloud_time,
            notices: self.mapped.notices,
            fingerprint: (self.digest.effects() > 0).then(|| self.digest.hex()),
            first: self.mapped.first,
            last: self.now,
        })
    }

    fn readable(&mut self, message: Message) -> Option<(Stamp, Sensor)> {
        message
            .inspect_err(|error| {
                self.mapped.unreadable += 1;
                if self.mapped.unreadable <= self.config.max_warnings_shown as u64 {
                    output::print_note(&error.to_string());
                }
            })
            .ok()
    }

    fn sensor(&mut self, at: Stamp, sensor: Sensor) -> Result<(), Failure> {
        while let Some(tick) = self.ticks.before(at) {
            self.feed(tick, Input::Tick)?;
        }
        if let Sensor::Scan(scan) = &sensor {
            self.mapped.scans += 1;
            self.mapped.points += scan.xyz.len() as u64;
        }
        self.feed(at, Input::Sensor(sensor))
    }

    /// Takes control and requests the map.
    fn finish(&mut self, name: String) -> Result<(), Failure> {
        let Some(now) = self.now else {
            return Ok(());
        };
        let by = ClientId(Uuid::from_u128(1));
        let map = MapId(map_id(self.mapped.first.unwrap_or_default(), now, self.mapped.scans));
        for (number, order) in [
            (1, CommandKind::TakeControl { name: "autoinspect map".to_owned() }),
            (2, CommandKind::FinishMapping { map, name }),
        ] {
            let id = CommandId(Uuid::from_u128(number));
            self.feed(now, Input::Command(Command { id, by: Principal::operator(by), kind: order }))?;
        }
        Ok(())
    }

    /// Steps, then runs the jobs that the stack has started. Their results come before the next input, always in the same
    /// order.
    fn feed(&mut self, at: Stamp, input: Input) -> Result<(), Failure> {
        self.step(at, input)?;
        while let Some(job) = self.jobs.pop_front() {
            let start = thread_cpu_time();
            let done = self.stack.take_compute_job(job).map_or_else(|| job.not_done(), ComputeJob::run);
            self.mapped.loop_time += thread_cpu_time() - start;
            self.step(at, Input::JobDone(done))?;
        }
        Ok(())
    }

    /// Journals an input, steps, and handles the effects.
    fn step(&mut self, at: Stamp, input: Input) -> Result<(), Failure> {
        // The clock never goes back, even if two recordings overlap.
        let at = self.now.map_or(at, |now| now.max(at));
        self.now = Some(at);
        if let Some(journal) = &mut self.journal {
            journal.append(at, &input).map_err(Failure::failed)?;
        }
        let start = thread_cpu_time();
        self.stack.step(at, input, &mut self.effects);
        let took = thread_cpu_time() - start;
        self.mapped.step_time += took;
        self.mapped.since_scan += took;
        if self.journal.is_some() {
            self.digest.add(at, &self.effects);
        }
        std::mem::take(&mut self.effects).into_iter().try_for_each(|effect| self.handle_effect(effect))
    }

    fn handle_effect(&mut self, effect: StackEffect) -> Result<(), Failure> {
        match effect {
            StackEffect::StartJob { work: Job::SaveMap(finished), .. } => {
                self.mapped.finished = Some(finished)
            }
            // No command of this run starts these jobs.
            StackEffect::StartJob { work: Job::LoadMap { .. } | Job::ReadMap(_), .. } => {}
            StackEffect::StartJob { job, .. } => self.jobs.push_back(job),
            StackEffect::Answer { refused: Some(reason), .. } => self.mapped.refused = Some(reason),
            StackEffect::Publish(Publication::Scan(_)) => {
                self.mapped.scan_seconds.push(std::mem::take(&mut self.mapped.since_scan).as_secs_f64());
            }
            StackEffect::Publish(Publication::Keyframe(keyframe)) if keyframe.session == SESSION => {
                let start = thread_cpu_time();
                store::write_cloud(&self.clouds, &keyframe).map_err(Failure::failed)?;
                self.mapped.cloud_time += thread_cpu_time() - start;
            }
            StackEffect::Publish(Publication::Notice(notice)) if notice.severity >= Severity::Warning => {
                if self.mapped.notices.len() < self.config.max_warnings_shown {
                    output::print_note(&notice.text);
                }
                self.mapped.notices.push(notice.text);
            }
            StackEffect::Drive(_)
            | StackEffect::Answer { refused: None, .. }
            | StackEffect::Publish(_)
            | StackEffect::Commit { .. }
            | StackEffect::CallAction { .. }
            | StackEffect::CancelAction(_) => {}
        }
        Ok(())
    }
}

/// The map's id: the same recording gives the same id.
fn map_id(first: Stamp, last: Stamp, scans: u64) -> Uuid {
    Uuid::from_u64_pair(first.nanos() as u64, (last - first).nanos() as u64 ^ scans.rotate_left(40))
}
