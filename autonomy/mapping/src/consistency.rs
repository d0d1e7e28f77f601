//! Which loops may bend the map: those that agree with what is known of the walk, or with enough others.
//!
//! Places can be built alike to the screw, and registration cannot tell them apart. So a loop is believed at once only
//! where the graph already says, within a margin that is tight itself, that the pair must be there. Where the graph is vague, several
//! loops must agree; where it disagrees, many, from places farther apart than a room is long, and never by much more than
//! the graph's own deviation. Source of the pairwise test: Mangelson et al., *Pairwise Consistent Measurement
//! Set Maximization*, ICRA 2018.

use crate::clique::{bits, largest};
use crate::drift::{CovarianceGraph, OdometryChain};
use crate::verify::{Evidence, RejectionReason, VerifiedPair};
use crate::{Edge, UncertainPose};
use geometry::{Isometry, Vector3};
use vocab::KeyframeId;

/// 99.9 % of the squared Mahalanobis distances of six normal errors lie below.
const CHI_SQUARED_6: f64 = 22.46;
/// Loops that wait; beyond it the oldest is dropped.
const WAITING: usize = 64;
/// How many of them, newest first, are looked at again after a loop was accepted: each costs a search of the graph.
const LOOKED_AT_AGAIN: usize = 8;

/// When a loop is believed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConsistencyConfig {
    /// Place deviation up to which an expectation confirms a loop by itself, metres: a third of the least distance at
    /// which things repeat (racks, columns, doors).
    pub tight: f64,
    /// Loops that must agree where the expectation is vaguer.
    pub support: usize,
    /// Metres that their keyframes must be apart.
    pub spread: f64,
    /// Loops that must agree where they contradict the expectation.
    pub contrary_support: usize,
    /// Metres that those keyframes must be apart: more than a room.
    pub contrary_spread: f64,
    /// Deviations beyond which a contradiction is never believed, however many agree.
    pub contrary_deviations: f64,
}

impl Default for ConsistencyConfig {
    fn default() -> Self {
        Self {
            tight: 0.4,
            support: 3,
            spread: 2.5,
            contrary_support: 6,
            contrary_spread: 18.0,
            contrary_deviations: 10.0,
        }
    }
}

/// What became of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It is an edge of the graph.
    Accepted,
    /// It passed all gates, but waits for others to agree with it.
    Held,
    /// It is not what it seemed.
    Rejected(RejectionReason),
    /// It waited too long.
    Dropped,
}

/// A verdict with its reasons: recorded and shown. A held loop gets a second one when it is accepted or dropped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// The loop.
    pub edge: Edge,
    /// What spoke for and against it.
    pub evidence: Evidence,
    /// What became of it.
    pub verdict: Verdict,
    /// How many loops agreed with it, itself among them.
    pub agreeing: usize,
}

/// The graph as far as loops are judged by it.
#[derive(Clone, Debug)]
pub struct LoopConsistencyCheck {
    trust: ConsistencyConfig,
    chain: OdometryChain,
    web: CovarianceGraph,
    waiting: Vec<Waiting>,
}

/// A loop that waits for others.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    edge: Edge,
    evidence: Evidence,
    /// Those waiting that agree with it, by their places.
    agrees: u64,
}

/// How a loop compares with what the graph says of the pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stance {
    Confirmed,
    Vague,
    Contrary,
    Absurd,
}

impl LoopConsistencyCheck {
    /// Knows one keyframe.
    pub fn new(trust: ConsistencyConfig) -> Self {
        Self { trust, chain: OdometryChain::default(), web: CovarianceGraph::default(), waiting: Vec::new() }
    }

