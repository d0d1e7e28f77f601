//! Several files that follow each other in time, as one container.

use super::{Container, MessageOrder, Messages, Topic};
use crate::error::ReadError;
use crate::writer::{CONTINUES_KEY, RUN_KEY, SEGMENT_KEY};
use std::sync::Arc;
use vocab::Stamp;

/// Files of one recording, in order.
pub(crate) struct FileSequence {
    parts: Vec<Part>,
    topics: Vec<Topic>,
    warnings: Vec<String>,
}

struct Part {
    container: Arc<dyn Container>,
    /// For each of the part's topics, its index in the sequence.
    topics: Vec<usize>,
}

impl FileSequence {
    /// Joins files. Topics with the same name, type and encoding become one topic.
    pub fn new(containers: Vec<Arc<dyn Container>>, mut warnings: Vec<String>) -> Self {
        let mut topics: Vec<Topic> = Vec::new();
        let mut parts = Vec::with_capacity(containers.len());
        for container in containers {
            let mut indices = Vec::new();
            for topic in container.topics() {
                let same = |other: &Topic| {
                    other.name == topic.name
                        && other.type_name == topic.type_name
                        && other.encoding == topic.encoding
                };
                match topics.iter().position(same) {
                    Some(index) => {
                        topics[index].count += topic.count;
                        indices.push(index);
                    }
                    None => {
                        indices.push(topics.len());
                        topics.push(topic.clone());
                    }
                }
            }
            warnings.extend_from_slice(container.warnings());
            parts.push(Part { container, topics: indices });
        }
        let gaps = parts.windows(2).filter_map(|pair| gap_between(&*pair[0].container, &*pair[1].container));
        warnings.extend(gaps.map(|gap| gap.to_string()));
        Self { parts, topics, warnings }
    }
}

impl Container for FileSequence {
    fn topics(&self) -> &[Topic] {
        &self.topics
    }

    fn span(&self) -> Option<(Stamp, Stamp)> {
        let spans = || self.parts.iter().filter_map(|part| part.container.span());
        let first = spans().map(|(first, _)| first).min()?;
        let last = spans().map(|(_, last)| last).max()?;
        Some((first, last))
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }

    fn metadata(&self, key: &str) -> Option<&str> {
        self.parts.iter().find_map(|part| part.container.metadata(key))
    }

    fn messages(&self, wanted: &[bool], order: MessageOrder) -> Messages {
        let parts: Vec<_> = self
            .parts
            .iter()
            .map(|part| {
                let wanted: Vec<bool> = part.topics.iter().map(|topic| wanted[*topic]).collect();
                (part.container.clone(), part.topics.clone(), wanted)
            })
            .collect();
        // A journal needs every input.
        let mut previous: Option<Arc<dyn Container>> = None;
        // A file is opened when the previous one has ended.
        Box::new(parts.into_iter().flat_map(move |(container, topics, wanted)| {
            let gap =
                previous.replace(container.clone()).and_then(|previous| gap_between(&*previous, &*container));
            let gap = gap.filter(|_| order == MessageOrder::File).map(Err);
            let messages = container.messages(&wanted, order).map(move |raw| {
                raw.map(|mut raw| {
                    raw.topic = topics[raw.topic];
                    raw
                })
            });
            gap.into_iter().chain(messages)
        }))
    }
}

/// An error if a segment is not the continuation of the previous one.
fn gap_between(previous: &dyn Container, next: &dyn Container) -> Option<ReadError> {
    let run = next.metadata(RUN_KEY)?;
    let number = |container: &dyn Container| container.metadata(SEGMENT_KEY)?.parse::<u32>().ok();
    let follows = previous.metadata(RUN_KEY) == Some(run)
        && number(previous)
            .zip(number(next))
            .is_some_and(|(previous, next)| previous.checked_add(1) == Some(next))
        && next.metadata(CONTINUES_KEY) == Some("true");
    let segment = next.metadata(SEGMENT_KEY).unwrap_or_default();
    (!follows)
        .then(|| ReadError::MissingInputs { run: run.to_owned(), segment: format!("segment {segment}") })
}
