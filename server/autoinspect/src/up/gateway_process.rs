//! The gateway's process.

use super::access::AccessArgs;
use super::child_report::ChildReport;
use super::process_watch::{SupervisionArgs, thread_failed, watch_process, watchdog};
use super::stop::ShutdownSignal;
use crate::failure::Failure;
use crate::output;
use api::ProcessRole;
use clap::Args;
use crossbeam_channel::select;
use gateway::{GatewayConfig, GatewayError};
use std::net::SocketAddr;
use std::path::PathBuf;
use tokio::sync::oneshot;
use watchdog::catch_panic;

/// Arguments of the gateway's process.
#[derive(Args, Debug)]
pub struct GatewayArgs {
    /// Data directory.
    #[arg(long)]
    data: PathBuf,
    /// Socket on which the core listens.
    #[arg(long)]
    socket: PathBuf,
    /// Folder of the browser client.
    #[arg(long = "static")]
    static_dir: PathBuf,
    /// Address for browsers.
    #[arg(long)]
    listen: SocketAddr,
    #[command(flatten)]
    access: AccessArgs,
    #[command(flatten)]
    supervision: SupervisionArgs,
}

/// Name of the thread that serves.
const GATEWAY_THREAD: &str = "gateway";

/// Runs the gateway until a request to stop. It prints the address on which it listens.
pub fn run_gateway(args: &GatewayArgs) -> Result<(), Failure> {
    let watchdog = watchdog();
    let failed = watch_process(&watchdog, GATEWAY_THREAD, &args.supervision)?;
    let stop = ShutdownSignal::on_signals_or_end_of_input(&watchdog)?;
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .thread_name("gateway")
        .enable_all()
        .build()
        .map_err(Failure::failed)?;
    let (on_ready, ready) = oneshot::channel();
    let config = GatewayConfig {
        listen: args.listen,
        core_socket: args.socket.clone(),
        data_dir: args.data.clone(),
        static_dir: args.static_dir.clone(),
        access: args.access.of_gateway(),
        tls: args.access.tls(&args.data),
        on_ready: Some(on_ready),
        heartbeat: Some(watchdog.watch(GATEWAY_THREAD, runtime::THREAD_LIMITS.control)),
        restart: args.supervision.restart(ProcessRole::Gateway),
    };
    let stopped = runtime.spawn_blocking(move || {
        select! {
            // A disconnected channel is also a request to stop.
            recv(stop.receiver()) -> _ => Ok(()),
            recv(failed) -> failure => Err(thread_failed(failure.ok())),
        }
    });
    runtime.spawn(async move {
        if let Ok(address) = ready.await {
            output::print_line(&ChildReport::Address(address).to_string());
        }
    });
    let (result, outcome) = oneshot::channel();
    let serve = gateway::serve(config, async {
        // Nobody listens if the gateway has ended by itself.
        let _ = result.send(stopped.await.unwrap_or(Ok(())));
    });
    let served = catch_panic(GATEWAY_THREAD, || runtime.block_on(serve));
    // The thread that waits for the signal does not end by itself.
    runtime.shutdown_background();
    let served = served.map_err(|failure| {
        args.supervision.report(&ChildReport::Failed(failure.to_string()));
        thread_failed(Some(failure))
    })?;
    served.map_err(|error| match error {
        GatewayError::Listen { .. } | GatewayError::DemoOnNetwork { .. } | GatewayError::Tls(_) => {
            Failure::usage(error)
        }
    })?;
    outcome.blocking_recv().unwrap_or(Ok(()))
}
