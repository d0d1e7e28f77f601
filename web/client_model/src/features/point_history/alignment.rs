//! How the two photos that are compared are aligned: as the robot has stored it, or as it answers when the pair is asked for.

use site_model::{PictureComparison, PictureComparisonOutcome};
use std::collections::BTreeMap;

/// Answers that are kept. Chosen: a person looks through some dozens; those of the lowest numbers go first.
const MAX_KEPT: usize = 64;

/// How the two results that are compared are aligned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PairAlignment<'a> {
    /// They are no two photos.
    NoPhotos,
    /// The robot was not asked yet.
    NotAsked,
    /// The robot compares them now.
    Awaited,
    /// The robot could not answer: one sentence.
    Failed(&'a str),
    /// The robot has compared them.
    Known(&'a PictureComparisonOutcome),
}

/// Numbers of the earlier and the later result.
type Pair = (u64, u64);

/// The pairs that the robot was asked for.
#[derive(Clone, Debug, Default)]
pub(super) struct AskedPairs {
    awaited: Option<Pair>,
    answers: BTreeMap<Pair, Result<PictureComparisonOutcome, String>>,
}

impl AskedPairs {
    /// What is known of a pair.
    pub(super) fn alignment(&self, pair: Pair) -> PairAlignment<'_> {
        match self.answers.get(&pair) {
            _ if self.awaited == Some(pair) => PairAlignment::Awaited,
            Some(Ok(outcome)) => PairAlignment::Known(outcome),
            Some(Err(sentence)) => PairAlignment::Failed(sentence),
            None => PairAlignment::NotAsked,
        }
    }

    /// Notes that a pair is asked for. Returns false while another one is.
    pub(super) fn ask(&mut self, pair: Pair) -> bool {
        self.awaited.is_none() && self.awaited.replace(pair).is_none()
    }

    /// Takes an answer in.
    pub(super) fn answer(&mut self, pair: Pair, answer: Result<PictureComparison, String>) {
        if self.awaited == Some(pair) {
            self.awaited = None;
        }
        self.answers.insert(pair, answer.map(|comparison| comparison.outcome));
        if self.answers.len() > MAX_KEPT {
            self.answers.pop_first();
        }
    }

    /// No answer comes any more.
    pub(super) fn give_up(&mut self) {
        self.awaited = None;
    }
}
