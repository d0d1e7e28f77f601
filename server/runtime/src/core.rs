//! Starts the core's threads with the queues between them, and ends them in order.

use crate::access::{AccessDirectory, AccessMode, AccessWorker, AccountInbox, AccountsConfig, CommandAudit};
use crate::actions::{ActionConfig, ActionQueue, ActionWorker, OpenActions, SightChecker};
use crate::clock::CalendarTime;
use crate::control_loop::{ControlLoop, InputSources, LoopRequest};
use crate::gateway_link::{GatewayLink, GatewayLinkConfig};
use crate::gauges::{GaugeQueue, GaugeWorker};
use crate::imports::{ImportQueue, ImportWorker};
use crate::interrupted_sessions::InterruptedSessionWorker;
use crate::jobs::{ComputeWorker, DiskWorker, Jobs, finished_queue};
use crate::lease_arbiter::{LeaseArbiter, LeaseConfig};
use crate::ledger::{LedgerConfig, LedgerQueue, LedgerWork, LedgerWorker, SiteKeeper};
use crate::live_map::{LiveMap, LiveMapConfig};
use crate::mailbox::Mailbox;
use crate::map_list::{publish_map_list, publish_uploads};
use crate::map_usage::MapUsage;
use crate::node_following::NodeFollower;
use crate::picture_comparisons::PictureWorker;
use crate::picture_queue::PictureQueue;
use crate::platform::{BatteryForecast, PlatformProbe};
use crate::pose_persistence::{PosePersistence, PosePersistenceConfig};
use crate::publisher::{PublisherConfig, PublisherWorker};
use crate::recording::RecordingTarget;
use crate::run_clouds::{RunCloudQueue, RunCloudQueueConfig, RunCloudWorker};
use crate::scene_changes::{SceneChangeQueue, SceneChangeWorker};
use crate::session_journal::{SessionJournalConfig, SessionJournalQueue, SessionJournalWorker};
use crate::start_error::StartError;
use crate::state_publisher::StatePublisher;
use crate::stored_data::{CleanUpConfig, StoredDataWorker};
use crate::stored_data_check::{StoredDataCheckConfig, StoredDataCheckWorker};
use crate::texts;
use crate::threads::{CONTROL_THREAD, THREAD_LIMITS, join, recorder_thread, spawn};
use crate::tile_recovery::TileRecovery;
use crate::topomap_generation::TopomapGenerator;
use api::ProcessRestart;
use crossbeam_channel::Sender;
use messages::RobotProfile;
use ports::{ChangeFinder, ExampleMaker, GaugeReader, MapImporter, PictureComparer, RobotLink};
use stack::Stack;
use std::path::PathBuf;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Instant;
use store::{BlobsConfig, InterruptedSessions, RunCloudsConfig, Store};
use watchdog::Watchdog;

/// Limits of the core's queues.
#[derive(Clone, Copy, Debug)]
struct QueueLimits {
    /// Stops of motion, and permissions to move, that may wait for the control loop. While the queue is full, the thread that reads from the gateway waits. Chosen: one
    /// that waits has the effect of all, so that few are enough.
    max_stops: usize,
    /// Other commands that may wait for the control loop. While the queue is full, further ones are refused, so that a stop behind them does not wait. Chosen: as the
    /// gateway's queue to the core.
    max_commands: usize,
    /// Inputs of the ledger that may wait for the control loop. While the queue is full, the ledger waits. Chosen: a transaction of the ledger.
    max_ledger_inputs: usize,
}

const QUEUE_LIMITS: QueueLimits = QueueLimits { max_stops: 16, max_commands: 256, max_ledger_inputs: 64 };

/// Parts of a core that its caller provides.
pub struct CoreConfig {
    /// The robot. Given by the caller.
    pub link: Box<dyn RobotLink>,
    /// Stores maps and tiles. Given by the caller.
    pub store: Arc<Store>,
    /// Records the inputs; `None` records nothing. Given by the caller.
    pub recording: Option<RecordingTarget>,
    /// Path of the Unix socket for the gateway. Given by the caller.
    pub socket: PathBuf,
    /// Makes maps of files; `None` refuses all imports. Given by the caller.
    pub importer: Option<Box<dyn MapImporter>>,
    /// Makes the example, with `importer`; `None` refuses it. Given by the caller.
    pub example_maker: Option<Box<dyn ExampleMaker>>,
    /// Compares runs of missions with earlier ones; `None` compares none. Given by the caller.
    pub change_finder: Option<Box<dyn ChangeFinder>>,
    /// Reads gauges in pictures; `None` reads none. Given by the caller.
    pub gauge_reader: Option<Box<dyn GaugeReader>>,
    /// Compares pictures of inspection points with earlier ones; `None` compares none. Given by the caller.
    pub picture_comparer: Option<Box<dyn PictureComparer>>,
    /// Watches the threads. Whoever starts a core ends it when one of them fails. Given by the caller.
    pub watchdog: Watchdog,
    /// Why this process was started again, if it was. Given by the supervisor.
    pub restart: Option<ProcessRestart>,
    /// Why the simulated robot was started again, if it was. Given by the supervisor.
    pub robot_restart: Option<RobotRestart>,
    /// Whether people have to sign in. Given by the command line.
    pub access: AccessMode,
    /// Entries of the audit log that are kept; `None`: [`LedgerConfig::audit_entries`]. Given by the command line.
    pub audit_entries: Option<u64>,
}

