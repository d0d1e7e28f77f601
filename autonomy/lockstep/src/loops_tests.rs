//! Loop closure of the whole stack: a walk that returns to its start with drifted odometry.

use crate::{Digest, JobPace, Lockstep, replay};
use geometry::{Vector3, aligned_rmse, isometry_from_pose, vec_from_plain};
use messages::{
    Command, CommandKind, EdgeKind, FinishedMap, Input, Job, JobDone, JobId, JobOwner, JobResult,
    LoopDecision, LoopSource, LoopVerdict, MapQuality, PlaceComparison, PoseGraph, Principal, Publication,
    StackEffect,
};
use sim::{
    GroundTruth, RouteFollower, ScheduledFault, SimConfig, SimulatedSite, Simulator, SiteName, SiteRoute,
};
use stack::Stack;
use std::collections::VecDeque;
use std::sync::{Arc, OnceLock};
use uuid::Uuid;
use vocab::{ClientId, CommandId, KeyframeId, MapId, Pose, SessionId, Span, Stamp, Vec3};

pub(crate) const SESSION: SessionId = SessionId(Uuid::from_u128(1));
const ME: ClientId = ClientId(Uuid::from_u128(1));

/// The inputs of a walk without the results of jobs, and the ground truth.
struct Walk {
    inputs: Vec<(Stamp, Input)>,
    truths: Vec<GroundTruth>,
}

/// From a hall through a door into a room, and back. On the way in, the LiDAR is silent and the legs slip sideways. So the scans in the room
/// share no surface with the scans before.
fn walk() -> &'static Walk {
    static WALK: OnceLock<Walk> = OnceLock::new();
    WALK.get_or_init(|| {
        let site = Arc::new(SimulatedSite::new(SiteName::B1));
        let Some(SiteRoute { start, .. }) = site.route("short").cloned() else { panic!("no such route") };
        let hall = [[18.2, 23.5], [26.0, 22.9], [18.0, 23.0]];
        let room = [[15.4, 21.6], [15.4, 20.0], [12.5, 20.0], [6.5, 20.0], [12.5, 20.0], [15.4, 20.0]];
        let waypoints =
            hall.into_iter().chain(room).chain([[15.4, 21.6]]).chain(hall[..2].to_vec()).collect();
        let route = SiteRoute { name: "room", start, waypoints, speed: 0.9 };
        let (from, until) = (Span::from_secs_f64(29.0), Span::from_secs_f64(44.0));
        let velocity = Vec3::new(0.0, 0.05, 0.0);
        let faults = vec![
            ScheduledFault::SilentLidar { from, until },
            ScheduledFault::LegSlip { from, until, velocity },
        ];
        let config = SimConfig {
            lidar_columns: 200,
            people: 0,
            start: Some(route.start),
            faults,
            ..SimConfig::new(site, 3)
        };
        let mut simulator = Simulator::new(config);
        let mut boot = simulator.boot();
        boot.start_mapping = Some(SESSION);
        let mut walk =
            Walk { inputs: vec![(simulator.now(), Input::Boot(Box::new(boot)))], truths: Vec::new() };
        let (mut walker, mut events) = (RouteFollower::new(route), Vec::new());
        while let Some(drive) = walker.drive(&simulator.truth()) {
            simulator.command(drive);
            simulator.advance(simulator.now() + Span::from_millis(50), &mut events);
            walk.inputs.extend(events.drain(..).map(|event| (event.at, Input::Sensor(event.sensor))));
            walk.inputs.push((simulator.now(), Input::Tick));
            walk.truths.extend(simulator.take_ground_truth());
        }
        walk
    })
}

/// A stack that has processed that walk, with its effects.
pub(crate) struct StackRun {
    pub(crate) stack: Stack,
    pub(crate) log: Vec<(Stamp, Input)>,
    pub(crate) digest: Digest,
    pub(crate) at: Stamp,
    pub(crate) graph: Arc<PoseGraph>,
    pub(crate) decisions: Vec<LoopDecision>,
    answers: Vec<Option<String>>,
    /// The map that the stack asked to save, and in which job.
    pub(crate) finished: Option<Arc<FinishedMap>>,
    pub(crate) saving: Option<JobId>,
    /// Published qualities, and sentences of notices.
    pub(crate) qualities: Vec<MapQuality>,
    pub(crate) notices: Vec<String>,
    /// Results of jobs that the stack has not received yet.
    pub(crate) done: VecDeque<JobDone>,
    commands: u128,
}

