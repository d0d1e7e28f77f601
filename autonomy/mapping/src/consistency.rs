//! Consistency check of verified loops: only those that agree with the graph, or with enough other loops, are accepted
//! (docs/maths/loops.md, section 6).
//!
//! Places can be built exactly alike, and registration cannot distinguish them. So a loop is accepted at once only if the graph already expects the
//! pair there, with a small standard deviation. Where the graph is uncertain, several loops must agree with each other. Where it disagrees, many
//! must agree, from keyframes farther apart than a room is long, and never by much more than the graph's own deviation. Source of the pairwise
//! test: Mangelson et al., *Pairwise Consistent Measurement Set Maximization*, ICRA 2018.

use crate::clique::{bits, largest_clique};
use crate::graph_element::{PoseGraphEdge, index};
use crate::pose_graph::PoseGraph;
use crate::uncertain_pose::CHI_SQUARED_6_999;
use crate::verification::{PairEvidence, RejectionReason, VerifiedPair};
use crate::{PoseCertaintyConfig, UncertainPose};
use geometry::{Isometry, Vector3};
use vocab::KeyframeId;

/// Parameters of [`LoopConsistencyCheck`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopConsistencyConfig {
    /// Standard deviation of the graph's expectation up to which it confirms a loop by itself, metres. Its default is that of
    /// [`PoseCertaintyConfig`].
    pub confirming_std_m: f64,
    /// Number of loops that must agree where the expectation is less certain. Chosen: two may agree by chance in places that repeat.
    pub min_support: usize,
    /// Least extent of their keyframes, metres. A spread of several loops, not the width of one view as
    /// [`CandidateConfig::max_offset_m`](crate::candidates::CandidateConfig::max_offset_m). Chosen: loops at one place repeat the same error.
    pub min_extent_m: f64,
    /// Number of loops that must agree where they contradict the expectation. Chosen: twice [`Self::min_support`], because a wrong one would bend the map.
    pub min_contradicting_support: usize,
    /// Least extent of those keyframes, metres: more than a room. Source: docs/maths/loops.md, section 6: loops between two equal rooms all agree, and extend no farther than
    /// the room.
    pub min_contradicting_extent_m: f64,
    /// A contradiction of more than this many standard deviations is never accepted, however many loops agree. Chosen: an error of that size is none of the odometry that
    /// the covariance describes.
    pub max_contradiction_deviations: f64,
    /// Greatest number of held loops; beyond it the oldest is dropped. At most 64, the width of a bit set.
    pub max_held: usize,
    /// Branches of the search for the largest set of loops that agree, after which the best set found so far is taken. It bounds the time of a
    /// step. Chosen: the search is exact up to it.
    pub max_branches: usize,
    /// Number of held loops, newest first, that are checked again after a loop was accepted. Each costs a search of the graph. Chosen: the newest ones are near the loop
    /// that was accepted.
    pub rechecked: usize,
}

impl Default for LoopConsistencyConfig {
    fn default() -> Self {
        Self {
            confirming_std_m: PoseCertaintyConfig::default().max_std_m,
            min_support: 3,
            min_extent_m: 2.5,
            min_contradicting_support: 6,
            min_contradicting_extent_m: 18.0,
            max_contradiction_deviations: 10.0,
            max_held: 64,
            max_branches: 20_000,
            rechecked: 8,
        }
    }
}

/// Outcome of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It is a loop of the graph.
    Accepted,
    /// It passed the verification, but waits for other loops to agree with it.
    Held,
    /// It failed the verification.
    Rejected(RejectionReason),
    /// It was held for too long.
    Dropped,
}

/// A verdict with its figures, to be recorded and shown. A held loop gets a second one when it is accepted or dropped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// The loop.
    pub edge: PoseGraphEdge,
    /// The figures of its verification.
    pub evidence: PairEvidence,
    /// The outcome.
    pub verdict: Verdict,
    /// Number of loops that agree with it, itself included.
    pub agreeing: usize,
}

/// Decides which verified loops enter the graph, and holds those that wait for support.
#[derive(Clone, Debug, Default)]
pub struct LoopConsistencyCheck {
    config: LoopConsistencyConfig,
    held: Vec<HeldLoop>,
}

/// A loop that waits for others.
#[derive(Clone, Copy, Debug)]
struct HeldLoop {
    edge: PoseGraphEdge,
    evidence: PairEvidence,
    /// Bit set of the held loops that agree with it, by index.
    agreeing: u64,
}

/// How a loop compares with what the graph expects of the pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LoopAgreement {
    /// It agrees, and the expectation is certain.
    Confirmed,
    /// It agrees with an uncertain expectation.
    Uncertain,
    /// It contradicts the expectation.
    Contradicting,
    /// It contradicts the expectation by more than is ever accepted.
    Implausible,
}

