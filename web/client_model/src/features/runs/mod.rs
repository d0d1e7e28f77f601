//! Runs of missions: those under way and in the queue, how far they are, those that ended, and what the operator asks of them.

mod estimate;
mod policy;
mod result_file;
mod stored;

pub use estimate::{RunEstimate, estimate_run};
pub use result_file::ResultFileKind;
pub use stored::{
    RunContent, RunQuery, StoredAttempt, StoredPage, StoredResult, StoredResultDetails, StoredRun,
    StoredSlot, StoredSlotDetails,
};

use super::Feature;
use super::site::SiteFeature;
use crate::shared::{Context, SliceChange};
use crate::{ClientCommand, ClientEffect, ClientEvent, ClientTime};
use api::Command;
use policy::RoutePolicy;
use site_model::{
    InspectionPointId, LocalDateTime, MissionCommandKind, MissionStatus, NodeId, RouteStatus, RunCause,
    RunId, RunState, RunStatus, ScheduleId, Site, SkipReason, StartMode, Utc,
};
use std::collections::BTreeMap;
use vocab::Stamp;

/// Parameters of the runs that are kept.
struct RunsConfig {
    /// Ended runs that are kept with their tasks at most. Chosen: as many as the robot remembers; older ones are fetched again.
    max_kept: usize,
    /// Time between two fetches of the slots that were decided, seconds. Nothing is sent when a slot is skipped. Chosen: schedules go by minutes.
    slot_period_s: f64,
}

const CONFIG: RunsConfig = RunsConfig { max_kept: 64, slot_period_s: 60.0 };

/// What came before a result: the result before it at the same inspection point if there is one, or a sentence that says why it could not be fetched.
type Previous = Result<Option<StoredResult>, String>;

/// Runs as the robot last reported them.
#[derive(Clone, Debug, Default)]
pub struct Runs {
    status: Option<MissionStatus>,
    route: RouteStatus,
    policy: RoutePolicy,
    /// The last report of each run that this client has seen, also of those that ended since.
    seen: BTreeMap<RunId, RunStatus>,
    /// What became of slots of schedules. A slot that this client was not told of is missing.
    slots: BTreeMap<(ScheduleId, LocalDateTime), RunState>,
    /// Which of the stored runs are listed.
    query: RunQuery,
    /// The runs that the robot has stored and that are listed, the newest first; none before they were fetched.
    stored: Option<Vec<StoredRun>>,
    /// Where older ones begin, if there are any.
    older: Option<String>,
    /// Why they could not be fetched.
    list_problem: Option<String>,
    /// Slots of schedules that were decided, those due last first.
    decided: Vec<StoredSlot>,
    slots_fetched: Option<ClientTime>,
    /// Earlier results at inspection points, by the point and the number of the later one.
    previous: BTreeMap<(InspectionPointId, u64), Previous>,
    /// What is stored of runs that were opened, or a sentence that says why it could not be fetched.
    contents: BTreeMap<RunId, Result<RunContent, String>>,
}

/// A run that has ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PastRun<'a> {
    /// The run.
    pub run: RunId,
    /// Its mission.
    pub mission: site_model::MissionId,
    /// Its outcome.
    pub outcome: RunState,
    /// Its last report, if this client has seen one.
    pub report: Option<&'a RunStatus>,
    /// What led to it, if that is known.
    pub cause: Option<&'a RunCause>,
    /// When it began or was asked for, if that is known.
    pub began: Option<Utc>,
    /// When it ended, if that is known.
    pub ended: Option<Utc>,
}

impl Runs {
    /// State of all missions; `None` before the robot has reported it.
    pub fn status(&self) -> Option<&MissionStatus> {
        self.status.as_ref()
    }

    /// The run under way, or else the one that waits to go on.
    pub fn current(&self) -> Option<&RunStatus> {
        self.status.as_ref()?.runs.iter().find(|run| run.state != RunState::Queued)
    }

    /// Runs that wait for their turn.
    pub fn queue(&self) -> impl Iterator<Item = &RunStatus> {
        let runs = self.status.iter().flat_map(|status| &status.runs);
        runs.filter(|run| run.state == RunState::Queued)
    }

    /// Where the robot is on the topological map, and its route.
    pub fn route(&self) -> &RouteStatus {
        &self.route
    }

    /// From each node from which the robot would get there, the step to the next node on the cheapest route to where it goes; none without a route.
    pub fn policy(&self) -> &[[NodeId; 2]] {
        self.policy.steps()
    }

    /// Follows site and route.
    pub(crate) fn update(&mut self, site: &SiteFeature, now: Option<Stamp>) {
        self.policy.update(site, self.route.route.as_ref(), now);
    }

