//! Loop closure of one session: from keyframes to pairs worth a look, from what came of the look to edges and better poses; and on
//! known ground, where the robot is among old keyframes.
//!
//! Looking is work for a job (see [`crate::ComputeJob`]); results are taken in the order in which they arrive, which the log
//! records, so that a replay repeats them.

pub(crate) mod plain;
mod queue;
mod words;

use crate::optimiser::{GraphError, Optimiser, Pair};
use crate::prior_map::DecodedPriorMap;
use crate::search::Found;
use crate::work::{Asked, ComputeJob};
use geometry::{Isometry, Matrix6, isometry_from_pose, pose_from_isometry};
use mapping::{
    Decision, Edge, LoopConfig, LoopFinder, Node, Novelty, RevisitResult, Session, Verdict, VerificationTask,
    VerifiedPair, Waypoint,
};
use messages::{
    ComparedRevisit, LoopDecision, LoopEvidence, LoopTask, LoopVerdict, MapQuality, RevisitCounts,
    StackEffect, VerifiedLoop,
};
use queue::Queue;
use std::collections::BTreeMap;
use vocab::{KeyframeId, Pose, SessionId};

/// What a session knows of its loops.
#[derive(Debug)]
pub(crate) struct Loops {
    session: SessionId,
    /// Where the LiDAR is, base frame, metres.
    sensor: [f32; 3],
    finder: LoopFinder,
    optimiser: Optimiser,
    queue: Queue,
    visits: RevisitCounts,
    /// In the order of deciding.
    decisions: Vec<LoopDecision>,
    /// Of each pair that was looked at, the last look.
    looked_at: BTreeMap<Pair, LookedAt>,
    /// Why no more loops are closed.
    broken: Option<String>,
}

#[derive(Debug)]
struct LookedAt {
    asked: LoopTask,
    edge: Edge,
    evidence: LoopEvidence,
    /// None while nothing was decided.
    verdict: Option<LoopVerdict>,
}

/// What came of something.
#[derive(Debug, Default)]
pub(crate) struct LoopEvents {
    pub decisions: Vec<LoopDecision>,
    /// The robot found its place on known ground.
    pub tied: Option<messages::Reanchored>,
    /// Whether edges or poses of the session changed.
    pub changed: bool,
    /// Whether the robot has found itself in the map that the session goes on from.
    pub found: bool,
    /// Why loops are no longer closed, said once.
    pub trouble: Option<String>,
}

impl Loops {
    /// Of a session that begins. `sensor`: the LiDAR's place, base frame, metres.
    pub fn new(session: SessionId, sensor: [f32; 3]) -> Self {
        Self {
            session,
            sensor,
            finder: LoopFinder::new(LoopConfig::default()),
            optimiser: Optimiser::default(),
            queue: Queue::default(),
            visits: RevisitCounts::default(),
            decisions: Vec::new(),
            looked_at: BTreeMap::new(),
            broken: None,
        }
    }

    /// Of a session that goes on from a saved map, in which the robot has to find itself first, see [`Self::place`].
    ///
    /// # Errors
    /// When its graph cannot be solved.
    pub fn resume(session: SessionId, sensor: [f32; 3], map: &DecodedPriorMap) -> Result<Self, GraphError> {
        let DecodedPriorMap { keyframes, edges, loops, .. } = map;
        let closed = |edge: &Edge| {
            // So that a person may take it back, and close it again.
            let (source, guess) = (messages::LoopSource::Geometry, pose_from_isometry(&edge.from_from_to));
            let asked = LoopTask { session, from: edge.from, to: edge.to, source, guess };
            let (evidence, verdict) = (LoopEvidence::default(), Some(LoopVerdict::Accepted));
            ((edge.from, edge.to), LookedAt { asked, edge: *edge, evidence, verdict })
        };
        Ok(Self {
            finder: LoopFinder::resume(LoopConfig::default(), keyframes, edges, loops),
            optimiser: Optimiser::resume(&map.nodes, edges, loops)?,
            looked_at: loops.iter().map(closed).collect(),
            ..Self::new(session, sensor)
        })
    }

    /// Tells where a waypoint was in that map. Says whether it could be believed.
    pub fn place(&mut self, found: &Found, session: &mut Session) -> bool {
        let placed =
            self.finder.localise_in_map(found.waypoint, found.keyframe, &found.keyframe_from_waypoint);
        let (Some(pose), Some((first, _))) = (placed, session.trajectory().first().copied()) else {
            return false;
        };
        session.reanchor(first, found.keyframe, &pose);
        true
    }

