//! Loop closing of one session: queues comparisons, evaluates their results, carries out people's decisions, and moves the map.
//!
//! Comparisons run in jobs. Results are taken in the order in which they arrive, which the log records, so that a replay repeats them.

use crate::Verdict;
use crate::graph_element::PoseGraphEdge;
use crate::graph_optimiser::{GraphError, KeyframePair};
use crate::loop_finder::{LoopConfig, LoopFinder, MapKeyframe};
use crate::map_search::MapSearchFix;
use crate::quality::MapQualityData;
use crate::revisits::{Novelty, RevisitResult};
use crate::session::{Session, Waypoint};
use crate::verification::{
    CandidateSource, Comparison, ComparisonResult, PairEvidence, RejectionReason, VerificationTask,
    VerifiedPair,
};
use crate::verification_queue::{QueuedComparison, VerificationQueue, VerificationQueueConfig};
use geometry::{Isometry, Matrix6};
use std::collections::{BTreeMap, BTreeSet};
use vocab::{KeyframeId, Stamp};

/// Parameters of [`LoopClosing`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopClosingConfig {
    /// How loops are found.
    pub finder: LoopConfig,
    /// How comparisons are queued.
    pub queue: VerificationQueueConfig,
    /// Decisions of a session that are kept, because a person can decide on a pair as often as he likes. When there are as many, the last one on each of the newest
    /// half as many pairs stays. The loops themselves are in the graph. Chosen: many times what a day of mapping makes, and some 6 MB in the journal.
    pub max_decisions: usize,
}

impl Default for LoopClosingConfig {
    fn default() -> Self {
        Self {
            finder: LoopConfig::default(),
            queue: VerificationQueueConfig::default(),
            max_decisions: 20_000,
        }
    }
}

/// Loop closing of one session.
#[derive(Debug)]
pub struct LoopClosing {
    /// Position of the LiDAR, base frame, metres.
    sensor: [f32; 3],
    finder: LoopFinder,
    queue: VerificationQueue,
    /// [`LoopClosingConfig::max_decisions`].
    max_decisions: usize,
    revisits: RevisitCounts,
    /// In the order of deciding.
    decisions: Vec<LoopRecord>,
    /// The last comparison of each pair, and its outcome, if there is one yet.
    pairs: BTreeMap<KeyframePair, (ComparedPair, Option<LoopOutcome>)>,
    /// Whether no more loops are closed, see [`crate::PoseGraph::failure`].
    has_failed: bool,
}

/// A pair that was compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComparedPair {
    /// Why it was proposed.
    pub source: CandidateSource,
    /// Guess of the newer keyframe's pose in the older one.
    pub guess: Isometry,
    /// The pose found.
    pub edge: PoseGraphEdge,
    /// The figures of its verification.
    pub evidence: PairEvidence,
}

/// A decision about a pair. A pair may get several; the last one counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopRecord {
    /// The pair.
    pub pair: ComparedPair,
    /// The outcome.
    pub outcome: LoopOutcome,
    /// Number of loops that agree with it, itself included.
    pub agreeing: usize,
}

/// Outcome of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoopOutcome {
    /// Decided by the verification and the consistency check.
    Decided(Verdict),
    /// A person accepted it.
    AcceptedByPerson,
    /// A person rejected it.
    RejectedByPerson,
}

/// Comparisons of revisits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RevisitCounts {
    /// Number of comparisons.
    pub compared: u64,
    /// Number of those that confirmed the expected pose.
    pub confirmed: u64,
}

/// The robot's pose was confirmed at a revisit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReanchoredEvent {
    /// When the robot was there.
    pub stamp: Stamp,
    /// The keyframe.
    pub keyframe: KeyframeId,
}

/// Changes caused by a result or a command.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoopEvents {
    /// New decisions.
    pub decisions: Vec<LoopRecord>,
    /// A revisit that was confirmed.
    pub reanchored: Option<ReanchoredEvent>,
    /// Whether edges or poses of the graph changed.
    pub is_graph_changed: bool,
    /// Why no more loops are closed; reported once.
    pub failure: Option<GraphError>,
}

/// Kind of a waypoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AddedWaypoint {
    /// This keyframe.
    Keyframe(KeyframeId),
    /// A revisit of known ground.
    Revisit,
    /// A point of the finished map that the session extends, with the number of the waypoint.
    Unlocalised(u64),
}

