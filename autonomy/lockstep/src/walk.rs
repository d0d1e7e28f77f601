//! A simulated robot and its stack, stepped together faster than real time.

use crate::Digest;
use messages::{
    ActionOutcome, Input, Job, JobDone, JobId, JobResult, Keyframe, LedgerEvent, PriorKeyframe, PriorMap,
    Publication, RegisteredAction, SiteSnapshot, SiteWrite, StackEffect, TICK_PERIOD,
};
use scan_codec::{PreparationConfig, ScanPreparation};
use sim::{GroundTruth, SimConfig, SimEvent, Simulator};
use site_model::{ACTION_CATALOGUE, Change, Edit, EditId, Site};
use stack::{ComputeJob, Stack};
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use uuid::Uuid;
use vocab::{ActionCallId, MapId, SessionId, Span, Stamp};

/// When the results of jobs arrive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct JobPace {
    /// Number of ticks that a job takes. Its result arrives with the tick after them.
    pub ticks: u32,
    /// Whether the newest of several results arrives first.
    pub newest_first: bool,
}

/// An action that the stack called.
#[derive(Clone, Debug)]
pub struct CalledAction {
    /// The call.
    pub call: ActionCallId,
    /// Name of the action.
    pub action: String,
    /// Its parameters as JSON.
    pub parameters: String,
    /// The robot when it was called, for scoring.
    pub truth: GroundTruth,
}

/// Ticks that an action takes.
const ACTION_TICKS: u32 = 20;

/// Simulator and stack in one thread. Saving a map always succeeds, and a saved map can be used and extended. Everything is durable at the next tick. Actions succeed
/// after a second.
pub struct Lockstep {
    simulator: Simulator,
    /// What the link of a robot does with sweeps.
    preparation: ScanPreparation,
    stack: Stack,
    digest: Digest,
    log: Option<Vec<(Stamp, Input)>>,
    waiting: VecDeque<Input>,
    pace: JobPace,
    /// Results with their remaining ticks.
    working: Vec<(u32, JobDone)>,
    maps: BTreeMap<MapId, Arc<PriorMap>>,
    /// The site as a ledger would have it.
    site: Site,
    edits: u64,
    /// Events, steps and results of runs as a ledger would get them.
    rows: Vec<LedgerEvent>,
    calls: Vec<CalledAction>,
    /// Turns of the body that the next calls need, radians.
    turns: VecDeque<f64>,
    /// Calls that are performed, with their remaining ticks.
    acting: Vec<(u32, ActionCallId)>,
    /// Keyframe contents of the running session.
    keyframes: Vec<PriorKeyframe>,
    events: Vec<SimEvent>,
    effects: Vec<StackEffect>,
}

impl Lockstep {
    /// Boots the stack with the simulated robot's boot record. If `session` is given, mapping starts with the first scan. `keep_log` keeps every
    /// input in memory for a replay.
    pub fn new(config: SimConfig, session: Option<SessionId>, keep_log: bool) -> Self {
        let simulator = Simulator::new(config);
        let mut boot = simulator.boot();
        boot.start_mapping = session;
        let mut lockstep = Self {
            simulator,
            preparation: ScanPreparation::default(),
            stack: Stack::new(),
            digest: Digest::default(),
            log: keep_log.then(Vec::new),
            waiting: VecDeque::new(),
            pace: JobPace::default(),
            working: Vec::new(),
            maps: BTreeMap::new(),
            site: Site::default(),
            edits: 0,
            rows: Vec::new(),
            calls: Vec::new(),
            turns: VecDeque::new(),
            acting: Vec::new(),
            keyframes: Vec::new(),
            events: Vec::new(),
            effects: Vec::new(),
        };
        let now = lockstep.now();
        lockstep.step(now, Input::Boot(Box::new(boot)), &mut |_, _| {});
        lockstep
    }

    /// The simulator, for its clock, ground truth and faults.
    pub fn simulator(&mut self) -> &mut Simulator {
        &mut self.simulator
    }

    /// Sets how sweeps are prepared for the stack from now on.
    pub fn prepare_scans(&mut self, config: PreparationConfig) {
        self.preparation = ScanPreparation::new(config);
    }

    /// The robot's clock.
    pub fn now(&self) -> Stamp {
        self.simulator.now()
    }