    /// The nodes of the route that the robot follows, from the beginning of its present edge on; none without a route. It ends before an edge that the site has not.
    pub fn route_nodes(&self, site: &Site) -> Vec<NodeId> {
        let edges = self.route.route.iter().flat_map(|route| &route.edges);
        let mut edges = edges.map_while(|edge| site.edge(*edge)).peekable();
        let first = edges.peek().map(|edge| edge.from);
        first.into_iter().chain(edges.map(|edge| edge.to)).collect()
    }

    /// Runs that have ended, the newest first: those that ended a moment ago, then those that the robot has listed.
    pub fn past(&self) -> impl Iterator<Item = PastRun<'_>> {
        let is_listed =
            |run: RunId| self.stored.iter().flatten().any(|stored| stored.run == run && stored.is_ended);
        let lately = self.status.iter().flat_map(|status| status.ended.iter().rev());
        let lately = lately.filter(|ended| self.query.has_new(ended.mission, ended.outcome));
        let unlisted = lately.filter(move |ended| !is_listed(ended.run)).map(|ended| {
            let report = self.seen.get(&ended.run);
            PastRun {
                run: ended.run,
                mission: ended.mission,
                outcome: ended.outcome,
                report,
                cause: report.map(|report| &report.cause),
                began: report.and_then(|report| report.began),
                ended: None,
            }
        });
        let listed = self.stored.iter().flatten().filter(|stored| stored.is_ended).map(|stored| PastRun {
            run: stored.run,
            mission: stored.mission,
            outcome: stored.state,
            report: self.seen.get(&stored.run),
            cause: stored.details.as_ref().map(|details| &details.cause),
            began: stored.details.as_ref().and_then(|details| details.began).or(Some(stored.asked)),
            ended: Some(stored.changed),
        });
        unlisted.chain(listed)
    }

    /// Which of the stored runs are listed.
    pub fn query(&self) -> RunQuery {
        self.query
    }

    /// Whether the list is complete: false while it is fetched.
    pub fn is_listed(&self) -> bool {
        self.stored.is_some() || self.list_problem.is_some()
    }

    /// Whether there are older runs than those that are listed.
    pub fn has_older(&self) -> bool {
        self.older.is_some()
    }

    /// Why the stored runs could not be fetched.
    pub fn list_problem(&self) -> Option<&str> {
        self.list_problem.as_deref()
    }

    /// Slots of schedules that were decided, those due last first.
    pub fn decided_slots(&self) -> &[StoredSlot] {
        &self.decided
    }

    /// Why a slot of a schedule was skipped. `None` if it has a run, or this client does not know.
    pub fn skipped_slot(&self, schedule: ScheduleId, slot: LocalDateTime) -> Option<SkipReason> {
        let is_it = |decided: &&StoredSlot| decided.schedule == schedule && decided.slot() == Some(slot);
        self.decided.iter().find(is_it)?.skipped()
    }

    /// The result before another one at the same inspection point; `None` before it was fetched.
    pub fn previous(&self, point: InspectionPointId, before: u64) -> Option<&Previous> {
        self.previous.get(&(point, before))
    }

    /// What is stored of a run, or a sentence that says why it could not be fetched; `None` before it was.
    pub fn content(&self, run: RunId) -> Option<&Result<RunContent, String>> {
        self.contents.get(&run)
    }

    fn list(&mut self, query: RunQuery, cx: &mut Context<'_>) {
        self.query = query;
        (self.stored, self.older, self.list_problem) = (None, None, None);
        cx.effects.push(ClientEffect::FetchRuns { query, before: None });
    }

    fn on_listed(&mut self, before: Option<&str>, page: &StoredPage<StoredRun>) {
        for run in &page.items {
            if let Some(RunCause::Schedule { schedule, slot }) = run.details.as_ref().map(|it| &it.cause) {
                self.slots.insert((*schedule, *slot), run.state);
            }
        }
        match (&mut self.stored, before) {
            (Some(stored), Some(before)) if self.older.as_deref() == Some(before) => {
                stored.extend(page.items.iter().cloned());
            }
            (_, Some(_)) => return,
            (stored, None) => *stored = Some(page.items.clone()),
        }
        self.older = page.next.clone();
        self.list_problem = None;
    }

    /// What became of a slot of a schedule: the state of its run. `None` if this client has not seen it.
    pub fn slot(&self, schedule: ScheduleId, slot: LocalDateTime) -> Option<RunState> {
        self.slots.get(&(schedule, slot)).copied()
    }

    fn on_status(&mut self, status: &MissionStatus, cx: &mut Context<'_>) {
        let last = |status: &MissionStatus| status.ended.last().map(|ended| ended.run);
        if self.status.as_ref().is_none_or(|known| last(known) != last(status)) {
            cx.effects.push(ClientEffect::FetchRuns { query: self.query, before: None });
            self.fetch_slots(cx);
        }
        let current = status.runs.iter().find(|run| run.state != RunState::Queued);
        if let Some(run) = current
            && self.current().is_none_or(|known| known.run != run.run)
        {
            // From here on each result is told; what was stored before is fetched.
            cx.effects.push(ClientEffect::FetchRun(run.run));
        }
        for run in &status.runs {
            self.seen.insert(run.run, run.clone());
            self.note_slot(run.run, run.state);
        }
        for ended in &status.ended {
            self.note_slot(ended.run, ended.outcome);
        }
        let is_listed = |run: &RunId| {
            status.runs.iter().any(|it| it.run == *run) || status.ended.iter().any(|it| it.run == *run)
        };
        if self.seen.len() > CONFIG.max_kept {
            self.seen.retain(|run, _| is_listed(run));
        }
        self.status = Some(status.clone());
    }

    /// A result was stored. That of a run whose content this client shows is fetched with its attempt.
    fn on_result(&mut self, result: &api::StoredResult, cx: &mut Context<'_>) {
        let is_known = match self.contents.get(&result.run) {
            Some(Ok(content)) => content.results.iter().any(|known| known.number >= result.number),
            Some(Err(_)) => false,
            None => self.current().is_none_or(|run| run.run != result.run),
        };
        if !is_known {
            cx.effects.push(ClientEffect::FetchRun(result.run));
        }
    }

    /// Takes the content of a run in. Of two fetches the one that was answered later may have been asked earlier.
    fn on_content(&mut self, run: RunId, result: &Result<RunContent, String>) {
        let count = |content: &Result<RunContent, String>| content.as_ref().map_or(0, |it| it.results.len());
        if self.contents.get(&run).is_none_or(|known| count(known) <= count(result)) {
            self.contents.insert(run, result.clone());
        }
    }

    fn fetch_slots(&mut self, cx: &mut Context<'_>) {
        self.slots_fetched = Some(cx.shared.now);
        cx.effects.push(ClientEffect::FetchSlots);
    }

    fn note_slot(&mut self, run: RunId, state: RunState) {
        if let Some(RunCause::Schedule { schedule, slot }) = self.seen.get(&run).map(|run| &run.cause) {
            self.slots.insert((*schedule, *slot), state);
        }
    }
}