/// Why a person's command about a loop is refused.
#[derive(Clone, Debug, PartialEq)]
pub enum LoopCommandError {
    /// The graph cannot be optimised any more.
    GraphFailed(GraphError),
    /// The pair is a loop already.
    AlreadyLoop(KeyframePair),
    /// The pair was not compared yet.
    NotCompared(KeyframePair),
    /// The registration of the pair failed.
    NotRegistered(KeyframePair),
    /// At least one of the keyframes does not exist.
    UnknownKeyframes(KeyframePair),
    /// The pair is neither a loop nor held.
    NoLoop(KeyframePair),
    /// The keyframes follow each other on the walk.
    Neighbours,
}

impl LoopClosing {
    /// Of a session that begins. `sensor` is the position of the LiDAR, base frame, metres.
    pub fn new(config: LoopClosingConfig, sensor: [f32; 3]) -> Self {
        Self::with_finder(LoopFinder::new(config.finder), config, sensor)
    }

    /// Of a session that extends a finished map with these keyframes and this graph. The robot has to be localised in it first, see
    /// [`Self::localise_in_map`].
    pub fn resume(
        config: LoopClosingConfig,
        sensor: [f32; 3],
        keyframes: &[MapKeyframe],
        graph: &mut crate::PoseGraph,
    ) -> Self {
        // The map's loops are known, so that a person may reject and accept them again.
        let compared = |edge: &PoseGraphEdge| {
            let (source, guess) = (CandidateSource::Geometry, edge.from_from_to);
            let evidence = PairEvidence::empty(source);
            let pair = ComparedPair { source, guess, edge: *edge, evidence };
            ((edge.from, edge.to), (pair, Some(LoopOutcome::Decided(Verdict::Accepted))))
        };
        let pairs = graph.loops().iter().map(compared).collect();
        let finder = LoopFinder::resume(config.finder, keyframes, graph);
        Self { pairs, ..Self::with_finder(finder, config, sensor) }
    }

    fn with_finder(finder: LoopFinder, config: LoopClosingConfig, sensor: [f32; 3]) -> Self {
        Self {
            sensor,
            finder,
            queue: VerificationQueue::new(config.queue),
            max_decisions: config.max_decisions,
            revisits: RevisitCounts::default(),
            decisions: Vec::new(),
            pairs: BTreeMap::new(),
            has_failed: false,
        }
    }

    /// The parameters.
    pub fn config(&self) -> &LoopConfig {
        self.finder.config()
    }

    /// Sets the pose of a waypoint in the finished map. Returns whether it was plausible.
    pub fn localise_in_map(&mut self, fix: &MapSearchFix, session: &mut Session) -> bool {
        let pose = self.finder.localise_in_map(fix.waypoint, fix.keyframe, &fix.keyframe_from_waypoint);
        let (Some(pose), Some((first, _))) = (pose, session.trajectory().first().copied()) else {
            return false;
        };
        session.reanchor(first, fix.keyframe, &pose);
        true
    }

    /// Adds the session's newest waypoint with its cloud (base frame, metres). Pairs worth verifying wait for [`Self::start`].
    pub fn add_waypoint(
        &mut self,
        session: &mut Session,
        waypoint: &Waypoint,
        xyz: &[[f32; 3]],
    ) -> (AddedWaypoint, LoopEvents) {
        // Its rotation is in the map, whose z axis points up as that of the odometry's frame does.
        let added = match self.finder.add_waypoint(session.graph_mut(), waypoint, xyz, self.sensor) {
            Novelty::Keyframe { id, tasks } => {
                session.anchor_at(id);
                for task in tasks {
                    self.push(task);
                }
                AddedWaypoint::Keyframe(id)
            }
            Novelty::Revisit(revisit) => {
                session.mark_revisit();
                if let Some(revisit) = revisit.filter(|_| !self.has_failed) {
                    let queued = QueuedComparison::of_revisit(waypoint.stamp, &revisit);
                    self.queue.push(queued, revisit.comparison);
                }
                AddedWaypoint::Revisit
            }
            Novelty::Unlocalised(number) => AddedWaypoint::Unlocalised(number),
        };
        let mut events = LoopEvents::default();
        self.check_graph(session, &mut events);
        (added, events)
    }

