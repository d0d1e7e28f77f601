//! Jobs of the stack, in two lanes: one thread for the disk and one for computing. So relocalisation never waits until a map has been written.
//!
//! Each lane keeps the order in which its jobs were handed in. On the disk lane that order matters: a map is saved after the clouds of all its
//! keyframes are on disk, and tiles are removed when nothing is being saved. A job on the compute lane owns what it needs and reads no file.

use crate::clock::{CalendarTime, RobotClock};
use crate::interrupted_sessions::{InterruptedSessionWorker, SessionRequest};
use crate::mailbox::Mailbox;
use crate::map_list::publish_map_list;
use crate::state_publisher::StatePublisher;
use crate::stored_data::{StoredDataRequest, StoredDataWorker};
use crate::texts;
use crate::topomap_generation::{TopomapGenerator, TopomapRequest, TopomapTask};
use api::TileHash;
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, TrySendError};
use messages::{FinishedMap, Job, JobDone, JobId, JobResult, Keyframe, PriorMap, Severity};
use ports::error_with_causes;
use stack::{ComputeJob, MapPreparation, PreparedMap, Stack};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};
use store::{SavedMap, Store, StoreError, keyframe_descriptors};
use vocab::{MapId, SessionId};
use watchdog::{BEAT_PERIOD, Heartbeat};

/// Parameters of [`Jobs`].
#[derive(Clone, Copy, Debug)]
struct JobsConfig {
    /// Greatest number of jobs that wait on each lane; further ones are refused. A cloud takes about 1 MB and a few milliseconds to write. Chosen: 256 MB of clouds at
    /// most.
    max_queued: usize,
    /// Greatest number of finished jobs that wait for the control loop. Chosen: the control loop takes them every 50 ms.
    max_finished: usize,
    /// A lane that works at one job for longer hangs. Saving a map of a day's walk takes minutes. Chosen: an hour, so that no saving is taken for a hang.
    max_job_duration: Duration,
}

const CONFIG: JobsConfig =
    JobsConfig { max_queued: 256, max_finished: 64, max_job_duration: Duration::from_secs(3_600) };

/// A job of the disk lane.
pub enum DiskJob {
    /// Save a map for the stack.
    Save {
        /// The stack's name for the job.
        job: JobId,
        /// The map.
        map: Arc<FinishedMap>,
    },
    /// Read a saved map for the stack.
    Load {
        /// The stack's name for the job.
        job: JobId,
        /// The session that extends the map, if one does.
        session: Option<SessionId>,
        /// The map.
        map: MapId,
        /// How it is to be prepared.
        preparation: Option<MapPreparation>,
    },
    /// Write the cloud of a keyframe.
    WriteCloud(Keyframe),
    /// A session has ended: its clouds and tiles are not needed unless a map holds them.
    Forget {
        /// The session.
        session: SessionId,
        /// Its tiles.
        tiles: Vec<TileHash>,
    },
    /// A person has decided on a session that was interrupted.
    Interrupted(SessionRequest),
    /// A person changes stored data.
    StoredData(StoredDataRequest),
    /// Read what a topological map is made from.
    ReadTopomapSource(TopomapRequest),
}

/// A job of the compute lane.
pub enum ComputeTask {
    /// Of the stack. A comparison of two keyframes takes some 20 ms, and the stack starts four at a time. A relocalisation takes dozens of them.
    Run(ComputeJob),
    /// Prepare the map that a job of the disk lane has read.
    PrepareMap(MapPreparation, JobDone),
    /// Make a topological map: up to some seconds, for which relocalisation waits.
    GenerateTopomap(TopomapGenerator, Box<TopomapTask>),
}

/// A job that has ended.
pub struct FinishedJob {
    /// Its result.
    pub done: JobDone,
    /// The prepared form of the map that it has read.
    pub prepared: Option<PreparedMap>,
}

impl From<JobDone> for FinishedJob {
    fn from(done: JobDone) -> Self {
        Self { done, prepared: None }
    }
}

/// Where jobs are handed in. Never blocks: a job that finds its lane full fails at once.
#[derive(Clone)]
pub struct Jobs {
    disk: Sender<DiskJob>,
    compute: Sender<ComputeTask>,
    mailbox: Arc<Mailbox>,
    clock: Arc<RobotClock>,
}