impl Feature for Runs {
    fn on_event(&mut self, event: &api::Event, cx: &mut Context<'_>) {
        match event {
            api::Event::Missions(status) => self.on_status(status, cx),
            api::Event::Route(route) => self.route = route.clone(),
            api::Event::ResultStored(result) => self.on_result(result, cx),
            _ => {}
        }
    }

    fn on_client_event(&mut self, event: &ClientEvent, cx: &mut Context<'_>) {
        match event {
            ClientEvent::RunsListed { query, before, result } if *query == self.query => match result {
                Ok(page) => self.on_listed(before.as_deref(), page),
                Err(sentence) => self.list_problem = Some(sentence.clone()),
            },
            ClientEvent::SlotsListed(Ok(page)) => self.decided = page.items.clone(),
            ClientEvent::PreviousFetched { point, before, result } => {
                self.previous.insert((*point, *before), result.clone());
            }
            ClientEvent::Tick if self.status.is_some() => {
                let age_s = self.slots_fetched.map_or(f64::INFINITY, |at| cx.shared.now.since(at));
                if age_s >= CONFIG.slot_period_s {
                    self.fetch_slots(cx);
                }
            }
            ClientEvent::RunFetched { run, result } => self.on_content(*run, result),
            _ => {}
        }
    }

    fn on_command(&mut self, command: &ClientCommand, cx: &mut Context<'_>) {
        match command {
            ClientCommand::StartMission { mission, is_queued } => {
                let mode = if *is_queued { StartMode::Queue } else { StartMode::Now };
                let run = cx.shared.ids.run();
                cx.send(Command::Mission(MissionCommandKind::Start { run, mission: *mission, mode }));
            }
            ClientCommand::OpenRun(run) => cx.effects.push(ClientEffect::FetchRun(*run)),
            ClientCommand::FetchResultFile { blob, kind } => {
                cx.effects.push(ClientEffect::FetchResultFile { blob: *blob, kind: *kind });
            }
            ClientCommand::ListRuns(query) if *query != self.query => self.list(*query, cx),
            ClientCommand::ListOlderRuns => {
                if let Some(before) = self.older.clone() {
                    cx.effects.push(ClientEffect::FetchRuns { query: self.query, before: Some(before) });
                }
            }
            ClientCommand::OpenPrevious { point, before } => {
                cx.effects.push(ClientEffect::FetchPrevious { point: *point, before: *before });
            }
            ClientCommand::Run(kind) => cx.send(Command::Mission(*kind)),
            _ => {}
        }
    }

    fn on_change(&mut self, change: &SliceChange, _cx: &mut Context<'_>) {
        // The snapshot that follows has the present state. A robot without missions sends none.
        if *change == SliceChange::Connected {
            self.status = None;
            self.route = RouteStatus::default();
        }
    }
}

#[cfg(test)]
mod tests;
