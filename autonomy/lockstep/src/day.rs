//! A simulated robot that an operator drives in sight, and the map of a first day. Several tests share them.

use crate::Lockstep;
use geometry::{Vector3, vec_from_plain};
use messages::{
    Command, CommandKind, FinishedMap, GoalKind, GoalStatus, Input, Job, JobId, LocalisationState,
    MappingState, MotionState, PoseGraph, PoseInMap, Principal, PriorMap, Publication, RelocalisationTask,
    StackEffect,
};
use sim::{RouteFollower, SimConfig, SimulatedSite, SiteName, SiteRoute, Start};
use site_model::{MissionStatus, RouteStatus};
use std::sync::{Arc, OnceLock};
use uuid::Uuid;
use vocab::{ClientId, CommandId, GoalId, MapId, Pose, SessionId, Span};

/// The map of the first day.
pub(crate) const FIRST: MapId = MapId(Uuid::from_u128(5));

/// A robot driven along routes, and the state that its stack publishes.
pub(crate) struct Day {
    pub(crate) lockstep: Lockstep,
    commands: u128,
    pub(crate) estimate: Pose,
    /// The estimate when each action was called.
    pub(crate) estimates_of_calls: Vec<Pose>,
    pub(crate) graph: Arc<PoseGraph>,
    pub(crate) mapping: MappingState,
    /// Every published state of mapping.
    pub(crate) states: Vec<MappingState>,
    pub(crate) localisation: LocalisationState,
    /// Every published state of localisation.
    pub(crate) localisations: Vec<LocalisationState>,
    pub(crate) docks: Arc<[PoseInMap]>,
    pub(crate) motion: MotionState,
    pub(crate) missions: Arc<MissionStatus>,
    pub(crate) route: Arc<RouteStatus>,
    pub(crate) refusals: Vec<String>,
    pub(crate) notices: Vec<String>,
    /// Outcomes of all goals, in their order.
    pub(crate) outcomes: Vec<GoalStatus>,
    /// What remained of goals, as it was published, metres.
    pub(crate) remaining_m: Vec<f64>,
    /// The newest relocalisation request, with its job.
    pub(crate) asked: Option<(JobId, RelocalisationTask)>,
    pub(crate) finished: Option<Arc<FinishedMap>>,
}

impl Day {
    pub(crate) fn begin(start: Start, seed: u64, session: Option<SessionId>) -> Self {
        Self::among(0, start, seed, session)
    }

    /// With this number of people walking on the site.
    pub(crate) fn among(people: u32, start: Start, seed: u64, session: Option<SessionId>) -> Self {
        Self::on(SiteName::B1, people, start, seed, session)
    }

    /// On any site.
    pub(crate) fn on(
        site: impl Into<Arc<SimulatedSite>>,
        people: u32,
        start: Start,
        seed: u64,
        session: Option<SessionId>,
    ) -> Self {
        let config =
            SimConfig { lidar_columns: 200, people, start: Some(start), ..SimConfig::new(site, seed) };
        Self::of(config, session)
    }

    /// Of any simulation.
    pub(crate) fn of(config: SimConfig, session: Option<SessionId>) -> Self {
        Self {
            lockstep: Lockstep::new(config, session, true),
            commands: 0,
            estimate: Pose::IDENTITY,
            estimates_of_calls: Vec::new(),
            graph: Arc::default(),
            mapping: MappingState::Idle,
            states: Vec::new(),
            localisation: LocalisationState::Idle,
            localisations: Vec::new(),
            docks: Arc::default(),
            motion: MotionState::Idle,
            missions: Arc::default(),
            route: Arc::default(),
            refusals: Vec::new(),
            notices: Vec::new(),
            outcomes: Vec::new(),
            remaining_m: Vec::new(),
            asked: None,
            finished: None,
        }
    }

    pub(crate) fn command(&mut self, kind: CommandKind) {
        self.commands += 1;
        let id = CommandId(Uuid::from_u128(self.commands));
        self.lockstep.give(Input::Command(Command { id, by: self.operator(), kind }));
    }

    /// Who gives the commands.
    pub(crate) fn operator(&self) -> Principal {
        Principal::operator(ClientId(Uuid::from_u128(1)))
    }

    /// Starts a goal with a new id.
    pub(crate) fn start_goal(&mut self, kind: GoalKind) -> GoalId {
        let goal = GoalId(Uuid::from_u128(self.commands + 1));
        self.command(CommandKind::StartGoal { goal, kind });
        goal
    }