    /// Gives the stack an input, such as a command, at the next tick.
    pub fn give(&mut self, input: Input) {
        self.waiting.push_back(input);
    }

    /// Lets the next calls of actions need a turn of the body, each by one of these angles, radians.
    pub fn demand_turns(&mut self, turns_rad: &[f64]) {
        self.turns.extend(turns_rad);
    }

    /// Sets the delay and the order of job results from now on.
    pub fn pace_jobs(&mut self, pace: JobPace) {
        self.pace = pace;
    }

    /// Runs until `until` and calls `watch` with every effect.
    pub fn advance(&mut self, until: Stamp, watch: &mut dyn FnMut(Stamp, &StackEffect)) {
        while self.now() < until {
            let next = (self.now() + TICK_PERIOD).min(until);
            let mut events = std::mem::take(&mut self.events);
            self.simulator.advance(next, &mut events);
            for event in events.drain(..) {
                let sensor = self.preparation.prepare(event.at, event.sensor);
                self.step(event.at, Input::Sensor(sensor), watch);
            }
            self.events = events;
            while let Some(input) = self.waiting.pop_front() {
                self.step(next, input, watch);
            }
            for done in self.finished() {
                // A replay does not do this, and has the same effects.
                let preparation = self.stack.map_preparation(done.id());
                if let Some(prepared) = preparation.and_then(|preparation| preparation.run(&done)) {
                    self.stack.supply_prepared_map(prepared);
                }
                self.step(next, Input::JobDone(done), watch);
            }
            for call in self.finished_actions() {
                let outcome = ActionOutcome::Succeeded { result: "{}".to_owned() };
                self.step(next, Input::ActionDone { call, outcome }, watch);
            }
            self.step(next, Input::Tick, watch);
        }
    }

    /// A saved map.
    pub fn map(&self, map: MapId) -> Option<&Arc<PriorMap>> {
        self.maps.get(&map)
    }

    /// Adds a map as if it had been saved.
    pub fn keep_map(&mut self, map: Arc<PriorMap>) {
        self.maps.insert(map.map, map);
    }

    /// Gives the stack a site, and the actions that come with the platform.
    pub fn give_site(&mut self, site: Site) {
        let objects = site.objects().cloned().collect();
        let snapshot = SiteSnapshot { objects, removed: site.removed().collect() };
        self.site = site;
        let action = |action: &site_model::ActionDescription| RegisteredAction {
            name: action.name.to_owned(),
            is_idempotent: action.is_idempotent,
            expected: Span::from_secs_f64(action.expected_s),
        };
        self.give(Input::ActionsRegistered(ACTION_CATALOGUE.iter().map(action).collect()));
        self.give(Input::Site(Box::new(snapshot)));
    }

    /// The site, with what the robot has changed.
    pub fn site(&self) -> &Site {
        &self.site
    }

    /// Events, steps and results of runs, in the order in which they became durable.
    pub fn rows(&self) -> &[LedgerEvent] {
        &self.rows
    }

    /// All actions that were called.
    pub fn calls(&self) -> &[CalledAction] {
        &self.calls
    }

    /// Digest of all effects so far.
    pub fn digest(&self) -> &Digest {
        &self.digest
    }

    /// All inputs so far, if they are kept.
    pub fn log(&self) -> &[(Stamp, Input)] {
        self.log.as_deref().unwrap_or_default()
    }

