//! Accounts, sessions and tokens in the ledger.
//!
//! The ledger's thread writes them, and so does `autoinspect account` beside a running core. Whoever reads them has a connection of its own, which notices both.

use super::rows::{Fault, Table, integer, or_null, text};
use super::schema::{ACCOUNTS, CREDENTIALS};
use super::{LedgerWriter, error, open_for_reading};
use crate::StoreError;
use api::{CredentialId, Role};
use rusqlite::Connection;
use rusqlite::types::Value;
use std::collections::BTreeMap;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use vocab::Stamp;

/// An account.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredAccount {
    /// What it may do.
    pub role: Role,
    /// Its password, a PHC string.
    pub password: String,
    /// Whether it may sign in.
    pub is_enabled: bool,
    /// When it was made, by calendar time.
    pub created: Stamp,
    /// When it was changed last.
    pub changed: Stamp,
}

/// A session or a token.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredCredential {
    /// Of a session the account, of a token its name.
    pub owner: String,
    /// What a token may do; none: it is a session, and may do what its account may.
    pub token_role: Option<Role>,
    /// When it began, by calendar time.
    pub created: Stamp,
    /// When it was last used, to a few minutes.
    pub used: Stamp,
    /// When it ends at the latest.
    pub expires: Stamp,
    /// When somebody ended it.
    pub ended: Option<Stamp>,
    /// The address from which it began.
    pub address: Option<String>,
}

/// All accounts, sessions and tokens.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Accounts {
    /// Accounts by their names.
    pub accounts: BTreeMap<String, StoredAccount>,
    /// Sessions and tokens, those that have ended too.
    pub credentials: BTreeMap<CredentialId, StoredCredential>,
}

impl LedgerWriter<'_> {
    /// Writes an account in the place of the one with this name.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn put_account(&self, name: &str, account: &StoredAccount) -> Result<(), StoreError> {
        let values = [
            Value::from(name.to_owned()),
            Value::from(account.role.name().to_owned()),
            Value::from(account.password.clone()),
            Value::from(i64::from(account.is_enabled)),
            Value::from(account.created.nanos()),
            Value::from(account.changed.nanos()),
        ];
        ACCOUNTS.put(self.transaction, &values).map_err(|fault| self.error(fault))
    }

    /// Removes an account with its sessions.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn remove_account(&self, name: &str) -> Result<(), StoreError> {
        self.delete(&ACCOUNTS, "account = ?", name)?;
        self.delete(&CREDENTIALS, "role IS NULL AND owner = ?", name)
    }

    /// Writes a session or token in the place of the one with this id.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn put_credential(&self, id: CredentialId, credential: &StoredCredential) -> Result<(), StoreError> {
        let values = [
            Value::from(id.to_string()),
            Value::from(credential.owner.clone()),
            or_null(credential.token_role.map(|role| role.name().to_owned())),
            Value::from(credential.created.nanos()),
            Value::from(credential.used.nanos()),
            Value::from(credential.expires.nanos()),
            or_null(credential.ended.map(Stamp::nanos)),
            or_null(credential.address.clone()),
        ];
        CREDENTIALS.put(self.transaction, &values).map_err(|fault| self.error(fault))
    }

    /// Removes a session or token.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn remove_credential(&self, id: CredentialId) -> Result<(), StoreError> {
        self.delete(&CREDENTIALS, "id = ?", &id.to_string())
    }

    fn delete(&self, table: &Table, condition: &str, value: &str) -> Result<(), StoreError> {
        let sql = format!("DELETE FROM {} WHERE {condition}", table.name);
        let deleted = self.transaction.prepare_cached(&sql).and_then(|mut found| found.execute([value]));
        deleted.map(drop).map_err(|source| self.error(source.into()))
    }

    /// All accounts, sessions and tokens, as this transaction sees them.
    ///
    /// # Errors
    /// When they cannot be read.
    pub fn accounts(&self) -> Result<Accounts, StoreError> {
        read(self.transaction).map_err(|fault| self.error(fault))
    }
}