    pub(crate) fn run(&mut self, seconds: f64) {
        let until = self.lockstep.now() + Span::from_secs_f64(seconds);
        let Self {
            lockstep,
            estimate,
            estimates_of_calls,
            graph,
            mapping,
            states,
            localisation,
            localisations,
            docks,
            motion,
            missions,
            route,
            refusals,
            notices,
            outcomes,
            remaining_m,
            asked,
            finished,
            ..
        } = self;
        lockstep.advance(until, &mut |_, effect| match effect {
            StackEffect::Publish(Publication::Estimate(now)) => *estimate = now.map_from_base,
            StackEffect::CallAction { .. } => estimates_of_calls.push(*estimate),
            StackEffect::Publish(Publication::Graph { graph: now, .. }) => *graph = Arc::clone(now),
            StackEffect::Publish(Publication::GraphDelta(delta)) => {
                assert!(Arc::make_mut(graph).apply(delta), "the delta belongs to another graph");
            }
            StackEffect::Publish(Publication::Mapping(now)) => {
                *mapping = now.clone();
                states.push(now.clone());
            }
            StackEffect::Publish(Publication::Localisation(now)) => {
                *localisation = *now;
                localisations.push(*now);
            }
            StackEffect::Publish(Publication::Docks(now)) => *docks = Arc::clone(now),
            StackEffect::Publish(Publication::Motion(now)) => *motion = now.clone(),
            StackEffect::Publish(Publication::Missions(now)) => *missions = Arc::clone(now),
            StackEffect::Publish(Publication::Route(now)) => *route = Arc::clone(now),
            StackEffect::StartJob { job, work: Job::Relocalise(task) } => *asked = Some((*job, *task)),
            StackEffect::StartJob { work: Job::SaveMap(map), .. } => *finished = Some(Arc::clone(map)),
            StackEffect::Publish(Publication::Goal(update)) if update.status.is_outcome() => {
                outcomes.push(update.status.clone());
            }
            StackEffect::Publish(Publication::Goal(update)) => {
                if let GoalStatus::Running(progress) = &update.status {
                    remaining_m.extend(progress.remaining_m);
                }
            }
            StackEffect::Publish(Publication::Notice(notice)) => notices.push(notice.text.clone()),
            StackEffect::Answer { refused: Some(reason), .. } => refusals.push(reason.clone()),
            _ => {}
        });
    }

    /// Drives like an operator who sees the robot.
    pub(crate) fn drive(&mut self, start: Start, waypoints: &[[f64; 2]]) {
        let route = SiteRoute { name: "day", start, waypoints: waypoints.to_vec(), speed: 0.9 };
        let mut walker = RouteFollower::new(route);
        while let Some(drive) = walker.drive(&self.lockstep.simulator().truth()) {
            if drive.velocity != vocab::Twist::default() {
                self.command(CommandKind::Teleoperate(drive.velocity));
            }
            self.run(0.1);
        }
    }

    pub(crate) fn finish(&mut self, map: MapId) -> Arc<FinishedMap> {
        self.command(CommandKind::FinishMapping { map, name: "Hall".to_owned() });
        for _ in 0..200 {
            self.run(0.1);
            if self.mapping == MappingState::Idle {
                break;
            }
        }
        assert_eq!(self.refusals, [""; 0]);
        self.finished.take().unwrap_or_else(|| panic!("not saved: {:?}", self.mapping))
    }

    pub(crate) fn true_position(&mut self) -> Vector3 {
        vec_from_plain(self.lockstep.simulator().truth().site_from_base.position)
    }

    /// Error of the estimate in the frame of a map that began at `origin` with the site's heading, metres.
    pub(crate) fn error(&mut self, origin: &Vector3) -> f64 {
        (self.true_position() - origin - vec_from_plain(self.estimate.position)).norm()
    }
}

/// The map of the short route through the main hall, what was saved, and its origin in the site.
pub(crate) fn first() -> &'static (Arc<PriorMap>, Arc<FinishedMap>, Vector3) {
    static FIRST_DAY: OnceLock<(Arc<PriorMap>, Arc<FinishedMap>, Vector3)> = OnceLock::new();
    FIRST_DAY.get_or_init(|| {
        let Some(route) = SimulatedSite::new(SiteName::B1).route("short").cloned() else {
            panic!("no such route")
        };
        let mut day = Day::begin(route.start, 3, Some(SessionId(Uuid::from_u128(1))));
        day.run(1.0);
        let origin = day.true_position();
        day.drive(route.start, &route.waypoints);
        let finished = day.finish(FIRST);
        let Some(prior_map) = day.lockstep.map(FIRST).cloned() else { panic!("the map was not kept") };
        (prior_map, finished, origin)
    })
}
