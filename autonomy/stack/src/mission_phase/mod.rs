//! Missions in the stack: the site as the ledger has it, the runner that decides, and the executor that follows routes. `wiring.rs` connects them with the
//! executive, the ledger and clients.

mod action_calls;
mod conversions;
mod ledger_events;
mod open_call;
mod route_goals;
mod status;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod wiring;

pub(crate) use conversions::goal_request;

use crate::waiting_answers::WaitingAnswers;
use messages::{BatteryState, Principal, RegisteredAction, Role, SiteSnapshot};
use missions::{
    ActionInfo, DockConfig, GraphLocaliser, GraphLocaliserConfig, GraphPlace, MissionInput, MissionRunner,
    MissionSituation, Records, RouteExecutor, RouteExecutorConfig, RunnerConfig, docked_at,
};
use navigation::ElevationMapConfig;
use open_call::OpenCall;
use site_model::{DockId, Edit, MissionEvent, MissionStatus, RouteStatus, RunId, RunState, Site};
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use uuid::Uuid;
use vocab::{ActionCallId, ClientId, CommandId, Pose, Span, Stamp};

/// Parameters of [`MissionPhase`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MissionConfig {
    /// Time between two looks at where the robot is on the graph. It walks 0.2 m in it. Chosen: four steps of control; the search costs time in proportion to the nodes.
    pub place_period: Span,
    /// When a robot is in a dock, and when that dock was moved.
    pub docks: DockConfig,
    /// How far beyond the reach of the camera's head the body turns, radians. More than the tolerance of a pose, so that the target is within reach afterwards. Chosen: 6
    /// degrees.
    pub turn_margin_rad: f64,
    /// Turns of the body for one call, before it has failed. Chosen: a turn ends within the tolerance of a pose, so that the second one is a reserve.
    pub max_turns: u32,
}

impl Default for MissionConfig {
    fn default() -> Self {
        Self {
            place_period: Span::from_millis(200),
            docks: DockConfig::default(),
            turn_margin_rad: 0.1,
            max_turns: 2,
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
    /// Commands that wait until the runner answers them.
    waiting: WaitingAnswers<()>,
    /// Inputs of the runner that follow from its own effects.
    pending: VecDeque<MissionInput>,
    /// The run of which people were told last that it waits.
    reported_waiting_run: Option<RunId>,
    /// Whether what is published may have changed.
    is_changed: bool,
    battery: Option<BatteryState>,
    situation: MissionSituation,
    map_from_base: Option<Pose>,
    looked_at: Option<Stamp>,
    published: Option<Arc<MissionStatus>>,
    published_route: Option<Arc<RouteStatus>>,
}

impl Default for MissionPhase {
    fn default() -> Self {
        let floor_separation_m = ElevationMapConfig::default().floor_separation_m;
        Self {
            config: MissionConfig::default(),
            runner: None,
            written: Records::default(),
            restored: Vec::new(),
            actions: BTreeMap::new(),
            site: Arc::default(),
            executor: RouteExecutor::new(RouteExecutorConfig::default()),
            localiser: GraphLocaliser::new(GraphLocaliserConfig::new(floor_separation_m.into())),
            commits: VecDeque::new(),
            calls: BTreeMap::new(),
            waiting: WaitingAnswers::default(),
            pending: VecDeque::new(),
            reported_waiting_run: None,
            is_changed: true,
            battery: None,
            situation: MissionSituation::default(),
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
    /// Sets the whole site. The first one makes the runner.
    fn set_site(&mut self, snapshot: SiteSnapshot) -> Arc<Site> {
        self.site = Arc::new(Site::new(snapshot.objects, snapshot.removed));
        if self.runner.is_none() {
            let restored = std::mem::take(&mut self.restored);
            self.written = Records::from_events(&restored);
            self.runner = Some(MissionRunner::restore(RunnerConfig::default(), &restored));
            self.pending.push_back(MissionInput::Actions(std::mem::take(&mut self.actions)));
        }
        Arc::clone(&self.site)
    }

    /// Applies an edit. An edit that does not apply changes nothing: the whole site follows then.
    fn apply_edit(&mut self, edit: &Edit) -> Option<Arc<Site>> {
        Arc::make_mut(&mut self.site).apply(edit, edit.id).ok()?;
        Some(Arc::clone(&self.site))
    }

    /// The dock in which the robot is charged, if it is in one of the site.
    fn docked(&self) -> Option<DockId> {
        let is_charged = self.battery.is_some_and(|battery| battery.charging);
        let map_from_base = self.map_from_base.filter(|_| is_charged)?;
        docked_at(&self.site, &map_from_base, &self.config.docks)
    }

    /// The run that would begin or go on now if the robot were localised.
    fn waiting_run(&self) -> Option<RunId> {
        let records = self.runner.as_ref()?.records();
        match records.active() {
            Some(run) => (run.state == RunState::Restarted).then_some(run.id),
            None => records.queue().first().copied(),
        }
    }

    /// Whether the answer to this command waits.
    pub fn is_waiting(&self, command: CommandId) -> bool {
        self.waiting.contains(command)
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