    fn push(&mut self, task: VerificationTask) {
        if !self.has_failed {
            self.queue.push(QueuedComparison::of_pair(&task), task.comparison);
        }
    }

    /// Starts as many comparisons as may run. Returns their jobs, numbered from `next_job` on.
    pub fn start(&mut self, next_job: &mut u64) -> Vec<(u64, QueuedComparison)> {
        self.queue.start(next_job)
    }

    /// The data of a job's comparison. They are returned only once.
    pub fn take_comparison(&mut self, job: u64) -> Option<(QueuedComparison, Comparison)> {
        self.queue.take(job)
    }

    /// A job has ended without a result.
    pub fn fail_comparison(&mut self, job: u64) {
        if let Some(QueuedComparison::Pair { .. }) = self.queue.end(job) {
            self.queue.count_skipped();
        }
    }

    /// A job has ended with a result that cannot be used.
    pub fn ignore_comparison(&mut self, job: u64) {
        self.queue.end(job);
    }

    /// The job that compared `pair` has ended: the pair is evaluated, and accepted loops move the map. Jobs of other sessions are ignored.
    pub fn complete_pair(
        &mut self,
        job: u64,
        pair: KeyframePair,
        result: &ComparisonResult,
        session: &mut Session,
    ) -> LoopEvents {
        let Some(QueuedComparison::Pair { from, to, source, guess }) = self.queue.end(job) else {
            return LoopEvents::default();
        };
        // A pair that is a loop already is not changed by another comparison, nor by a result of another build's question.
        if self.has_failed || pair != (from, to) || session.graph().has_loop(pair) {
            return LoopEvents::default();
        }
        let verified = VerifiedPair::new(from, to, result);
        let compared = ComparedPair { source, guess, edge: verified.edge, evidence: result.evidence };
        self.pairs.insert(pair, (compared, None));
        self.evaluate(&verified, session)
    }

    /// The job that compared a waypoint with a keyframe has ended. The robot's pose may be known better, and a new relation of two keyframes may
    /// become a loop. Jobs of other sessions are ignored.
    pub fn complete_revisit(
        &mut self,
        job: u64,
        (compared_waypoint, compared_keyframe): (u64, KeyframeId),
        result: &ComparisonResult,
        session: &mut Session,
    ) -> LoopEvents {
        let Some(QueuedComparison::Revisit { waypoint, stamp, keyframe, .. }) = self.queue.end(job) else {
            return LoopEvents::default();
        };
        if self.has_failed || (waypoint, keyframe) != (compared_waypoint, compared_keyframe) {
            return LoopEvents::default();
        }
        self.revisits.compared += 1;
        let outcome = self.finder.complete_revisit(session.graph(), waypoint, result);
        if outcome == RevisitResult::Rejected {
            return LoopEvents::default();
        }
        self.revisits.confirmed += 1;
        let mut events = LoopEvents::default();
        match outcome {
            RevisitResult::Rejected | RevisitResult::Confirmed => {}
            RevisitResult::Loop(verified) => events = self.evaluate_revisit_loop(&verified, session),
            RevisitResult::Reanchored(reanchoring) => {
                session.reanchor(reanchoring.since, reanchoring.anchor, &reanchoring.anchor_from_waypoint);
                if let Some(verified) = &reanchoring.edge {
                    events = self.evaluate_revisit_loop(verified, session);
                }
            }
        }
        events.reanchored = Some(ReanchoredEvent { stamp, keyframe });
        events
    }

    /// Evaluates a loop between two keyframes that was measured from a revisit, not from one of them.
    fn evaluate_revisit_loop(&mut self, verified: &VerifiedPair, session: &mut Session) -> LoopEvents {
        let edge = verified.edge;
        let pair = (edge.from, edge.to);
        let is_rejected = matches!(
            self.last_outcome(pair),
            Some(LoopOutcome::Decided(Verdict::Rejected(_)) | LoopOutcome::RejectedByPerson)
        );
        if is_rejected || session.graph().has_loop(pair) || edge.from.0.abs_diff(edge.to.0) <= 1 {
            return LoopEvents::default();
        }
        let (source, guess, evidence) = (CandidateSource::Geometry, edge.from_from_to, verified.evidence);
        self.pairs.insert(pair, (ComparedPair { source, guess, edge, evidence }, None));
        self.evaluate(verified, session)
    }

