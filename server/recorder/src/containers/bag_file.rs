//! Reads ROS 1 bags as containers.

use super::merge::{BlockSource, MergedMessages};
use super::{Container, MessageEncoding, MessageOrder, Messages, RawMessage, Topic, legible_name};
use crate::error::{OpenError, ReadError};
use formats::FormatError;
use formats::cdr::Encoding;
use formats::rosbag1::{self, BagIndex};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vocab::Stamp;

/// A ROS 1 bag with the index of its chunks.
pub(crate) struct BagFile {
    contents: Arc<Contents>,
}

struct Contents {
    path: PathBuf,
    index: BagIndex,
    topics: Vec<Topic>,
    /// Topic of each connection.
    connections: BTreeMap<u32, usize>,
}

impl BagFile {
    /// Opens a bag.
    ///
    /// # Errors
    /// When it cannot be read or is not a bag of version 2.0.
    pub fn open(path: &Path) -> Result<Self, OpenError> {
        let file = File::open(path).map_err(|source| OpenError::Io { path: path.to_owned(), source })?;
        let index = rosbag1::read_index(&mut BufReader::new(file))
            .map_err(|source| OpenError::Format { path: path.to_owned(), source })?;
        let mut topics: Vec<Topic> = Vec::new();
        let mut connections = BTreeMap::new();
        for (number, connection) in &index.connections {
            let (name, type_name) = (legible_name(&connection.topic), legible_name(&connection.type_name));
            let same = |topic: &Topic| topic.name == name && topic.type_name == type_name;
            let position = topics.iter().position(same).unwrap_or_else(|| {
                topics.push(Topic {
                    name: name.clone(),
                    type_name: type_name.clone(),
                    encoding: MessageEncoding::Ros(Encoding::Ros1),
                    count: 0,
                });
                topics.len() - 1
            });
            let counts = index.chunks.iter().filter_map(|chunk| chunk.counts.get(number));
            topics[position].count += counts.sum::<u64>();
            connections.insert(*number, position);
        }
        Ok(Self { contents: Arc::new(Contents { path: path.to_owned(), index, topics, connections }) })
    }
}

impl Container for BagFile {
    fn topics(&self) -> &[Topic] {
        &self.contents.topics
    }

    fn span(&self) -> Option<(Stamp, Stamp)> {
        let chunks = &self.contents.index.chunks;
        let first = chunks.iter().map(|chunk| chunk.span.0).min()?;
        let last = chunks.iter().map(|chunk| chunk.span.1).max()?;
        Some((first, last))
    }

    fn warnings(&self) -> &[String] {
        &self.contents.index.warnings
    }

    fn messages(&self, wanted: &[bool], order: MessageOrder) -> Messages {
        match ChunkReader::open(self.contents.clone(), wanted.to_vec(), order) {
            Ok(reader) => Box::new(MergedMessages::new(reader, order)),
            Err(error) => Box::new(std::iter::once(Err(error))),
        }
    }
}

/// Reads the wanted messages chunk by chunk.
struct ChunkReader {
    file: File,
    contents: Arc<Contents>,
    wanted: Vec<bool>,
    /// Numbers of the chunks to read, last first.
    queue: Vec<usize>,
}

impl ChunkReader {
    fn open(contents: Arc<Contents>, wanted: Vec<bool>, order: MessageOrder) -> Result<Self, ReadError> {
        let file = File::open(&contents.path)
            .map_err(|source| ReadError::Io { path: contents.path.clone(), source })?;
        let chunks = &contents.index.chunks;
        let is_wanted =
            |connection: &u32| contents.connections.get(connection).is_some_and(|topic| wanted[*topic]);
        let mut queue: Vec<usize> =
            (0..chunks.len()).filter(|number| chunks[*number].counts.keys().any(is_wanted)).collect();
        if order == MessageOrder::LogTime {
            queue.sort_by_key(|number| (chunks[*number].span.0, *number));
        }
        queue.reverse();
        Ok(Self { file, contents, wanted, queue })
    }
}

impl BlockSource for ChunkReader {
    fn next_start(&self) -> Option<Stamp> {
        self.queue.last().map(|number| self.contents.index.chunks[*number].span.0)
    }

    fn load_next(&mut self, messages: &mut Vec<(u64, RawMessage)>) -> Result<(), ReadError> {
        let Some(number) = self.queue.pop() else { return Ok(()) };
        let position = self.contents.index.chunks[number].position;
        let path = || self.contents.path.clone();
        let chunk = rosbag1::read_chunk(&mut self.file, position)
            .map_err(|source: FormatError| ReadError::Format { path: path(), source })?;
        let bytes = Arc::new(chunk.bytes);
        for message in chunk.messages {
            let topic = self.contents.connections.get(&message.connection);
            if let Some(topic) = topic.filter(|topic| self.wanted[**topic]) {
                let place = ((number as u64) << 32) | messages.len() as u64;
                messages.push((place, RawMessage::new(*topic, message.at, bytes.clone(), message.range)));
            }
        }
        let damaged = |problem| ReadError::Damaged { path: path(), at: position, problem };
        chunk.warning.map_or(Ok(()), |problem| Err(damaged(problem)))
    }
}
