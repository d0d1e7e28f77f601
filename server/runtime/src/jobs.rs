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
use api::TileHash;
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, TrySendError};
use messages::{FinishedMap, Job, JobDone, JobId, JobResult, Keyframe, PriorMap, Severity};
use ports::error_with_causes;
use stack::{ComputeJob, MapPreparation, PreparedMap, Stack};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;
use store::{SavedMap, Store, StoreError, keyframe_descriptors};
use vocab::{MapId, SessionId};

/// Parameters of [`Jobs`].
#[derive(Clone, Copy, Debug)]
struct JobsConfig {
    /// Greatest number of jobs that wait on each lane; further ones are refused. A cloud takes about 1 MB and a few milliseconds to write.
    max_queued: usize,
}

const CONFIG: JobsConfig = JobsConfig { max_queued: 256 };

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
}

/// A job of the compute lane.
pub enum ComputeTask {
    /// Of the stack. A comparison of two keyframes takes some 20 ms, and the stack starts four at a time. A relocalisation takes dozens of them.
    Run(ComputeJob),
    /// Prepare the map that a job of the disk lane has read.
    PrepareMap(MapPreparation, JobDone),
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
    /// To tell the stack at once that a job was not done. Unbounded: the stack starts few.
    finished: Sender<FinishedJob>,
    mailbox: Arc<Mailbox>,
    clock: Arc<RobotClock>,
}

impl Jobs {
    /// All ends of the queues.
    pub fn new(
        finished: Sender<FinishedJob>,
        mailbox: Arc<Mailbox>,
        clock: Arc<RobotClock>,
    ) -> (Self, Receiver<DiskJob>, Receiver<ComputeTask>) {
        let (disk, disk_jobs) = crossbeam_channel::bounded(CONFIG.max_queued);
        let (compute, compute_jobs) = crossbeam_channel::bounded(CONFIG.max_queued);
        (Self { disk, compute, finished, mailbox, clock }, disk_jobs, compute_jobs)
    }

    /// Hands in a job of the disk lane.
    pub fn start(&self, job: DiskJob) {
        match self.disk.try_send(job) {
            Err(TrySendError::Full(job)) => self.refuse(job),
            // The thread has ended, which it does only after the control loop.
            Err(TrySendError::Disconnected(_)) | Ok(()) => {}
        }
    }

    /// Hands in what a person decided on an interrupted session or on stored data.
    ///
    /// # Errors
    /// The reason for the refusal, one sentence for people.
    pub fn start_for_person(&self, job: DiskJob) -> Result<(), &'static str> {
        self.disk.try_send(job).map_err(|_| texts::DISK_TOO_SLOW)
    }

    fn start_compute(&self, job: JobId, work: ComputeJob) {
        match self.compute.try_send(ComputeTask::Run(work)) {
            Err(TrySendError::Full(_)) => self.answer(job.not_done()),
            Err(TrySendError::Disconnected(_)) | Ok(()) => {}
        }
    }

    /// Hands in a job that the stack has just started, with the data that it needs.
    pub fn start_for(&self, stack: &mut Stack, job: JobId, work: Job) {
        match work {
            Job::SaveMap(map) => self.start(DiskJob::Save { job, map }),
            Job::LoadMap { session, map } => self.start_load(stack, job, Some(session), map),
            Job::ReadMap(map) => self.start_load(stack, job, None, map),
            Job::VerifyLoop(_)
            | Job::CompareRevisit(_)
            | Job::SearchMap(_)
            | Job::Relinearise(_)
            | Job::AssessQuality(_)
            | Job::Relocalise(_)
            | Job::PlanDisambiguation(_) => match stack.take_compute_job(job) {
                Some(work) => self.start_compute(job, work),
                None => self.answer(job.not_done()),
            },
        }
    }

    fn start_load(&self, stack: &Stack, job: JobId, session: Option<SessionId>, map: MapId) {
        let preparation = stack.map_preparation(job);
        self.start(DiskJob::Load { job, session, map, preparation });
    }

    /// The other end of the compute lane for the disk lane, which hands on the maps that it has read.
    pub fn compute_lane(&self) -> Sender<ComputeTask> {
        self.compute.clone()
    }

    fn answer(&self, done: JobDone) {
        // The receiver lives as long as the control loop, which is the caller.
        let _ = self.finished.send(done.into());
    }

    fn refuse(&self, job: DiskJob) {
        match job {
            DiskJob::Save { job, .. } => {
                self.answer(job.failed("the disk is too slow; wait a minute and save again"));
            }
            DiskJob::Load { job, .. } => {
                self.answer(job.failed("the disk is too slow; wait a minute and try again"));
            }
            DiskJob::WriteCloud(keyframe) => {
                let text = format!(
                    "The disk is too slow: the cloud of keyframe {} will be missing from the saved map.",
                    keyframe.id.0
                );
                self.mailbox.notice(self.clock.now(), Severity::Error, text);
            }
            // The files stay until the store is next opened.
            DiskJob::Forget { .. } => {}
            // [`Self::start_for_person`] hands these in.
            DiskJob::Interrupted(_) | DiskJob::StoredData(_) => {}
        }
    }
}

