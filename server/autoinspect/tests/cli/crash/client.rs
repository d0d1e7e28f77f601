//! A gateway that keeps the latest state of a core and can be read until the core's last byte.

use crate::fake_gateway::{FakeGateway, PATIENCE};
use api::{
    BinnedMap, Command, CommandOutcome, CoreMessage, DamagedMap, Event, GraphNode, Import,
    InterruptedSession, Localisation, MapSummary, Mapping, Motion,
};
use site_model::{MissionStatus, RunStatus};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};
use vocab::{CommandId, KeyframeId, SessionId, Stamp};

/// What the core has published so far.
#[derive(Clone, Default)]
pub struct CoreState {
    pub maps: Option<Vec<MapSummary>>,
    pub damaged_maps: Option<Vec<DamagedMap>>,
    pub binned_maps: Vec<BinnedMap>,
    pub sessions: Option<Vec<InterruptedSession>>,
    pub motion: Option<Motion>,
    pub mapping: Mapping,
    pub localisation: Localisation,
    /// When the robot became localised, if it is.
    pub localised_since: Option<Instant>,
    pub import: Import,
    /// None before it has come.
    pub missions: Option<MissionStatus>,
    /// The run that was shown last, as it was shown last: a run that has ended shows no tasks.
    pub last_run: Option<RunStatus>,
    pub notices: Vec<String>,
    /// Instant of the first estimate.
    pub began: Option<Stamp>,
    /// Instant of the newest estimate.
    pub now: Option<Stamp>,
    /// Keyframes of the running session.
    pub keyframes: BTreeMap<KeyframeId, Stamp>,
    session: Option<SessionId>,
    outcomes: BTreeMap<CommandId, CommandOutcome>,
}

impl CoreState {
    fn apply(&mut self, event: Event) {
        match event {
            Event::Maps(maps) => self.maps = Some(maps),
            Event::DamagedMaps(maps) => self.damaged_maps = Some(maps),
            Event::BinnedMaps(maps) => self.binned_maps = maps,
            Event::InterruptedSessions(sessions) => self.sessions = Some(sessions),
            Event::Motion(motion) => self.motion = Some(motion),
            Event::Mapping(mapping) => self.mapping = mapping,
            Event::Localisation(localisation) => {
                let is_localised = matches!(localisation, Localisation::Localised { degradation: None, .. });
                self.localised_since =
                    is_localised.then(|| self.localised_since.unwrap_or_else(Instant::now));
                self.localisation = localisation;
            }
            Event::Import(import) => self.import = import,
            Event::Missions(missions) => {
                self.last_run = missions.runs.first().cloned().or(self.last_run.take());
                self.missions = Some(missions);
            }
            Event::Notice(notice) => self.notices.push(notice.text),
            Event::Estimate(estimate) => {
                self.began.get_or_insert(estimate.stamp);
                self.now = Some(estimate.stamp);
            }
            Event::Graph(graph) => {
                self.session = graph.session;
                self.keyframes = graph.nodes.iter().map(Self::keyframe).collect();
            }
            Event::GraphChanged(changed) if changed.session == self.session => {
                self.keyframes.extend(changed.nodes.iter().map(Self::keyframe));
            }
            Event::CommandDone { id, outcome } => drop(self.outcomes.insert(id, outcome)),
            _ => {}
        }
    }

    fn keyframe(node: &GraphNode) -> (KeyframeId, Stamp) {
        (node.id, node.stamp)
    }
}

/// A connection to a core. A thread reads all that it sends, also what it sent before it was killed.
pub struct CoreClient {
    gateway: FakeGateway,
    messages: Receiver<CoreMessage>,
    pub state: CoreState,
}

impl CoreClient {
    /// Connects, and waits for the first message.
    pub fn connect(socket: &Path) -> Option<Self> {
        let mut reader = FakeGateway::try_connect(socket)?;
        let gateway = reader.another_sender();
        let (sender, messages) = mpsc::channel();
        thread::spawn(move || {
            while let Some(message) = reader.next_message() {
                if sender.send(message).is_err() {
                    return;
                }
            }
        });
        let first = messages.recv_timeout(PATIENCE).ok()?;
        matches!(first, CoreMessage::Hello { .. }).then(|| Self {
            gateway,
            messages,
            state: CoreState::default(),
        })
    }

    /// Applies what arrives within this time.
    fn receive_for(&mut self, time: Duration) -> Result<(), String> {
        let until = Instant::now() + time;
        loop {
            match self.messages.recv_timeout(until.saturating_duration_since(Instant::now())) {
                Ok(CoreMessage::Event { event, .. }) => self.state.apply(event),
                Ok(_) => {}
                Err(RecvTimeoutError::Timeout) => return Ok(()),
                Err(RecvTimeoutError::Disconnected) => {
                    return Err("the core has closed the connection".into());
                }
            }
        }
    }

    /// Takes what arrives until a condition holds, and does something meanwhile, 20 times a second.
    pub fn until_with(
        &mut self,
        what: &str,
        mut meanwhile: impl FnMut(&mut Self),
        mut condition: impl FnMut(&CoreState) -> bool,
    ) -> Result<(), String> {
        let start = Instant::now();
        while !condition(&self.state) {
            if start.elapsed() > PATIENCE {
                return Err(format!("did not happen within {} s: {what}", PATIENCE.as_secs()));
            }
            meanwhile(self);
            self.receive_for(Duration::from_millis(50)).map_err(|error| format!("{what}: {error}"))?;
        }
        Ok(())
    }

    /// Takes what arrives until a condition holds.
    pub fn until(&mut self, what: &str, condition: impl FnMut(&CoreState) -> bool) -> Result<(), String> {
        self.until_with(what, |_| {}, condition)
    }

    /// Takes what arrives for some time, and does something meanwhile, 20 times a second.
    pub fn for_time(&mut self, time: Duration, mut meanwhile: impl FnMut(&mut Self)) -> Result<(), String> {
        let end = Instant::now() + time;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(());
            }
            meanwhile(self);
            self.receive_for(left.min(Duration::from_millis(50)))?;
        }
    }

    /// Sends a command and does not wait for its outcome.
    pub fn send(&mut self, command: Command) -> CommandId {
        self.gateway.send_command(command)
    }

    /// Sends a command and waits until it is accepted.
    pub fn command(&mut self, command: Command) -> Result<(), String> {
        let what = format!("{command:?}");
        let id = self.send(command);
        self.until(&format!("an answer to {what}"), |state| state.outcomes.contains_key(&id))?;
        match self.state.outcomes.remove(&id) {
            Some(CommandOutcome::Accepted) => Ok(()),
            other => Err(format!("{what} was not accepted: {other:?}")),
        }
    }

    /// Whether a command was accepted.
    pub fn is_accepted(state: &CoreState, id: CommandId) -> bool {
        matches!(state.outcomes.get(&id), Some(CommandOutcome::Accepted))
    }

    /// All that the core has published, once it has been killed.
    pub fn read_to_end(mut self) -> CoreState {
        while self.receive_for(Duration::from_millis(100)).is_ok() {}
        self.state
    }
}
