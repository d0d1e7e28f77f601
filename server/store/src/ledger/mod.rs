//! The ledger: what people have made of the site, what the robot did and who asked for it, in one SQLite database with one writer.
//!
//! A transaction is on the disk when [`Ledger::write`] returns (WAL, `synchronous=FULL`). Rows are added or replaced by newer ones; none is deleted but those of accounts
//! that were removed, of sessions that ended long ago, and the oldest of the audit log ([`Ledger::keep_audit_entries`]). A damaged
//! database is put aside under another name and a new one is begun with what can still be read of its documents, see `recovery.rs`.

mod accounts;
mod audit;
mod check;
mod documents;
#[cfg(test)]
mod history_tests;
mod recovery;
mod rows;
mod runs;
mod schema;
#[cfg(test)]
mod tests;
mod wal;

pub use accounts::{AccountReader, Accounts, StoredAccount, StoredCredential};
pub use audit::AuditEntry;
pub use check::{VerifiedAudit, verify_ledger};
pub use documents::EditRecord;
pub use runs::UnfinishedRun;

use crate::{StoreError, files, texts};
use api::SiteState;
use rows::Fault;
use rusqlite::{Connection, OpenFlags, Transaction, TransactionBehavior};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Parameters of the database.
#[derive(Clone, Copy, Debug)]
struct DatabaseConfig {
    /// Longest wait for the check of stored data, which only reads. Chosen: the check reads for far less at a time.
    busy_timeout: Duration,
    /// Statements that stay prepared. Chosen as a round number: with fewer, statements that recur are parsed again.
    cached_statements: usize,
    /// Length of the write-ahead log from which on it is moved into the database, bytes. SQLite's own default, a thousand pages.
    max_log_bytes: u64,
}

const CONFIG: DatabaseConfig =
    DatabaseConfig { busy_timeout: Duration::from_secs(5), cached_statements: 64, max_log_bytes: 4 << 20 };

/// The open database. It has one writer, whoever owns this.
#[derive(Debug)]
pub struct Ledger {
    connection: Connection,
    path: PathBuf,
    /// Entries of the audit log that are kept; `None`: all.
    max_audit_entries: Option<u64>,
}

/// A transaction of the ledger.
#[derive(Debug)]
pub struct LedgerWriter<'a> {
    transaction: &'a Transaction<'a>,
    path: &'a Path,
    max_audit_entries: Option<u64>,
}

impl Ledger {
    /// Opens a database that exists, or makes one. Returns it with the site. A damaged one is left as it is.
    fn open(path: &Path) -> Result<(Self, SiteState), StoreError> {
        let opened = match fs::symlink_metadata(path) {
            Err(_) => {
                create(path)?;
                Self::open_existing(path)
            }
            Ok(about) if about.is_dir() => Err(Fault::Broken(texts::LEDGER_IS_DIRECTORY)),
            Ok(about) if about.len() == 0 => Err(Fault::Broken(texts::LEDGER_IS_EMPTY)),
            Ok(_) => Self::open_existing(path),
        };
        opened.map_err(|fault| error(path, fault))
    }

    fn open_existing(path: &Path) -> Result<(Self, SiteState), Fault> {
        roll_back(path)?;
        // Read first, so that nothing is written to a damaged file.
        check::check_structure(&open_for_reading(path)?, check::Depth::Quick)?;
        let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let mut connection = Connection::open_with_flags(path, flags)?;
        connection.busy_timeout(CONFIG.busy_timeout)?;
        connection.set_prepared_statement_cache_capacity(CONFIG.cached_statements);
        connection.pragma_update(None, "journal_mode", "WAL")?;
        connection.pragma_update(None, "synchronous", "FULL")?;
        // See `begin_log_anew`.
        connection.pragma_update(None, "wal_autocheckpoint", 0)?;
        schema::migrate(&mut connection)?;
        let state = documents::read_site(&connection)?;
        let ledger = Self { connection, path: path.to_owned(), max_audit_entries: None };
        ledger.begin_log_anew(0);
        Ok((ledger, state))
    }

    /// Opens the ledger of a data directory that a core may be using, or makes one. Nothing is repaired: that is the core's to do.
    ///
    /// # Errors
    /// When it cannot be opened.
    pub fn open_beside_core(path: &Path) -> Result<Self, StoreError> {
        Ok(Self::open(path)?.0)
    }

    /// Keeps this number of entries of the audit log from now on, and about a hundredth more. Older ones are removed, and an entry says so. A ledger that was opened keeps all.
    pub fn keep_audit_entries(&mut self, most: u64) {
        self.max_audit_entries = Some(most);
    }