    /// Takes the session's newest waypoint in, with its cloud (base frame, metres). Says how it joins the graph if it is a
    /// keyframe ([`Self::add_keyframe`] comes next then), or that it is on known ground. What is worth a look waits for
    /// [`Self::start`].
    pub fn arrive(&mut self, waypoint: &Waypoint, xyz: &[[f32; 3]]) -> Arrived {
        // Of the map, whose z axis points up as well as the odometry's does.
        match self.finder.add_waypoint(waypoint, xyz, self.sensor) {
            Novelty::Keyframe { edge, tasks } => {
                for task in tasks {
                    self.ask(task);
                }
                Arrived::Keyframe(edge)
            }
            Novelty::Revisit(visit) => {
                if let Some(visit) = visit.filter(|_| self.broken.is_none()) {
                    let asked = plain::visit_to_plain(self.session, waypoint.stamp, &visit);
                    self.queue.push(Asked::Revisit(asked), visit.comparison);
                }
                Arrived::Revisit
            }
            Novelty::Unlocalised(number) => Arrived::Lost(number),
        }
    }

    /// Takes the session's newest keyframe in, that `edge` leads to.
    pub fn add_keyframe(&mut self, node: &Node, edge: Option<&Edge>) -> LoopEvents {
        if self.broken.is_some() {
            return LoopEvents::default();
        }
        match self.optimiser.add_keyframe(node, edge) {
            Ok(()) => LoopEvents::default(),
            Err(error) => self.give_up(&error),
        }
    }

    fn ask(&mut self, task: VerificationTask) {
        if self.broken.is_none() {
            let asked = Asked::Loop(plain::task_to_plain(self.session, &task));
            self.queue.push(asked, task.comparison);
        }
    }

    /// Starts jobs, as many as may run. `jobs` counts all jobs of the stack.
    pub fn start(&mut self, jobs: &mut u64, effects: &mut Vec<StackEffect>) {
        self.queue.start(jobs, effects);
    }

    /// What a job takes; once.
    pub fn take_compute_job(&mut self, job: u64) -> Option<ComputeJob> {
        self.queue.take(job, &self.finder.config().gates)
    }

    /// A job has ended without a result.
    pub fn not_verified(&mut self, job: u64) {
        if let Some(Asked::Loop(_)) = self.queue.end(job) {
            self.queue.leave_out();
        }
    }

    /// A job has ended: its pair is judged, and what is accepted moves the map. Jobs of other sessions are ignored.
    pub fn verified(&mut self, job: u64, found: &VerifiedLoop, session: &mut Session) -> LoopEvents {
        let (Some(Asked::Loop(asked)), Some(verified)) =
            (self.queue.end(job), plain::verified_from_plain(found))
        else {
            return LoopEvents::default();
        };
        let pair = (asked.from, asked.to);
        // A second look at what is an edge already, or at what was asked of another build, changes nothing.
        if self.broken.is_some() || pair != (found.task.from, found.task.to) || self.optimiser.has(pair) {
            return LoopEvents::default();
        }
        let known = LookedAt { asked, edge: verified.edge, evidence: found.evidence, verdict: None };
        self.looked_at.insert(pair, known);
        self.evaluate(&verified, session)
    }

    /// A job has ended: the robot's place may be known anew, and if that says something new of how two keyframes lie to each
    /// other it is a loop. Jobs of other sessions are ignored.
    pub fn compared(&mut self, job: u64, found: &ComparedRevisit, session: &mut Session) -> LoopEvents {
        let (Some(Asked::Revisit(asked)), Some(compared)) =
            (self.queue.end(job), plain::compared_from_plain(found))
        else {
            return LoopEvents::default();
        };
        let same = (asked.visit, asked.keyframe) == (found.task.visit, found.task.keyframe);
        if self.broken.is_some() || !same {
            return LoopEvents::default();
        }
        self.visits.compared += 1;
        let tied = self.finder.complete_revisit(asked.visit, &compared);
        if tied == RevisitResult::Rejected {
            return LoopEvents::default();
        }
        self.visits.confirmed += 1;
        let mut news = LoopEvents::default();
        match tied {
            RevisitResult::Rejected | RevisitResult::Confirmed => {}
            RevisitResult::Loop(verified) => news = self.loop_from_visit(&verified, session),
            RevisitResult::Reanchored(tie) => {
                session.reanchor(tie.since, tie.anchor, &tie.anchor_from_waypoint);
                if let Some(edge) = &tie.edge {
                    news = self.loop_from_visit(edge, session);
                }
            }
        }
        let (session, stamp, keyframe) = (asked.session, asked.stamp, asked.keyframe);
        let (keyframe_from_base, information) = (found.keyframe_from_base, found.information);
        news.tied = Some(messages::Reanchored { session, stamp, keyframe, keyframe_from_base, information });
        news
    }

