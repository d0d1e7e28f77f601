//! Keeps the clouds that the robot sees on a run of a mission: one every 2 m, and one when the action of a task begins. The control loop chooses them and never waits; a thread
//! of its own encodes and writes them.
//!
//! | what waits | policy |
//! | --- | --- |
//! | clouds | one that finds the queue full is left out, and the next scan is taken instead |

use crate::clock::{CalendarTime, RobotClock};
use crate::mailbox::Mailbox;
use crate::texts;
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender};
use geometry::Vector3;
use messages::{CorrectedScan, LocalisationState, Publication, Severity};
use ports::error_with_causes;
use site_model::{LocalisationQuality, MissionId, MissionStatus, ReportPlace, RunId, RunState, TaskState};
use std::sync::Arc;
use store::{RunCloudCause, RunCloudEntry, RunCloudsConfig, Store};
use vocab::{BlobHash, Covariance6, Vec3};
use watchdog::{BEAT_PERIOD, Heartbeat};

/// Parameters of [`RunCloudQueue`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunCloudQueueConfig {
    /// Distance between two clouds on the way, metres: two keyframes. Chosen: objects are then seen from several places; less fills the space of the clouds sooner.
    pub distance_m: f64,
    /// Clouds that may wait for the thread. Chosen: 8 m of walk, while the disk is busy.
    pub max_waiting: usize,
}

impl Default for RunCloudQueueConfig {
    fn default() -> Self {
        Self { distance_m: 2.0, max_waiting: 4 }
    }
}

/// A cloud that is to be kept.
struct ChosenCloud {
    run: RunId,
    mission: MissionId,
    cause: RunCloudCause,
    step: Option<u32>,
    scan: CorrectedScan,
    place: ReportPlace,
}

/// The control loop's end: chooses clouds.
pub struct RunCloudQueue {
    config: RunCloudQueueConfig,
    clouds: Sender<ChosenCloud>,
    run: Option<(RunId, MissionId)>,
    /// Where the last cloud of the run was kept, metres, map frame.
    last: Option<Vector3>,
    /// The task whose action is performed, by number and attempt, and whether its cloud is still to be kept.
    task: Option<(u32, u32)>,
    is_task_wanted: bool,
    localisation: LocalisationState,
    covariance: Covariance6,
}

/// The thread's end.
pub struct RunCloudWorker {
    pub config: RunCloudsConfig,
    pub store: Arc<Store>,
    /// The LiDAR in the base, metres.
    pub base_from_lidar_m: Vec3,
    pub clouds: RunCloudInbox,
    pub mailbox: Arc<Mailbox>,
    pub clock: Arc<RobotClock>,
}

/// Clouds on their way to the thread.
pub struct RunCloudInbox(Receiver<ChosenCloud>);

impl RunCloudQueue {
    /// Both ends.
    pub fn new(config: RunCloudQueueConfig) -> (Self, RunCloudInbox) {
        let (clouds, inbox) = crossbeam_channel::bounded(config.max_waiting);
        let queue = Self {
            config,
            clouds,
            run: None,
            last: None,
            task: None,
            is_task_wanted: false,
            localisation: LocalisationState::Idle,
            covariance: Covariance6::default(),
        };
        (queue, RunCloudInbox(inbox))
    }

    /// Follows what the stack publishes. Never blocks.
    pub fn watch(&mut self, publication: &Publication) {
        match publication {
            Publication::Missions(status) => self.follow_run(status),
            Publication::Localisation(state) => self.localisation = *state,
            Publication::Estimate(estimate) => self.covariance = estimate.covariance,
            Publication::Scan(scan) => self.choose(scan),
            _ => {}
        }
    }

