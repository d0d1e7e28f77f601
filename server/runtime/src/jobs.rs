//! Work that is too long for the control loop, in two lanes: one thread for the disk, one for computing. So looking for the robot's place never
//! waits until a map has been written.
//!
//! Each lane keeps the order in which its work was handed in. On the disk lane that order matters: a map is saved after the clouds of all its
//! keyframes are on disk, and tiles are removed when nothing is being saved. Nothing on the computing lane depends on the disk: it owns what it needs.

use crate::clock::RobotClock;
use crate::mailbox::Mailbox;
use crate::recording::sentence;
use crate::state_publisher::StatePublisher;
use api::TileHash;
use crossbeam_channel::{Receiver, Sender, TrySendError};
use messages::{FinishedMap, Job, JobDone, JobResult, Keyframe, PriorMap, Severity};
use stack::{ComputeJob, Stack};
use std::path::Path;
use std::sync::Arc;
use store::{SavedMap, Store, StoreError, keyframe_descriptors};
use vocab::{MapId, SessionId};

/// Jobs that may wait on each lane. A cloud takes about 1 MB and a few milliseconds.
const QUEUE_MAX: usize = 256;

/// Work of the disk lane.
pub enum DiskJob {
    /// Save a map for the stack.
    Save {
        /// The stack's number.
        job: u64,
        /// The map.
        map: Arc<FinishedMap>,
    },
    /// Read a saved map.
    Load {
        /// The stack's number.
        job: u64,
        /// The session that goes on from it, if any.
        session: Option<SessionId>,
        /// The map.
        map: MapId,
    },
    /// Write the cloud of a keyframe.
    WriteCloud(Keyframe),
    /// A session has ended: its clouds and tiles are not needed unless a map holds them.
    Forget {
        /// Which session.
        session: SessionId,
        /// Its tiles.
        tiles: Vec<TileHash>,
    },
}

/// Work of the computing lane, with the stack's number. A comparison of two keyframes takes some 20 ms, and the stack starts four at a time; a
/// relocalisation takes dozens of them.
type NumberedCompute = (u64, ComputeJob);

/// Where work is handed in. Never blocks: what finds the queue full is not done, and that is said.
#[derive(Clone)]
pub struct Jobs {
    disk: Sender<DiskJob>,
    compute: Sender<NumberedCompute>,
    /// To tell the stack at once that a job was not done. Unbounded: the stack starts few.
    finished: Sender<JobDone>,
    mailbox: Arc<Mailbox>,
    clock: Arc<RobotClock>,
}

impl Jobs {
    /// All ends of the queues.
    pub fn new(
        finished: Sender<JobDone>,
        mailbox: Arc<Mailbox>,
        clock: Arc<RobotClock>,
    ) -> (Self, Receiver<DiskJob>, Receiver<NumberedCompute>) {
        let (disk, disk_jobs) = crossbeam_channel::bounded(QUEUE_MAX);
        let (compute, compute_jobs) = crossbeam_channel::bounded(QUEUE_MAX);
        (Self { disk, compute, finished, mailbox, clock }, disk_jobs, compute_jobs)
    }

    /// Hands in work of the disk lane.
    pub fn start(&self, job: DiskJob) {
        match self.disk.try_send(job) {
            Err(TrySendError::Full(job)) => self.refuse(job),
            // The thread has ended, which it does only after the control loop.
            Err(TrySendError::Disconnected(_)) | Ok(()) => {}
        }
    }

    fn start_compute(&self, job: u64, work: ComputeJob) {
        match self.compute.try_send((job, work)) {
            Err(TrySendError::Full((job, _))) => self.answer(job, JobResult::not_done()),
            Err(TrySendError::Disconnected(_)) | Ok(()) => {}
        }
    }

    /// Hands in what the stack wants done, with what that takes.
    pub fn start_for(&self, stack: &mut Stack, job: u64, work: Job) {
        match work {
            Job::SaveMap(map) => self.start(DiskJob::Save { job, map }),
            Job::LoadMap { session, map } => self.start(DiskJob::Load { job, session: Some(session), map }),
            Job::ReadMap(map) => self.start(DiskJob::Load { job, session: None, map }),
            Job::VerifyLoop(_)
            | Job::CompareRevisit(_)
            | Job::SearchMap(_)
            | Job::Relocalise(_)
            | Job::PlanDisambiguation(_) => match stack.take_compute_job(job) {
                Some(work) => self.start_compute(job, work),
                None => self.answer(job, JobResult::not_done()),
            },
        }
    }

    fn answer(&self, job: u64, result: JobResult) {
        // The receiver lives as long as the control loop, which is the caller.
        let _ = self.finished.send(JobDone { job, result });
    }

