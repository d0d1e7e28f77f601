//! Tables of the ledger, and how those of earlier programs become those of today.

use super::rows::{Fault, Table};
use rusqlite::Connection;

/// Identifies the file, in the header of the database: "AuIn".
const APPLICATION_ID: i32 = 0x4175_496e;

/// Scripts that lead from each version of the schema to the next. A script that a program was released with is never changed.
///
/// `checksum` is BLAKE3 of the other columns of a row, see `rows.rs`. Times are nanoseconds since 1970, UTC, as the computer's clock had it.
const MIGRATIONS: &[&str] = &["
    -- Edits of the site in the order in which they were applied. The number of the last is the revision of the site.
    CREATE TABLE edits (
        seq INTEGER PRIMARY KEY, id TEXT NOT NULL UNIQUE, author TEXT, at_ns INTEGER NOT NULL, changes TEXT NOT NULL,
        checksum BLOB NOT NULL) STRICT;
    -- The present state of each object. Without a body: it was removed.
    CREATE TABLE documents (
        kind TEXT NOT NULL, id TEXT NOT NULL, revision INTEGER NOT NULL, body TEXT, author TEXT, at_ns INTEGER NOT NULL,
        checksum BLOB NOT NULL, PRIMARY KEY (kind, id)) STRICT, WITHOUT ROWID;
    CREATE TABLE document_revisions (
        kind TEXT NOT NULL, id TEXT NOT NULL, revision INTEGER NOT NULL, body TEXT, author TEXT, at_ns INTEGER NOT NULL,
        checksum BLOB NOT NULL, PRIMARY KEY (kind, id, revision)) STRICT, WITHOUT ROWID;
    CREATE TABLE runs (
        seq INTEGER PRIMARY KEY, run TEXT NOT NULL UNIQUE, mission TEXT NOT NULL, state TEXT NOT NULL, is_ended INTEGER NOT NULL,
        version INTEGER NOT NULL, body TEXT NOT NULL, began_ns INTEGER NOT NULL, changed_ns INTEGER NOT NULL,
        checksum BLOB NOT NULL) STRICT;
    CREATE TABLE steps (
        run TEXT NOT NULL, step INTEGER NOT NULL, attempt INTEGER NOT NULL, state TEXT NOT NULL, version INTEGER NOT NULL,
        body TEXT NOT NULL, intended_ns INTEGER NOT NULL, done_ns INTEGER,
        checksum BLOB NOT NULL, PRIMARY KEY (run, step, attempt)) STRICT, WITHOUT ROWID;
    CREATE TABLE results (
        seq INTEGER PRIMARY KEY, run TEXT NOT NULL, step INTEGER NOT NULL, attempt INTEGER NOT NULL, kind TEXT NOT NULL,
        blob BLOB, version INTEGER NOT NULL, body TEXT NOT NULL, at_ns INTEGER NOT NULL,
        checksum BLOB NOT NULL) STRICT;
    CREATE INDEX results_of_run ON results (run, seq);
    -- What happened in runs, schedules and monitors, in its order; the state of missions is rebuilt from it.
    CREATE TABLE mission_events (
        seq INTEGER PRIMARY KEY, run TEXT, version INTEGER NOT NULL, body TEXT NOT NULL, at_ns INTEGER NOT NULL,
        checksum BLOB NOT NULL) STRICT;
    CREATE INDEX mission_events_of_run ON mission_events (run, seq);
    -- Each slot of a schedule once.
    CREATE TABLE firings (
        schedule TEXT NOT NULL, due_ns INTEGER NOT NULL, run TEXT, outcome TEXT NOT NULL, version INTEGER NOT NULL,
        body TEXT NOT NULL, at_ns INTEGER NOT NULL,
        checksum BLOB NOT NULL, PRIMARY KEY (schedule, due_ns)) STRICT, WITHOUT ROWID;
    -- Who did what. `previous` is the checksum of the row before, so that no row can be changed or removed unnoticed.
    CREATE TABLE audit (
        seq INTEGER PRIMARY KEY, at_ns INTEGER NOT NULL, principal TEXT, command TEXT NOT NULL, outcome TEXT NOT NULL,
        previous BLOB, checksum BLOB NOT NULL) STRICT;
", "
    -- Results are found by their inspection point, see `POINT_OF_RESULT`, and slots by the time at which they were due.
    CREATE INDEX results_of_point ON results (
        CASE WHEN json_valid(body) THEN json_extract(body, '$.inspection_point') END, seq);
    CREATE INDEX firings_by_due ON firings (due_ns, schedule);
", "
    -- Who may sign in. `password` is a PHC string of Argon2id.
    CREATE TABLE accounts (
        account TEXT NOT NULL, role TEXT NOT NULL, password TEXT NOT NULL, is_enabled INTEGER NOT NULL,
        created_ns INTEGER NOT NULL, changed_ns INTEGER NOT NULL,
        checksum BLOB NOT NULL, PRIMARY KEY (account)) STRICT, WITHOUT ROWID;
    -- Sessions of accounts, and tokens of programs, which have a role of their own. `id` is the BLAKE3 of the secret. What has ended is kept for some time, because it
    -- tells that a browser has signed in to an account before.
    CREATE TABLE credentials (
        id TEXT NOT NULL, owner TEXT NOT NULL, role TEXT, created_ns INTEGER NOT NULL, used_ns INTEGER NOT NULL,
        expires_ns INTEGER NOT NULL, ended_ns INTEGER, address TEXT,
        checksum BLOB NOT NULL, PRIMARY KEY (id)) STRICT, WITHOUT ROWID;
", "
    -- How pictures of results differ from earlier ones.
    CREATE TABLE picture_comparisons (
        result INTEGER PRIMARY KEY, version INTEGER NOT NULL, body TEXT NOT NULL, at_ns INTEGER NOT NULL,
        checksum BLOB NOT NULL) STRICT;
"];

/// The inspection point of a result: the expression by which the index `results_of_point` is sorted, to the letter.
pub(super) const POINT_OF_RESULT: &str =
    "CASE WHEN json_valid(body) THEN json_extract(body, '$.inspection_point') END";

pub(super) const EDITS: Table =
    Table { name: "edits", columns: &["seq", "id", "author", "at_ns", "changes"] };
pub(super) const DOCUMENTS: Table =
    Table { name: "documents", columns: &["kind", "id", "revision", "body", "author", "at_ns"] };
pub(super) const DOCUMENT_REVISIONS: Table = Table { name: "document_revisions", columns: DOCUMENTS.columns };
pub(super) const RUNS: Table = Table {
    name: "runs",
    columns: &["seq", "run", "mission", "state", "is_ended", "version", "body", "began_ns", "changed_ns"],
};
pub(super) const STEPS: Table = Table {
    name: "steps",
    columns: &["run", "step", "attempt", "state", "version", "body", "intended_ns", "done_ns"],
};
pub(super) const RESULTS: Table = Table {
    name: "results",
    columns: &["seq", "run", "step", "attempt", "kind", "blob", "version", "body", "at_ns"],
};
pub(super) const PICTURE_COMPARISONS: Table =
    Table { name: "picture_comparisons", columns: &["result", "version", "body", "at_ns"] };
pub(super) const FIRINGS: Table =
    Table { name: "firings", columns: &["schedule", "due_ns", "run", "outcome", "version", "body", "at_ns"] };
pub(super) const MISSION_EVENTS: Table =
    Table { name: "mission_events", columns: &["seq", "run", "version", "body", "at_ns"] };
pub(super) const AUDIT: Table =
    Table { name: "audit", columns: &["seq", "at_ns", "principal", "command", "outcome", "previous"] };
pub(super) const ACCOUNTS: Table = Table {
    name: "accounts",
    columns: &["account", "role", "password", "is_enabled", "created_ns", "changed_ns"],
};
pub(super) const CREDENTIALS: Table = Table {
    name: "credentials",
    columns: &["id", "owner", "role", "created_ns", "used_ns", "expires_ns", "ended_ns", "address"],
};

/// All tables.
pub(super) const TABLES: [&Table; 12] = [
    &EDITS,
    &DOCUMENTS,
    &DOCUMENT_REVISIONS,
    &RUNS,
    &STEPS,
    &RESULTS,
    &PICTURE_COMPARISONS,
    &MISSION_EVENTS,
    &FIRINGS,
    &AUDIT,
    &ACCOUNTS,
    &CREDENTIALS,
];

/// Checks that this is a ledger which this program can read or bring up to date.
pub(super) fn check_version(connection: &Connection) -> Result<(), Fault> {
    let application: i32 = connection.pragma_query_value(None, "application_id", |row| row.get(0))?;
    if application != APPLICATION_ID {
        return Err(Fault::Broken(crate::texts::NO_LEDGER));
    }
    version(connection).map(drop)
}

fn version(connection: &Connection) -> Result<usize, Fault> {
    let version: u32 = connection.pragma_query_value(None, "user_version", |row| row.get(0))?;
    if version as usize > MIGRATIONS.len() {
        return Err(Fault::LaterVersion(version));
    }
    Ok(version as usize)
}

/// The newest version of the schema that this program knows.
pub(super) fn newest_version() -> u32 {
    MIGRATIONS.len() as u32
}

/// Brings the tables up to date, each version in a transaction of its own.
pub(super) fn migrate(connection: &mut Connection) -> Result<(), Fault> {
    for next in version(connection)?..MIGRATIONS.len() {
        let transaction = connection.transaction()?;
        transaction.execute_batch(MIGRATIONS[next])?;
        transaction.pragma_update(None, "user_version", next as u32 + 1)?;
        transaction.pragma_update(None, "application_id", APPLICATION_ID)?;
        transaction.commit()?;
    }
    Ok(())
}