    fn follow_run(&mut self, status: &MissionStatus) {
        let is_active = |state| matches!(state, RunState::Running | RunState::Ending);
        let run = status.runs.iter().find(|run| is_active(run.state));
        let id = run.map(|run| (run.run, run.mission));
        if id != self.run {
            (self.run, self.last, self.task, self.is_task_wanted) = (id, None, None, false);
        }
        let tasks = run.map(|run| &run.tasks[..]).unwrap_or_default();
        let mut acting = (0..).zip(tasks).filter(|(_, task)| task.state == TaskState::Running);
        let task = acting.next().map(|(step, task)| (step, task.attempt));
        if task.is_some() && task != self.task {
            self.is_task_wanted = true;
        }
        self.task = task;
    }

    fn choose(&mut self, scan: &CorrectedScan) {
        let Some((run, mission)) = self.run else { return };
        let LocalisationState::Localised { map, degradation } = self.localisation else { return };
        let at = geometry::vec_from_plain(scan.map_from_base.position);
        let is_far = self.last.is_none_or(|last| (at - last).norm() >= self.config.distance_m);
        if !is_far && !self.is_task_wanted {
            return;
        }
        let cause = if self.is_task_wanted { RunCloudCause::Task } else { RunCloudCause::Distance };
        let step = self.task.filter(|_| self.is_task_wanted).map(|(step, _)| step);
        let good = degradation.is_none();
        let place = ReportPlace {
            map: Some(map),
            map_from_base: scan.map_from_base,
            covariance: self.covariance,
            quality: if good { LocalisationQuality::Good } else { LocalisationQuality::Degraded },
        };
        let chosen = ChosenCloud { run, mission, cause, step, scan: scan.clone(), place };
        if self.clouds.try_send(chosen).is_ok() {
            (self.last, self.is_task_wanted) = (Some(at), false);
        }
    }
}

