//! Rows with checksums. SQLite notices damage to its own structure, but not a wrong bit in a value; so the last column of every table is the BLAKE3 of the others.

use rusqlite::types::Value;
use rusqlite::{Connection, Params, params_from_iter};

/// A table, without its last column.
#[derive(Debug)]
pub(super) struct Table {
    pub(super) name: &'static str,
    pub(super) columns: &'static [&'static str],
}

/// Why the database cannot be used.
#[derive(Debug)]
pub(super) enum Fault {
    /// SQLite reports an error.
    Database(rusqlite::Error),
    /// A later program wrote it.
    LaterVersion(u32),
    /// It is damaged: the middle of a sentence.
    Broken(&'static str),
    /// A row without damage has values that mean nothing to this program.
    NotUnderstood,
}

impl From<rusqlite::Error> for Fault {
    fn from(error: rusqlite::Error) -> Self {
        Self::Database(error)
    }
}

/// A row as it was read.
pub(super) struct LedgerRow {
    values: Vec<Value>,
    checksum: Value,
}

impl Table {
    /// Writes a row in the place of that with the same key.
    pub(super) fn put(&self, connection: &Connection, values: &[Value]) -> Result<(), Fault> {
        self.write("REPLACE", connection, values).map(drop)
    }

    /// Writes a row unless there is one with the same key. Returns whether it was written.
    pub(super) fn put_new(&self, connection: &Connection, values: &[Value]) -> Result<bool, Fault> {
        Ok(self.write("IGNORE", connection, values)? > 0)
    }

    fn write(&self, otherwise: &str, connection: &Connection, values: &[Value]) -> Result<usize, Fault> {
        let places = vec!["?"; values.len() + 1].join(", ");
        let sql = format!(
            "INSERT OR {otherwise} INTO {} ({}, checksum) VALUES ({places})",
            self.name,
            self.columns.join(", ")
        );
        let checksum = self.checksum(values);
        let row = values.iter().chain([&checksum]);
        Ok(connection.prepare_cached(&sql)?.execute(params_from_iter(row))?)
    }

    /// Reads rows; `rest` is what follows the name of the table. `take` gets each whole row. Fails at the first damaged one.
    pub(super) fn read<T>(
        &self,
        connection: &Connection,
        rest: &str,
        parameters: impl Params,
        mut take: impl FnMut(&[Value]) -> Option<T>,
    ) -> Result<Vec<T>, Fault> {
        let mut found = Vec::new();
        self.for_each(connection, rest, parameters, |row| {
            let values = self.whole(&row).ok_or(Fault::Broken(DAMAGED_ROW))?;
            found.push(take(values).ok_or(Fault::NotUnderstood)?);
            Ok(())
        })?;
        Ok(found)
    }

    /// Hands every row to `take`, damaged ones too. Fails where SQLite does.
    pub(super) fn for_each(
        &self,
        connection: &Connection,
        rest: &str,
        parameters: impl Params,
        mut take: impl FnMut(LedgerRow) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let sql = format!("SELECT {}, checksum FROM {} {rest}", self.columns.join(", "), self.name);
        let mut statement = connection.prepare_cached(&sql)?;
        let mut rows = statement.query(parameters)?;
        while let Some(row) = rows.next()? {
            let values = (0..self.columns.len()).map(|column| row.get(column));
            let values = values.collect::<rusqlite::Result<Vec<Value>>>()?;
            take(LedgerRow { values, checksum: row.get(self.columns.len())? })?;
        }
        Ok(())
    }

    /// The values of a row without damage.
    pub(super) fn whole<'r>(&self, row: &'r LedgerRow) -> Option<&'r [Value]> {
        (self.checksum(&row.values) == row.checksum).then_some(&row.values)
    }

    /// The last column of a row with these values.
    pub(super) fn checksum(&self, values: &[Value]) -> Value {
        let mut hasher = blake3::Hasher::new();
        let mut add = |kind: u8, bytes: &[u8]| {
            hasher.update(&[kind]);
            hasher.update(&(bytes.len() as u64).to_le_bytes());
            hasher.update(bytes);
        };
        add(0, self.name.as_bytes());
        for value in values {
            match value {
                Value::Null => add(1, &[]),
                Value::Integer(number) => add(2, &number.to_le_bytes()),
                Value::Real(number) => add(3, &number.to_le_bytes()),
                Value::Text(text) => add(4, text.as_bytes()),
                Value::Blob(bytes) => add(5, bytes),
            }
        }
        Value::Blob(hasher.finalize().as_bytes().to_vec())
    }
}

/// A row that does not match its checksum.
pub(super) const DAMAGED_ROW: &str = crate::texts::DAMAGED_ROW;

/// Text of a value.
pub(super) fn text(value: &Value) -> Option<&str> {
    match value {
        Value::Text(text) => Some(text),
        _ => None,
    }
}

/// Whole number of a value.
pub(super) fn integer(value: &Value) -> Option<i64> {
    match value {
        Value::Integer(number) => Some(*number),
        _ => None,
    }
}

/// A value that may be missing.
pub(super) fn or_null<T>(value: Option<T>) -> Value
where
    Value: From<T>,
{
    value.map_or(Value::Null, Value::from)
}