    /// A loop between two keyframes that was seen from a visit, not from one of them.
    fn loop_from_visit(&mut self, verified: &VerifiedPair, session: &mut Session) -> LoopEvents {
        let edge = verified.edge;
        let pair = (edge.from, edge.to);
        let refused =
            self.looked_at.get(&pair).is_some_and(|known| known.verdict == Some(LoopVerdict::Rejected));
        if refused || self.optimiser.has(pair) || edge.from.0.abs_diff(edge.to.0) <= 1 {
            return LoopEvents::default();
        }
        let (source, guess) = (messages::LoopSource::Geometry, pose_from_isometry(&edge.from_from_to));
        let asked = LoopTask { session: self.session, from: edge.from, to: edge.to, source, guess };
        let evidence = plain::evidence_to_plain(&verified.evidence);
        self.looked_at.insert(pair, LookedAt { asked, edge, evidence, verdict: None });
        self.evaluate(verified, session)
    }

    /// Judges a pair that was compared; what is accepted moves the map.
    fn evaluate(&mut self, verified: &VerifiedPair, session: &mut Session) -> LoopEvents {
        let mut news = LoopEvents::default();
        for decision in self.finder.evaluate(verified) {
            let Decision { edge, verdict, .. } = decision;
            let pair = (edge.from, edge.to);
            if self.optimiser.has(pair) {
                continue;
            }
            if verdict == Verdict::Accepted {
                if let Err(error) = self.optimiser.add_loop(&edge) {
                    return self.give_up(&error);
                }
                session.add_loop(edge);
                news.changed = true;
            }
            let reason = words::reason(&decision, &self.finder.config().gates);
            self.decide(pair, plain::verdict_to_plain(verdict), false, reason, &mut news);
        }
        self.move_map(session, news)
    }

    /// A person says that a pair is a loop.
    pub fn accept(
        &mut self,
        from: KeyframeId,
        to: KeyframeId,
        session: &mut Session,
    ) -> Result<LoopEvents, String> {
        let pair = ordered(from, to);
        let named = names(pair);
        if let Some(reason) = &self.broken {
            return Err(reason.clone());
        }
        if self.optimiser.has(pair) {
            return Err(format!("{named} are a loop already."));
        }
        let edge = match self.looked_at.get(&pair) {
            None => {
                return Err(format!("{named} have not been compared yet. Propose them as a loop first."));
            }
            Some(known) if known.edge.information == Matrix6::zeros() => {
                let text = "could not be fitted together. Propose them again with a better guess";
                return Err(format!("{named} {text}."));
            }
            Some(known) => known.edge,
        };
        if !self.finder.accept(&edge) {
            return Err(unknown(pair));
        }
        if let Err(error) = self.optimiser.add_loop(&edge) {
            return Ok(self.give_up(&error));
        }
        session.add_loop(edge);
        let mut news = LoopEvents { changed: true, ..LoopEvents::default() };
        self.decide(pair, LoopVerdict::Accepted, true, "A person accepted it.".to_owned(), &mut news);
        Ok(self.move_map(session, news))
    }

    /// A person says that a pair is no loop.
    pub fn reject(
        &mut self,
        from: KeyframeId,
        to: KeyframeId,
        session: &mut Session,
    ) -> Result<LoopEvents, String> {
        let pair = ordered(from, to);
        let held = self.looked_at.get(&pair).is_some_and(|known| known.verdict == Some(LoopVerdict::Held));
        let closed = self.optimiser.remove_loop(pair);
        if !closed && !held {
            return Err(format!("{} are no loop, so there is nothing to reject.", names(pair)));
        }
        while self.finder.remove_loop(pair.0, pair.1) {}
        // The robot's place may have rested on it.
        if let (Some((anchor, pose)), Some((now, _))) = (self.finder.position(), session.trajectory().last())
        {
            session.reanchor(*now, anchor, &pose);
        }
        let mut news = LoopEvents { changed: session.remove_loop(pair.0, pair.1), ..LoopEvents::default() };
        self.decide(pair, LoopVerdict::Rejected, true, "A person rejected it.".to_owned(), &mut news);
        Ok(self.move_map(session, news))
    }

