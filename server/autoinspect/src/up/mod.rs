//! `autoinspect up` and its processes.
//!
//! The core runs the robot, the gateway serves browsers. They are separate processes, so that no browser can affect the
//! robot's behaviour. A simulated robot is a third process, which lives on when the core ends, like a real robot. `up` starts them, restarts each when it ends, and
//! stops them in order.

mod access;
mod changes_process;
mod child_complaint;
mod child_report;
mod child_wait;
mod core_process;
mod example_process;
mod gateway_process;
mod gauge_process;
mod health;
mod import_process;
mod paths;
mod picture_process;
mod process;
mod process_watch;
mod robot_process;
mod role;
mod stop;
mod supervisor;

use access::AccessArgs;
pub use access::first_admin_link;
pub use core_process::{CoreArgs, run_core, wall_clock};
use core_process::{RecordingsArgs, TrialArgs};
pub use gateway_process::{GatewayArgs, run_gateway};
pub use paths::default_data_dir;
pub use robot_process::{SimulatedRobotArgs, run_robot};
pub use stop::ShutdownSignal;

use crate::failure::Failure;
use crate::robot::{RobotArgs, RobotName};
use crate::{output, texts};
use clap::Args;
use gateway::TlsConfig;
use health::reachable;
use ports::DataDir;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use supervisor::{Supervisor, SupervisorArguments};

/// Run the platform: a robot's core and the server for browsers.
#[derive(Args, Debug)]
#[command(after_help = "EXAMPLES:
  autoinspect up --demo                            a simulated robot in the test hall; nobody has to sign in
  autoinspect up --robot sim:plant --people 10
  autoinspect up --robot replay:recording.mcap --speed 2
  autoinspect up --listen 0.0.0.0:8080 --tls auto --data /var/lib/autoinspect")]
pub struct UpArgs {
    /// Folder of maps and recordings [default: the user's data directory].
    #[arg(long)]
    data: Option<PathBuf>,
    /// Address for browsers; port 0 lets the system choose.
    #[arg(long, default_value = "127.0.0.1:8080")]
    listen: SocketAddr,
    /// Folder of the browser client [default: beside the program or in the current directory].
    #[arg(long = "static")]
    static_dir: Option<PathBuf>,
    /// Do not record the inputs of the robot's stack.
    #[arg(long)]
    no_record: bool,
    /// Append the ground truth of a simulated robot to this file, for scoring.
    #[arg(long, hide = true)]
    truth: Option<PathBuf>,
    #[command(flatten)]
    access: AccessArgs,
    #[command(flatten)]
    recordings: RecordingsArgs,
    #[command(flatten)]
    trial: TrialArgs,
    #[command(flatten)]
    robot: RobotArgs,
}

/// Runs `autoinspect up` until a signal stops it.
pub fn run(args: &UpArgs) -> Result<(), Failure> {
    args.access.check(args.listen)?;
    args.robot.check()?;
    let data = args.data.clone().unwrap_or_else(default_data_dir);
    std::fs::create_dir_all(&data).map_err(|error| Failure::failed(texts::cannot_create(&data, &error)))?;
    let data = data.canonicalize().map_err(|error| Failure::unreadable(&data, error))?;
    let static_dir = paths::static_dir(args.static_dir.as_deref())?;
    let (socket, robot_socket) = (DataDir::new(&data).core_socket(), DataDir::new(&data).robot_socket());
    let text = |path: &Path| path.display().to_string();

    let simulated_robot = matches!(args.robot.robot, RobotName::Sim(_)).then(|| {
        let mut robot = vec!["simulated-robot".to_owned(), "--socket".to_owned(), text(&robot_socket)];
        robot.extend(args.robot.to_arguments());
        robot.extend(args.truth.iter().flat_map(|truth| ["--truth".to_owned(), text(truth)]));
        robot
    });
    let robot = match simulated_robot {
        Some(_) => args.robot.with_robot(RobotName::Socket(robot_socket)),
        None => args.robot.clone(),
    };
    let mut core =
        vec!["core".to_owned(), "--data".to_owned(), text(&data), "--socket".to_owned(), text(&socket)];
    core.extend(robot.to_arguments());
    core.extend(args.recordings.to_arguments());
    core.extend(args.trial.to_arguments());
    core.extend(args.access.to_arguments());
    if args.no_record {
        core.push("--no-record".to_owned());
    }
    let gateway =
        ["gateway", "--data", &text(&data), "--socket", &text(&socket), "--static", &text(&static_dir)];
    let gateway = gateway.map(str::to_owned).into_iter().chain(args.access.to_arguments()).collect();

    let stop = ShutdownSignal::on_signals()?;
    let arguments = SupervisorArguments { simulated_robot, core, gateway };
    let mut supervisor = Supervisor::new(arguments, args.listen, socket);
    supervisor.run(&stop, |address| {
        let address = reachable(address);
        let base = format!("{}://{address}", if args.access.is_encrypted() { "https" } else { "http" });
        output::print_line(&texts::platform_running(&base));
        output::print_note(&texts::platform_data(&data));
        if let TlsConfig::Own(folder) = args.access.tls(&data)
            && let Some(fingerprint) = gateway::authority_fingerprint(&folder)
        {
            output::print_note(&texts::trust_authority(&format!("http://{address}"), &fingerprint));
        }
        if let Some(link) = first_admin_link(&data, &base) {
            output::print_note(&texts::make_first_admin(&link));
        }
    })
}