/// The queue of finished jobs. A lane waits while it is full; the control loop, which empties it, never waits for a lane.
pub fn finished_queue() -> (Sender<FinishedJob>, Receiver<FinishedJob>) {
    crossbeam_channel::bounded(CONFIG.max_finished)
}

impl Jobs {
    /// All ends of the queues.
    pub fn new(
        mailbox: Arc<Mailbox>,
        clock: Arc<RobotClock>,
    ) -> (Self, Receiver<DiskJob>, Receiver<ComputeTask>) {
        let (disk, disk_jobs) = crossbeam_channel::bounded(CONFIG.max_queued);
        let (compute, compute_jobs) = crossbeam_channel::bounded(CONFIG.max_queued);
        (Self { disk, compute, mailbox, clock }, disk_jobs, compute_jobs)
    }

    /// Writes the cloud of a keyframe.
    pub fn write_cloud(&self, keyframe: Keyframe) {
        let id = keyframe.id;
        if self.is_refused(DiskJob::WriteCloud(keyframe)) {
            let text = texts::cloud_not_written(id);
            self.mailbox.notice(self.clock.now(), Severity::Error, text);
        }
    }

    /// Removes the files of a session that has ended. If that is refused, they stay until the store is next opened.
    pub fn forget(&self, session: SessionId, tiles: Vec<TileHash>) {
        self.is_refused(DiskJob::Forget { session, tiles });
    }

    /// Hands in a job of the disk lane. Returns whether there was no room for it.
    fn is_refused(&self, job: DiskJob) -> bool {
        // A thread that has ended has done so after the control loop.
        matches!(self.disk.try_send(job), Err(TrySendError::Full(_)))
    }

    /// Hands in what a person decided on an interrupted session or on stored data.
    ///
    /// # Errors
    /// The reason for the refusal, one sentence for people.
    pub fn start_for_person(&self, job: DiskJob) -> Result<(), &'static str> {
        self.disk.try_send(job).map_err(|_| texts::DISK_TOO_SLOW)
    }

    /// Hands in a job that the stack has just started, with the data that it needs. Returns its result if it fails at once.
    #[must_use]
    pub fn start_for(&self, stack: &mut Stack, job: JobId, work: Job) -> Option<JobDone> {
        match work {
            Job::SaveMap(map) => {
                self.is_refused(DiskJob::Save { job, map }).then(|| job.failed(texts::DISK_TOO_SLOW_TO_SAVE))
            }
            Job::LoadMap { session, map } => self.start_load(stack, job, Some(session), map),
            Job::ReadMap(map) => self.start_load(stack, job, None, map),
            Job::VerifyLoop(_)
            | Job::CompareRevisit(_)
            | Job::SearchMap(_)
            | Job::Relinearise(_)
            | Job::AssessQuality(_)
            | Job::Relocalise(_)
            | Job::PlanDisambiguation(_) => {
                let is_started = stack.take_compute_job(job).is_some_and(|work| {
                    !matches!(self.compute.try_send(ComputeTask::Run(work)), Err(TrySendError::Full(_)))
                });
                (!is_started).then(|| job.not_done())
            }
        }
    }

    fn start_load(
        &self,
        stack: &Stack,
        job: JobId,
        session: Option<SessionId>,
        map: MapId,
    ) -> Option<JobDone> {
        let preparation = stack.map_preparation(job);
        self.is_refused(DiskJob::Load { job, session, map, preparation })
            .then(|| job.failed(texts::DISK_TOO_SLOW_TO_LOAD))
    }

    /// The other end of the compute lane for the disk lane, which hands on the maps that it has read.
    pub fn compute_lane(&self) -> Sender<ComputeTask> {
        self.compute.clone()
    }
}

/// The thread of the disk lane.
pub struct DiskWorker {
    pub store: Arc<Store>,
    pub jobs: Receiver<DiskJob>,
    pub interrupted: InterruptedSessionWorker,
    pub stored_data: StoredDataWorker,
    pub topomap: TopomapGenerator,
    pub compute: Sender<ComputeTask>,
    pub finished: Sender<FinishedJob>,
    pub state_publisher: Arc<StatePublisher>,
    pub mailbox: Arc<Mailbox>,
    pub clock: Arc<RobotClock>,
}