impl StackRun {
    fn nothing() -> Self {
        Self {
            stack: Stack::new(),
            log: Vec::new(),
            digest: Digest::default(),
            at: Stamp::EPOCH,
            graph: Arc::default(),
            decisions: Vec::new(),
            answers: Vec::new(),
            finished: None,
            saving: None,
            qualities: Vec::new(),
            notices: Vec::new(),
            done: VecDeque::new(),
            commands: 0,
        }
    }

    /// Steps the stack through the whole walk. Before each tick, `deliver` decides which of the waiting results arrive.
    pub(crate) fn walking(
        leave_open: bool,
        mut deliver: impl FnMut(&mut VecDeque<JobDone>) -> Vec<JobDone>,
    ) -> Self {
        let mut run = Self::nothing();
        for (at, input) in &walk().inputs {
            let mut input = input.clone();
            if let Input::Boot(boot) = &mut input {
                boot.leave_loops_open = leave_open;
            }
            if input == Input::Tick {
                for done in deliver(&mut run.done) {
                    run.step(*at, Input::JobDone(done));
                }
            }
            run.step(*at, input);
        }
        run
    }

    /// Like [`Self::walking`], and delivers all remaining results at the end.
    pub(crate) fn walked(
        leave_open: bool,
        deliver: impl FnMut(&mut VecDeque<JobDone>) -> Vec<JobDone>,
    ) -> Self {
        let mut run = Self::walking(leave_open, deliver);
        run.finish_jobs();
        run
    }

    pub(crate) fn finish_jobs(&mut self) {
        while let Some(done) = self.done.pop_front() {
            self.step(self.at, Input::JobDone(done));
        }
    }

    pub(crate) fn step(&mut self, at: Stamp, input: Input) {
        self.at = at;
        self.log.push((at, input.clone()));
        let mut effects = Vec::new();
        self.stack.step(at, input, &mut effects);
        self.digest.add(at, &effects);
        for effect in effects {
            match effect {
                StackEffect::StartJob { job, work: Job::SaveMap(finished) } => {
                    (self.finished, self.saving) = (Some(finished), Some(job));
                }
                StackEffect::StartJob { job, .. } => {
                    let Some(work) = self.stack.take_compute_job(job) else { panic!("no work for {job:?}") };
                    self.done.push_back(work.run());
                }
                StackEffect::Publish(Publication::Graph { graph, .. }) => self.graph = graph,
                StackEffect::Publish(Publication::GraphDelta(delta)) => {
                    assert!(
                        Arc::make_mut(&mut self.graph).apply(&delta),
                        "the delta belongs to another graph"
                    );
                }
                StackEffect::Publish(Publication::LoopDecided(decision)) => self.decisions.push(decision),
                StackEffect::Publish(Publication::Quality(quality)) => self.qualities.push(quality),
                StackEffect::Publish(Publication::Notice(notice)) => self.notices.push(notice.text),
                StackEffect::Answer { refused, .. } => self.answers.push(refused),
                _ => {}
            }
        }
    }

    pub(crate) fn command(&mut self, kind: CommandKind) -> Option<String> {
        self.commands += 1;
        let id = CommandId(Uuid::from_u128(self.commands));
        self.step(self.at, Input::Command(Command { id, by: Principal::operator(ME), kind }));
        self.answers.last().cloned().flatten()
    }

    fn loops(&self) -> Vec<(KeyframeId, KeyframeId)> {
        let edges = self.graph.edges.iter().filter(|edge| edge.kind == EdgeKind::Loop);
        edges.map(|edge| (edge.from, edge.to)).collect()
    }

    /// Root mean square error of the keyframes, metres.
    fn error(&self) -> f64 {
        let pairs: Vec<(Vector3, Vector3)> = self
            .graph
            .nodes
            .iter()
            .map(|node| (true_position(node.stamp), vec_from_plain(node.map_from_keyframe.position)))
            .collect();
        aligned_rmse(&pairs).unwrap_or(f64::NAN)
    }

