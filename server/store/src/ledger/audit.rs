//! The audit log: who asked for what, and what became of it. Each entry holds the checksum of the one before.

use super::LedgerWriter;
use super::documents::author;
use super::rows::{DAMAGED_ROW, Fault, integer};
use super::schema::AUDIT;
use messages::Principal;
use rusqlite::Connection;
use rusqlite::types::Value;
use vocab::Stamp;

impl LedgerWriter<'_> {
    /// Adds an entry.
    pub(super) fn put_audit(
        &self,
        by: Option<&Principal>,
        command: &str,
        outcome: &str,
        at: Stamp,
    ) -> Result<(), Fault> {
        let newest = "ORDER BY seq DESC LIMIT 1";
        let last =
            AUDIT.read(self.transaction, newest, [], |row| Some((integer(&row[0])?, AUDIT.checksum(row))))?;
        let (seq, previous) = last.into_iter().next().unwrap_or((0, Value::Null));
        let values = [
            Value::from(seq + 1),
            Value::from(at.nanos()),
            author(by),
            Value::from(command.to_owned()),
            Value::from(outcome.to_owned()),
            previous,
        ];
        AUDIT.put(self.transaction, &values)
    }
}

/// Checks that no entry was changed, removed or put in between.
pub(super) fn check_chain(connection: &Connection) -> Result<(), Fault> {
    let mut last = (0, Value::Null);
    AUDIT.for_each(connection, "ORDER BY seq", [], |row| {
        let values = AUDIT.whole(&row).ok_or(Fault::Broken(DAMAGED_ROW))?;
        let seq = integer(&values[0]).unwrap_or(0);
        if seq != last.0 + 1 || values[5] != last.1 {
            return Err(Fault::Broken(crate::texts::AUDIT_LOG_CHANGED));
        }
        last = (seq, AUDIT.checksum(values));
        Ok(())
    })
}
