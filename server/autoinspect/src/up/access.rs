//! Who may use the platform: arguments, and the link that makes the first admin.

use crate::failure::Failure;
use crate::texts;
use clap::Args;
use ports::DataDir;
use std::net::SocketAddr;
use std::path::Path;

/// Who may use the platform.
#[derive(Args, Clone, Debug)]
pub struct AccessArgs {
    /// Let everybody in as an admin, without a sign-in; the server is then reached from this computer only.
    #[arg(long)]
    demo: bool,
    /// Further name or address under which the server may be reached. Those of this computer need not be given.
    #[arg(long = "allow-host", value_name = "NAME")]
    allowed_hosts: Vec<String>,
}

impl AccessArgs {
    /// Fails for a demonstration on a network.
    pub fn check(&self, listen: SocketAddr) -> Result<(), Failure> {
        if self.demo && !listen.ip().is_loopback() {
            return Err(Failure::usage(texts::demo_on_network(&listen)));
        }
        Ok(())
    }

    /// The same as arguments of a child process.
    pub fn to_arguments(&self) -> Vec<String> {
        let demo = self.demo.then(|| "--demo".to_owned());
        let hosts = self.allowed_hosts.iter().map(|name| format!("--allow-host={name}"));
        demo.into_iter().chain(hosts).collect()
    }

    /// For the gateway.
    pub fn of_gateway(&self) -> gateway::AccessConfig {
        gateway::AccessConfig { is_demo: self.demo, allowed_hosts: self.allowed_hosts.clone() }
    }

    /// For the core.
    pub fn of_core(&self) -> runtime::AccessMode {
        if self.demo { runtime::AccessMode::Demo } else { runtime::AccessMode::SignIn }
    }
}

/// The address that makes the first admin, while there is none. `base` is that of the server.
pub fn first_admin_link(data: &Path, base: &str) -> Option<String> {
    let secret = std::fs::read_to_string(DataDir::new(data).first_admin_link()).ok()?;
    let secret = secret.trim();
    // What stands after # is not sent to servers, so it gets into no log of a proxy.
    (!secret.is_empty()).then(|| format!("{base}/#first-admin={secret}"))
}
