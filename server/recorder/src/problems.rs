//! Errors grouped by kind and topic: a topic with ten thousand bad messages is one problem, not ten thousand.

use crate::error::ReadError;
use std::collections::BTreeMap;
use std::mem::{Discriminant, discriminant};

/// Errors of reading a recording, grouped by kind and topic in the order of first appearance.
#[derive(Debug, Default)]
pub struct ReadProblems {
    /// The first sentence of each group, and the number of further errors.
    groups: Vec<(String, u64)>,
    groups_of_topics: BTreeMap<String, Vec<(Discriminant<ReadError>, usize)>>,
}

impl ReadProblems {
    /// Adds an error.
    pub fn add(&mut self, error: &ReadError) {
        let kind = discriminant(error);
        let of_topic = self.groups_of_topics.entry(topic(error).to_owned()).or_default();
        match of_topic.iter().find(|(other, _)| *other == kind) {
            Some((_, index)) => self.groups[*index].1 += 1,
            None => {
                of_topic.push((kind, self.groups.len()));
                self.groups.push((error.to_string(), 0));
            }
        }
    }

    /// Whether there were no errors.
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    /// One sentence for each group: its first error and the number of further errors.
    pub fn sentences(&self) -> Vec<String> {
        let sentence = |(first, more): &(String, u64)| match more {
            0 => first.clone(),
            _ => format!("{first} (and {more} more like it)"),
        };
        self.groups.iter().map(sentence).collect()
    }
}

/// The error's topic; empty without one, so that such errors form one group for each kind.
fn topic(error: &ReadError) -> &str {
    match error {
        ReadError::Message { topic, .. }
        | ReadError::Backward { topic, .. }
        | ReadError::EmptyScan { topic, .. } => topic,
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vocab::Stamp;

    #[test]
    fn errors_of_one_kind_and_topic_are_counted_and_others_are_listed() {
        let mut problems = ReadProblems::default();
        assert!(problems.is_empty());
        let backward = |topic: &str, by| ReadError::Backward { topic: topic.into(), at: Stamp::EPOCH, by };
        for error in [backward("/a", 1.0), backward("/b", 2.0), backward("/a", 3.0), ReadError::NotAJournal] {
            problems.add(&error);
        }
        let sentences = problems.sentences();
        assert_eq!(sentences.len(), 3);
        assert!(
            sentences[0].contains("/a") && sentences[0].ends_with("(and 1 more like it)"),
            "{sentences:?}"
        );
    }
}