    /// Knows the keyframes of a finished map, which are at `poses` in it, with the edges that were walked and the loops. At least
    /// one keyframe; edges between others are left out.
    pub fn resume(trust: ConsistencyConfig, poses: &[Isometry], edges: &[Edge], loops: &[Edge]) -> Self {
        let (mut chain, mut web) = (OdometryChain::default(), CovarianceGraph::default());
        let known = |edge: &&Edge| index(edge.from).max(index(edge.to)) < poses.len();
        let measured = |edge: &Edge| UncertainPose::from_information(edge.from_from_to, &edge.information);
        // Of each keyframe the way that leads to it from the newest before it.
        let mut ways: Vec<Option<(usize, UncertainPose)>> = vec![None; poses.len()];
        for edge in edges.iter().filter(known) {
            let (from, to, way) = (index(edge.from), index(edge.to), measured(edge));
            web.connect_walked(from, to, &way);
            let (from, to, way) = if from < to { (from, to, way) } else { (to, from, way.inverse()) };
            if from < to && ways[to].is_none_or(|(before, _)| before < from) {
                ways[to] = Some((from, way));
            }
        }
        for edge in loops.iter().filter(known) {
            web.connect(index(edge.from), index(edge.to), &measured(edge));
        }
        for (keyframe, way) in ways.iter().enumerate().skip(1) {
            let apart = poses[keyframe - 1].inverse() * poses[keyframe];
            chain.walk(apart.translation.vector.norm());
            match way {
                Some((from, way)) => chain.attach(*from, way),
                None => chain.begin(&(poses[0].inverse() * poses[keyframe])),
            }
        }
        Self { trust, chain, web, waiting: Vec::new() }
    }

    /// Adds the next keyframe, that the odometry's edge leads to from the last one.
    pub fn add_keyframe(&mut self, edge: &Edge) {
        let step = UncertainPose::from_information(edge.from_from_to, &edge.information);
        let next = self.chain.len();
        self.chain.push(&step);
        self.web.connect_walked(next - 1, next, &step);
    }

    /// Metres were walked over known ground.
    pub fn walk(&mut self, metres: f64) {
        self.chain.walk(metres);
    }

    /// Adds the next keyframe, that `edge` leads to from an old one, its metres having been walked already.
    pub fn attach_keyframe(&mut self, edge: &Edge) {
        let way = UncertainPose::from_information(edge.from_from_to, &edge.information);
        let next = self.chain.len();
        self.chain.attach(index(edge.from), &way);
        self.web.connect_walked(index(edge.from).min(next - 1), next, &way);
    }

    /// The walk by odometry.
    pub fn chain(&self) -> &OdometryChain {
        &self.chain
    }

    /// The best known pose of every keyframe in `from`, over odometry and accepted loops.
    pub fn reach(&self, from: KeyframeId) -> Vec<Option<UncertainPose>> {
        self.web.reach(index(from))
    }

    /// The best known pose of one keyframe in another.
    pub fn between(&self, from: KeyframeId, to: KeyframeId) -> Option<UncertainPose> {
        self.web.between(index(from), index(to))
    }

    /// As [`Self::reach`], from the place that `way` leads to from a keyframe.
    pub fn reach_along(&self, from: KeyframeId, way: &UncertainPose) -> Vec<Option<UncertainPose>> {
        self.web.reach_along(index(from), way)
    }

    /// Whether a measurement agrees with an expectation that is itself sure enough.
    pub fn confirms(&self, expected: &UncertainPose, measured: &UncertainPose) -> bool {
        self.stance(Some(expected), measured) == Stance::Confirmed
    }

    /// Loops that wait for others.
    pub fn waiting(&self) -> usize {
        self.waiting.len()
    }