impl LoopConsistencyCheck {
    /// Without held loops.
    pub fn new(config: LoopConsistencyConfig) -> Self {
        Self { config, held: Vec::new() }
    }

    /// Whether a measurement agrees with an expectation that is certain enough by itself.
    pub fn confirms(&self, expected: &UncertainPose, measured: &UncertainPose) -> bool {
        self.agreement(Some(expected), measured) == LoopAgreement::Confirmed
    }

    /// Number of loops that wait for others.
    pub fn held_count(&self) -> usize {
        self.held.len()
    }

    /// Decides about a verified pair, and about held loops that it supports. Accepted loops are added to the graph. Cost: at most nine searches of
    /// the graph for a loop that is accepted at once, and as many as agree (64) for one that releases others.
    pub fn evaluate(&mut self, graph: &mut PoseGraph, verified: &VerifiedPair) -> Vec<Decision> {
        let decision = |verdict, agreeing| Decision {
            edge: verified.edge,
            evidence: verified.evidence,
            verdict,
            agreeing,
        };
        if let Some(reason) = verified.rejection {
            return vec![decision(Verdict::Rejected(reason), 0)];
        }
        if self.agreement_of(graph, &verified.edge) == LoopAgreement::Confirmed {
            graph.add_loop(&verified.edge);
            let mut decisions = vec![decision(Verdict::Accepted, 1)];
            self.recheck_held(graph, &mut decisions);
            return decisions;
        }
        let mut decisions = Vec::new();
        if self.held.len() == self.config.max_held.min(64) {
            let HeldLoop { edge, evidence, .. } = self.release(0);
            decisions.push(Decision { edge, evidence, verdict: Verdict::Dropped, agreeing: 0 });
        }
        self.hold(graph, verified.edge, verified.evidence);
        let set = self.largest_set_with_newest();
        if self.is_convincing(graph, set) {
            let agreeing = set.count_ones() as usize;
            let mut accepted: Vec<HeldLoop> = Vec::new();
            // From the last one, so that the indices before it stay valid.
            for index in bits(set).collect::<Vec<_>>().into_iter().rev() {
                accepted.push(self.release(index));
            }
            for HeldLoop { edge, evidence, .. } in accepted.into_iter().rev() {
                graph.add_loop(&edge);
                decisions.push(Decision { edge, evidence, verdict: Verdict::Accepted, agreeing });
            }
            self.recheck_held(graph, &mut decisions);
        } else {
            decisions.push(decision(Verdict::Held, set.count_ones() as usize));
        }
        decisions
    }

    /// Adds a loop to the graph without a check, because a person accepted it. It is not held any more. Returns whether the keyframes exist.
    pub fn accept(&mut self, graph: &mut PoseGraph, edge: &PoseGraphEdge) -> bool {
        self.drop_held(edge.from, edge.to);
        graph.add_loop(edge)
    }

    /// Removes a loop from the graph and from the held ones, because a person rejected it. Returns whether there was one. Which held loops agree
    /// with each other is computed again without it, with two searches of the graph for each.
    pub fn remove_loop(&mut self, graph: &mut PoseGraph, from: KeyframeId, to: KeyframeId) -> bool {
        let was_held = self.drop_held(from, to);
        let was_accepted = graph.remove_loop(from, to);
        if was_accepted {
            for HeldLoop { edge, evidence, .. } in std::mem::take(&mut self.held) {
                self.hold(graph, edge, evidence);
            }
        }
        was_held || was_accepted
    }

    fn drop_held(&mut self, from: KeyframeId, to: KeyframeId) -> bool {
        let before = self.held.len();
        while let Some(index) = self.held.iter().position(|h| (h.edge.from, h.edge.to) == (from, to)) {
            self.release(index);
        }
        self.held.len() < before
    }

    /// Accepts held loops that the graph confirms now, newest first.
    fn recheck_held(&mut self, graph: &mut PoseGraph, decisions: &mut Vec<Decision>) {
        let oldest = self.held.len().saturating_sub(self.config.rechecked);
        for index in (oldest..self.held.len()).rev() {
            if self.agreement_of(graph, &self.held[index].edge) == LoopAgreement::Confirmed {
                let HeldLoop { edge, evidence, .. } = self.release(index);
                graph.add_loop(&edge);
                decisions.push(Decision { edge, evidence, verdict: Verdict::Accepted, agreeing: 1 });
            }
        }
    }

    fn agreement_of(&self, graph: &PoseGraph, edge: &PoseGraphEdge) -> LoopAgreement {
        let expected = graph.relative_pose(edge.from, edge.to);
        self.agreement(expected.as_ref(), &edge.relative_pose())
    }