    /// Greatest distance of a keyframe from its position in another graph, which must contain all of them, metres.
    fn position_difference_m(&self, other: &PoseGraph) -> f64 {
        let other_position = |stamp: Stamp| {
            let node = other.nodes.iter().find(|node| node.stamp == stamp);
            node.map(|node| node.map_from_keyframe.position).expect("a keyframe of both graphs")
        };
        let nodes = self.graph.nodes.iter();
        nodes
            .map(|node| (node.map_from_keyframe.position, other_position(node.stamp)))
            .map(|(a, b)| (vec_from_plain(a) - vec_from_plain(b)).norm())
            .fold(0.0, f64::max)
    }
}

fn true_position(stamp: Stamp) -> Vector3 {
    let truths = &walk().truths;
    let next = truths.partition_point(|truth| truth.stamp < stamp).clamp(1, truths.len() - 1);
    let (a, b) = (&truths[next - 1], &truths[next]);
    let share = (stamp - a.stamp).secs_f64() / (b.stamp - a.stamp).secs_f64();
    let [a, b] = [a, b].map(|truth| vec_from_plain(truth.site_from_base.position));
    a + (b - a) * share
}

/// Delivers every result at the next tick.
pub(crate) fn promptly(done: &mut VecDeque<JobDone>) -> Vec<JobDone> {
    done.drain(..).collect()
}

fn prompt() -> &'static StackRun {
    static RUN: OnceLock<StackRun> = OnceLock::new();
    RUN.get_or_init(|| StackRun::walked(false, promptly))
}

/// The walk by odometry alone.
fn open() -> &'static StackRun {
    static RUN: OnceLock<StackRun> = OnceLock::new();
    RUN.get_or_init(|| StackRun::walked(true, promptly))
}

#[test]
fn returning_to_the_start_closes_loops_and_reduces_the_map_error() {
    let (open, closed) = (open(), prompt());
    assert!(open.decisions.is_empty() && open.loops().is_empty());
    assert!(open.error() > 0.05, "the odometry should drift: {} m", open.error());
    assert!(!closed.loops().is_empty(), "{:?}", closed.decisions);
    assert!(closed.error() < 0.4 * open.error(), "{} m, and {} m without", closed.error(), open.error());
    for (from, to) in closed.loops() {
        let decision = closed.decisions.iter().rev().find(|d| (d.task.from, d.task.to) == (from, to));
        let Some(decision) = decision else { panic!("{from:?} {to:?} was never decided on") };
        assert_eq!((decision.verdict, decision.by_hand), (LoopVerdict::Accepted, false));
        assert!(decision.reason.ends_with('.') && decision.evidence.overlap[0] > 0.2, "{decision:?}");
    }
}

#[test]
fn a_log_with_loop_results_replays_bit_for_bit_without_running_jobs() {
    let run = prompt();
    let again = replay(run.log.iter().cloned(), &mut Stack::new());
    assert_eq!(again.hex(), run.digest.hex());
    // A changed result of a job must change the digest.
    let mut changed = run.log.clone();
    let result = changed.iter_mut().rev().find_map(|(_, input)| match input {
        Input::JobDone(JobDone {
            result: JobResult::LoopClosing(Ok(PlaceComparison::Loop(found))), ..
        }) => Some(found),
        _ => None,
    });
    let Some(result) = result else { panic!("no loop was verified") };
    result.evidence.residual_m += 1e-15;
    assert_ne!(replay(changed, &mut Stack::new()).hex(), run.digest.hex());
}

#[test]
fn the_whole_graph_is_published_on_request_and_a_replay_of_the_request_too() {
    let mut run = StackRun::walking(true, promptly);
    let published = Arc::clone(&run.graph);
    let whole = |run: &mut StackRun| {
        let mut effects = Vec::new();
        run.stack.step(run.at, Input::GraphRequested, &mut effects);
        run.log.push((run.at, Input::GraphRequested));
        run.digest.add(run.at, &effects);
        match effects.as_slice() {
            [StackEffect::Publish(Publication::Graph { session: SESSION, graph })] => Arc::clone(graph),
            other => panic!("{other:?}"),
        }
    };
    let first = whole(&mut run);
    assert!(first.nodes.len() > 10 && first.revision == published.revision);
    assert_eq!(first.edges, published.edges);
    assert_eq!(whole(&mut run), first, "as often as it is asked for");
    assert_eq!(replay(run.log.iter().cloned(), &mut Stack::new()).hex(), run.digest.hex());

    let mut effects = Vec::new();
    run.command(CommandKind::DiscardMapping);
    run.stack.step(run.at, Input::GraphRequested, &mut effects);
    assert!(effects.is_empty(), "there is no graph any more: {effects:?}");
}