    /// Judges a verified pair. What it decides may free others that waited. Cost: at most nine searches of the
    /// graph for a loop that is accepted at once, and as many as agree (64) for one that frees others.
    pub fn evaluate(&mut self, verified: &VerifiedPair) -> Vec<Decision> {
        let decision = |verdict, agreeing| Decision {
            edge: verified.edge,
            evidence: verified.evidence,
            verdict,
            agreeing,
        };
        if let Some(rejection) = verified.rejection {
            return vec![decision(Verdict::Rejected(rejection), 0)];
        }
        if self.stance_of(&verified.edge) == Stance::Confirmed {
            self.connect(&verified.edge);
            let mut decisions = vec![decision(Verdict::Accepted, 1)];
            self.confirm_waiting(&mut decisions);
            return decisions;
        }
        let mut decisions = Vec::new();
        if self.waiting.len() == WAITING {
            let Waiting { edge, evidence, .. } = self.no_longer(0);
            decisions.push(Decision { edge, evidence, verdict: Verdict::Dropped, agreeing: 0 });
        }
        self.wait(verified.edge, verified.evidence);
        let set = self.agreeing_with_last();
        if self.convinces(set) {
            let agreeing = set.count_ones() as usize;
            let mut accepted: Vec<Waiting> = Vec::new();
            // Backwards, so that places ahead stay.
            for place in bits(set).collect::<Vec<_>>().into_iter().rev() {
                accepted.push(self.no_longer(place));
            }
            for Waiting { edge, evidence, .. } in accepted.into_iter().rev() {
                self.connect(&edge);
                decisions.push(Decision { edge, evidence, verdict: Verdict::Accepted, agreeing });
            }
            self.confirm_waiting(&mut decisions);
        } else {
            decisions.push(decision(Verdict::Held, set.count_ones() as usize));
        }
        decisions
    }

    /// Takes an edge without judging it: a person's word. It waits no longer then. Says whether there are such keyframes.
    pub fn accept(&mut self, edge: &Edge) -> bool {
        self.forget_waiting(edge.from, edge.to);
        self.connect(edge)
    }

    fn connect(&mut self, edge: &Edge) -> bool {
        let known = index(edge.from).max(index(edge.to)) < self.chain.len();
        if known {
            let measured = UncertainPose::from_information(edge.from_from_to, &edge.information);
            self.web.connect(index(edge.from), index(edge.to), &measured);
        }
        known
    }

    /// Takes a loop back that was accepted or waits, a person having found it wrong. Says whether there was one; what was
    /// walked is none. Who of those waiting agree is looked at again without it: two searches of the graph for each.
    pub fn remove_loop(&mut self, from: KeyframeId, to: KeyframeId) -> bool {
        let waited = self.forget_waiting(from, to);
        let closed = self.web.disconnect(index(from), index(to));
        if closed {
            for Waiting { edge, evidence, .. } in std::mem::take(&mut self.waiting) {
                self.wait(edge, evidence);
            }
        }
        waited || closed
    }

    fn forget_waiting(&mut self, from: KeyframeId, to: KeyframeId) -> bool {
        let before = self.waiting.len();
        while let Some(place) = self.waiting.iter().position(|w| (w.edge.from, w.edge.to) == (from, to)) {
            self.no_longer(place);
        }
        self.waiting.len() < before
    }

    /// Accepts those that waited and are now confirmed, newest first.
    fn confirm_waiting(&mut self, decisions: &mut Vec<Decision>) {
        let oldest = self.waiting.len().saturating_sub(LOOKED_AT_AGAIN);
        for place in (oldest..self.waiting.len()).rev() {
            if self.stance_of(&self.waiting[place].edge) == Stance::Confirmed {
                let Waiting { edge, evidence, .. } = self.no_longer(place);
                self.connect(&edge);
                decisions.push(Decision { edge, evidence, verdict: Verdict::Accepted, agreeing: 1 });
            }
        }
    }

    fn stance_of(&self, edge: &Edge) -> Stance {
        let expected = self.web.between(index(edge.from), index(edge.to));
        self.stance(expected.as_ref(), &UncertainPose::from_information(edge.from_from_to, &edge.information))
    }

    fn stance(&self, expected: Option<&UncertainPose>, measured: &UncertainPose) -> Stance {
        let Some(expected) = expected else { return Stance::Absurd };
        let deviation = expected.translation_std_m();
        match expected.distance_squared(measured) {
            Some(squared) if squared <= CHI_SQUARED_6 => {
                if deviation <= self.trust.tight {
                    Stance::Confirmed
                } else {
                    Stance::Vague
                }
            }
            Some(_) => {
                let error = expected.pose.inverse() * measured.pose;
                let limit = self.trust.contrary_deviations * deviation;
                if error.translation.vector.norm() <= limit { Stance::Contrary } else { Stance::Absurd }
            }
            None => Stance::Absurd,
        }
    }

