//! Loops of the map being made: what was decided on each pair of keyframes, and how far adding one by hand has come.

use crate::ClientTime;
use api::{LoopDecision, LoopVerdict, LoopsChanged, MAX_LOOP_DECISIONS};
use std::collections::{BTreeSet, VecDeque};
use vocab::KeyframeId;

/// Two keyframes that may have seen the same place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LoopPair {
    /// The older one.
    pub from: KeyframeId,
    /// The newer one.
    pub to: KeyframeId,
}

impl LoopPair {
    /// The pair of these, whichever is older.
    pub fn of(a: KeyframeId, b: KeyframeId) -> Self {
        Self { from: a.min(b), to: a.max(b) }
    }

    /// The pair that a decision is about.
    pub fn decided(decision: &LoopDecision) -> Self {
        Self::of(decision.from, decision.to)
    }

    /// Whether the two are the same or follow each other on the walk: the odometry joins them already.
    pub fn is_adjacent(self) -> bool {
        self.from.0.abs_diff(self.to.0) <= 1
    }
}

/// How many pairs there are of each kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LoopCounts {
    /// Edges of the graph.
    pub accepted: usize,
    /// Those that fit and wait for others.
    pub held: usize,
    /// Those that are no loops, and those that waited too long.
    pub rejected: usize,
}

/// What was decided on loops; a pair's last decision counts.
#[derive(Clone, Debug, Default)]
pub struct Loops {
    /// Oldest first, at most [`MAX_LOOP_DECISIONS`].
    decisions: VecDeque<LoopDecision>,
    /// Of each pair the last decision, newest first, as indices into `decisions`.
    last: Vec<usize>,
    counts: LoopCounts,
    revision: u64,
}

impl Loops {
    /// The last decision on each pair, newest first.
    pub fn latest(&self) -> impl ExactSizeIterator<Item = &LoopDecision> + '_ {
        self.last.iter().map(|&at| &self.decisions[at])
    }

    /// The `n`th of [`Self::latest`], at once.
    pub fn nth_latest(&self, n: usize) -> Option<&LoopDecision> {
        self.decisions.get(*self.last.get(n)?)
    }

    /// The last decision on a pair. Cost: linear in the decisions.
    pub fn get(&self, pair: LoopPair) -> Option<&LoopDecision> {
        self.decisions.iter().rev().find(|decision| LoopPair::decided(decision) == pair)
    }

    /// Number of pairs.
    pub fn len(&self) -> usize {
        self.last.len()
    }

    /// Whether nothing was decided yet.
    pub fn is_empty(&self) -> bool {
        self.last.is_empty()
    }

    /// How many pairs there are of each kind.
    pub fn counts(&self) -> LoopCounts {
        self.counts
    }

    /// Grows with every change.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Takes new decisions; the oldest of too many are forgotten. Cost: n log n in the decisions held.
    pub(crate) fn change(&mut self, changed: LoopsChanged) {
        if changed.reset {
            self.decisions.clear();
        }
        self.decisions.extend(changed.added);
        self.decisions.drain(..self.decisions.len().saturating_sub(MAX_LOOP_DECISIONS));
        let mut seen = BTreeSet::new();
        let newest_first = self.decisions.iter().enumerate().rev();
        self.last = newest_first
            .filter(|(_, decision)| seen.insert(LoopPair::decided(decision)))
            .map(|(at, _)| at)
            .collect();
        self.counts = counted(self.latest());
        self.revision += 1;
    }
}

fn counted<'a>(decisions: impl Iterator<Item = &'a LoopDecision>) -> LoopCounts {
    let mut counts = LoopCounts::default();
    for decision in decisions {
        match decision.verdict {
            LoopVerdict::Accepted => counts.accepted += 1,
            LoopVerdict::Held => counts.held += 1,
            LoopVerdict::Rejected | LoopVerdict::Dropped => counts.rejected += 1,
        }
    }
    counts
}

/// How far adding a loop by hand has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoopPick {
    /// The first keyframe is to be chosen.
    First,
    /// The second one is; this is the first.
    Second(KeyframeId),
    /// Both are chosen, and can be proposed.
    Both(LoopPair),
}

impl LoopPick {
    /// Takes the next keyframe; choosing the first one again takes it back, and a third begins anew.
    pub(crate) fn choose(self, keyframe: KeyframeId) -> Self {
        match self {
            Self::Second(first) if first == keyframe => Self::First,
            Self::Second(first) => Self::Both(LoopPair::of(first, keyframe)),
            Self::First | Self::Both(_) => Self::Second(keyframe),
        }
    }
}

/// Where the newer of two keyframes is guessed to be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LoopInitialGuess {
    /// Where the graph has it: right while the map is.
    #[default]
    Graph,
    /// At the very place of the older one, turned as the graph has it: for a map that has drifted.
    SamePlace,
}

/// A pair that was proposed and is being compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopProposal {
    /// Which.
    pub pair: LoopPair,
    /// When it was asked.
    pub asked: ClientTime,
}
