//! What all features share: time, ids, and the slices that others depend on.

use crate::features::commands::PendingCommands;
use crate::features::connection::Connection;
use crate::features::control::ControlLease;
use crate::features::history::History;
use crate::features::map_view::MapViews;
use crate::features::maps::SavedMaps;
use crate::features::notices::Notices;
use crate::features::selection::{PointerMode, Selected};
use crate::{ClientEffect, ClientTime, Ids, texts};
use api::{ClientIdentity, CommandOutcome, LeaseToken, Severity};
use vocab::{ClientId, CommandId, MapId};

/// State that more than one feature needs.
#[derive(Debug)]
pub(crate) struct Shared {
    /// This client's secret, kept over reconnections.
    pub(crate) lease: LeaseToken,
    /// Who this client is, as the server says; none before the first welcome.
    pub(crate) you: Option<ClientIdentity>,
    /// Client time of the last event.
    pub(crate) now: ClientTime,
    /// Source of the ids that the client makes.
    pub(crate) ids: Ids,
    pub(crate) connection: Connection,
    pub(crate) control: ControlLease,
    pub(crate) commands: PendingCommands,
    pub(crate) notices: Notices,
    pub(crate) maps: SavedMaps,
    pub(crate) map_views: MapViews,
    /// The parts of a long graph that have come.
    pub(crate) graph_parts: api::GraphAssembly,
    pub(crate) selected: Selected,
    pub(crate) history: History,
}

impl Shared {
    pub(crate) fn new(lease: LeaseToken, ids: Ids, now: ClientTime) -> Self {
        Self {
            lease,
            you: None,
            now,
            ids,
            connection: Connection::new(now),
            control: ControlLease::default(),
            commands: PendingCommands::default(),
            notices: Notices::default(),
            maps: SavedMaps::default(),
            map_views: MapViews::default(),
            graph_parts: api::GraphAssembly::default(),
            selected: Selected::default(),
            history: History::default(),
        }
    }

    /// Whether another client holds the control lease.
    pub(crate) fn is_controlled_by_other(&self) -> bool {
        self.control.owner().is_some_and(|owner| Some(owner) != self.client())
    }

    /// This client's id, once the server has told it.
    pub(crate) fn client(&self) -> Option<ClientId> {
        self.you.as_ref().map(|you| you.client)
    }

    /// What this client calls itself to the others.
    pub(crate) fn operator_name(&self) -> String {
        let account = self.you.as_ref().and_then(|you| you.account.clone());
        account.unwrap_or_else(|| {
            texts::operator_name(self.client().map_or(0, |client| client.0.as_u128() as u16))
        })
    }
}

/// Something that changed in one slice and that others react to.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum SliceChange {
    /// The server has welcomed this client, for the first time or again. Its snapshot follows.
    Connected,
    /// The graph belongs to another mapping session than before; keyframe ids start anew.
    SessionChanged,
    /// This map is viewed from now on, or still: a saved one, or the live map.
    MapViewed {
        /// The map; `None` for the live one.
        map: Option<MapId>,
        /// Whether another one was viewed before.
        changed: bool,
    },
    /// Poses from before are not in the frame of poses from now on.
    FrameChanged,
    /// The robot answered a command.
    CommandAnswered {
        /// Which.
        id: CommandId,
        /// What was asked; `None` for commands that are not waited for.
        command: Option<api::Command>,
        /// Whether it was accepted.
        accepted: bool,
    },
}

/// What a reducer works with besides its own state: the shared slices, effects for the shell, changes for other features.
pub(crate) struct Context<'a> {
    /// The shared slices.
    pub(crate) shared: &'a mut Shared,
    /// What the shell shall do, in this order.
    pub(crate) effects: &'a mut Vec<ClientEffect>,
    /// Changes that other features get after this reducer.
    pub(crate) changes: &'a mut Vec<SliceChange>,
}

impl Context<'_> {
    /// Client time of the event.
    pub(crate) fn now(&self) -> ClientTime {
        self.shared.now
    }

    /// Shows a sentence to the operator.
    pub(crate) fn notify(&mut self, severity: Severity, text: String) {
        self.shared.notices.add(self.shared.now, severity, text);
    }

    /// Sends a command to the robot and waits for its answer.
    pub(crate) fn send(&mut self, command: api::Command) {
        let id = self.shared.ids.command();
        self.send_with_id(id, command);
    }

    /// Sends a command for which the sender needs the control lease.
    pub(crate) fn send_in_control(&mut self, command: api::Command) {
        self.take_free_control();
        self.send(command);
    }

    /// As [`Self::send`], under an id of the caller's.
    pub(crate) fn send_with_id(&mut self, id: CommandId, command: api::Command) {
        if self.shared.connection.is_connected() {
            self.effects.push(ClientEffect::command(id, command.clone()));
        } else if command == api::Command::StopMotion {
            // The server keeps places for it when all sockets are taken.
            self.effects.push(ClientEffect::RequestStop);
            self.notify(Severity::Error, texts::STOP_NOT_SENT.to_owned());
        }
        let now = self.shared.now;
        self.shared.commands.add(id, command, now);
    }

    /// Sends a command that is not repeated after a reconnection and whose answer nobody waits for.
    pub(crate) fn send_once(&mut self, command: api::Command) {
        let id = self.shared.ids.command();
        self.effects.push(ClientEffect::command(id, command));
    }

    /// Asks for the control lease.
    pub(crate) fn take_control(&mut self) {
        let name = self.shared.operator_name();
        self.send(api::Command::TakeControl { name });
    }

    /// Asks for the control lease if nobody holds it: operators need not press a button for that.
    pub(crate) fn take_free_control(&mut self) {
        let asked =
            self.shared.commands.is_pending(|command| matches!(command, api::Command::TakeControl { .. }));
        if self.shared.control.owner().is_none() && !asked {
            self.take_control();
        }
    }

    /// Views a saved map, or the live one.
    pub(crate) fn view_map(&mut self, map: Option<MapId>) {
        let changed = self.shared.map_views.view(map, self.effects);
        if changed {
            self.shared.selected.selection = None;
            self.shared.selected.part();
            self.shared.selected.leave(PointerMode::PickPose);
        }
        self.changes.push(SliceChange::MapViewed { map, changed });
    }

    /// The robot answered a command.
    pub(crate) fn answer(&mut self, id: CommandId, outcome: &CommandOutcome) {
        let command = self.shared.commands.take(id);
        let accepted = match outcome {
            CommandOutcome::Accepted => true,
            CommandOutcome::Refused(reason) => {
                self.shared.history.forget_command(id);
                self.notify(Severity::Warning, reason.clone());
                false
            }
        };
        self.changes.push(SliceChange::CommandAnswered { id, command, accepted });
    }

    /// Shows the notices whose age the robot's clock tells by now.
    pub(crate) fn show_notices(&mut self) {
        let now = self.shared.now;
        self.shared.notices.show_received(self.shared.connection.clock(), now);
    }
}