/// The simulated robot failed and was started again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RobotRestart {
    /// Why.
    pub restart: ProcessRestart,
    /// Whether it happened since this process was started last, so that clients have not been told yet.
    pub is_new: bool,
}

/// A running core. Dropping it ends its threads in order: the robot stops, the socket closes, queued work is done and queued inputs are recorded.
pub struct Core {
    /// Dropping it tells the control loop to stop.
    stop: Option<Sender<()>>,
    mailbox: Arc<Mailbox>,
    // The threads, in the order in which they end.
    control: Option<JoinHandle<()>>,
    ledger: Option<JoinHandle<()>>,
    session_journal: Option<JoinHandle<()>>,
    actions: Option<JoinHandle<()>>,
    run_clouds: Option<JoinHandle<()>>,
    accounts: Option<(Arc<AccountInbox>, JoinHandle<()>)>,
    publisher: Option<JoinHandle<()>>,
    disk: Option<JoinHandle<()>>,
    compute: Option<JoinHandle<()>>,
    imports: Option<JoinHandle<()>>,
    scene_changes: Option<JoinHandle<()>>,
    gauges: Option<JoinHandle<()>>,
    picture_comparisons: Option<JoinHandle<()>>,
    stored_data_check: Option<JoinHandle<()>>,
    recorder: Option<JoinHandle<()>>,
    gateway: Option<GatewayLink>,
}