    /// A person points at a pair, with a guess of `to` in `from`: it is looked at before all others.
    pub fn propose(&mut self, from: KeyframeId, to: KeyframeId, guess: &Pose) -> Result<(), String> {
        let pair = ordered(from, to);
        if let Some(reason) = &self.broken {
            return Err(reason.clone());
        }
        if self.optimiser.has(pair) {
            return Err(format!("{} are a loop already. Reject it first.", names(pair)));
        }
        if from.0.abs_diff(to.0) <= 1 {
            return Err("Choose two keyframes that do not follow each other on the walk.".to_owned());
        }
        let Some(guess) = isometry_from_pose(guess) else {
            return Err("That guess is not a pose. Place the keyframe again.".to_owned());
        };
        let guess = if pair == (from, to) { guess } else { guess.inverse() };
        let task: VerificationTask =
            self.finder.propose(pair.0, pair.1, guess).ok_or_else(|| unknown(pair))?;
        self.ask(task);
        Ok(())
    }

    /// How good the session's map is.
    pub fn quality(&mut self, session: &Session) -> MapQuality {
        let poses: Vec<Isometry> = session.nodes().iter().map(|node| node.map_from_keyframe).collect();
        plain::quality_to_plain(self.finder.quality(&poses))
    }

    /// Whether pairs are being looked at or wait for it.
    pub fn is_looking(&self) -> bool {
        self.broken.is_none() && !self.queue.is_empty()
    }

    /// The session ends: nothing more is looked at, and the poses are made as good as the graph allows.
    pub fn finish(&mut self, session: &mut Session) -> LoopEvents {
        self.queue.clear();
        if session.loops().is_empty() || self.broken.is_some() {
            return LoopEvents::default();
        }
        let settled = self.optimiser.settle();
        self.put(settled, session, LoopEvents::default())
    }

    /// Everything decided, in order.
    pub fn decisions(&self) -> &[LoopDecision] {
        &self.decisions
    }

    /// Pairs that there was no time to look at.
    pub fn left_out(&self) -> u64 {
        self.queue.left_out()
    }

    /// Walks over known ground.
    pub fn visits(&self) -> RevisitCounts {
        self.visits
    }

    /// Brings the poses up to date if edges changed.
    fn move_map(&mut self, session: &mut Session, news: LoopEvents) -> LoopEvents {
        if !news.changed {
            return news;
        }
        let solved = self.optimiser.solve();
        self.put(solved, session, news)
    }

    fn put(
        &mut self,
        solved: Result<Vec<Isometry>, GraphError>,
        session: &mut Session,
        news: LoopEvents,
    ) -> LoopEvents {
        match solved {
            Ok(poses) => {
                session.move_keyframes(&poses);
                news
            }
            Err(error) => LoopEvents { trouble: self.give_up(&error).trouble, ..news },
        }
    }

    fn decide(
        &mut self,
        pair: Pair,
        verdict: LoopVerdict,
        by_hand: bool,
        reason: String,
        news: &mut LoopEvents,
    ) {
        let Some(known) = self.looked_at.get_mut(&pair) else { return };
        known.verdict = Some(verdict);
        let decision = LoopDecision {
            task: known.asked,
            from_from_to: pose_from_isometry(&known.edge.from_from_to),
            evidence: known.evidence,
            verdict,
            by_hand,
            reason,
        };
        self.decisions.push(decision.clone());
        news.decisions.push(decision);
    }

    /// The map stays as it is, and is not corrected any more.
    fn give_up(&mut self, error: &GraphError) -> LoopEvents {
        let text = format!(
            "Loops of this map are not closed any more, because its graph cannot be solved: {error}. Save it and begin another."
        );
        self.queue.clear();
        self.broken = Some(text.clone());
        LoopEvents { trouble: Some(text), changed: true, ..LoopEvents::default() }
    }
}

/// What a waypoint is.
pub(crate) enum Arrived {
    /// A keyframe, with the edge that leads to it.
    Keyframe(Option<Edge>),
    /// A visit to known ground.
    Revisit,
    /// Somewhere in the saved map that the session goes on from; its number.
    Lost(u64),
}

/// Older keyframe first.
fn ordered(a: KeyframeId, b: KeyframeId) -> Pair {
    if a.0 <= b.0 { (a, b) } else { (b, a) }
}

fn names((from, to): Pair) -> String {
    format!("Keyframes {} and {}", from.0, to.0)
}

fn unknown(pair: Pair) -> String {
    format!("{} are not both on this map. Choose two that are.", names(pair))
}
