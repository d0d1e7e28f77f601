//! A client without a browser: its model, its clock and the effects that it emitted.

use crate::*;
use api::{ClientMessage, Command, Estimate, ServerMessage, TileAnchor, TileEntry, TileHash};
use uuid::Uuid;
use vocab::{Aabb, ClientId, KeyframeId, Pose, Stamp, Vec3};

/// A model with its clock and all it wanted done.
pub(crate) struct TestClient {
    pub(crate) model: Model,
    pub(crate) now: ClientTime,
    pub(crate) effects: Vec<ClientEffect>,
    pub(crate) sequence: u64,
}

pub(crate) const ME: ClientId = ClientId(Uuid::from_u128(7));
pub(crate) const OTHER: ClientId = ClientId(Uuid::from_u128(8));

impl TestClient {
    pub(crate) fn new() -> Self {
        let now = ClientTime(0.0);
        let mut effects = Vec::new();
        let mut model = Model::new(api::LeaseToken(ME.0), Ids::new(42), ViewSettings::default(), now);
        model.connect(&mut effects);
        Self { model, now, effects, sequence: 0 }
    }

    pub(crate) fn connected() -> Self {
        let mut client = Self::new();
        client.connect();
        client.take_effects();
        client
    }

    pub(crate) fn connect(&mut self) {
        self.apply(ClientEvent::SocketOpened(Socket::Control));
        self.welcome();
    }

    pub(crate) fn welcome(&mut self) {
        self.welcome_as(ME);
    }

    pub(crate) fn welcome_as(&mut self, client: ClientId) {
        self.sequence = 0;
        self.server(ServerMessage::Welcome {
            version: api::VERSION,
            program: "1.2.3".into(),
            you: api::ClientIdentity::in_demo(client),
        });
    }

    pub(crate) fn apply(&mut self, event: ClientEvent) {
        self.model.handle_event(self.now, event, &mut self.effects);
    }

    pub(crate) fn server(&mut self, message: ServerMessage) {
        self.apply(ClientEvent::Server { message, bytes: 100 });
    }

    pub(crate) fn event(&mut self, event: api::Event) {
        self.sequence += 1;
        self.server(ServerMessage::Event { sequence: self.sequence, event });
    }

    pub(crate) fn command(&mut self, command: ClientCommand) {
        self.apply(ClientEvent::Command(command));
    }

    pub(crate) fn wait(&mut self, seconds: f64) {
        self.now = self.now.after(seconds);
        self.apply(ClientEvent::Tick);
    }

    pub(crate) fn take_effects(&mut self) -> Vec<ClientEffect> {
        std::mem::take(&mut self.effects)
    }

    pub(crate) fn take_commands(&mut self) -> Vec<Command> {
        let command = |effect| match effect {
            ClientEffect::Send(ClientMessage::Command { command, .. }) => Some(command),
            _ => None,
        };
        self.take_effects().into_iter().filter_map(command).collect()
    }

    pub(crate) fn lose_connection(&mut self) {
        self.apply(ClientEvent::SocketClosed { socket: Socket::Control, jitter: 0.5 });
    }
}

pub(crate) fn estimate_at(secs: f64, x: f64) -> Estimate {
    let map_from_base = Pose { position: Vec3::new(x, 0.0, 0.5), ..Pose::IDENTITY };
    Estimate { stamp: Stamp::from_secs_f64(secs), map_from_base, ..Estimate::default() }
}

pub(crate) fn tile(number: u8, level: u8, x: f32, points: u32) -> TileEntry {
    TileEntry {
        hash: TileHash([number; 32]),
        anchor: TileAnchor::Map,
        level,
        spacing_m: 0.4 / f32::from(1_u16 << level),
        bounds: Aabb { min: [x, -1.0, 0.0], max: [x + 2.0, 1.0, 2.0] },
        points,
        bytes: points * 3,
    }
}

pub(crate) fn eye_at(x: f64) -> Viewpoint {
    Viewpoint { position: [x, 0.0, 1.0], forward: [1.0, 0.0, 0.0], focal_px: 900.0, corner_cos: 0.8 }
}

pub(crate) fn decided(from: u32, to: u32, verdict: api::LoopVerdict) -> api::LoopDecision {
    api::LoopDecision {
        from: KeyframeId(from),
        to: KeyframeId(to),
        source: api::LoopSource::Appearance(0.2),
        verdict,
        by_hand: false,
        reason: "It fits.".into(),
        overlap: [0.9; 2],
        residual_m: 0.01,
        free_space_violation: [0.0; 2],
        runner_up_ratio: 0.0,
        guess: Pose::IDENTITY,
        from_from_to: Pose { position: Vec3::new(0.0, 0.3, 0.0), ..Pose::IDENTITY },
    }
}