    fn refuse(&self, job: DiskJob) {
        match job {
            DiskJob::Save { job, .. } => {
                let reason = "the disk is too slow; wait a minute and save again".to_owned();
                self.answer(job, JobResult::Failed { reason });
            }
            DiskJob::Load { job, .. } => {
                let reason = "the disk is too slow; wait a minute and try again".to_owned();
                self.answer(job, JobResult::Failed { reason });
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
        }
    }
}

/// The thread of the disk lane.
pub struct DiskWorker {
    pub store: Arc<Store>,
    pub jobs: Receiver<DiskJob>,
    pub finished: Sender<JobDone>,
    pub state_publisher: Arc<StatePublisher>,
    pub mailbox: Arc<Mailbox>,
    pub clock: Arc<RobotClock>,
}

/// The thread of the computing lane.
pub struct ComputeWorker {
    pub jobs: Receiver<NumberedCompute>,
    pub finished: Sender<JobDone>,
}

impl ComputeWorker {
    /// Works until nobody can hand in more.
    pub fn run(self) {
        for (job, work) in &self.jobs {
            // The control loop may have ended already; then nobody wants the result.
            if self.finished.send(JobDone { job, result: work.run() }).is_err() {
                return;
            }
        }
    }
}

impl DiskWorker {
    /// Works until nobody can hand in more. Work handed in before that is done first.
    pub fn run(self) {
        for job in &self.jobs {
            match job {
                DiskJob::Save { job, map } => self.done(job, self.save(&map)),
                DiskJob::Load { job, session, map } => self.load(job, session, map),
                DiskJob::WriteCloud(keyframe) => self.write_session_cloud(&keyframe),
                DiskJob::Forget { session, tiles } => self.forget(session, &tiles),
            }
        }
    }

    fn done(&self, job: u64, result: JobResult) {
        // The control loop may have ended already; a map is saved all the same.
        let _ = self.finished.send(JobDone { job, result });
    }

    fn save(&self, map: &FinishedMap) -> JobResult {
        match self.store.save_map(map) {
            Ok(report) => {
                self.list_maps();
                JobResult::MapSaved { map: map.map, bytes: report.summary.bytes }
            }
            Err(error) => {
                tracing::error!("map {} was not saved: {}", map.map, sentence(&error));
                JobResult::Failed { reason: sentence(&error) }
            }
        }
    }

    /// Reads a saved map, and makes its clouds a session's that goes on from it, which the robot need not wait for.
    fn load(&self, job: u64, session: Option<SessionId>, map: MapId) {
        let known = match known_map(&self.store.dir().map(map)) {
            Ok(known) => known,
            Err(error) => {
                return self.done(job, JobResult::Failed { reason: sentence(&error) });
            }
        };
        self.done(job, JobResult::MapLoaded(Arc::new(known)));
        if let Some(session) = session
            && let Err(error) = self.store.copy_map_clouds_to_session(map, session)
        {
            let text = format!(
                "The extended map will not be whole: {}. Discard it and free some disk.",
                sentence(&error)
            );
            self.mailbox.notice(self.clock.now(), Severity::Error, text);
        }
    }

    fn list_maps(&self) {
        match self.store.maps() {
            Ok(maps) => self.state_publisher.publish(api::Event::Maps(maps)),
            Err(error) => tracing::error!("{}", sentence(&error)),
        }
    }

    fn write_session_cloud(&self, keyframe: &Keyframe) {
        if let Err(error) = self.store.write_session_cloud(keyframe) {
            let text = format!(
                "The cloud of keyframe {} will be missing from the saved map: {}.",
                keyframe.id.0,
                sentence(&error)
            );
            self.mailbox.notice(self.clock.now(), Severity::Error, text);
        }
    }

    fn forget(&self, session: SessionId, tiles: &[TileHash]) {
        let forgotten =
            self.store.discard_session(session).and_then(|()| self.store.remove_session_tiles(tiles));
        if let Err(error) = forgotten {
            tracing::warn!("files of session {session} are left over: {}", sentence(&error));
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
    use uuid::Uuid;

    #[test]
    fn a_full_disk_lane_refuses_what_it_is_asked_and_holds_up_no_computing() {
        let (finished, results) = crossbeam_channel::unbounded();
        let (jobs, disk, compute) = Jobs::new(finished, Arc::default(), Arc::default());
        let session = SessionId(Uuid::from_u128(1));
        for _ in 0..QUEUE_MAX {
            jobs.start(DiskJob::Forget { session, tiles: Vec::new() });
        }
        let mut stack = Stack::new();
        jobs.start_for(&mut stack, 1, Job::ReadMap(MapId(Uuid::from_u128(2))));
        let refused = results.try_recv().expect("answered at once");
        assert!(
            matches!(refused, JobDone { job: 1, result: JobResult::Failed { reason } } if reason.contains("disk"))
        );
        assert_eq!((disk.len(), compute.len()), (QUEUE_MAX, 0));
        // What the stack no longer keeps is not done, and that is said.
        let task = messages::DisambiguationTask { map: MapId(Uuid::from_u128(2)), number: 0 };
        jobs.start_for(&mut stack, 2, Job::PlanDisambiguation(task));
        assert_eq!(results.try_recv(), Ok(JobDone { job: 2, result: JobResult::not_done() }));
    }
}
