//! What the server says, taken into the model.

use super::Model;
use crate::pending::PendingCommand;
use crate::{Aged, CameraMove, ClientEffect, Loading, Socket};
use api::{Command, CommandOutcome, Localisation, Mapping, Motion, ScanFrame, ServerMessage, Severity};
use vocab::MapId;

/// A notice older than this is history, not news.
const NEWS_S: f64 = 30.0;

impl Model {
    pub(super) fn hear(&mut self, message: ServerMessage, effects: &mut Vec<ClientEffect>) {
        match message {
            ServerMessage::Welcome { version, program } => self.welcome(version, program, effects),
            ServerMessage::Refused { reason } => self.link.refuse(reason),
            ServerMessage::Pong { token, now: there } => {
                if let Some(sent) = self.pinged
                    && token == self.pings
                {
                    self.clock.learn(sent, self.now, there);
                    self.read_notices();
                }
            }
            ServerMessage::Event { sequence, event } => {
                if sequence <= self.sequence {
                    return;
                }
                if sequence > self.sequence + 1 {
                    // Something was lost; a new connection starts with a snapshot.
                    self.drop_link(Socket::Control, effects);
                    return;
                }
                self.sequence = sequence;
                self.learn(event, effects);
            }
        }
    }

    fn welcome(&mut self, version: u16, program: String, effects: &mut Vec<ClientEffect>) {
        if version != api::VERSION {
            let ours = api::VERSION;
            self.link.refuse(format!(
                "The server speaks version {version} and this page version {ours}. Reload the page."
            ));
            return;
        }
        self.program = program;
        self.sequence = 0;
        self.clock.forget();
        self.unread.clear();
        self.link.welcome(self.now);
        self.ping(effects);
        let (again, stale): (Vec<PendingCommand>, Vec<PendingCommand>) =
            std::mem::take(&mut self.pending).into_iter().partition(|pending| pending.resend(self.now));
        for pending in &again {
            effects.push(ClientEffect::command(pending.id, pending.order.clone()));
        }
        for pending in stale.iter().filter(|pending| !matches!(pending.order, Command::Teleoperate(_))) {
            let text =
                format!("{} may not have reached the robot: the link was lost. Try again.", pending.name());
            self.notices.add(self.now, Severity::Warning, text);
        }
        self.pending = again;
    }

    fn learn(&mut self, event: api::Event, effects: &mut Vec<ClientEffect>) {
        let arrived = self.now;
        match event {
            api::Event::Estimate(value) => {
                self.track.extend(&value);
                self.robot.estimate = Some(Aged { value, arrived });
            }
            api::Event::Graph(graph) => {
                if graph.session != self.live.graph.session {
                    self.track.clear();
                    self.forget_loops();
                }
                self.track.anchor(&graph);
                self.live.set_graph(graph);
            }
            api::Event::Tiles(changed) => {
                if changed.reset {
                    self.live.tiles.unload(true, effects);
                }
                self.live.tiles.add(&changed.added);
            }
            api::Event::Loops(changed) => self.learn_loops(changed),
            api::Event::Quality(quality) => self.quality = quality,
            api::Event::Mapping(mapping) => self.learn_mapping(mapping, effects),
            api::Event::Localisation(localisation) => self.learn_localisation(localisation),
            api::Event::Motion(value) => {
                if !matches!(value, Motion::Idle | Motion::Teleoperated) {
                    self.walk_armed = false;
                }
                self.robot.motion = Some(Aged { value, arrived });
            }
            api::Event::Executive(value) => self.robot.executive = Some(Aged { value, arrived }),
            api::Event::Goals(goals) => self.robot.goals = goals,
            api::Event::Control(control) => self.control = control,
            api::Event::Health(value) => self.robot.health = Some(Aged { value, arrived }),
            api::Event::Battery(value) => self.robot.battery = Some(Aged { value, arrived }),
            api::Event::Import(import) => {
                match import {
                    api::Import::Done { upload, .. } => self.laid(upload, true),
                    api::Import::Failed { upload, .. } => self.laid(upload, false),
                    api::Import::None | api::Import::Running { .. } => {}
                }
                self.import = import;
            }
            api::Event::Docks(docks) => self.docks = docks,
            api::Event::Maps(maps) => self.maps = Some(maps),
            api::Event::Notice(notice) => {
                self.unread.push(notice);
                self.read_notices();
            }
            api::Event::CommandDone { id, outcome } => self.done(id, outcome),
            api::Event::Platform(value) => self.platform = Some(Aged { value, arrived }),
        }
    }

