//! rosbag2: folders with a `metadata.yaml`, and the SQLite files in them.

use crate::{FormatError, texts};
use rusqlite::{Connection, OpenFlags, params};
use std::path::Path;
use vocab::Stamp;

/// One topic of a database.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DatabaseTopic {
    /// Its number in the database.
    pub id: i64,
    /// Its name.
    pub name: String,
    /// ROS type, e.g. `sensor_msgs/msg/Imu`.
    pub type_name: String,
    /// Encoding of its messages; only `cdr` is read.
    pub serialization: String,
    /// Messages.
    pub count: u64,
}

/// One message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DatabaseMessage {
    /// Number of the row.
    pub row: i64,
    /// Number of its topic.
    pub topic: i64,
    /// When it was recorded.
    pub at: Stamp,
    /// Its bytes.
    pub data: Vec<u8>,
}

/// Messages that one query reads, at most.
pub const BATCH_MESSAGES: usize = 32;

/// A rosbag2 database, opened for reading.
pub struct Database {
    connection: Connection,
}

/// Whether a file that starts with these bytes is an SQLite database.
pub fn is_database(start: &[u8]) -> bool {
    start.starts_with(b"SQLite format 3\0")
}

impl Database {
    /// Opens a `.db3` file without changing it.
    ///
    /// # Errors
    /// When it is not a database with rosbag2's tables.
    pub fn open(path: &Path) -> Result<Self, FormatError> {
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let connection = Connection::open_with_flags(path, flags)?;
        let tables: i64 = connection.query_row(
            "SELECT COUNT(*) FROM sqlite_master WHERE type = 'table' AND name IN ('topics', 'messages')",
            [],
            |row| row.get(0),
        )?;
        if tables != 2 {
            return Err(FormatError::WrongKind {
                expected: texts::ROS2_BAG,
                found: texts::NO_ROSBAG2_TABLES.into(),
            });
        }
        Ok(Self { connection })
    }

    /// Its topics with their number of messages, by id.
    ///
    /// # Errors
    /// When the database is damaged.
    pub fn topics(&self) -> Result<Vec<DatabaseTopic>, FormatError> {
        let mut statement = self.connection.prepare(
            "SELECT id, name, type, serialization_format, \
             (SELECT COUNT(*) FROM messages WHERE topic_id = topics.id) FROM topics ORDER BY id",
        )?;
        let rows = statement.query_map([], |row| {
            Ok(DatabaseTopic {
                id: row.get(0)?,
                name: row.get(1)?,
                type_name: row.get(2)?,
                serialization: row.get(3)?,
                count: row.get::<_, i64>(4)?.max(0) as u64,
            })
        })?;
        Ok(rows.collect::<Result<_, _>>()?)
    }

    /// When the first and the last message were recorded.
    ///
    /// # Errors
    /// When the database is damaged.
    pub fn span(&self) -> Result<Option<(Stamp, Stamp)>, FormatError> {
        let (first, last): (Option<i64>, Option<i64>) =
            self.connection.query_row("SELECT MIN(timestamp), MAX(timestamp) FROM messages", [], |row| {
                Ok((row.get(0)?, row.get(1)?))
            })?;
        Ok(first.zip(last).map(|(first, last)| (Stamp::from_nanos(first), Stamp::from_nanos(last))))
    }

    /// The next messages of some topics after this time and row, ordered by time and row. At most [`BATCH_MESSAGES`] at a time, because a message
    /// can have megabytes.
    ///
    /// # Errors
    /// When the database is damaged.
    pub fn messages_after(
        &self,
        topics: &[i64],
        (at, row): (Stamp, i64),
    ) -> Result<Vec<DatabaseMessage>, FormatError> {
        let numbers: Vec<String> = topics.iter().map(i64::to_string).collect();
        let mut statement = self.connection.prepare_cached(&format!(
            "SELECT id, topic_id, timestamp, data FROM messages WHERE topic_id IN ({}) \
             AND (timestamp, id) > (?1, ?2) ORDER BY timestamp, id LIMIT {BATCH_MESSAGES}",
            numbers.join(",")
        ))?;
        let rows = statement.query_map(params![at.nanos(), row], |row| {
            Ok(DatabaseMessage {
                row: row.get(0)?,
                topic: row.get(1)?,
                at: Stamp::from_nanos(row.get(2)?),
                data: row.get(3)?,
            })
        })?;
        Ok(rows.collect::<Result<_, _>>()?)
    }
}

/// The list of files in a `metadata.yaml`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BagMetadata {
    /// Names of the data files, in order.
    pub files: Vec<String>,
    /// Compression of files or messages by rosbag2: empty, or for example `zstd`.
    pub compression: String,
}

/// Reads the two entries of a `metadata.yaml` that are needed to find the data. It is written by programs, in one
/// layout, so its lines are read and no YAML in general.
pub fn read_metadata(text: &str) -> BagMetadata {
    let mut metadata = BagMetadata::default();
    let mut in_files = false;
    for line in text.lines().map(str::trim) {
        if let Some(item) = line.strip_prefix("- ").filter(|_| in_files) {
            metadata.files.push(unquoted(item).to_owned());
            continue;
        }
        in_files = line == "relative_file_paths:";
        if let Some(value) = line.strip_prefix("compression_format:") {
            metadata.compression = unquoted(value.trim()).to_owned();
        }
    }
    metadata
}

fn unquoted(text: &str) -> &str {
    text.trim_matches(['"', '\''])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metadata_names_files_in_order() {
        let text = "rosbag2_bagfile_information:\n  relative_file_paths:\n    - a_0.db3\n    - \"a_1.db3\"\n  \
                    duration:\n    nanoseconds: 1\n  compression_format: ''\n  topics:\n    - other\n";
        let metadata = read_metadata(text);
        assert_eq!(metadata.files, ["a_0.db3", "a_1.db3"]);
        assert_eq!(metadata.compression, "");
        assert_eq!(read_metadata("compression_format: zstd").compression, "zstd");
    }

    #[test]
    fn messages_come_by_time_and_a_cut_database_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bag.db3");
        let connection = Connection::open(&path).unwrap();
        connection
            .execute_batch(
                "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);
                 CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);
                 INSERT INTO topics VALUES (1, '/a', 'x/msg/A', 'cdr'), (2, '/b', 'x/msg/B', 'cdr');",
            )
            .unwrap();
        for (row, time) in (0..100).map(|i| (i, 1000 - i / 2)) {
            connection
                .execute("INSERT INTO messages VALUES (?1, ?2, ?3, x'01')", params![row, 1 + row % 2, time])
                .unwrap();
        }
        drop(connection);
        let database = Database::open(&path).unwrap();
        assert_eq!(database.topics().unwrap()[1].count, 50);
        let (mut last, mut count) = ((Stamp::from_nanos(i64::MIN), i64::MIN), 0);
        loop {
            let batch = database.messages_after(&[2], last).unwrap();
            let Some(end) = batch.last() else { break };
            assert!(batch.is_sorted_by_key(|message| (message.at, message.row)));
            last = (end.at, end.row);
            count += batch.len();
        }
        assert_eq!(count, 50);

        let bytes = std::fs::read(&path).unwrap();
        for cut in (0..bytes.len()).step_by(97) {
            std::fs::write(&path, &bytes[..cut]).unwrap();
            let read = Database::open(&path).and_then(|database| {
                database.topics()?;
                database.messages_after(&[1, 2], (Stamp::EPOCH, 0))
            });
            if let Ok(messages) = read {
                assert!(messages.len() <= 100);
            }
        }
    }
}
