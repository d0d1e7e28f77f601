//! Reads rosbag2's SQLite files as containers.

use super::{Container, MessageEncoding, MessageOrder, Messages, RawMessage, Topic, legible_name};
use crate::error::{OpenError, ReadError};
use formats::cdr::Encoding;
use formats::rosbag2::{Database, DatabaseMessage};
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vocab::Stamp;

/// A database with the list of its topics.
pub(crate) struct DatabaseFile {
    path: PathBuf,
    topics: Vec<Topic>,
    /// Id of each topic in the database.
    ids: Vec<i64>,
    span: Option<(Stamp, Stamp)>,
}

impl DatabaseFile {
    /// Opens a database.
    ///
    /// # Errors
    /// When it is not a readable rosbag2 database.
    pub fn open(path: &Path) -> Result<Self, OpenError> {
        let failed = |source| OpenError::Format { path: path.to_owned(), source };
        let database = Database::open(path).map_err(failed)?;
        let rows = database.topics().map_err(failed)?;
        let span = database.span().map_err(failed)?;
        let ids = rows.iter().map(|row| row.id).collect();
        let topics = rows.into_iter().map(|row| Topic {
            name: legible_name(&row.name),
            type_name: legible_name(&formats::ros::plain_type_name(&row.type_name)),
            encoding: match row.serialization.as_str() {
                "cdr" => MessageEncoding::Ros(Encoding::Cdr),
                other => MessageEncoding::Other(other.to_owned()),
            },
            count: row.count,
        });
        Ok(Self { path: path.to_owned(), topics: topics.collect(), ids, span })
    }
}

impl Container for DatabaseFile {
    fn topics(&self) -> &[Topic] {
        &self.topics
    }

    fn span(&self) -> Option<(Stamp, Stamp)> {
        self.span
    }

    fn warnings(&self) -> &[String] {
        &[]
    }

    /// Both orders are by time, because rosbag2 guarantees no file order.
    fn messages(&self, wanted: &[bool], _order: MessageOrder) -> Messages {
        let is_wanted = |(topic, id): (usize, &i64)| wanted[topic].then_some((topic, *id));
        let topics: Vec<(usize, i64)> = self.ids.iter().enumerate().filter_map(is_wanted).collect();
        if topics.is_empty() {
            return Box::new(std::iter::empty());
        }
        match Database::open(&self.path) {
            Ok(database) => Box::new(DatabaseRows {
                database,
                path: self.path.clone(),
                topics,
                batch: VecDeque::new(),
                last: (Stamp::from_nanos(i64::MIN), i64::MIN),
                ended: false,
            }),
            Err(source) => {
                Box::new(std::iter::once(Err(ReadError::Format { path: self.path.clone(), source })))
            }
        }
    }
}

/// Messages by time, read in batches of rows.
struct DatabaseRows {
    database: Database,
    path: PathBuf,
    /// Index and database id of the wanted topics.
    topics: Vec<(usize, i64)>,
    batch: VecDeque<DatabaseMessage>,
    last: (Stamp, i64),
    ended: bool,
}

impl Iterator for DatabaseRows {
    type Item = Result<RawMessage, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.batch.is_empty() && !self.ended {
            let ids: Vec<i64> = self.topics.iter().map(|(_, id)| *id).collect();
            match self.database.messages_after(&ids, self.last) {
                Ok(batch) => self.batch = batch.into(),
                Err(source) => {
                    self.ended = true;
                    return Some(Err(ReadError::Format { path: self.path.clone(), source }));
                }
            }
            self.ended = self.batch.is_empty();
        }
        let message = self.batch.pop_front()?;
        self.last = (message.at, message.row);
        let (topic, _) = self.topics.iter().find(|(_, id)| *id == message.topic)?;
        let range = 0..message.data.len();
        Some(Ok(RawMessage::new(*topic, message.at, Arc::new(message.data), range)))
    }
}