    /// By equation 3; an error above the quantile is judged by the position alone.
    fn agreement(&self, expected: Option<&UncertainPose>, measured: &UncertainPose) -> LoopAgreement {
        let Some(expected) = expected else { return LoopAgreement::Implausible };
        let std_m = expected.translation_std_m();
        match expected.mahalanobis_squared(measured) {
            Some(squared) if squared <= CHI_SQUARED_6_999 => {
                if std_m <= self.config.confirming_std_m {
                    LoopAgreement::Confirmed
                } else {
                    LoopAgreement::Uncertain
                }
            }
            Some(_) => {
                let error = expected.pose.inverse() * measured.pose;
                let limit_m = self.config.max_contradiction_deviations * std_m;
                if error.translation.vector.norm() <= limit_m {
                    LoopAgreement::Contradicting
                } else {
                    LoopAgreement::Implausible
                }
            }
            None => LoopAgreement::Implausible,
        }
    }

    /// Holds a loop, and notes which held loops agree with it. Cost: two searches of the graph, however many are held.
    fn hold(&mut self, graph: &PoseGraph, edge: PoseGraphEdge, evidence: PairEvidence) {
        let own = self.held.len();
        let mut agreeing = 0_u64;
        let mut ends = [edge.from, edge.to].map(|keyframe| RelativePoses { graph, keyframe, by_loops: None });
        for (other, held) in self.held.iter().enumerate() {
            agreeing |= u64::from(are_consistent(&edge, &held.edge, &mut ends)) << other;
        }
        for other in bits(agreeing) {
            self.held[other].agreeing |= 1 << own;
        }
        self.held.push(HeldLoop { edge, evidence, agreeing });
    }

    /// Removes a held loop.
    fn release(&mut self, index: usize) -> HeldLoop {
        let removed = self.held.remove(index);
        let before = (1_u64 << index) - 1;
        for held in &mut self.held {
            held.agreeing = held.agreeing & before | held.agreeing >> 1 & !before;
        }
        removed
    }

    /// The largest set of held loops that agree with each other and with the newest one.
    fn largest_set_with_newest(&self) -> u64 {
        let agreeing: Vec<u64> = self.held.iter().map(|held| held.agreeing).collect();
        largest_clique(&agreeing, agreeing.len().saturating_sub(1), self.config.max_branches)
    }

    /// Whether a set of held loops is enough to be accepted.
    fn is_convincing(&self, graph: &PoseGraph, set: u64) -> bool {
        let config = &self.config;
        if (set.count_ones() as usize) < config.min_support {
            return false;
        }
        let agreements: Vec<LoopAgreement> =
            bits(set).map(|i| self.agreement_of(graph, &self.held[i].edge)).collect();
        if agreements.contains(&LoopAgreement::Implausible) {
            return false;
        }
        let (min_support, min_extent_m) = if agreements.contains(&LoopAgreement::Contradicting) {
            (config.min_contradicting_support, config.min_contradicting_extent_m)
        } else {
            (config.min_support, config.min_extent_m)
        };
        let is_wide = |end: fn(&PoseGraphEdge) -> KeyframeId| {
            let positions: Vec<Vector3> = bits(set)
                .filter_map(|i| graph.chain().pose(index(end(&self.held[i].edge))))
                .map(|pose: &Isometry| pose.translation.vector)
                .collect();
            let pairs = positions.iter().flat_map(|a| positions.iter().map(move |b| (a - b).norm()));
            pairs.fold(0.0, f64::max) >= min_extent_m
        };
        agreements.len() >= min_support && is_wide(|edge| edge.from) && is_wide(|edge| edge.to)
    }
}

/// Poses of other keyframes in one.
struct RelativePoses<'a> {
    graph: &'a PoseGraph,
    keyframe: KeyframeId,
    /// Over loops; computed when it is first asked for.
    by_loops: Option<Vec<Option<UncertainPose>>>,
}

impl RelativePoses<'_> {
    /// By odometry alone if both keyframes are of one segment of the walk, else over loops.
    fn get(&mut self, other: KeyframeId) -> Option<UncertainPose> {
        let (graph, keyframe) = (self.graph, self.keyframe);
        graph.chain().relative_pose(index(keyframe), index(other)).or_else(|| {
            let poses = self.by_loops.get_or_insert_with(|| graph.poses_in(keyframe));
            poses.get(index(other)).copied().flatten()
        })
    }
}

/// Whether two loops and the paths between their ends close a circle within their covariance (equation 10). `ends` are those of `a`.
fn are_consistent(a: &PoseGraphEdge, b: &PoseGraphEdge, [from, to]: &mut [RelativePoses<'_>; 2]) -> bool {
    let [first, second] = [a, b].map(PoseGraphEdge::relative_pose);
    let (Some(there), Some(back)) = (from.get(b.from), to.get(b.to)) else { return false };
    let around = there.inverse().compose(&first).compose(&back);
    around.mahalanobis_squared(&second).is_some_and(|squared| squared <= CHI_SQUARED_6_999)
}

#[cfg(test)]
#[path = "consistency_tests.rs"]
mod tests;
