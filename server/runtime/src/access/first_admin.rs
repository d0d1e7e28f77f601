//! The link that makes the first admin. Its secret is in a file of the data directory that only the service's user can read, from which `autoinspect up` prints it.

use accounts::{credential_id, new_secret};
use api::access::Secret;
use std::fs;
use std::io::{self, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::PathBuf;

/// The file.
#[derive(Debug)]
pub(super) struct FirstAdminLink {
    path: PathBuf,
}

impl FirstAdminLink {
    pub fn new(path: PathBuf) -> Self {
        Self { path }
    }

    fn secret(&self) -> Option<Secret> {
        let text = fs::read_to_string(&self.path).ok()?;
        Some(Secret::new(text.trim())).filter(|secret| !secret.reveal().is_empty())
    }

    /// Makes the file, or removes it.
    ///
    /// # Errors
    /// When the disk fails, or the system has no random numbers.
    pub fn set(&self, is_needed: bool) -> io::Result<()> {
        if !is_needed {
            return match fs::remove_file(&self.path) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
                _ => Ok(()),
            };
        }
        if self.secret().is_some() {
            return Ok(());
        }
        let secret = new_secret().map_err(io::Error::other)?;
        let mut file =
            fs::OpenOptions::new().write(true).create(true).truncate(true).mode(0o600).open(&self.path)?;
        writeln!(file, "{}", secret.reveal())
    }

    /// Whether this is the secret of the link.
    pub fn is_of_link(&self, secret: &Secret) -> bool {
        // Hashes are compared, so that the time tells nothing of the secret.
        self.secret().is_some_and(|link| credential_id(link.reveal()) == credential_id(secret.reveal()))
    }
}
