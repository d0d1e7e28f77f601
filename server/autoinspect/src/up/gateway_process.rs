//! The gateway's process.

use super::stop::Stop;
use crate::failure::Failure;
use crate::output;
use clap::Args;
use gateway::{GatewayConfig, GatewayError};
use std::net::SocketAddr;
use std::path::PathBuf;
use tokio::sync::oneshot;

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
}

/// Runs the gateway until a request to stop. Its first line on standard output is the address on which it listens.
pub fn run_gateway(args: &GatewayArgs) -> Result<(), Failure> {
    let stop = Stop::on_signals_or_end_of_input()?;
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
        on_ready: Some(on_ready),
    };
    let stopped = runtime.spawn_blocking(move || {
        // A disconnected channel is also a request to stop.
        let _ = stop.receiver().recv();
    });
    runtime.spawn(async move {
        if let Ok(address) = ready.await {
            output::print_line(&address.to_string());
        }
    });
    let served = runtime.block_on(gateway::serve(config, async {
        let _ = stopped.await;
    }));
    // The thread that waits for the signal does not end by itself.
    runtime.shutdown_background();
    served.map_err(|error| match error {
        GatewayError::Listen { .. } => Failure::usage(error),
    })
}
