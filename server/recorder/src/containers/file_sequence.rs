//! Several files that follow each other in time, as one container.

use super::{Container, Messages, Order, Topic};
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

    fn messages(&self, wanted: &[bool], order: Order) -> Messages {
        let parts: Vec<_> = self
            .parts
            .iter()
            .map(|part| {
                let wanted: Vec<bool> = part.topics.iter().map(|topic| wanted[*topic]).collect();
                (part.container.clone(), part.topics.clone(), wanted)
            })
            .collect();
        // A file is opened when the previous one has ended.
        Box::new(parts.into_iter().flat_map(move |(container, topics, wanted)| {
            container.messages(&wanted, order).map(move |raw| {
                raw.map(|mut raw| {
                    raw.topic = topics[raw.topic];
                    raw
                })
            })
        }))
    }
}
