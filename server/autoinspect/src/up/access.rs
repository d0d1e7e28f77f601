//! Who may use the platform and how connections are encrypted: arguments, and the link that makes the first admin.

use crate::failure::Failure;
use crate::texts;
use clap::{Args, ValueEnum};
use gateway::TlsConfig;
use ports::DataDir;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

/// Who may use the platform.
#[derive(Args, Clone, Debug)]
pub struct AccessArgs {
    /// Let everybody in as an admin, without a sign-in; the server is then reached from this computer only.
    #[arg(long)]
    demo: bool,
    /// Further name or address under which the server may be reached. Those of this computer need not be given.
    #[arg(long = "allow-host", value_name = "NAME")]
    allowed_hosts: Vec<String>,
    /// Encrypt connections: `auto` with certificates of an authority of the robot's own, `none` not at all.
    #[arg(long, value_enum, value_name = "HOW", conflicts_with_all = ["tls_certificate", "tls_key"])]
    tls: Option<TlsChoice>,
    /// Encrypt connections with this certificate, a PEM file that ends with those of its authorities. It is read again when it changes.
    #[arg(long, value_name = "FILE", requires = "tls_key")]
    tls_certificate: Option<PathBuf>,
    /// Key of that certificate, a PEM file.
    #[arg(long, value_name = "FILE", requires = "tls_certificate")]
    tls_key: Option<PathBuf>,
    /// Entries of the audit log that are kept, 1,000 at least [default: 500000]. Older ones are removed, and an entry says so.
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u64).range(1_000..))]
    audit_entries: Option<u64>,
}

/// Values of `--tls`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum TlsChoice {
    /// Plain http.
    #[default]
    None,
    /// A certificate authority of the robot's own, made on the first start.
    Auto,
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
        let own = (self.tls == Some(TlsChoice::Auto)).then(|| "--tls=auto".to_owned());
        let file = |option: &str, path: &Option<PathBuf>| {
            path.as_ref().map(|path| format!("--{option}={}", path.display()))
        };
        let files = [file("tls-certificate", &self.tls_certificate), file("tls-key", &self.tls_key)];
        let audit = self.audit_entries.map(|entries| format!("--audit-entries={entries}"));
        demo.into_iter().chain(hosts).chain(own).chain(files.into_iter().flatten()).chain(audit).collect()
    }

    /// Entries of the audit log that are kept, if that was given.
    pub fn audit_entries(&self) -> Option<u64> {
        self.audit_entries
    }

    /// Whether connections are encrypted.
    pub fn is_encrypted(&self) -> bool {
        self.tls == Some(TlsChoice::Auto) || self.tls_certificate.is_some()
    }

    /// How the gateway encrypts connections.
    pub fn tls(&self, data: &Path) -> TlsConfig {
        match (&self.tls_certificate, &self.tls_key) {
            (Some(certificates), Some(key)) => {
                TlsConfig::Files { certificates: certificates.clone(), key: key.clone() }
            }
            _ if self.tls == Some(TlsChoice::Auto) => TlsConfig::Own(DataDir::new(data).tls()),
            _ => TlsConfig::None,
        }
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