mod nightly {
    use super::*;

    #[test]
    fn loops_are_closed_when_results_arrive_late_and_in_another_order() {
        let mut ticks = 0;
        let run = StackRun::walked(false, |done| {
            // Results arrive up to two seconds late, the newest first.
            ticks += 1;
            if ticks % 40 == 0 { done.drain(..).rev().collect() } else { Vec::new() }
        });
        assert!(run.error() < 0.4 * open().error(), "{} m, and {} m without", run.error(), open().error());
        assert_eq!(replay(run.log.iter().cloned(), &mut Stack::new()).hex(), run.digest.hex());
    }
}

#[test]
fn results_of_a_session_that_has_ended_are_ignored() {
    let mut run = StackRun::walking(false, |_| Vec::new());
    run.done.retain(|done| done.id().owner == JobOwner::LoopClosing);
    let late: Vec<JobDone> = run.done.drain(..).collect();
    assert!((1..=4).contains(&late.len()), "{} jobs at a time", late.len());
    assert_eq!(run.command(CommandKind::DiscardMapping), None);
    assert_eq!(run.command(CommandKind::StartMapping(SessionId(Uuid::from_u128(2)))), None);
    for done in late {
        run.step(run.at, Input::JobDone(done));
    }
    assert!(
        run.decisions.is_empty() && run.done.is_empty(),
        "results of an ended session must not cause decisions or jobs"
    );
    assert_eq!(replay(run.log.iter().cloned(), &mut Stack::new()).hex(), run.digest.hex());
}

pub(crate) fn finish() -> CommandKind {
    CommandKind::FinishMapping { map: MapId(Uuid::from_u128(5)), name: " Hall ".to_owned() }
}

#[test]
fn a_finished_map_waits_for_its_last_loops() {
    let mut run = StackRun::walking(false, |_| Vec::new());
    assert!(!run.done.is_empty());
    assert_eq!(run.command(finish()), None);
    assert!(run.finished.is_none(), "pairs are still being verified");
    for kind in [finish(), CommandKind::DiscardMapping, CommandKind::StartMapping(SESSION)] {
        assert!(run.command(kind.clone()).is_some(), "{kind:?}");
    }
    let nodes = run.graph.nodes.len();
    run.finish_jobs();
    let Some(map) = run.finished.clone() else { panic!("the map is not saved") };
    assert_eq!((map.name.as_str(), map.graph.nodes.len()), ("Hall", nodes));
    assert!(map.graph.edges.iter().any(|edge| edge.kind == EdgeKind::Loop) && !map.decisions.is_empty());
    assert_eq!(replay(run.log.iter().cloned(), &mut Stack::new()).hex(), run.digest.hex());

    // A job that never ends must not prevent the map from being saved.
    let mut run = StackRun::walking(false, |_| Vec::new());
    assert_eq!(run.command(finish()), None);
    let asked = run.at;
    while run.at - asked < Span::from_millis(10_000) {
        assert!(run.finished.is_none());
        run.step(run.at + Span::from_millis(50), Input::Tick);
    }
    assert!(run.finished.is_some_and(|map| map.at == asked));
}

#[test]
fn a_person_rejects_loops_and_accepts_them_again() {
    let mut run = StackRun::walked(false, promptly);
    let loops = run.loops();
    let (closed, by_odometry) = (run.graph.clone(), open().graph.clone());
    for &(from, to) in &loops {
        // The order of the two keyframes does not matter.
        assert_eq!(run.command(CommandKind::RejectLoop { from: to, to: from }), None);
        let Some(last) = run.decisions.last() else { panic!("no decision was published") };
        assert_eq!((last.verdict, last.by_hand, last.task.from), (LoopVerdict::Rejected, true, from));
    }
    assert!(run.loops().is_empty());
    // Where odometry was dead reckoning, relinearisation leaves errors of millimetres.
    assert!(
        run.position_difference_m(&by_odometry) < 5e-3,
        "{} m from the odometry",
        run.position_difference_m(&by_odometry)
    );
    for &(from, to) in &loops {
        assert_eq!(run.command(CommandKind::AcceptLoop { from, to }), None);
    }
    assert_eq!(run.loops(), loops);
    assert!(
        run.position_difference_m(&closed) < 5e-3,
        "{} m from before",
        run.position_difference_m(&closed)
    );
    assert_eq!(replay(run.log.iter().cloned(), &mut Stack::new()).hex(), run.digest.hex());
}