/// The thread of the compute lane.
pub struct ComputeWorker {
    pub jobs: Receiver<ComputeTask>,
    pub finished: Sender<FinishedJob>,
}

/// Waits for the next job; none when nobody can hand in more.
fn next_job<T>(jobs: &Receiver<T>, heartbeat: &Heartbeat) -> Option<T> {
    loop {
        heartbeat.beat();
        match jobs.recv_timeout(BEAT_PERIOD) {
            Ok(job) => return Some(job),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return None,
        }
    }
}

impl ComputeWorker {
    /// Works until nobody can hand in more.
    pub fn run(self, heartbeat: &Heartbeat) {
        while let Some(task) = next_job(&self.jobs, heartbeat) {
            let _job = heartbeat.begin_long_job(CONFIG.max_job_duration);
            let finished = match task {
                ComputeTask::Run(work) => work.run().into(),
                ComputeTask::PrepareMap(preparation, done) => {
                    FinishedJob { prepared: preparation.run(&done), done }
                }
                ComputeTask::GenerateTopomap(generator, task) => {
                    generator.generate(*task);
                    continue;
                }
            };
            // The control loop may have ended already; then nobody wants the result.
            if self.finished.send(finished).is_err() {
                return;
            }
        }
    }
}

impl DiskWorker {
    /// Works until nobody can hand in more. Jobs handed in before that are done first.
    pub fn run(mut self, heartbeat: &Heartbeat) {
        let mut clean_up_at = Instant::now();
        loop {
            heartbeat.beat();
            let received = self.jobs.recv_deadline(clean_up_at.min(Instant::now() + BEAT_PERIOD));
            let _job = heartbeat.begin_long_job(CONFIG.max_job_duration);
            match received {
                Ok(job) => self.work(job),
                Err(RecvTimeoutError::Timeout) if Instant::now() < clean_up_at => {}
                Err(RecvTimeoutError::Timeout) => {
                    self.stored_data.clean_up();
                    clean_up_at = Instant::now() + self.stored_data.config.period;
                }
                Err(RecvTimeoutError::Disconnected) => return,
            }
        }
    }

    fn work(&mut self, job: DiskJob) {
        match job {
            DiskJob::Save { job, map } => self.done(self.save(job, &map)),
            DiskJob::Load { job, session, map, preparation } => {
                self.load(job, session, map, preparation);
            }
            DiskJob::WriteCloud(keyframe) => self.write_session_cloud(&keyframe),
            DiskJob::Forget { session, tiles } => self.forget(session, &tiles),
            DiskJob::Interrupted(request) => self.interrupted.handle(request),
            DiskJob::StoredData(request) => self.stored_data.handle(request, &self.interrupted.sessions),
            DiskJob::ReadTopomapSource(request) => {
                if let Some(task) = self.topomap.read(request) {
                    // Waits where the compute lane is full, as for maps. The lane ends after this one.
                    let task = ComputeTask::GenerateTopomap(self.topomap.clone(), Box::new(task));
                    let _ = self.compute.send(task);
                }
            }
        }
    }

    fn done(&self, done: JobDone) {
        // The control loop may have ended already; a map is saved all the same.
        let _ = self.finished.send(done.into());
    }

    fn save(&self, job: JobId, map: &FinishedMap) -> JobDone {
        match self.store.save_map(map) {
            Ok(_) => {
                self.list_maps();
                JobDone { number: job.number, result: JobResult::MapSaving(Ok(map.map)) }
            }
            Err(error) => {
                tracing::error!("map {} was not saved: {}", map.map, error_with_causes(&error));
                job.failed(error_with_causes(&error))
            }
        }
    }

    /// Reads a saved map, and hands it on to be prepared. For a session that extends it, then makes its clouds the session's; the robot need not wait
    /// for that.
    fn load(&self, job: JobId, session: Option<SessionId>, map: MapId, preparation: Option<MapPreparation>) {
        match known_map(&self.store.dir().map(map)) {
            Ok(known) => match preparation {
                // Waits where the compute lane is full. That lane never waits for this one.
                Some(preparation) => {
                    let task = ComputeTask::PrepareMap(preparation, job.map_read(Arc::new(known)));
                    // The lane ends after this one.
                    let _ = self.compute.send(task);
                }
                None => self.done(job.map_read(Arc::new(known))),
            },
            Err(error) => return self.done(job.failed(error_with_causes(&error))),
        }
        if let Some(session) = session
            && let Err(error) = self.store.copy_map_clouds_to_session(map, session)
        {
            let text = texts::extended_map_not_whole(&error_with_causes(&error));
            self.mailbox.notice(self.clock.now(), Severity::Error, text);
        }
    }