    /// Lets a loop wait, and notes who agrees with it. Cost: two searches of the graph, however many wait.
    fn wait(&mut self, edge: Edge, evidence: Evidence) {
        let place = self.waiting.len();
        let mut agrees = 0_u64;
        let [from, to] =
            [edge.from, edge.to].map(|end| Ways { consistency: self, end: index(end), by_loops: None });
        let mut ends = [from, to];
        for (other, waiting) in self.waiting.iter().enumerate() {
            let agree = agree(&edge, &waiting.edge, &mut ends);
            agrees |= u64::from(agree) << other;
        }
        for other in bits(agrees) {
            self.waiting[other].agrees |= 1 << place;
        }
        self.waiting.push(Waiting { edge, evidence, agrees });
    }

    /// Takes a loop out of those that wait.
    fn no_longer(&mut self, place: usize) -> Waiting {
        let gone = self.waiting.remove(place);
        let ahead = (1_u64 << place) - 1;
        for waiting in &mut self.waiting {
            waiting.agrees = waiting.agrees & ahead | waiting.agrees >> 1 & !ahead;
        }
        gone
    }

    /// The largest set of waiting loops that agree with each other and with the last one.
    fn agreeing_with_last(&self) -> u64 {
        let agree: Vec<u64> = self.waiting.iter().map(|waiting| waiting.agrees).collect();
        largest(&agree, agree.len().saturating_sub(1))
    }

    /// Whether a set of waiting loops is enough.
    fn convinces(&self, set: u64) -> bool {
        if (set.count_ones() as usize) < self.trust.support {
            return false;
        }
        let stances: Vec<Stance> = bits(set).map(|i| self.stance_of(&self.waiting[i].edge)).collect();
        if stances.contains(&Stance::Absurd) {
            return false;
        }
        let (support, spread) = if stances.contains(&Stance::Contrary) {
            (self.trust.contrary_support, self.trust.contrary_spread)
        } else {
            (self.trust.support, self.trust.spread)
        };
        let far = |end: fn(&Edge) -> KeyframeId| {
            let places: Vec<Vector3> = bits(set)
                .filter_map(|i| self.chain.pose(index(end(&self.waiting[i].edge))))
                .map(|pose: &Isometry| pose.translation.vector)
                .collect();
            let pairs = places.iter().flat_map(|a| places.iter().map(move |b| (a - b).norm()));
            pairs.fold(0.0, f64::max) >= spread
        };
        stances.len() >= support && far(|edge| edge.from) && far(|edge| edge.to)
    }
}

/// How other keyframes lie to one.
struct Ways<'a> {
    consistency: &'a LoopConsistencyCheck,
    end: usize,
    /// Over loops; searched for when it is first asked for.
    by_loops: Option<Vec<Option<UncertainPose>>>,
}

impl Ways<'_> {
    /// By odometry alone if both are of one stretch of the walk, and over loops if not.
    fn to(&mut self, other: KeyframeId) -> Option<UncertainPose> {
        let (consistency, end) = (self.consistency, self.end);
        consistency.chain.relative(end, index(other)).or_else(|| {
            let reached = self.by_loops.get_or_insert_with(|| consistency.web.reach(end));
            reached.get(index(other)).copied().flatten()
        })
    }
}

/// Whether two loops and the ways between their ends close a circle within their covariance. `ends`: those of `a`.
fn agree(a: &Edge, b: &Edge, [from, to]: &mut [Ways<'_>; 2]) -> bool {
    let [first, second] =
        [a, b].map(|edge| UncertainPose::from_information(edge.from_from_to, &edge.information));
    let (Some(there), Some(back)) = (from.to(b.from), to.to(b.to)) else { return false };
    let around = there.inverse().then(&first).then(&back);
    around.distance_squared(&second).is_some_and(|squared| squared <= CHI_SQUARED_6)
}

fn index(keyframe: KeyframeId) -> usize {
    keyframe.0 as usize
}

#[cfg(test)]
#[path = "consistency_tests.rs"]
mod tests;
