//! The robot's decisions on pairs of keyframes.

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
    /// The pair of two keyframes in any order.
    pub fn of(a: KeyframeId, b: KeyframeId) -> Self {
        Self { from: a.min(b), to: a.max(b) }
    }

    /// The pair that a decision is about.
    pub fn of_decision(decision: &LoopDecision) -> Self {
        Self::of(decision.from, decision.to)
    }

    /// Whether the two are the same or consecutive: an edge of the odometry joins them already.
    pub fn is_adjacent(self) -> bool {
        self.from.0.abs_diff(self.to.0) <= 1
    }
}

/// Number of pairs by verdict.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LoopCounts {
    /// Edges of the graph.
    pub accepted: usize,
    /// Pairs that fit and wait for others to agree.
    pub held: usize,
    /// Pairs that are no loops, and those that waited too long.
    pub rejected: usize,
}

/// Decisions on pairs of keyframes. The last decision on a pair counts.
#[derive(Clone, Debug, Default)]
pub struct LoopDecisions {
    /// Oldest first, at most [`MAX_LOOP_DECISIONS`].
    decisions: VecDeque<LoopDecision>,
    /// Indices into `decisions` of the last one on each pair, newest first.
    latest: Vec<usize>,
    counts: LoopCounts,
    revision: u64,
}

impl LoopDecisions {
    /// The last decision on each pair, newest first.
    pub fn latest(&self) -> impl ExactSizeIterator<Item = &LoopDecision> + '_ {
        self.latest.iter().map(|&at| &self.decisions[at])
    }

    /// Element `n` of [`Self::latest`], in constant time.
    pub fn nth_latest(&self, n: usize) -> Option<&LoopDecision> {
        self.decisions.get(*self.latest.get(n)?)
    }

    /// The last decision on a pair. Cost: linear in the number of decisions.
    pub fn get(&self, pair: LoopPair) -> Option<&LoopDecision> {
        self.decisions.iter().rev().find(|decision| LoopPair::of_decision(decision) == pair)
    }

    /// Number of pairs.
    pub fn len(&self) -> usize {
        self.latest.len()
    }

    /// Whether there is no decision yet.
    pub fn is_empty(&self) -> bool {
        self.latest.is_empty()
    }

    /// Number of pairs by verdict.
    pub fn counts(&self) -> LoopCounts {
        self.counts
    }

    /// Grows with every change.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Adds new decisions and forgets the oldest of too many. Cost: n log n in the number of decisions.
    pub(crate) fn update(&mut self, changed: &LoopsChanged) {
        if changed.reset {
            self.decisions.clear();
        }
        self.decisions.extend(changed.added.iter().cloned());
        self.decisions.drain(..self.decisions.len().saturating_sub(MAX_LOOP_DECISIONS));
        let mut seen = BTreeSet::new();
        let newest_first = self.decisions.iter().enumerate().rev();
        self.latest = newest_first
            .filter(|(_, decision)| seen.insert(LoopPair::of_decision(decision)))
            .map(|(at, _)| at)
            .collect();
        self.counts = count(self.latest());
        self.revision += 1;
    }
}

fn count<'a>(decisions: impl Iterator<Item = &'a LoopDecision>) -> LoopCounts {
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