/// The thread of the disk lane.
pub struct DiskWorker {
    pub store: Arc<Store>,
    pub jobs: Receiver<DiskJob>,
    pub interrupted: InterruptedSessionWorker,
    pub stored_data: StoredDataWorker,
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

impl ComputeWorker {
    /// Works until nobody can hand in more.
    pub fn run(self) {
        for task in &self.jobs {
            let finished = match task {
                ComputeTask::Run(work) => work.run().into(),
                ComputeTask::PrepareMap(preparation, done) => {
                    FinishedJob { prepared: preparation.run(&done), done }
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
    pub fn run(mut self) {
        let mut clean_up_at = Instant::now();
        loop {
            match self.jobs.recv_deadline(clean_up_at) {
                Ok(job) => self.work(job),
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
            let text = format!(
                "The extended map will not be whole: {}. Discard it and free some disk.",
                error_with_causes(&error)
            );
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
            let text = format!(
                "The cloud of keyframe {} will be missing from the saved map: {}.",
                keyframe.id.0,
                error_with_causes(&error)
            );
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
        let (finished, results) = crossbeam_channel::unbounded();
        let (jobs, disk, compute) = Jobs::new(finished, Arc::default(), Arc::default());
        let session = SessionId(Uuid::from_u128(1));
        for _ in 0..CONFIG.max_queued {
            jobs.start(DiskJob::Forget { session, tiles: Vec::new() });
        }
        let mut stack = Stack::new();
        let map = MapId(Uuid::from_u128(2));
        let StackEffect::StartJob { job, work } = StackEffect::start_job(1, Job::ReadMap(map)) else {
            panic!("no job")
        };
        jobs.start_for(&mut stack, job, work);
        let refused = results.try_recv().expect("answered at once").done;
        assert!(
            matches!(&refused.result, JobResult::Localisation(Err(failure)) if failure.reason.contains("disk"))
        );
        assert_eq!((refused.id(), disk.len(), compute.len()), (job, CONFIG.max_queued, 0));
        // The stack holds no data for this job, so it fails.
        let task = messages::DisambiguationTask { map, number: 0 };
        let job = JobId { owner: JobOwner::Disambiguation, number: 2 };
        jobs.start_for(&mut stack, job, Job::PlanDisambiguation(task));
        assert_eq!(results.try_recv().map(|finished| finished.done), Ok(job.not_done()));
    }

    #[test]
    fn computing_goes_on_while_a_map_waits_to_be_saved() {
        let (finished, results) = crossbeam_channel::unbounded();
        let (jobs, disk, compute) = Jobs::new(finished.clone(), Arc::default(), Arc::default());
        let save = JobId { owner: JobOwner::MapSaving, number: 0 };
        // Nobody works on the disk lane.
        jobs.start(DiskJob::Load {
            job: save,
            session: None,
            map: MapId(Uuid::from_u128(2)),
            preparation: None,
        });
        let map = PriorMap {
            map: MapId(Uuid::from_u128(2)),
            graph: messages::PoseGraph::default(),
            keyframes: Vec::new(),
        };
        let job = JobId { owner: JobOwner::Localisation, number: 1 };
        let task = ComputeTask::PrepareMap(MapPreparation::Localisation, job.map_read(Arc::new(map)));
        jobs.compute_lane().send(task).expect("room");
        drop(jobs);
        ComputeWorker { jobs: compute, finished }.run();
        let done = results.try_recv().expect("computed");
        assert_eq!((done.done.id(), done.prepared.is_some(), disk.len()), (job, true, 1));
    }
}