    /// Writes what `write` does in one transaction, which is on the disk when this returns. Nothing of it is written if it fails.
    ///
    /// # Errors
    /// When the disk fails, or with the error of `write`.
    pub fn write<T>(
        &mut self,
        write: impl FnOnce(&LedgerWriter<'_>) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        let path = &self.path;
        let failed = |source: rusqlite::Error| error(path, source.into());
        let transaction =
            self.connection.transaction_with_behavior(TransactionBehavior::Immediate).map_err(failed)?;
        let max_audit_entries = self.max_audit_entries;
        let done = write(&LedgerWriter { transaction: &transaction, path, max_audit_entries })?;
        transaction.commit().map_err(failed)?;
        self.begin_log_anew(CONFIG.max_log_bytes);
        Ok(done)
    }

    /// Moves the write-ahead log into the database if it is longer than this, and cuts it to nothing. By itself SQLite would write over the beginning of a log that it has moved.
    /// A frame that a kill cuts short would then have old bytes after it, and would look like one with a wrong bit; at the end of a file it looks cut.
    ///
    /// While somebody reads the database, that is tried again after the next transaction: nobody waits for a reader.
    fn begin_log_anew(&self, max_bytes: u64) {
        let log = recovery::with_ending(&self.path, "-wal");
        if fs::metadata(log).is_ok_and(|about| about.len() > max_bytes) {
            let moved = self
                .connection
                .busy_timeout(Duration::ZERO)
                .and_then(|()| self.connection.query_row("PRAGMA wal_checkpoint(TRUNCATE)", [], |_| Ok(())));
            let restored = self.connection.busy_timeout(CONFIG.busy_timeout);
            if let Err(error) = moved.and(restored) {
                // What is committed stays in the log.
                tracing::warn!("{}: the write-ahead log was not moved: {error}", self.path.display());
            }
        }
    }

    /// The site as it is stored.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn site(&self) -> Result<SiteState, StoreError> {
        documents::read_site(&self.connection).map_err(|fault| self.error(fault))
    }

    fn error(&self, fault: Fault) -> StoreError {
        error(&self.path, fault)
    }
}

impl LedgerWriter<'_> {
    fn error(&self, fault: Fault) -> StoreError {
        error(self.path, fault)
    }
}

fn error(path: &Path, fault: Fault) -> StoreError {
    let path = path.to_owned();
    match fault {
        Fault::Database(source) => StoreError::Database { path, source },
        Fault::LaterVersion(version) => {
            StoreError::LaterVersion { path, version, newest: schema::newest_version() }
        }
        Fault::Broken(what) => StoreError::Ledger { path, what },
        Fault::NotUnderstood => StoreError::LedgerRow { path },
    }
}

/// Lets SQLite undo the transaction of a program that was killed before the ledger had a write-ahead log. Until then nobody can open it for reading.
fn roll_back(path: &Path) -> Result<(), Fault> {
    if recovery::with_ending(path, "-journal").exists() {
        let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let connection = Connection::open_with_flags(path, flags)?;
        connection.busy_timeout(CONFIG.busy_timeout)?;
        connection.query_row("SELECT count(*) FROM sqlite_schema", [], |_| Ok(()))?;
    }
    Ok(())
}

fn open_for_reading(path: &Path) -> Result<Connection, Fault> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let connection = Connection::open_with_flags(path, flags)?;
    connection.busy_timeout(CONFIG.busy_timeout)?;
    Ok(connection)
}

/// Makes an empty ledger under another name first, so that a file with the final name is never incomplete.
fn create(path: &Path) -> Result<(), StoreError> {
    let temporary = files::temporary_path(path);
    for ending in ["", "-wal", "-shm"] {
        files::remove_file(&recovery::with_ending(&temporary, ending))?;
    }
    let make = || {
        let mut connection = Connection::open(&temporary)?;
        // Nobody else sees this file, so a crash needs no rollback.
        connection.pragma_update(None, "journal_mode", "MEMORY")?;
        schema::migrate(&mut connection)?;
        // Here, because a kill while a ledger in use gets its write-ahead log leaves a journal beside it.
        connection.pragma_update(None, "journal_mode", "WAL")?;
        connection.close().map_err(|(_, source)| source)?;
        Ok(())
    };
    make().map_err(|fault| error(&temporary, fault))?;
    files::sync_file(&temporary)?;
    fs::rename(&temporary, path).map_err(|source| StoreError::io("write", path, source))?;
    path.parent().map_or(Ok(()), files::sync_directory)
}
