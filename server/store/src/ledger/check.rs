//! Looks for damage in the ledger.

use super::rows::{DAMAGED_ROW, Fault};
use super::{audit, error, open_for_reading, schema};
use crate::stored_data_check::StoredDataReport;
use crate::{Store, StoreError};
use rusqlite::Connection;
use std::fs;
use std::ops::ControlFlow;
use std::path::Path;

/// The audit log of a ledger that is whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VerifiedAudit {
    /// Number of the first entry; 0 without any.
    pub first: u64,
    /// Number of the last entry; 0 without any.
    pub last: u64,
    /// Checksum of the last entry.
    pub checksum: Option<[u8; 32]>,
}

/// How thoroughly SQLite looks at its structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Depth {
    /// Without the content of indices.
    Quick,
    /// Everything.
    Full,
}

/// Checks that a database is a ledger, and its structure whole.
pub(super) fn check_structure(connection: &Connection, depth: Depth) -> Result<(), Fault> {
    schema::check_version(connection)?;
    let pragma = match depth {
        Depth::Quick => "PRAGMA quick_check(1)",
        Depth::Full => "PRAGMA integrity_check(1)",
    };
    let found: String = connection.query_row(pragma, [], |row| row.get(0))?;
    if found != "ok" {
        tracing::error!("the ledger is damaged: {found}");
        return Err(Fault::Broken(crate::texts::LEDGER_STRUCTURE));
    }
    Ok(())
}

fn check_all(connection: &Connection) -> Result<(), Fault> {
    check_structure(connection, Depth::Full)?;
    for table in schema::TABLES {
        table.for_each(connection, "", [], |row| {
            table.whole(&row).map(drop).ok_or(Fault::Broken(DAMAGED_ROW))
        })?;
    }
    audit::check_chain(connection)
}

/// Reads the whole ledger at `path`, compares every row with its checksum, and checks that no entry of the audit log was changed, removed or put in between. Returns the
/// numbers of the first and the last entry of the audit log, both 0 without any, and the checksum of the last one, which anchors the whole log: whoever notes it elsewhere
/// notices also a log that was cut at its end.
///
/// # Errors
/// When the ledger cannot be read or is damaged.
pub fn verify_ledger(path: &Path) -> Result<VerifiedAudit, StoreError> {
    let verify = || {
        let connection = open_for_reading(path)?;
        check_all(&connection)?;
        let (last, checksum) = audit::last_entry(&connection)?;
        Ok(VerifiedAudit { first: audit::first_entry(&connection)?, last, checksum })
    };
    verify().map_err(|fault| error(path, fault))
}

impl Store {
    /// Reads the whole ledger, if there is one, and compares every row with its checksum.
    pub(crate) fn check_ledger(&self, report: &mut dyn StoredDataReport) -> ControlFlow<()> {
        let path = self.dir().ledger();
        let Ok(about) = fs::symlink_metadata(&path) else { return ControlFlow::Continue(()) };
        match open_for_reading(&path).and_then(|connection| check_all(&connection)) {
            Ok(()) => {}
            Err(fault) => match error(&path, fault) {
                // People were told when it was opened.
                StoreError::LaterVersion { .. } => {}
                error => report.on_damage(error),
            },
        }
        report.on_read(about.len())
    }
}