    fn learn_localisation(&mut self, now: Localisation) {
        let before = std::mem::replace(&mut self.localisation, now);
        let found = |state| matches!(state, Localisation::Localised { .. });
        self.placed = found(now) || (self.placed && before.map() == now.map());
        // What was walked before was not in that map's frame.
        if before.map() != now.map() || (found(now) && !found(before)) {
            self.track.clear();
        }
    }

    fn learn_mapping(&mut self, mapping: Mapping, effects: &mut Vec<ClientEffect>) {
        let before = std::mem::replace(&mut self.mapping, mapping);
        if let (Mapping::Saving { map }, Mapping::Idle) = (&before, &self.mapping) {
            // What was just saved is what one wants to see.
            let map = *map;
            self.view_map(Some(map), effects);
        }
        let begun = !matches!(self.mapping, Mapping::Idle | Mapping::Saving { .. });
        if before == Mapping::Idle && begun {
            self.view_map(None, effects);
        }
        if let (
            Mapping::Loading { .. } | Mapping::Starting { .. } | Mapping::Finding { .. },
            Mapping::Finding { .. } | Mapping::Running { .. },
        ) = (&before, &self.mapping)
            && std::mem::discriminant(&before) != std::mem::discriminant(&self.mapping)
        {
            // What was walked before was told in another frame.
            self.track.clear();
        }
    }

    /// Shows what is news. A snapshot repeats the last notice, however old; which it is only the robot's clock can tell.
    fn read_notices(&mut self) {
        if self.clock.stamp_at(self.now).is_none() {
            return;
        }
        for notice in std::mem::take(&mut self.unread) {
            if self.clock.age_of(notice.at, self.now).is_some_and(|age| age < NEWS_S) {
                self.notices.add(self.now, notice.severity, notice.text);
            }
        }
    }

    fn done(&mut self, id: vocab::CommandId, outcome: CommandOutcome) {
        let proposal = |pending: &PendingCommand| matches!(pending.order, Command::ProposeLoop { .. });
        let proposed = self.pending.iter().any(|pending| pending.id == id && proposal(pending));
        let work =
            self.pending.iter().find(|pending| pending.id == id).and_then(|pending| match pending.order {
                Command::AlignMap { upload, .. } => Some(upload),
                _ => None,
            });
        self.pending.retain(|pending| pending.id != id);
        if let CommandOutcome::Refused(reason) = outcome {
            self.history.refused(id);
            if let Some(work) = work {
                self.laid(work, false);
            }
            if proposed {
                self.proposed = None;
            }
            self.notices.add(self.now, Severity::Warning, reason);
        }
    }

    pub(super) fn scan(&mut self, frame: &ScanFrame, bytes: usize) {
        self.stream.hear(self.now);
        self.throughput.add(self.now, bytes);
        self.robot.scan = Some(Aged { value: frame.stamp, arrived: self.now });
    }

    pub(super) fn tiles_listed(
        &mut self,
        map: MapId,
        result: Result<api::TileList, String>,
        effects: &mut Vec<ClientEffect>,
    ) {
        let Some((_, view)) = self.saved.as_mut().filter(|(id, _)| *id == map) else { return };
        match result {
            Ok(list) => {
                view.tiles.add(&list.tiles);
                view.listed_bounds = list.robust_bounds;
                view.loading = Loading::Done;
                effects.push(ClientEffect::MoveCamera(CameraMove::Fit));
            }
            Err(sentence) => view.loading = Loading::Failed(sentence),
        }
    }

    pub(super) fn graph_loaded(&mut self, map: MapId, result: Result<api::Graph, String>) {
        let Some((_, view)) = self.saved.as_mut().filter(|(id, _)| *id == map) else { return };
        match result {
            Ok(graph) => view.set_graph(graph),
            Err(sentence) => self.notices.add(self.now, Severity::Warning, sentence),
        }
    }
}
