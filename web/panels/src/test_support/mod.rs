//! What the tests of panels share: a client without a server, and its panels in a harness that finds controls by name.

pub(crate) mod missions;

use crate::{PanelState, theme};
use api::{MapSummary, Mapping, ServerMessage};
use client_model::{
    ClientCommand, ClientEffect, ClientEvent, ClientTime, Ids, Model, Screen, Socket, Theme, ViewSettings,
};
use egui::{Color32, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use uuid::Uuid;
use vocab::{ClientId, MapId, SessionId, Stamp};

/// The client under test.
pub(crate) const ME: ClientId = ClientId(Uuid::from_u128(1));
/// Another client.
pub(crate) const OTHER: ClientId = ClientId(Uuid::from_u128(2));

/// A client with a robot server that a test plays: the model, the panels' state, and the commands that the panels emitted.
pub(crate) struct TestClient {
    pub(crate) model: Model,
    pub(crate) panels: PanelState,
    pub(crate) commands: Vec<ClientCommand>,
    sequence: u64,
    has_fonts: bool,
}

impl TestClient {
    /// A client that the server has welcomed.
    pub(crate) fn connected() -> Self {
        Self::connected_as(api::ClientIdentity::in_demo(ME))
    }

    /// A client that the server has welcomed as this one.
    pub(crate) fn connected_as(you: api::ClientIdentity) -> Self {
        let now = ClientTime(1.0);
        let mut model = Model::new(api::LeaseToken(ME.0), Ids::new(1), ViewSettings::default(), now);
        let mut effects: Vec<ClientEffect> = Vec::new();
        model.handle_event(now, ClientEvent::SocketOpened(Socket::Control), &mut effects);
        let mut client = Self {
            model,
            panels: PanelState::default(),
            commands: Vec::new(),
            sequence: 0,
            has_fonts: false,
        };
        client.receive(ServerMessage::Welcome { version: api::VERSION, program: "1".into(), you });
        client
    }

    fn receive(&mut self, message: ServerMessage) {
        self.model.handle_event(ClientTime(1.0), ClientEvent::Server { message, bytes: 10 }, &mut Vec::new());
    }

    /// After the server sent an event.
    pub(crate) fn event(mut self, event: api::Event) -> Self {
        self.receive_event(event);
        self
    }

    /// The server sends an event.
    pub(crate) fn receive_event(&mut self, event: api::Event) {
        self.sequence += 1;
        self.receive(ServerMessage::Event { sequence: self.sequence, event });
    }

    /// After the model carried out a command of the operator.
    pub(crate) fn command(mut self, command: ClientCommand) -> Self {
        self.model.handle_event(ClientTime(1.0), ClientEvent::Command(command), &mut Vec::new());
        self
    }

    /// As [`Self::command`], with what the shell shall do.
    pub(crate) fn command_with_effects(mut self, command: ClientCommand) -> (Self, Vec<ClientEffect>) {
        let mut effects = Vec::new();
        self.model.handle_event(ClientTime(1.0), ClientEvent::Command(command), &mut effects);
        (self, effects)
    }

    /// On another screen.
    pub(crate) fn on(self, screen: Screen) -> Self {
        self.command(ClientCommand::ShowScreen(screen))
    }

    /// Whether the panels emitted this command.
    pub(crate) fn emitted(&self, command: &ClientCommand) -> bool {
        self.commands.contains(command)
    }

    /// The panels in a window of this size, points.
    pub(crate) fn shown<'a>(self, width: f32, height: f32) -> Harness<'a, Self> {
        let mut harness = Harness::builder().with_size(vec2(width, height)).build_ui_state(
            |ui, client: &mut Self| {
                let ctx = ui.ctx().clone();
                if client.has_fonts {
                    crate::show(&ctx, &client.model, &mut client.panels, &mut client.commands);
                } else {
                    // Fonts can be used from the frame after this one.
                    theme::install_fonts(&ctx);
                    theme::install(&ctx, Theme::Dark);
                    client.has_fonts = true;
                }
            },
            self,
        );
        harness.run_steps(3);
        harness
    }
}

/// Clicks the control of this name and draws the frames that answer the click.
pub(crate) fn click(harness: &mut Harness<'_, TestClient>, name: &str) {
    harness.get_by_label(name).click();
    harness.run_steps(2);
}

/// The value of the status of this name; empty if it has none.
pub(crate) fn value(harness: &Harness<'_, TestClient>, name: &str) -> String {
    harness.get_by_label(name).value().unwrap_or_default()
}

/// A mapping session that made 41 keyframes.
pub(crate) fn running() -> Mapping {
    let session = SessionId(Uuid::from_u128(5));
    Mapping::Running {
        session,
        extends: None,
        since: Stamp::EPOCH,
        distance_m: 12.3,
        keyframes: 41,
        on_known_ground: false,
    }
}

/// A saved map.
pub(crate) fn map(number: u128, name: &str) -> MapSummary {
    MapSummary {
        id: MapId(Uuid::from_u128(number)),
        name: name.into(),
        created: Stamp::from_secs_f64(1_795_257_600.0),
        distance_m: 120.0,
        keyframes: 60,
        points: 2_345_678,
        bytes: 7_000_000,
        has_pose_graph: true,
    }
}

/// Contrast of two colours as WCAG 2 defines it.
pub(crate) fn contrast(a: Color32, b: Color32) -> f32 {
    let luminance = |colour: Color32| {
        let linear = |channel: u8| {
            let c = f32::from(channel) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * linear(colour.r()) + 0.7152 * linear(colour.g()) + 0.0722 * linear(colour.b())
    };
    let (a, b) = (luminance(a) + 0.05, luminance(b) + 0.05);
    (a / b).max(b / a)
}