    /// The outcome of a pair since it was compared last.
    fn last_outcome(&self, pair: KeyframePair) -> Option<LoopOutcome> {
        self.pairs.get(&pair)?.1
    }

    /// Evaluates a pair that was compared. Accepted loops move the map.
    fn evaluate(&mut self, verified: &VerifiedPair, session: &mut Session) -> LoopEvents {
        let mut events = LoopEvents::default();
        let loops_before = session.graph().loops().len();
        let decisions = self.finder.evaluate(session.graph_mut(), verified);
        self.check_graph(session, &mut events);
        if self.has_failed {
            return events;
        }
        let new_loops: BTreeSet<KeyframePair> =
            session.graph().loops()[loops_before..].iter().map(|edge| (edge.from, edge.to)).collect();
        events.is_graph_changed = !new_loops.is_empty();
        // A pair may be held several times, as a pair and from revisits. It becomes a loop once.
        let mut accepted = BTreeSet::new();
        for decision in decisions {
            let pair = (decision.edge.from, decision.edge.to);
            let was_loop = session.graph().has_loop(pair) && !new_loops.contains(&pair);
            if was_loop || accepted.contains(&pair) {
                continue;
            }
            if decision.verdict == Verdict::Accepted {
                accepted.insert(pair);
            }
            self.record(pair, LoopOutcome::Decided(decision.verdict), decision.agreeing, &mut events);
        }
        self.move_map(session, &mut events);
        events
    }

    /// A person accepts a pair.
    ///
    /// # Errors
    /// When the pair cannot become a loop.
    pub fn accept(
        &mut self,
        from: KeyframeId,
        to: KeyframeId,
        session: &mut Session,
    ) -> Result<LoopEvents, LoopCommandError> {
        let pair = ordered(from, to);
        self.check_open(pair, session)?;
        let edge = match self.pairs.get(&pair) {
            None => return Err(LoopCommandError::NotCompared(pair)),
            Some((compared, _)) if compared.edge.information == Matrix6::zeros() => {
                return Err(LoopCommandError::NotRegistered(pair));
            }
            Some((compared, _)) => compared.edge,
        };
        if !self.finder.accept(session.graph_mut(), &edge) {
            return Err(LoopCommandError::UnknownKeyframes(pair));
        }
        let mut events = LoopEvents::default();
        self.check_graph(session, &mut events);
        if self.has_failed {
            return Ok(events);
        }
        events.is_graph_changed = true;
        self.record(pair, LoopOutcome::AcceptedByPerson, 1, &mut events);
        self.move_map(session, &mut events);
        Ok(events)
    }

    /// A person rejects a pair.
    ///
    /// # Errors
    /// When it is neither a loop nor held.
    pub fn reject(
        &mut self,
        from: KeyframeId,
        to: KeyframeId,
        session: &mut Session,
    ) -> Result<LoopEvents, LoopCommandError> {
        let pair = ordered(from, to);
        let is_held = self.last_outcome(pair) == Some(LoopOutcome::Decided(Verdict::Held));
        let is_loop = session.graph().has_loop(pair);
        if !is_loop && !is_held {
            return Err(LoopCommandError::NoLoop(pair));
        }
        while self.finder.remove_loop(session.graph_mut(), pair.0, pair.1) {}
        // The robot's pose may have depended on it.
        if let (Some((anchor, pose)), Some((now, _))) = (self.finder.position(), session.trajectory().last())
        {
            session.reanchor(*now, anchor, &pose);
        }
        let mut events = LoopEvents { is_graph_changed: is_loop, ..LoopEvents::default() };
        self.record(pair, LoopOutcome::RejectedByPerson, 0, &mut events);
        self.move_map(session, &mut events);
        Ok(events)
    }

    /// A person proposes a pair, with a guess of `to` in `from`. It is compared before all others.
    ///
    /// # Errors
    /// When the pair cannot become a loop.
    pub fn propose(
        &mut self,
        from: KeyframeId,
        to: KeyframeId,
        guess: &Isometry,
        session: &Session,
    ) -> Result<(), LoopCommandError> {
        let pair = ordered(from, to);
        self.check_open(pair, session)?;
        if from.0.abs_diff(to.0) <= 1 {
            return Err(LoopCommandError::Neighbours);
        }
        let guess = if pair == (from, to) { *guess } else { guess.inverse() };
        let task = self.finder.propose(session.graph(), pair.0, pair.1, guess);
        self.push(task.ok_or(LoopCommandError::UnknownKeyframes(pair))?);
        Ok(())
    }

