//! The core's process: link to the robot, store, recorder and control loop.

use super::access::AccessArgs;
use super::changes_process::ChangesProcess;
use super::child_report::ChildReport;
use super::example_process::ExampleProcess;
use super::gauge_process::GaugeProcess;
use super::import_process::ImportProcess;
use super::picture_process::PictureProcess;
use super::process_watch::{SupervisionArgs, thread_failed, watch_process, watchdog};
use super::stop::ShutdownSignal;
use crate::failure::Failure;
use crate::journal::McapSegments;
use crate::robot::RobotArgs;
use crate::texts;
use api::{ProcessRestart, ProcessRole};
use clap::Args;
use crossbeam_channel::select;
use ports::RobotLink;
use recorder::RecordingMeta;
use runtime::{CONTROL_THREAD, Core, CoreConfig, RecordingTarget, RobotRestart, set_clock_offset};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};
use store::{Recordings, RecordingsConfig, Store};
use vocab::{Span, Stamp};

/// Arguments of the core's process.
#[derive(Args, Debug)]
pub struct CoreArgs {
    /// Data directory.
    #[arg(long)]
    data: PathBuf,
    /// Socket on which to listen for the gateway.
    #[arg(long)]
    socket: PathBuf,
    /// Do not record.
    #[arg(long)]
    no_record: bool,
    #[command(flatten)]
    recordings: RecordingsArgs,
    #[command(flatten)]
    trial: TrialArgs,
    #[command(flatten)]
    robot: RobotArgs,
    #[command(flatten)]
    access: AccessArgs,
    #[command(flatten)]
    supervision: SupervisionArgs,
    /// Why the simulated robot was started again.
    #[arg(long, hide = true)]
    robot_restart_cause: Option<String>,
    /// How often it was started again.
    #[arg(long, hide = true, default_value_t = 1)]
    robot_restart_count: u32,
}

impl CoreArgs {
    fn robot_restart(&self) -> Option<RobotRestart> {
        let restart = ProcessRestart {
            process: ProcessRole::SimulatedRobot,
            cause: self.robot_restart_cause.clone()?,
            count: self.robot_restart_count,
        };
        // A core whose robot is started again begins anew, too.
        Some(RobotRestart { restart, is_new: self.supervision.was_restarted_because(texts::ROBOT_RESTARTED) })
    }
}

/// What makes the platform quick to try and to test.
#[derive(Args, Clone, Copy, Debug)]
pub struct TrialArgs {
    /// Seconds by which the clock of schedules is ahead of this computer's, to try schedules.
    #[arg(long, value_name = "SECONDS", default_value_t = 0, allow_hyphen_values = true)]
    clock_offset: i64,
    /// Length of the walk of the example, minutes.
    #[arg(long, hide = true)]
    example_minutes: Option<f64>,
}

impl TrialArgs {
    /// The same as arguments of a child process.
    pub fn to_arguments(self) -> Vec<String> {
        let mut arguments = vec![format!("--clock-offset={}", self.clock_offset)];
        arguments.extend(self.example_minutes.map(|minutes| format!("--example-minutes={minutes}")));
        arguments
    }
}

/// Limits of the recordings.
#[derive(Args, Clone, Debug)]
pub struct RecordingsArgs {
    /// Megabytes that recordings may take [default: half of the disk].
    #[arg(long)]
    recordings_mb: Option<u64>,
}

impl RecordingsArgs {
    /// The same as arguments of a child process.
    pub fn to_arguments(&self) -> Vec<String> {
        self.recordings_mb
            .map(|megabytes| ["--recordings-mb".to_owned(), megabytes.to_string()])
            .into_iter()
            .flatten()
            .collect()
    }

    fn config(&self) -> RecordingsConfig {
        let max_bytes = self.recordings_mb.map(|megabytes| megabytes.saturating_mul(1_000_000));
        RecordingsConfig { max_bytes, ..RecordingsConfig::default() }
    }
}

/// Runs the core until a request to stop.
pub fn run_core(args: &CoreArgs) -> Result<(), Failure> {
    let watchdog = watchdog();
    let failed = watch_process(&watchdog, CONTROL_THREAD, &args.supervision)?;
    let stop = ShutdownSignal::on_signals_or_end_of_input(&watchdog)?;
    set_clock_offset(Span::from_millis(args.trial.clock_offset.saturating_mul(1_000)));
    let store = Arc::new(Store::open(&args.data).map_err(Failure::usage)?);
    let now = wall_clock();
    let Some(link) = args.robot.link(&stop)? else {
        return Ok(());
    };
    let robot_restarted = link.robot_restarted();
    let recording = if args.no_record { None } else { Some(recording(&store, args, &*link, now)?) };
    let config = CoreConfig {
        link,
        store,
        recording,
        socket: args.socket.clone(),
        importer: Some(Box::new(ImportProcess)),
        change_finder: Some(Box::new(ChangesProcess)),
        gauge_reader: Some(Box::new(GaugeProcess)),
        picture_comparer: Some(Box::new(PictureProcess)),
        example_maker: Some(Box::new(ExampleProcess { minutes: args.trial.example_minutes })),
        watchdog,
        restart: args.supervision.restart(ProcessRole::Core),
        robot_restart: args.robot_restart(),
        access: args.access.of_core(),
        audit_entries: args.access.audit_entries(),
    };
    let _core = Core::start(config).map_err(Failure::failed)?;
    select! {
        recv(stop.receiver()) -> _ => Ok(()),
        // Its clock and its place may have changed. A new core begins anew, and offers a mapping session that this one leaves unfinished.
        // Disconnected: the link has ended with the control loop, which says why.
        recv(robot_restarted) -> restarted => if restarted.is_err() {
            Err(thread_failed(failed.recv().ok()))
        } else {
            let cause = texts::ROBOT_RESTARTED;
            args.supervision.report(&ChildReport::Failed(cause.to_owned()));
            Err(Failure::failed(texts::process_failed(cause)))
        },
        recv(failed) -> failure => Err(thread_failed(failure.ok())),
    }
}

fn recording(
    store: &Store,
    args: &CoreArgs,
    link: &dyn RobotLink,
    now: Stamp,
) -> Result<RecordingTarget, Failure> {
    let recordings = Recordings::new(store.dir().recordings(), args.recordings.config());
    let run = recordings.begin_run(now).map_err(Failure::failed)?;
    let boot = link.boot();
    let origin = link.site().map_or_else(|| args.robot.robot.to_string(), |site| format!("sim:{site}"));
    let meta = RecordingMeta { robot: boot.profile.name, origin, segment: None };
    Ok(RecordingTarget { writer: Box::new(McapSegments { meta, mounting: boot.mounting }), run })
}

/// Time of this computer's clock. A time before 1970 counts as 1970.
pub fn wall_clock() -> Stamp {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    Stamp::from_nanos(i64::try_from(since.as_nanos()).unwrap_or(i64::MAX))
}