#[test]
fn a_pair_that_a_person_proposes_is_verified() {
    let mut run = StackRun::walked(false, promptly);
    let Some(&(from, to)) = run.loops().last() else { panic!("no loop") };
    let refused = run.command(CommandKind::ProposeLoop { from, to, guess: Pose::IDENTITY });
    assert!(refused.is_some_and(|reason| reason.contains("already")));
    assert_eq!(run.command(CommandKind::RejectLoop { from, to }), None);
    let edge = run.decisions.iter().rev().find(|d| (d.task.from, d.task.to) == (from, to));
    let Some(pose) = edge.and_then(|d| isometry_from_pose(&d.from_from_to)) else { panic!("no edge") };
    // The guess is half a metre wrong and given from the newer keyframe.
    let mut guess = geometry::pose_from_isometry(&pose.inverse());
    guess.position.x += 0.5;
    assert_eq!(run.command(CommandKind::ProposeLoop { from: to, to: from, guess }), None);
    run.finish_jobs();
    let Some(last) = run.decisions.last() else { panic!("the pair was not decided") };
    assert_eq!((last.task.from, last.task.to, last.task.source), (from, to, LoopSource::Person));
    assert_ne!(last.verdict, LoopVerdict::Rejected, "{}", last.reason);
    let found =
        isometry_from_pose(&last.from_from_to).map(|found| (found.inverse() * pose).translation.vector);
    assert!(found.is_some_and(|error| error.norm() < 0.03), "{found:?}");
}

#[test]
fn invalid_loop_commands_are_refused_with_a_reason() {
    let mut run = StackRun::nothing();
    let (id, no) = (KeyframeId, Pose { position: Vec3::new(f64::NAN, 0.0, 0.0), ..Pose::IDENTITY });
    run.step(Stamp::EPOCH, walk().inputs[0].1.clone());
    run.command(CommandKind::DiscardMapping);
    let refused = run.command(CommandKind::AcceptLoop { from: id(0), to: id(9) });
    assert!(refused.is_some_and(|reason| reason.contains("Start mapping")));

    let mut run = StackRun::walked(false, promptly);
    for (kind, reason) in [
        (CommandKind::AcceptLoop { from: id(0), to: id(5) }, "Propose them"),
        (CommandKind::RejectLoop { from: id(0), to: id(5) }, "nothing to reject"),
        (CommandKind::ProposeLoop { from: id(0), to: id(1), guess: Pose::IDENTITY }, "follow each other"),
        (
            CommandKind::ProposeLoop { from: id(0), to: id(4_000), guess: Pose::IDENTITY },
            "not both on this map",
        ),
        (CommandKind::ProposeLoop { from: id(0), to: id(9), guess: no }, "not a pose"),
    ] {
        let refused = run.command(kind.clone());
        assert!(refused.as_ref().is_some_and(|said| said.contains(reason)), "{kind:?}: {refused:?}");
    }
}

#[test]
fn the_simulated_robot_closes_loops_while_it_walks() {
    let site = Arc::new(SimulatedSite::new(SiteName::B1));
    let Some(route) = site.route("short").cloned() else { panic!("no such route") };
    let config = SimConfig {
        lidar_columns: 100,
        people: 0,
        start: Some(route.start),
        ..SimConfig::new(SiteName::B1, 5)
    };
    let mut lockstep = Lockstep::new(config, Some(SESSION), true);
    lockstep.pace_jobs(JobPace { ticks: 3, newest_first: true });
    let (mut walker, mut accepted) = (RouteFollower::new(route), 0);
    while let Some(drive) = walker.drive(&lockstep.simulator().truth()) {
        lockstep.simulator().command(drive);
        let until = lockstep.now() + Span::from_millis(50);
        lockstep.advance(until, &mut |_, effect| {
            let StackEffect::Publish(Publication::LoopDecided(decision)) = effect else { return };
            accepted += u32::from(decision.verdict == LoopVerdict::Accepted);
        });
    }
    assert!(accepted > 0);
    let log = lockstep.log().to_vec();
    assert_eq!(replay(log, &mut Stack::new()).hex(), lockstep.digest().hex());
}
