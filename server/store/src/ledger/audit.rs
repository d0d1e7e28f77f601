//! The audit log: who asked for what, and what became of it. Each entry holds the checksum of the one before.

use super::documents::{author, json};
use super::rows::{DAMAGED_ROW, Fault, integer, or_null, text};
use super::schema::AUDIT;
use super::{Ledger, LedgerWriter};
use crate::StoreError;
use api::{MAX_PAGE, StoredAudit};
use messages::Principal;
use rusqlite::types::Value;
use rusqlite::{Connection, params};
use serde::Serialize;
use std::net::IpAddr;
use vocab::Stamp;

/// What somebody asked for, and what became of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AuditEntry {
    /// Who; none: the platform itself, or somebody who did not sign in.
    pub by: Option<Principal>,
    /// From where; none: from the robot's own computer.
    pub address: Option<IpAddr>,
    /// What.
    pub command: String,
    /// What became of it.
    pub outcome: String,
}

/// Who and from where, in one column: the table is older than the address.
#[derive(Serialize)]
struct Origin<'a> {
    #[serde(flatten)]
    by: Option<&'a Principal>,
    #[serde(skip_serializing_if = "Option::is_none")]
    address: Option<IpAddr>,
}

impl LedgerWriter<'_> {
    /// Adds an entry to the audit log.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn put_audit_entry(&self, entry: &AuditEntry, at: Stamp) -> Result<(), StoreError> {
        let origin = Origin { by: entry.by.as_ref(), address: entry.address };
        let origin = (entry.by.is_some() || entry.address.is_some()).then(|| json(&origin));
        self.put_audit_row(or_null(origin), &entry.command, &entry.outcome, at)
            .map_err(|fault| self.error(fault))
    }

    /// Adds an entry.
    pub(super) fn put_audit(
        &self,
        by: Option<&Principal>,
        command: &str,
        outcome: &str,
        at: Stamp,
    ) -> Result<(), Fault> {
        self.put_audit_row(author(by), command, outcome, at)
    }

    fn put_audit_row(&self, by: Value, command: &str, outcome: &str, at: Stamp) -> Result<(), Fault> {
        let newest = "ORDER BY seq DESC LIMIT 1";
        let last =
            AUDIT.read(self.transaction, newest, [], |row| Some((integer(&row[0])?, AUDIT.checksum(row))))?;
        let (seq, previous) = last.into_iter().next().unwrap_or((0, Value::Null));
        let values = [
            Value::from(seq + 1),
            Value::from(at.nanos()),
            by,
            Value::from(command.to_owned()),
            Value::from(outcome.to_owned()),
            previous,
        ];
        AUDIT.put(self.transaction, &values)
    }
}

impl Ledger {
    /// Entries of the audit log before `before` that contain this text, the newest first. An empty text is in all.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn audit(
        &self,
        before: Option<u64>,
        containing: &str,
        limit: u32,
    ) -> Result<Vec<StoredAudit>, StoreError> {
        let before = before.map_or(i64::MAX, |before| i64::try_from(before).unwrap_or(i64::MAX));
        let take = |row: &[Value]| {
            Some(StoredAudit {
                number: integer(&row[0])?.try_into().ok()?,
                at: Stamp::from_nanos(integer(&row[1])?),
                origin: text(&row[2]).map(str::to_owned),
                command: text(&row[3])?.to_owned(),
                outcome: text(&row[4])?.to_owned(),
            })
        };
        // The client's id, which is hexadecimal, is not searched: words would be found in it by chance.
        let rest = "WHERE seq < ?1 AND (?2 = '' OR instr(lower(
                        coalesce(json_extract(principal, '$.account'), '') || ' ' ||
                        coalesce(json_extract(principal, '$.address'), '') || ' ' || command || ' ' || outcome), lower(?2)) > 0)
                    ORDER BY seq DESC LIMIT ?3";
        let parameters = params![before, containing, limit.clamp(1, MAX_PAGE)];
        AUDIT.read(&self.connection, rest, parameters, take).map_err(|fault| self.error(fault))
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

/// Number and checksum of the last entry.
pub(super) fn last_entry(connection: &Connection) -> Result<(u64, Option<[u8; 32]>), Fault> {
    let mut last = (0, None);
    AUDIT.for_each(connection, "ORDER BY seq DESC LIMIT 1", [], |row| {
        let values = AUDIT.whole(&row).ok_or(Fault::Broken(DAMAGED_ROW))?;
        let number = integer(&values[0]).and_then(|number| number.try_into().ok()).unwrap_or(0);
        let checksum = match AUDIT.checksum(values) {
            Value::Blob(bytes) => bytes.try_into().ok(),
            _ => None,
        };
        last = (number, checksum);
        Ok(())
    })?;
    Ok(last)
}
