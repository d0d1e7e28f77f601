//! Opens the ledger also where it is damaged: the file is kept under another name, and a new one begins with the documents that can still be read.

use super::documents::document;
use super::rows::{Fault, Table};
use super::schema::{ACCOUNTS, CREDENTIALS, DOCUMENT_REVISIONS, DOCUMENTS};
use super::{Ledger, open_for_reading};
use crate::{Store, StoreError, files, texts};
use api::SiteState;
use rusqlite::ErrorCode;
use rusqlite::types::Value;
use site_model::{Object, ObjectId, Revision};
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use vocab::Stamp;

/// Endings of the files that SQLite keeps beside a database.
const COMPANIONS: [&str; 2] = ["-wal", "-shm"];

/// The newest readable state of each object; without an object it was removed.
type Documents = BTreeMap<ObjectId, (Revision, Option<Object>)>;

impl Store {
    /// Opens the ledger, and returns it with the site. What is wrong is told by [`Store::take_problems`].
    ///
    /// # Errors
    /// When the disk fails, or a later program wrote the ledger. Nothing is changed then.
    pub fn open_ledger(&self) -> Result<(Ledger, SiteState), StoreError> {
        let path = self.dir().ledger();
        if !path.exists() {
            return self.begin_ledger(&path, None);
        }
        self.check_wal(&with_ending(&path, COMPANIONS[0]))?;
        match Ledger::open(&path) {
            Err(error) if is_damage(&error) => {
                put_aside(&path)?;
                self.begin_ledger(&path, Some(error))
            }
            opened => opened,
        }
    }

    /// Keeps a copy of a damaged write-ahead log, of which SQLite uses what comes before the damage.
    fn check_wal(&self, wal: &Path) -> Result<(), StoreError> {
        let Ok(bytes) = fs::read(wal) else { return Ok(()) };
        if super::wal::is_damaged(&bytes) {
            let aside = files::put_aside(wal)?;
            fs::write(wal, &bytes).map_err(|source| StoreError::io("write", wal, source))?;
            self.add_problem(texts::wal_damaged(wal, &aside));
        }
        Ok(())
    }

    /// Begins a ledger where there is none. If one was put aside, it begins with what can be read of that: also after a kill between the two steps.
    fn begin_ledger(
        &self,
        path: &Path,
        damage: Option<StoreError>,
    ) -> Result<(Ledger, SiteState), StoreError> {
        // SQLite would take these for those of the new file.
        let aside = files::last_put_aside(path);
        for ending in COMPANIONS {
            let companion = with_ending(path, ending);
            if companion.exists() {
                files::put_aside(&companion)?;
            }
        }
        let (mut ledger, state) = Ledger::open(path)?;
        let Some(aside) = aside else { return Ok((ledger, state)) };
        let documents = salvage(&aside);
        let accounts = salvage_accounts(&aside);
        ledger.write(|writer| {
            for (table, row) in &accounts {
                table.put(writer.transaction, row).map_err(|fault| writer.error(fault))?;
            }
            for (id, (revision, object)) in &documents {
                let written = writer.put_document(*id, *revision, object.as_ref(), Value::Null, Stamp::EPOCH);
                written.map_err(|fault| writer.error(fault))?;
            }
            let command = format!("recovery of {} objects", documents.len());
            writer.put_audit(None, &command, "done", Stamp::EPOCH).map_err(|fault| writer.error(fault))
        })?;
        self.add_problem(texts::ledger_begun_anew(path, damage.as_ref(), &aside, documents.len()));
        let state = ledger.site()?;
        Ok((ledger, state))
    }
}

/// Whether an error says that the file is damaged, and not that the disk fails or is full.
fn is_damage(error: &StoreError) -> bool {
    match error {
        StoreError::Ledger { .. } => true,
        StoreError::Database { source, .. } => !matches!(
            source.sqlite_error_code(),
            Some(
                ErrorCode::DiskFull
                    | ErrorCode::SystemIoFailure
                    | ErrorCode::CannotOpen
                    | ErrorCode::PermissionDenied
                    | ErrorCode::DatabaseBusy
                    | ErrorCode::DatabaseLocked
                    | ErrorCode::FileLockingProtocolFailed
                    | ErrorCode::OutOfMemory
            )
        ),
        _ => false,
    }
}

/// Gives a database and what belongs to it another name.
fn put_aside(path: &Path) -> Result<PathBuf, StoreError> {
    let aside = files::put_aside(path)?;
    for ending in COMPANIONS {
        let companion = with_ending(path, ending);
        if companion.exists() {
            let target = with_ending(&aside, ending);
            fs::rename(&companion, &target).map_err(|source| StoreError::io("rename", &companion, source))?;
        }
    }
    Ok(aside)
}

pub(super) fn with_ending(path: &Path, ending: &str) -> PathBuf {
    let mut name: OsString = path.as_os_str().to_owned();
    name.push(ending);
    name.into()
}

/// What can be read of the documents of a damaged database.
fn salvage(path: &Path) -> Documents {
    let mut found = Documents::new();
    if path.is_dir() {
        return found;
    }
    let Ok(connection) = open_for_reading(path) else { return found };
    for table in [&DOCUMENTS, &DOCUMENT_REVISIONS] {
        let read: Result<(), Fault> = table.for_each(&connection, "", [], |row| {
            let Some((id, revision, object)) = table.whole(&row).and_then(document) else { return Ok(()) };
            let known = found.get(&id).is_some_and(|(known, _)| *known >= revision);
            if !known {
                found.insert(id, (revision, object));
            }
            Ok(())
        });
        if read.is_err() {
            tracing::warn!("only a part of {} can be read", path.display());
        }
    }
    found
}

/// What can be read of the accounts of a damaged database, with the tables in which it belongs.
fn salvage_accounts(path: &Path) -> Vec<(&'static Table, Vec<Value>)> {
    let mut found = Vec::new();
    if path.is_dir() {
        return found;
    }
    let Ok(connection) = open_for_reading(path) else { return found };
    for table in [&ACCOUNTS, &CREDENTIALS] {
        // A ledger of an earlier program has no such table.
        let read = table.for_each(&connection, "", [], |row| {
            found.extend(table.whole(&row).map(|values| (table, values.to_vec())));
            Ok(())
        });
        if read.is_err() {
            tracing::warn!("the accounts in {} cannot all be read", path.display());
        }
    }
    found
}