impl RunCloudWorker {
    /// Works until the control loop has ended.
    pub fn run(self, heartbeat: &Heartbeat) {
        // People are told once for each run.
        let mut reported = None;
        loop {
            heartbeat.beat();
            match self.clouds.0.recv_timeout(BEAT_PERIOD) {
                Ok(chosen) => {
                    let run = chosen.run;
                    if let Err(reason) = self.keep(chosen)
                        && reported.replace(run) != Some(run)
                    {
                        tracing::warn!("{reason}");
                        self.mailbox.notice(self.clock.now(), Severity::Warning, reason);
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
        }
    }

    fn keep(&self, chosen: ChosenCloud) -> Result<(), String> {
        let ChosenCloud { run, mission, cause, step, scan, place } = chosen;
        let age_ns = (self.clock.now() - scan.stamp).nanos().max(0);
        let Vec3 { x, y, z } = self.base_from_lidar_m;
        let entry = RunCloudEntry {
            // The store knows it.
            cloud: BlobHash([0; 32]),
            bytes: 0,
            robot_time: scan.stamp,
            utc_ns: CalendarTime::read_of_schedules().utc.nanos().saturating_sub(age_ns),
            cause,
            mission: Some(mission),
            step,
            place,
            base_from_sensor_m: [x, y, z],
            points: u32::try_from(scan.cloud.xyz.len()).unwrap_or(u32::MAX),
        };
        let (xyz, intensity) = (&scan.cloud.xyz, &scan.cloud.intensity);
        match self.store.put_run_cloud(run, entry, xyz, intensity, &self.config) {
            Ok(Some(_)) => Ok(()),
            Ok(None) => Err(texts::NO_ROOM_FOR_RUN_CLOUDS.to_owned()),
            Err(error) => Err(texts::run_clouds_not_kept(&error_with_causes(&error))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::Cloud;
    use site_model::{RunCause, RunStatus, TaskId, TaskStatus};
    use uuid::Uuid;
    use vocab::{CommandId, MapId, Pose, Stamp};

    const RUN: RunId = RunId(Uuid::from_u128(7));
    const MISSION: MissionId = MissionId(Uuid::from_u128(8));
    const MAP: MapId = MapId(Uuid::from_u128(1));

    /// A run of two tasks, of which the second is in this state.
    fn status(state: RunState, second: TaskState) -> Publication {
        let task = |number: u128, state| TaskStatus {
            task: TaskId(Uuid::from_u128(number)),
            node: None,
            action: Some("photo".to_owned()),
            state,
            attempt: 1,
            failure: None,
        };
        let run = RunStatus {
            run: RUN,
            mission: MISSION,
            cause: RunCause::Command(CommandId(Uuid::from_u128(9))),
            state,
            outcome: None,
            began: None,
            tasks: vec![task(1, TaskState::Succeeded), task(2, second)],
            question: None,
        };
        Publication::Missions(Arc::new(MissionStatus { runs: vec![run], ..MissionStatus::default() }))
    }

    fn scan(at_ms: i64, x: f64) -> Publication {
        let position = Vec3::new(x, 0.0, 0.5);
        let cloud = Cloud { xyz: vec![[1.0, 2.0, 0.0], [x as f32, 0.0, 1.0]], intensity: Vec::new() };
        Publication::Scan(CorrectedScan {
            stamp: Stamp::EPOCH + vocab::Span::from_millis(at_ms),
            map_from_base: Pose { position, ..Pose::IDENTITY },
            cloud: Arc::new(cloud),
        })
    }

    #[test]
    fn clouds_are_kept_every_two_metres_and_at_tasks_while_a_run_is_active() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let store = Arc::new(Store::open(dir.path()).expect("opens"));
        let (mut queue, clouds) =
            RunCloudQueue::new(RunCloudQueueConfig { max_waiting: 64, ..RunCloudQueueConfig::default() });
        let walk = |queue: &mut RunCloudQueue, from_dm: i64| {
            (from_dm..from_dm + 50).for_each(|dm| queue.watch(&scan(100 * dm, 0.1 * dm as f64)));
        };
        walk(&mut queue, 0);
        queue.watch(&status(RunState::Running, TaskState::Navigating));
        walk(&mut queue, 50);
        let localised = LocalisationState::Localised { map: MAP, degradation: None };
        queue.watch(&Publication::Localisation(localised));
        // 10 m to 14.9 m: at 10, 12 and 14 m.
        walk(&mut queue, 100);
        queue.watch(&status(RunState::Running, TaskState::Running));
        queue.watch(&scan(16_000, 14.9));
        queue.watch(&scan(16_100, 14.9));
        queue.watch(&status(RunState::Paused, TaskState::Paused));
        walk(&mut queue, 150);
        drop(queue);
        let worker = RunCloudWorker {
            config: RunCloudsConfig { min_free_bytes: 0, ..RunCloudsConfig::default() },
            store: Arc::clone(&store),
            base_from_lidar_m: Vec3::new(0.1, 0.0, 0.25),
            clouds,
            mailbox: Arc::default(),
            clock: Arc::default(),
        };
        worker.run(&Heartbeat::unwatched());
        let kept = store.run_clouds(RUN).expect("read");
        let places: Vec<_> = kept
            .iter()
            .map(|cloud| (cloud.place.map_from_base.position.x, cloud.cause, cloud.step))
            .collect();
        assert_eq!(places.len(), 4, "{places:?}");
        for ((x, cause, step), wanted) in places.iter().zip([10.0, 12.0, 14.0]) {
            assert!((x - wanted).abs() < 0.15, "{places:?}");
            assert_eq!((*cause, *step), (RunCloudCause::Distance, None));
        }
        assert_eq!(places[3], (14.9, RunCloudCause::Task, Some(1)));
        let cloud = store.run_cloud(RUN, kept[3].cloud).expect("read");
        assert_eq!((cloud.xyz.len(), cloud.entry.base_from_sensor_m), (2, [0.1, 0.0, 0.25]));
        assert_eq!((cloud.entry.place.map, cloud.entry.mission), (Some(MAP), Some(MISSION)));
    }
}