    /// Results that are due, in order of arrival.
    fn finished(&mut self) -> Vec<JobDone> {
        let (due, later): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.working).into_iter().partition(|(ticks, _)| *ticks == 0);
        self.working = later.into_iter().map(|(ticks, done)| (ticks - 1, done)).collect();
        let mut due: Vec<JobDone> = due.into_iter().map(|(_, done)| done).collect();
        if self.pace.newest_first {
            due.reverse();
        }
        due
    }

    fn step(&mut self, at: Stamp, input: Input, watch: &mut dyn FnMut(Stamp, &StackEffect)) {
        if let Some(log) = &mut self.log {
            log.push((at, input.clone()));
        }
        let mut effects = std::mem::take(&mut self.effects);
        self.stack.step(at, input, &mut effects);
        self.digest.add(at, &effects);
        for effect in effects.drain(..) {
            watch(at, &effect);
            match effect {
                StackEffect::Drive(drive) => self.simulator.command(drive),
                StackEffect::StartJob { job, work: Job::SaveMap(finished) } => {
                    let (map, graph) = (finished.map, finished.graph.as_ref().clone());
                    self.keep_map(Arc::new(PriorMap { map, graph, keyframes: self.keyframes.clone() }));
                    let result = JobResult::MapSaving(Ok(finished.map));
                    self.working.push((self.pace.ticks, JobDone { number: job.number, result }));
                }
                StackEffect::StartJob { job, work: Job::LoadMap { map, .. } } => {
                    if let Some(prior_map) = self.maps.get(&map) {
                        self.keyframes.clone_from(&prior_map.keyframes);
                    }
                    self.read_map(job, map);
                }
                StackEffect::StartJob { job, work: Job::ReadMap(map) } => self.read_map(job, map),
                StackEffect::StartJob { job, .. } => {
                    let work = self.stack.take_compute_job(job);
                    let done = work.map_or_else(|| job.not_done(), ComputeJob::run);
                    self.working.push((self.pace.ticks, done));
                }
                StackEffect::Publish(Publication::Keyframe(keyframe)) => self.keep_keyframe(&keyframe),
                StackEffect::Commit { seq, events } => {
                    for event in events {
                        match event {
                            LedgerEvent::Site(write) => self.write_site(write),
                            LedgerEvent::Mission(_) | LedgerEvent::Step(_) | LedgerEvent::Result(_) => {
                                self.rows.push(event);
                            }
                            _ => {}
                        }
                    }
                    self.waiting.push_back(Input::Committed { seq });
                }
                StackEffect::CallAction { call, action, parameters } => {
                    let truth = self.simulator.truth();
                    self.calls.push(CalledAction { call, action, parameters, truth });
                    match self.turns.pop_front() {
                        Some(turn_rad) => {
                            let outcome = ActionOutcome::NeedsTurn { turn_rad };
                            self.waiting.push_back(Input::ActionDone { call, outcome });
                        }
                        None => self.acting.push((ACTION_TICKS, call)),
                    }
                }
                StackEffect::CancelAction(call) => {
                    if self.acting.iter().any(|(_, acting)| *acting == call) {
                        self.acting.retain(|(_, acting)| *acting != call);
                        let outcome = ActionOutcome::Cancelled;
                        self.waiting.push_back(Input::ActionDone { call, outcome });
                    }
                }
                StackEffect::Publish(_) | StackEffect::Answer { .. } => {}
            }
        }
        self.effects = effects;
    }

    /// Applies what the robot itself changes, as a ledger does, and tells the stack.
    fn write_site(&mut self, write: SiteWrite) {
        let site = &self.site;
        let put =
            write.put.into_iter().map(|object| Change::Put { base: site.revision(object.id()), object });
        let removed = write
            .removed
            .into_iter()
            .filter_map(|object| Some(Change::Remove { base: site.revision(object)?, object }));
        let changes: Vec<Change> = put.chain(removed).collect();
        self.edits += 1;
        let edit = Edit { id: EditId(Uuid::from_u128(self.edits.into())), changes };
        if self.site.apply(&edit, edit.id).is_ok() {
            self.waiting.push_back(Input::SiteEdited(Box::new(edit)));
        }
    }

    /// Calls that end now.
    fn finished_actions(&mut self) -> Vec<ActionCallId> {
        self.acting.iter_mut().for_each(|(ticks, _)| *ticks = ticks.saturating_sub(1));
        let done = self.acting.iter().filter(|(ticks, _)| *ticks == 0).map(|(_, call)| *call).collect();
        self.acting.retain(|(ticks, _)| *ticks > 0);
        done
    }

    fn read_map(&mut self, job: JobId, map: MapId) {
        let done = match self.maps.get(&map) {
            Some(prior_map) => job.map_read(Arc::clone(prior_map)),
            None => job.failed("there is no such map"),
        };
        self.working.push((self.pace.ticks, done));
    }

    fn keep_keyframe(&mut self, keyframe: &Keyframe) {
        if keyframe.id.0 == 0 {
            self.keyframes.clear();
        }
        let (pose, xyz) = (&keyframe.map_from_keyframe, &keyframe.cloud.xyz);
        self.keyframes.extend(stack::encode_prior_keyframe(pose, xyz, keyframe.lidar));
    }
}