    fn list_maps(&self) {
        if let Err(error) = publish_map_list(&self.store, &self.state_publisher, CalendarTime::read()) {
            tracing::error!("{}", error_with_causes(&error));
        }
    }

    fn write_session_cloud(&self, keyframe: &Keyframe) {
        if let Err(error) = self.store.write_session_cloud(keyframe) {
            let text = texts::keyframe_cloud_missing(keyframe.id, &error_with_causes(&error));
            self.mailbox.notice(self.clock.now(), Severity::Error, text);
        }
    }

    fn forget(&self, session: SessionId, tiles: &[TileHash]) {
        let forgotten =
            self.store.discard_session(session).and_then(|()| self.store.remove_session_tiles(tiles));
        if let Err(error) = forgotten {
            tracing::warn!("files of session {session} are left over: {}", error_with_causes(&error));
        }
    }
}

/// What the stack takes of a saved map in this folder. Linear in its keyframes, see [`keyframe_descriptors`].
///
/// # Errors
/// When there is no such map, or it cannot be read.
pub fn known_map(path: &Path) -> Result<PriorMap, StoreError> {
    let saved = SavedMap::read(path)?;
    let places = keyframe_descriptors(&saved.path, saved.poses.len())?;
    Ok(PriorMap { map: saved.summary.id, graph: saved.graph(), keyframes: places })
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{JobOwner, StackEffect};
    use uuid::Uuid;

    #[test]
    fn a_full_disk_lane_refuses_what_it_is_asked_and_holds_up_no_computing() {
        let (jobs, disk, compute) = Jobs::new(Arc::default(), Arc::default());
        let session = SessionId(Uuid::from_u128(1));
        for _ in 0..CONFIG.max_queued {
            jobs.forget(session, Vec::new());
        }
        let mut stack = Stack::new();
        let map = MapId(Uuid::from_u128(2));
        let StackEffect::StartJob { job, work } = StackEffect::start_job(1, Job::ReadMap(map)) else {
            panic!("no job")
        };
        let refused = jobs.start_for(&mut stack, job, work).expect("answered at once");
        assert!(
            matches!(&refused.result, JobResult::Localisation(Err(failure)) if failure.reason.contains("disk"))
        );
        assert_eq!((refused.id(), disk.len(), compute.len()), (job, CONFIG.max_queued, 0));
        // The stack holds no data for this job, so it fails.
        let task = messages::DisambiguationTask { map, number: 0 };
        let job = JobId { owner: JobOwner::Disambiguation, number: 2 };
        let done = jobs.start_for(&mut stack, job, Job::PlanDisambiguation(task));
        assert_eq!(done, Some(job.not_done()));
    }

    #[test]
    fn computing_goes_on_while_a_map_waits_to_be_saved() {
        let (finished, results) = finished_queue();
        let (jobs, disk, compute) = Jobs::new(Arc::default(), Arc::default());
        let save = JobId { owner: JobOwner::MapSaving, number: 0 };
        // Nobody works on the disk lane.
        let load =
            DiskJob::Load { job: save, session: None, map: MapId(Uuid::from_u128(2)), preparation: None };
        assert!(!jobs.is_refused(load));
        let map = PriorMap {
            map: MapId(Uuid::from_u128(2)),
            graph: messages::PoseGraph::default(),
            keyframes: Vec::new(),
        };
        let job = JobId { owner: JobOwner::Localisation, number: 1 };
        let task = ComputeTask::PrepareMap(MapPreparation::Localisation, job.map_read(Arc::new(map)));
        jobs.compute_lane().send(task).expect("room");
        drop(jobs);
        ComputeWorker { jobs: compute, finished }.run(&Heartbeat::unwatched());
        let done = results.try_recv().expect("computed");
        assert_eq!((done.done.id(), done.prepared.is_some(), disk.len()), (job, true, 1));
    }
}