/// Reads accounts, and notices changes by whoever made them.
#[derive(Debug)]
pub struct AccountReader {
    path: PathBuf,
    open: Option<OpenDatabase>,
}

#[derive(Debug)]
struct OpenDatabase {
    connection: Connection,
    /// Inode of the file: a damaged ledger is renamed, and a new one begun.
    inode: u64,
    /// What SQLite called the state that was read last.
    version: Option<i64>,
}

impl AccountReader {
    /// Will read the ledger at `path`, which need not be there yet.
    pub fn new(path: &Path) -> Self {
        Self { path: path.to_owned(), open: None }
    }

    /// All accounts, sessions and tokens, if anything in the ledger has changed since the last call.
    ///
    /// # Errors
    /// When the ledger cannot be read.
    pub fn read_if_changed(&mut self) -> Result<Option<Accounts>, StoreError> {
        let result = self.try_read().map_err(|fault| error(&self.path, fault));
        if result.is_err() {
            self.open = None;
        }
        result
    }

    fn try_read(&mut self) -> Result<Option<Accounts>, Fault> {
        let inode = std::fs::metadata(&self.path).map(|about| about.ino()).ok();
        if self.open.as_ref().is_some_and(|open| Some(open.inode) != inode) {
            self.open = None;
        }
        let Some(inode) = inode else { return Ok(None) };
        let open = match &mut self.open {
            Some(open) => open,
            None => {
                let connection = open_for_reading(&self.path)?;
                self.open.insert(OpenDatabase { connection, inode, version: None })
            }
        };
        let version = open.connection.pragma_query_value(None, "data_version", |row| row.get(0))?;
        if open.version == Some(version) {
            return Ok(None);
        }
        let accounts = read(&open.connection)?;
        open.version = Some(version);
        Ok(Some(accounts))
    }
}

fn read(connection: &Connection) -> Result<Accounts, Fault> {
    let accounts = read_whole_rows(&ACCOUNTS, connection, account)?.into_iter().collect();
    let credentials = read_whole_rows(&CREDENTIALS, connection, credential)?.into_iter().collect();
    Ok(Accounts { accounts, credentials })
}

/// All rows without damage. A damaged session must not keep everybody else out; the check of stored data tells people of it.
fn read_whole_rows<T>(
    table: &Table,
    connection: &Connection,
    take: impl Fn(&[Value]) -> Option<T>,
) -> Result<Vec<T>, Fault> {
    let mut found = Vec::new();
    table.for_each(connection, "", [], |row| {
        match table.whole(&row).and_then(&take) {
            Some(read) => found.push(read),
            None => tracing::error!("a damaged row of {} is left out", table.name),
        }
        Ok(())
    })?;
    Ok(found)
}

fn account(row: &[Value]) -> Option<(String, StoredAccount)> {
    let stamp = |value: &Value| integer(value).map(Stamp::from_nanos);
    let account = StoredAccount {
        role: text(&row[1])?.parse().ok()?,
        password: text(&row[2])?.to_owned(),
        is_enabled: integer(&row[3])? != 0,
        created: stamp(&row[4])?,
        changed: stamp(&row[5])?,
    };
    Some((text(&row[0])?.to_owned(), account))
}

fn credential(row: &[Value]) -> Option<(CredentialId, StoredCredential)> {
    let stamp = |value: &Value| integer(value).map(Stamp::from_nanos);
    let token_role = match &row[2] {
        Value::Null => None,
        role => Some(text(role)?.parse().ok()?),
    };
    let credential = StoredCredential {
        owner: text(&row[1])?.to_owned(),
        token_role,
        created: stamp(&row[3])?,
        used: stamp(&row[4])?,
        expires: stamp(&row[5])?,
        ended: stamp(&row[6]),
        address: text(&row[7]).map(str::to_owned),
    };
    Some((text(&row[0])?.parse().ok()?, credential))
}
