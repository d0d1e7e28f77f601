//! Missions in the stack: the site as the ledger has it, the runner that decides, and the executor that follows routes. `wiring.rs` connects them with the
//! executive, the ledger and clients.

mod action_calls;
mod conversions;
mod ledger_events;
mod open_call;
mod status;
mod wiring;

use messages::{BatteryState, CancelCause, GoalUpdate, Principal, RegisteredAction, Role, SiteSnapshot};
use missions::{
    ActionInfo, GraphLocaliser, GraphLocaliserConfig, GraphPlace, MissionInput, MissionRunner, Records,
    RouteExecutor, RouteExecutorConfig, RunnerConfig, Situation,
};
use open_call::OpenCall;
use site_model::{DockId, Edit, MissionEvent, MissionStatus, RouteStatus, RunId, RunState, Site};
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use uuid::Uuid;
use vocab::{ActionCallId, ClientId, CommandId, GoalId, Pose, Span, Stamp};

/// Parameters of [`MissionPhase`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MissionConfig {
    /// Time between two looks at where the robot is on the graph. It walks 0.2 m in it.
    pub place_period: Span,
    /// Distance from the node of a dock within which a robot that is charged is in that dock, metres. More than the error of localisation, less than the
    /// distance of two docks side by side.
    pub dock_distance_m: f64,
    /// Distance of a docked robot from the node of its dock from which on people are told that the dock was moved, metres. Twice the error of localisation.
    pub dock_moved_m: f64,
    /// The same for its heading, radians.
    pub dock_turned_rad: f64,
    /// How far beyond the reach of the camera's head the body turns, radians. More than the tolerance of a pose, so that the target is within reach afterwards.
    pub turn_margin_rad: f64,
    /// Turns of the body for one call, before it has failed.
    pub turns_max: u32,
    /// Commands whose answers wait until their events are durable. The oldest is forgotten beyond this; its client sends it again.
    pub waiting_max: usize,
}

impl Default for MissionConfig {
    fn default() -> Self {
        Self {
            place_period: Span::from_millis(200),
            dock_distance_m: 0.5,
            dock_moved_m: 0.1,
            dock_turned_rad: 0.1,
            turn_margin_rad: 0.1,
            turns_max: 2,
            waiting_max: 256,
        }
    }
}

/// The site, runs and routes.
#[derive(Debug)]
pub(crate) struct MissionPhase {
    config: MissionConfig,
    /// None before the site is known.
    runner: Option<MissionRunner>,
    /// What follows from the events up to the one that is written: the runner is ahead of it by the events of one update.
    written: Records,
    /// Events of earlier programs, until the runner is made.
    restored: Vec<MissionEvent>,
    /// Registered actions, until the runner is made.
    actions: BTreeMap<String, ActionInfo>,
    site: Arc<Site>,
    executor: RouteExecutor,
    localiser: GraphLocaliser,
    /// Commits of the stack and of the runner, by their numbers, that are not durable yet.
    commits: VecDeque<(u64, u64)>,
    /// Actions that were called and have not ended.
    calls: BTreeMap<ActionCallId, OpenCall>,
    /// Commands that wait for their answer.
    waiting: BTreeMap<CommandId, ClientId>,
    /// The goal on the topological map that is under way, as it is published.
    goal: Option<GoalUpdate>,
    /// Who has ended a goal last, and how.
    cancelled: Option<(Principal, CancelCause)>,
    /// Inputs of the runner that follow from its own effects.
    pending: VecDeque<MissionInput>,
    /// The run of which people were told last that it waits.
    told_waiting: Option<RunId>,
    /// Whether what is published may have changed.
    is_changed: bool,
    battery: Option<BatteryState>,
    situation: Situation,
    map_from_base: Option<Pose>,
    looked_at: Option<Stamp>,
    published: Option<Arc<MissionStatus>>,
    published_route: Option<Arc<RouteStatus>>,
}

impl Default for MissionPhase {
    fn default() -> Self {
        Self {
            config: MissionConfig::default(),
            runner: None,
            written: Records::default(),
            restored: Vec::new(),
            actions: BTreeMap::new(),
            site: Arc::default(),
            executor: RouteExecutor::new(RouteExecutorConfig::default()),
            localiser: GraphLocaliser::new(GraphLocaliserConfig::default()),
            commits: VecDeque::new(),
            calls: BTreeMap::new(),
            waiting: BTreeMap::new(),
            goal: None,
            cancelled: None,
            pending: VecDeque::new(),
            told_waiting: None,
            is_changed: true,
            battery: None,
            situation: Situation::default(),
            map_from_base: None,
            looked_at: None,
            published: None,
            published_route: None,
        }
    }
}

/// In whose name the platform itself asks for goals.
pub(crate) fn platform() -> Principal {
    Principal { client: ClientId(Uuid::nil()), account: None, role: Role::Operator }
}

impl MissionPhase {
    /// Takes the whole site in. The first one makes the runner.
    fn take_site(&mut self, snapshot: SiteSnapshot) -> Arc<Site> {
        self.site = Arc::new(Site::new(snapshot.objects, snapshot.removed));
        if self.runner.is_none() {
            let restored = std::mem::take(&mut self.restored);
            self.written = Records::from_events(&restored);
            self.runner = Some(MissionRunner::restore(RunnerConfig::default(), &restored));
            self.pending.push_back(MissionInput::Actions(std::mem::take(&mut self.actions)));
        }
        Arc::clone(&self.site)
    }

    /// Takes an edit in. An edit that does not apply changes nothing: the whole site follows then.
    fn take_edit(&mut self, edit: &Edit) -> Option<Arc<Site>> {
        Arc::make_mut(&mut self.site).apply(edit, edit.id).ok()?;
        Some(Arc::clone(&self.site))
    }

    /// The dock in which the robot is charged, if it is in one of the site.
    fn docked(&self) -> Option<DockId> {
        let base = self.map_from_base.filter(|_| self.battery.is_some_and(|battery| battery.charging))?;
        let distance_m = |pose: &Pose| {
            let (x, y) = (pose.position.x - base.position.x, pose.position.y - base.position.y);
            x.hypot(y)
        };
        let near = self.site.docks().filter_map(|dock| {
            let distance_m = distance_m(&self.site.node(dock.node)?.map_from_node);
            (distance_m <= self.config.dock_distance_m).then_some((distance_m, dock.id))
        });
        near.min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, dock)| dock)
    }

    /// The run that would begin or go on now if the robot were localised.
    fn waiting_run(&self) -> Option<RunId> {
        let records = self.runner.as_ref()?.records();
        match records.active() {
            Some(run) => (run.state == RunState::Restarted).then_some(run.id),
            None => records.queue().first().copied(),
        }
    }

    /// Whether the goal is one of the runner's.
    fn is_of_runner(&self, goal: GoalId) -> bool {
        self.goal.as_ref().is_none_or(|known| known.id != goal || known.by == platform())
    }

    /// Whether the answer to this command waits.
    pub fn is_waiting(&self, command: CommandId) -> bool {
        self.waiting.contains_key(&command)
    }

    /// The goal by which the body turns now.
    fn turn(&self) -> Option<GoalId> {
        self.calls.values().find_map(|open| open.turn)
    }

    fn place(&self) -> GraphPlace {
        self.situation.place
    }
}

fn action_info(actions: Vec<RegisteredAction>) -> BTreeMap<String, ActionInfo> {
    let info = |action: RegisteredAction| {
        let RegisteredAction { name, is_idempotent, expected } = action;
        (name, ActionInfo { is_idempotent, expected })
    };
    actions.into_iter().map(info).collect()
}
