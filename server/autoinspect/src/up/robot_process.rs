//! The process of the simulated robot.

use super::child_report::ChildReport;
use super::core_process::wall_clock;
use super::process_watch::{SupervisionArgs, thread_failed, watch_process, watchdog};
use super::stop::ShutdownSignal;
use crate::failure::Failure;
use crate::robot::{RobotArgs, RobotName};
use crate::texts;
use clap::Args;
use crossbeam_channel::select;
use links::{OnStep, RobotStartError, SimulatedRobot, SimulatedRobotConfig};
use sim::SimConfig;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Parameters of [`run_robot`].
#[derive(Clone, Copy, Debug)]
struct RobotProcessConfig {
    /// Longest wait for another robot on the same socket, which may be ending because its supervisor was killed. Chosen: an orderly end takes less.
    in_use_timeout: Duration,
    /// Pause between two attempts. Chosen: nobody notices it.
    retry_pause: Duration,
    /// Share of the furniture that is moved or removed on another day. Chosen: as `autoinspect sim record`.
    moved_share: f64,
}

const CONFIG: RobotProcessConfig = RobotProcessConfig {
    in_use_timeout: Duration::from_secs(3),
    retry_pause: Duration::from_millis(50),
    moved_share: 0.25,
};

/// Arguments of the simulated robot's process.
#[derive(Args, Debug)]
pub struct SimulatedRobotArgs {
    /// Socket on which to listen for the core.
    #[arg(long)]
    socket: PathBuf,
    /// Append the ground truth to this file, for scoring.
    #[arg(long)]
    truth: Option<PathBuf>,
    #[command(flatten)]
    robot: RobotArgs,
    #[command(flatten)]
    supervision: SupervisionArgs,
}

/// Name of the thread that simulates.
const SIMULATION_THREAD: &str = "simulation";

/// Runs the simulated robot until a request to stop. Its clock starts at this computer's time.
pub fn run_robot(args: &SimulatedRobotArgs) -> Result<(), Failure> {
    let watchdog = watchdog();
    let failed = watch_process(&watchdog, SIMULATION_THREAD, &args.supervision)?;
    let stop = ShutdownSignal::on_signals_or_end_of_input(&watchdog)?;
    let RobotName::Sim(source) = &args.robot.robot else {
        return Err(Failure::usage(texts::ONLY_SITES_ARE_SIMULATED));
    };
    let mut site = source.load().map_err(Failure::usage)?;
    if let Some(day) = args.robot.day {
        site = Arc::new(site.on_another_day(day, CONFIG.moved_share));
    }
    site = args.robot.changes.apply(site, args.robot.day.unwrap_or(args.robot.seed))?;
    let since = Instant::now();
    let robot = loop {
        let sim = SimConfig {
            lidar_columns: args.robot.lidar_columns,
            people: args.robot.people,
            epoch: wall_clock(),
            ..SimConfig::new(Arc::clone(&site), args.robot.seed)
        };
        let config = SimulatedRobotConfig::new(sim, args.robot.speed, args.socket.clone());
        let heartbeat = watchdog.watch(SIMULATION_THREAD, runtime::THREAD_LIMITS.control);
        let on_step: Option<OnStep> = Some(Box::new(move || heartbeat.beat()));
        match SimulatedRobot::start(SimulatedRobotConfig { truth: args.truth.clone(), on_step, ..config }) {
            Ok(robot) => break robot,
            Err(error @ RobotStartError::InUse { .. }) if since.elapsed() >= CONFIG.in_use_timeout => {
                return Err(Failure::usage(error));
            }
            Err(RobotStartError::InUse { .. }) => {}
            Err(error) => return Err(Failure::failed(error)),
        }
        if stop.wait(CONFIG.retry_pause) {
            return Ok(());
        }
    };
    // The site is built. From now on silence means that the robot hangs.
    args.supervision.report(&ChildReport::Alive);
    select! {
        recv(stop.receiver()) -> _ => Ok(()),
        recv(robot.ended()) -> _ => Err(Failure::failed(texts::SIMULATION_ENDED)),
        recv(failed) -> failure => Err(thread_failed(failure.ok())),
    }
}
