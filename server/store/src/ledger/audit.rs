//! The audit log: who asked for what, and what became of it. Each entry holds the checksum of the one before.
//!
//! Beyond a number of entries the oldest are removed. The same transaction adds an entry that says up to which number, and holds the checksum of the last one that was
//! removed. So the chain goes on from there: whoever has kept the removed entries can show that they belong to it, and without such an entry a log that does not begin
//! with its first entry counts as changed.

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
        AUDIT.put(self.transaction, &values)?;
        match self.max_audit_entries {
            Some(most) => self.cut_audit(seq + 1, most, at),
            None => Ok(()),
        }
    }

    /// Removes the oldest entries if there are more than `most` and some. `newest` is the number of the last one.
    fn cut_audit(&self, newest: i64, most: u64, at: Stamp) -> Result<(), Fault> {
        let most = i64::try_from(most.max(1)).unwrap_or(i64::MAX);
        let slack = (most / CUT_SHARE).max(1);
        let oldest = AUDIT.read(self.transaction, "ORDER BY seq LIMIT 1", [], |row| integer(&row[0]))?;
        let Some(oldest) =
            oldest.first().copied().filter(|oldest| newest - oldest >= most.saturating_add(slack))
        else {
            return Ok(());
        };
        // The entry that says so comes on top.
        let last = (newest + 1 - most).max(oldest);
        let removed =
            AUDIT.read(self.transaction, "WHERE seq = ?1", [last], |row| Some(AUDIT.checksum(row)))?;
        let Some(Value::Blob(checksum)) = removed.first() else { return Err(Fault::Broken(DAMAGED_ROW)) };
        let outcome = cut_outcome(last, checksum);
        self.transaction.prepare_cached("DELETE FROM audit WHERE seq <= ?1")?.execute([last])?;
        self.put_audit_row(Value::Null, CUT, &outcome, at)
    }
}

/// The log is cut once it has this share of its greatest number too much, so that it is not cut at every entry.
const CUT_SHARE: i64 = 100;

/// What the entry that is added to a log that was cut says of who asked for what: the platform itself.
const CUT: &str = "remove old entries of the audit log";

/// What it says was done.
fn cut_outcome(last: i64, checksum: &[u8]) -> String {
    let checksum: String = checksum.iter().map(|byte| format!("{byte:02x}")).collect();
    format!("done up to entry {last}, of which the checksum is {checksum}")
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

/// Checks that no entry was changed, removed or put in between. Those that the platform has removed itself are named by an entry, with the checksum of the last.
pub(super) fn check_chain(connection: &Connection) -> Result<(), Fault> {
    let changed = || Fault::Broken(crate::texts::AUDIT_LOG_CHANGED);
    let mut last: Option<(i64, Value)> = None;
    // What an entry has to say if the log does not begin with the first.
    let mut missing: Option<String> = None;
    AUDIT.for_each(connection, "ORDER BY seq", [], |row| {
        let values = AUDIT.whole(&row).ok_or(Fault::Broken(DAMAGED_ROW))?;
        let seq = integer(&values[0]).unwrap_or(0);
        match &last {
            Some((before, checksum)) if seq == before + 1 && values[5] == *checksum => {}
            None if seq == 1 && values[5] == Value::Null => {}
            None => match &values[5] {
                Value::Blob(checksum) => missing = Some(cut_outcome(seq - 1, checksum)),
                _ => return Err(changed()),
            },
            Some(_) => return Err(changed()),
        }
        let is_cut = values[2] == Value::Null && text(&values[3]) == Some(CUT);
        if is_cut && missing.as_deref() == text(&values[4]) {
            missing = None;
        }
        last = Some((seq, AUDIT.checksum(values)));
        Ok(())
    })?;
    if missing.is_some() { Err(changed()) } else { Ok(()) }
}

/// Number of the first entry that is there.
pub(super) fn first_entry(connection: &Connection) -> Result<u64, Fault> {
    let first = AUDIT.read(connection, "ORDER BY seq LIMIT 1", [], |row| integer(&row[0]))?;
    Ok(first.first().and_then(|first| (*first).try_into().ok()).unwrap_or(0))
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
