//! The core's process: link, store, recorder and control loop.

use super::import_process::ImportProcess;
use super::stop::Stop;
use crate::failure::Failure;
use crate::journal::McapJournal;
use crate::robot::RobotArgs;
use clap::Args;
use crossbeam_channel::select;
use ports::RobotLink;
use recorder::{RecordingMeta, RecordingWriter};
use runtime::{Core, CoreConfig, RecordingTarget};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};
use store::Store;
use vocab::Stamp;

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
    robot: RobotArgs,
}

/// Runs the core until a request to stop.
pub fn run_core(args: &CoreArgs) -> Result<(), Failure> {
    let stop = Stop::on_signals_or_end_of_input()?;
    let store = Arc::new(Store::open(&args.data).map_err(Failure::usage)?);
    let now = wall_clock();
    let link = args.robot.link(now)?;
    let recording = if args.no_record {
        None
    } else {
        Some(recording(&store, &*link, now, &args.robot.robot.to_string())?)
    };
    let config = CoreConfig {
        link,
        store,
        recording,
        socket: args.socket.clone(),
        importer: Some(Box::new(ImportProcess)),
    };
    let core = Core::start(config).map_err(Failure::failed)?;
    let ended = core.ended();
    select! {
        recv(stop.receiver()) -> _ => Ok(()),
        recv(ended) -> _ => Err(Failure::failed(crate::texts::CONTROL_LOOP_ENDED)),
    }
}

fn recording(
    store: &Store,
    link: &dyn RobotLink,
    now: Stamp,
    origin: &str,
) -> Result<RecordingTarget, Failure> {
    let recordings = store.recordings();
    let path = recordings.path(now);
    let boot = link.boot();
    let meta = RecordingMeta { robot: boot.profile.name, origin: origin.to_owned() };
    let writer = RecordingWriter::create(&path, &meta, &boot.mounting).map_err(Failure::failed)?;
    Ok(RecordingTarget { journal: Box::new(McapJournal(writer)), path, recordings })
}

/// Time of this computer's clock. A time before 1970 counts as 1970.
fn wall_clock() -> Stamp {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    Stamp::from_nanos(i64::try_from(since.as_nanos()).unwrap_or(i64::MAX))
}