    /// Whether a pair may still become a loop.
    fn check_open(&self, pair: KeyframePair, session: &Session) -> Result<(), LoopCommandError> {
        match session.graph().failure() {
            Some(error) => Err(LoopCommandError::GraphFailed(error.clone())),
            None if session.graph().has_loop(pair) => Err(LoopCommandError::AlreadyLoop(pair)),
            None => Ok(()),
        }
    }

    /// A snapshot of the session's map for its quality. Linear in the keyframes and edges.
    pub fn quality_data(&self, session: &Session) -> MapQualityData {
        let poses: Vec<Isometry> =
            session.graph().nodes().iter().map(|node| node.map_from_keyframe).collect();
        self.finder.quality_data(session.graph(), &poses)
    }

    /// Whether comparisons wait or run.
    pub fn is_comparing(&self) -> bool {
        !self.has_failed && !self.queue.is_empty()
    }

    /// The session ends: pending comparisons are dropped. Returns whether [`crate::PoseGraph::relinearisation`] would make the poses better.
    pub fn finish(&mut self, session: &Session) -> bool {
        self.queue.clear();
        !session.graph().loops().is_empty() && !self.has_failed
    }

    /// All decisions, in order.
    pub fn decisions(&self) -> &[LoopRecord] {
        &self.decisions
    }

    /// Number of pairs that were never compared.
    pub fn skipped(&self) -> u64 {
        self.queue.skipped()
    }

    /// Counts of revisits.
    pub fn revisits(&self) -> RevisitCounts {
        self.revisits
    }

    /// Optimises the graph if it changed.
    fn move_map(&mut self, session: &mut Session, events: &mut LoopEvents) {
        if events.is_graph_changed {
            session.optimise();
        }
        self.check_graph(session, events);
    }

    fn record(&mut self, pair: KeyframePair, outcome: LoopOutcome, agreeing: usize, events: &mut LoopEvents) {
        let Some((compared, last_outcome)) = self.pairs.get_mut(&pair) else { return };
        *last_outcome = Some(outcome);
        let record = LoopRecord { pair: *compared, outcome, agreeing };
        if self.decisions.len() >= self.max_decisions {
            let pair = |record: &LoopRecord| (record.pair.edge.from, record.pair.edge.to);
            keep_newest(&mut self.decisions, self.max_decisions / 2, pair);
        }
        self.decisions.push(record);
        events.decisions.push(record);
    }

    /// Reports a new failure of the graph. The map stays as it is, and loops are not closed any more.
    fn check_graph(&mut self, session: &Session, events: &mut LoopEvents) {
        if let Some(error) = session.graph().failure().filter(|_| !self.has_failed) {
            self.queue.clear();
            self.has_failed = true;
            events.failure = Some(error.clone());
            events.is_graph_changed = true;
        }
    }
}

impl LoopRecord {
    /// Why the verification rejected the pair, if it did.
    pub fn rejection(&self) -> Option<RejectionReason> {
        match self.outcome {
            LoopOutcome::Decided(Verdict::Rejected(reason)) => Some(reason),
            _ => None,
        }
    }
}

/// The older keyframe first.
fn ordered(a: KeyframeId, b: KeyframeId) -> KeyframePair {
    if a.0 <= b.0 { (a, b) } else { (b, a) }
}

/// Keeps the last item of each key, and of these the newest `max`.
fn keep_newest<T, K: Ord>(items: &mut Vec<T>, max: usize, key: impl Fn(&T) -> K) {
    let mut keys = BTreeSet::new();
    items.reverse();
    items.retain(|item| keys.insert(key(item)));
    items.truncate(max);
    items.reverse();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_decision_on_each_of_the_newest_pairs_is_kept() {
        let mut decisions = vec![(1, 'a'), (2, 'b'), (1, 'c'), (3, 'd'), (3, 'e'), (4, 'f')];
        keep_newest(&mut decisions, 3, |(pair, _)| *pair);
        assert_eq!(decisions, [(1, 'c'), (3, 'e'), (4, 'f')]);
    }
}