impl Core {
    /// Starts all threads.
    ///
    /// # Errors
    /// When the socket or a thread cannot be created, or the saved maps cannot be listed.
    pub fn start(config: CoreConfig) -> Result<Self, StartError> {
        let CoreConfig {
            link,
            store,
            recording,
            socket,
            importer,
            example_maker,
            change_finder,
            gauge_reader,
            picture_comparer,
            watchdog,
            restart,
            robot_restart,
            access: access_mode,
            audit_entries,
        } = config;
        let (mailbox, state_publisher, clock) =
            (Arc::<Mailbox>::default(), Arc::<StatePublisher>::default(), Arc::default());
        let (last_pose, docks, stop_latch) = (store.last_pose(), store.docks(), store.stop_latch());
        let calendar = CalendarTime::read();
        publish_map_list(&store, &state_publisher, calendar).map_err(StartError::Maps)?;
        publish_uploads(&store, &state_publisher, calendar).map_err(StartError::Maps)?;
        let map_usage = Arc::new(MapUsage::new(last_pose.map(|pose| pose.map)));

        let (ledger_sender, ledger_inputs) = crossbeam_channel::bounded(QUEUE_LIMITS.max_ledger_inputs);
        let ledger_config = LedgerConfig {
            audit_entries: audit_entries.unwrap_or(LedgerConfig::default().audit_entries),
            ..LedgerConfig::default()
        };
        let site = SiteKeeper::open(
            Arc::clone(&store),
            Arc::clone(&state_publisher),
            ledger_sender.clone(),
            Arc::clone(&mailbox),
            Arc::clone(&clock),
            ledger_config,
        );
        let InterruptedSessions { sessions: interrupted, mut problems } =
            store.interrupted_sessions().map_err(StartError::Sessions)?;
        problems.extend(store.take_problems());
        for problem in &problems {
            tracing::error!("{problem}");
        }
        let new_robot = robot_restart.as_ref().filter(|robot| robot.is_new);
        let restarts = new_robot.map(|robot| texts::robot_restarted(&robot.restart.cause));
        let restarts =
            restarts.into_iter().chain(restart.iter().map(|core| texts::core_restarted(&core.cause)));
        let problems: Vec<String> = restarts.chain(problems).collect();
        let restarts = robot_restart.map(|robot| robot.restart).into_iter().chain(restart).collect();
        state_publisher.publish(api::Event::InterruptedSessions(interrupted.clone()));
        let interrupted_ids = interrupted.iter().map(|session| session.session).collect();

        let (stop_sender, stops) = crossbeam_channel::bounded(QUEUE_LIMITS.max_stops);
        let (command_sender, commands) = crossbeam_channel::bounded(QUEUE_LIMITS.max_commands);
        let (finished_sender, finished) = finished_queue();
        let (stop, stopped) = crossbeam_channel::bounded(0);
        let (jobs, disk_jobs, compute_jobs) = Jobs::new(Arc::clone(&mailbox), Arc::clone(&clock));
        let (queue, recorder) = recorder_thread(recording, &mailbox, &clock, &watchdog)?;
        let compute = ComputeWorker { jobs: compute_jobs, finished: finished_sender.clone() };
        let commands_of_disk = command_sender.clone();
        let interrupted = InterruptedSessionWorker {
            store: Arc::clone(&store),
            state_publisher: Arc::clone(&state_publisher),
            mailbox: Arc::clone(&mailbox),
            clock: Arc::clone(&clock),
            command: Box::new(move |command| {
                // The control loop may have ended; then nobody waits for an answer.
                let _ = commands_of_disk.send(LoopRequest::Command(command));
            }),
            sessions: interrupted,
        };
        let stored_data = StoredDataWorker {
            config: CleanUpConfig::default(),
            store: Arc::clone(&store),
            state_publisher: Arc::clone(&state_publisher),
            mailbox: Arc::clone(&mailbox),
            clock: Arc::clone(&clock),
            usage: Arc::clone(&map_usage),
            calendar: CalendarTime::read,
            tiles_searched: Instant::now(),
        };
        let (ledger, inbox) = LedgerQueue::new(ledger_config);
        let boot = link.boot();
        let standing_height_m = boot.mounting.standing_height_m.unwrap_or(boot.profile.standing_height_m);
        let topomap = TopomapGenerator::new(
            Arc::clone(&store),
            Arc::clone(&state_publisher),
            Arc::clone(&inbox),
            RobotProfile { standing_height_m, ..boot.profile.clone() },
        );
        let node_follower = NodeFollower::new(
            Arc::clone(&store),
            Arc::clone(&inbox),
            Arc::clone(&mailbox),
            Arc::clone(&clock),
        );
        let disk = DiskWorker {
            store: Arc::clone(&store),
            jobs: disk_jobs,
            interrupted,
            stored_data,
            topomap: topomap.clone(),
            compute: jobs.compute_lane(),
            finished: finished_sender,
            state_publisher: Arc::clone(&state_publisher),
            mailbox: Arc::clone(&mailbox),
            clock: Arc::clone(&clock),
        };
        let graph_requests = command_sender.clone();
        let journal_config = SessionJournalConfig::default();
        let (session_journal, session_records) = SessionJournalQueue::new(journal_config);
        let session_journal_worker = SessionJournalWorker {
            config: journal_config,
            store: Arc::clone(&store),
            records: session_records,
            request_graph: Box::new(move || graph_requests.try_send(LoopRequest::WholeGraph).is_ok()),
            mailbox: Arc::clone(&mailbox),
            clock: Arc::clone(&clock),
        };
        let action_config = ActionConfig::default();
        let (actions, action_inbox) = ActionQueue::new(&action_config);
        let (result_sender, action_results) = crossbeam_channel::bounded(action_config.max_results);
        let base_from_lidar = link.boot().mounting.base_from_lidar;
        let (gauges, gauges_thread) = match gauge_reader {
            None => (None, None),
            Some(reader) => {
                let (gauges, pictures, answers) = GaugeQueue::new();
                let store = Arc::clone(&store);
                let worker = GaugeWorker { reader, store, pictures, answers, stop: stopped.clone() };
                let thread = spawn(&watchdog, "gauges", THREAD_LIMITS.lane, move |beat| worker.run(beat))?;
                (Some(gauges), Some(thread))
            }
        };
        let action_worker = ActionWorker {
            config: action_config,
            blobs: BlobsConfig::default(),
            store: Arc::clone(&store),
            robot: link.action_server(),
            camera_head: link.boot().profile.camera_head,
            base_from_lidar_m: base_from_lidar.unwrap_or_default().position,
            inbox: action_inbox,
            results: result_sender,
            mailbox: Arc::clone(&mailbox),
            state_publisher: Arc::clone(&state_publisher),
            clock: Arc::clone(&clock),
            open: OpenActions::default(),
            sight: SightChecker::new(Arc::clone(&store)),
            gauges,
        };
        let (run_clouds, chosen_clouds) = RunCloudQueue::new(RunCloudQueueConfig::default());
        let run_cloud_worker = RunCloudWorker {
            config: RunCloudsConfig::default(),
            store: Arc::clone(&store),
            base_from_lidar_m: base_from_lidar.unwrap_or_default().position,
            clouds: chosen_clouds,
            mailbox: Arc::clone(&mailbox),
            clock: Arc::clone(&clock),
        };
        let ledger_worker = LedgerWorker {
            store: Arc::clone(&store),
            inbox: Arc::clone(&inbox),
            site,
            inputs: ledger_sender,
            mailbox: Arc::clone(&mailbox),
            clock: Arc::clone(&clock),
        };
        let lease = Arc::new(LeaseArbiter::new(LeaseConfig::default(), Arc::clone(&state_publisher)));
        let publisher = PublisherWorker {
            lease: Arc::clone(&lease),
            config: PublisherConfig::default(),
            mailbox: Arc::clone(&mailbox),
            state_publisher: Arc::clone(&state_publisher),
            clock: Arc::clone(&clock),
            jobs: jobs.clone(),
            live_map: LiveMap::new(LiveMapConfig::default(), Arc::clone(&store)),
            platform: PlatformProbe::new(
                RobotProfile { standing_height_m, ..boot.profile },
                link.site(),
                store.recordings(),
                restarts,
            ),
            battery: BatteryForecast::default(),
            persistence: PosePersistence::new(PosePersistenceConfig::default(), Arc::clone(&store)),
            goals: Vec::new(),
            docks: None,
            requests: command_sender.clone(),
            needs_graph: false,
            is_graph_requested: false,
            tile_recovery: TileRecovery::default(),
        };
        let (imports, imports_thread) = match importer {
            None => (ImportQueue::none(), None),
            Some(importer) => {
                let (imports, requests) = ImportQueue::new();
                let commands_of_imports = command_sender.clone();
                let worker = ImportWorker {
                    importer,
                    example_maker,
                    robot_site: link.site(),
                    ledger: Arc::clone(&inbox),
                    command: Box::new(move |command| {
                        // The control loop may have ended; then nobody waits for an answer.
                        let _ = commands_of_imports.send(LoopRequest::Command(command));
                    }),
                    store: Arc::clone(&store),
                    state_publisher: Arc::clone(&state_publisher),
                    mailbox: Arc::clone(&mailbox),
                    clock: Arc::clone(&clock),
                    usage: Arc::clone(&map_usage),
                    requests,
                    stop: stopped.clone(),
                    cancelled: imports.cancelled(),
                };
                (
                    imports,
                    Some(spawn(&watchdog, "imports", THREAD_LIMITS.lane, move |beat| worker.run(beat))?),
                )
            }
        };
        let (scene_changes, ended_runs) = SceneChangeQueue::new();
        let scene_changes_thread = match change_finder {
            None => None,
            Some(finder) => {
                let worker = SceneChangeWorker {
                    finder,
                    store: Arc::clone(&store),
                    ledger: Arc::clone(&inbox),
                    runs: ended_runs,
                    mailbox: Arc::clone(&mailbox),
                    clock: Arc::clone(&clock),
                    stop: stopped.clone(),
                };
                Some(spawn(&watchdog, "scene-changes", THREAD_LIMITS.lane, move |beat| worker.run(beat))?)
            }
        };
        let picture_thread = match picture_comparer {
            None => None,
            Some(comparer) => {
                let (pictures, work) = PictureQueue::new();
                inbox.compare_pictures_with(pictures);
                let worker = PictureWorker {
                    comparer,
                    store: Arc::clone(&store),
                    ledger: Arc::clone(&inbox),
                    work,
                    state_publisher: Arc::clone(&state_publisher),
                    mailbox: Arc::clone(&mailbox),
                    clock: Arc::clone(&clock),
                    stop: stopped.clone(),
                };
                Some(spawn(&watchdog, "pictures", THREAD_LIMITS.lane, move |beat| worker.run(beat))?)
            }
        };
        let stored_data_check = StoredDataCheckWorker {
            config: StoredDataCheckConfig::default(),
            store: Arc::clone(&store),
            sessions: interrupted_ids,
            mailbox: Arc::clone(&mailbox),
            clock: Arc::clone(&clock),
            stop: stopped.clone(),
        };
        let sources = InputSources {
            arrivals: link.arrivals(),
            stops,
            commands,
            finished,
            ledger: ledger_inputs,
            actions: action_results,
            stop: stopped,
        };
        let inbox_of_audit = Arc::clone(&inbox);
        state_publisher.set_audit(CommandAudit::new(move |write| {
            // Nobody waits for it.
            let (done, _) = crossbeam_channel::bounded(1);
            inbox_of_audit.write(LedgerWork { write, done }).is_ok()
        }));
        let access = Arc::new(AccessDirectory::new(access_mode));
        let access_config = AccountsConfig::default();
        let accounts = Arc::new(AccountInbox::new(access_config, Arc::clone(&access)));
        let access_worker = AccessWorker::new(
            access_config,
            Arc::clone(&access),
            Arc::clone(&accounts),
            Arc::clone(&inbox),
            Arc::clone(&state_publisher),
            &store,
        );
        let accounts_of_thread = Arc::clone(&accounts);
        let gateway = GatewayLink::listen(
            GatewayLinkConfig::default(),
            &socket,
            Arc::clone(&state_publisher),
            stop_sender,
            command_sender,
            imports,
            jobs.clone(),
            topomap,
            inbox,
            access,
            accounts,
            Arc::clone(&lease),
            Arc::clone(&clock),
            &watchdog,
        )
        .map_err(|source| StartError::Socket { path: socket, source })?;
        let control = ControlLoop {
            lease,
            link,
            recorder: queue,
            jobs,
            mailbox: Arc::clone(&mailbox),
            state_publisher,
            clock,
            stack: Stack::new(),
            last_pose,
            docks,
            stop_latch,
            ledger,
            session_journal,
            actions,
            node_follower,
            run_clouds,
            scene_changes,
            map_usage,
            refused_jobs: Vec::new(),
            problems,
        };
        Ok(Self {
            stop: Some(stop),
            mailbox,
            imports: imports_thread,
            scene_changes: scene_changes_thread,
            gauges: gauges_thread,
            picture_comparisons: picture_thread,
            stored_data_check: Some(spawn(&watchdog, "data-check", THREAD_LIMITS.disk, move |beat| {
                stored_data_check.run(beat);
            })?),
            disk: Some(spawn(&watchdog, "disk", THREAD_LIMITS.lane, move |beat| disk.run(beat))?),
            compute: Some(spawn(&watchdog, "compute", THREAD_LIMITS.lane, move |beat| compute.run(beat))?),
            publisher: Some(spawn(&watchdog, "publisher", THREAD_LIMITS.publisher, move |beat| {
                publisher.run(beat);
            })?),
            ledger: Some(spawn(&watchdog, "ledger", THREAD_LIMITS.disk, move |beat| {
                ledger_worker.run(beat)
            })?),
            session_journal: Some(spawn(&watchdog, "sessions", THREAD_LIMITS.disk, move |beat| {
                session_journal_worker.run(beat);
            })?),
            actions: Some(spawn(&watchdog, "actions", THREAD_LIMITS.disk, move |beat| {
                action_worker.run(beat);
            })?),
            run_clouds: Some(spawn(&watchdog, "run-clouds", THREAD_LIMITS.disk, move |beat| {
                run_cloud_worker.run(beat);
            })?),
            accounts: Some((
                accounts_of_thread,
                spawn(&watchdog, "accounts", THREAD_LIMITS.disk, move |beat| access_worker.run(beat))?,
            )),
            control: Some(spawn(&watchdog, CONTROL_THREAD, THREAD_LIMITS.control, move |beat| {
                control.run(&sources, beat);
            })?),
            recorder,
            gateway: Some(gateway),
        })
    }
}

impl Drop for Core {
    fn drop(&mut self) {
        drop(self.stop.take());
        join(self.control.take());
        // It may wait for the ledger.
        if let Some((inbox, thread)) = self.accounts.take() {
            inbox.close();
            join(Some(thread));
        }
        join(self.ledger.take());
        join(self.session_journal.take());
        join(self.actions.take());
        join(self.run_clouds.take());
        self.mailbox.close();
        join(self.publisher.take());
        // It sends requests to the lane of the disk, which ends when nobody can send to it any more.
        drop(self.gateway.take());
        join(self.disk.take());
        join(self.compute.take());
        join(self.imports.take());
        join(self.scene_changes.take());
        join(self.gauges.take());
        join(self.picture_comparisons.take());
        join(self.stored_data_check.take());
        join(self.recorder.take());
    }
}

#[cfg(test)]
#[path = "core_tests.rs"]
mod tests;
