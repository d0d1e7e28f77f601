//! Work that is too long for the control loop, on one thread, in the order in which it was started.
//!
//! One thread because the order matters: a map is saved after the clouds of all its keyframes are on disk, and tiles
//! are forgotten when nothing is being saved.

use crate::clock::RobotClock;
use crate::mailbox::Mailbox;
use crate::recording::sentence;
use crate::state_publisher::StatePublisher;
use api::TileHash;
use crossbeam_channel::{Receiver, Sender, TrySendError};
use messages::{FinishedMap, Job, JobDone, JobResult, Keyframe, PriorMap, Severity};
use stack::Stack;
use std::path::Path;
use std::sync::Arc;
use store::{SavedMap, Store, StoreError, keyframe_descriptors};
use vocab::{MapId, SessionId};

/// Work that may wait. A cloud takes about 1 MB and a few milliseconds.
const QUEUE_MAX: usize = 256;

/// Something to do.
pub enum Work {
    /// Save a map for the stack.
    Save {
        /// The stack's number.
        job: u64,
        /// The map.
        map: Arc<FinishedMap>,
    },
    /// Look for the stack whether two keyframes saw the same place, some 20 ms, of which the stack starts four at
    /// a time; or where the robot is in a saved map, which takes dozens of such looks.
    Look {
        /// The stack's number.
        job: u64,
        /// What it takes.
        work: stack::ComputeJob,
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
    /// Keep the cloud of a keyframe.
    KeepCloud(Keyframe),
    /// A session has ended: its clouds and tiles are not needed unless a map holds them.
    Forget {
        /// Which session.
        session: SessionId,
        /// Its tiles.
        tiles: Vec<TileHash>,
    },
}

/// Where work is handed in. Never blocks: what finds the queue full is not done, and that is said.
#[derive(Clone)]
pub struct Jobs {
    sender: Sender<Work>,
    /// To tell the stack at once that a job was not done. Unbounded: the stack starts few.
    finished: Sender<JobDone>,
    mailbox: Arc<Mailbox>,
    clock: Arc<RobotClock>,
}

impl Jobs {
    /// Both ends of the queue.
    pub fn new(
        finished: Sender<JobDone>,
        mailbox: Arc<Mailbox>,
        clock: Arc<RobotClock>,
    ) -> (Self, Receiver<Work>) {
        let (sender, receiver) = crossbeam_channel::bounded(QUEUE_MAX);
        (Self { sender, finished, mailbox, clock }, receiver)
    }

    /// Hands in work.
    pub fn start(&self, work: Work) {
        match self.sender.try_send(work) {
            Err(TrySendError::Full(work)) => self.refuse(work),
            // The job thread has ended, which it does only after the control loop.
            Err(TrySendError::Disconnected(_)) | Ok(()) => {}
        }
    }

    /// Hands in what the stack wants done, with what that takes.
    pub fn start_for(&self, stack: &mut Stack, job: u64, work: Job) {
        match work {
            Job::SaveMap(map) => self.start(Work::Save { job, map }),
            Job::LoadMap { session, map } => self.start(Work::Load { job, session: Some(session), map }),
            Job::ReadMap(map) => self.start(Work::Load { job, session: None, map }),
            Job::VerifyLoop(_)
            | Job::CompareRevisit(_)
            | Job::SearchMap(_)
            | Job::Relocalise(_)
            | Job::PlanDisambiguation(_) => match stack.take_compute_job(job) {
                Some(work) => self.start(Work::Look { job, work }),
                None => self.answer(job, JobResult::not_done()),
            },
        }
    }

    fn answer(&self, job: u64, result: JobResult) {
        // The receiver lives as long as the control loop, which is the caller.
        let _ = self.finished.send(JobDone { job, result });
    }

    fn refuse(&self, work: Work) {
        match work {
            Work::Save { job, .. } => {
                let reason = "the disk is too slow; wait a minute and save again".to_owned();
                self.answer(job, JobResult::Failed { reason });
            }
            Work::Load { job, .. } => {
                let reason = "the disk is too slow; wait a minute and try again".to_owned();
                self.answer(job, JobResult::Failed { reason });
            }
            Work::Look { job, .. } => self.answer(job, JobResult::not_done()),
            Work::KeepCloud(keyframe) => {
                let text = format!(
                    "The disk is too slow: the cloud of keyframe {} will be missing from the saved map.",
                    keyframe.id.0
                );
                self.mailbox.notice(self.clock.now(), Severity::Error, text);
            }
            // The files stay until the store is next opened.
            Work::Forget { .. } => {}
        }
    }
}

/// The thread that does the work.
pub struct Worker {
    pub store: Arc<Store>,
    pub work: Receiver<Work>,
    pub finished: Sender<JobDone>,
    pub state_publisher: Arc<StatePublisher>,
    pub mailbox: Arc<Mailbox>,
    pub clock: Arc<RobotClock>,
}

impl Worker {
    /// Works until nobody can hand in more. Work handed in before that is done first.
    pub fn run(self) {
        for work in &self.work {
            match work {
                Work::Save { job, map } => self.done(job, self.save(&map)),
                Work::Look { job, work } => self.done(job, work.run()),
                Work::Load { job, session, map } => self.load(job, session, map),
                Work::KeepCloud(keyframe) => self.write_session_cloud(&keyframe),
                Work::Forget { session, tiles } => self.forget(session, &tiles),
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
    Ok(PriorMap { map: saved.summary.id, graph: saved.graph(), places })
}
