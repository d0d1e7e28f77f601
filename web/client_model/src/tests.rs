//! The model without a browser: connections, snapshots, orders, ages, tiles, undo.

mod links;
mod loops;
mod orders;
mod surveys;
mod tiles;
mod values;

use crate::*;
use api::{
    Anchor, ClientMessage, Command, CommandOutcome, Control, Estimate, Graph, GraphNode, Mapping, Motion,
    ServerMessage, TileEntry, TileHash, TileList, TilesChanged,
};
use proptest::prelude::*;
use uuid::Uuid;
use vocab::{Aabb, ClientId, KeyframeId, MapId, Pose, SessionId, Span, Stamp, Twist, UploadId, Vec3};

/// A model with its clock and all it wanted done.
struct Bench {
    model: Model,
    now: ClientTime,
    effects: Vec<ClientEffect>,
    sequence: u64,
}

const ME: ClientId = ClientId(Uuid::from_u128(7));
const OTHER: ClientId = ClientId(Uuid::from_u128(8));

impl Bench {
    fn new() -> Self {
        let now = ClientTime(0.0);
        let mut effects = Vec::new();
        let mut model = Model::new(ME, Ids::new(42), ViewSettings::default(), now);
        model.connect(&mut effects);
        Self { model, now, effects, sequence: 0 }
    }

    fn connected() -> Self {
        let mut bench = Self::new();
        bench.connect();
        bench.take();
        bench
    }

    fn connect(&mut self) {
        self.apply(ClientEvent::SocketOpened(Socket::Control));
        self.welcome();
    }

    fn welcome(&mut self) {
        self.sequence = 0;
        self.server(ServerMessage::Welcome { version: api::VERSION, program: "1.2.3".into() });
    }

    fn apply(&mut self, event: ClientEvent) {
        self.model.handle_event(self.now, event, &mut self.effects);
    }

    fn server(&mut self, message: ServerMessage) {
        self.apply(ClientEvent::Server { message, bytes: 100 });
    }

    fn event(&mut self, event: api::Event) {
        self.sequence += 1;
        self.server(ServerMessage::Event { sequence: self.sequence, event });
    }

    fn command(&mut self, command: ClientCommand) {
        self.apply(ClientEvent::Command(command));
    }

    fn wait(&mut self, seconds: f64) {
        self.now = self.now.after(seconds);
        self.apply(ClientEvent::Tick);
    }

    fn take(&mut self) -> Vec<ClientEffect> {
        std::mem::take(&mut self.effects)
    }

    fn orders(&mut self) -> Vec<Command> {
        let order = |effect| match effect {
            ClientEffect::Send(ClientMessage::Command { command: order, .. }) => Some(order),
            _ => None,
        };
        self.take().into_iter().filter_map(order).collect()
    }
}

fn lose(bench: &mut Bench) {
    bench.apply(ClientEvent::SocketClosed { socket: Socket::Control, jitter: 0.5 });
}

fn estimate_at(secs: f64, x: f64) -> Estimate {
    let map_from_base = Pose { position: Vec3::new(x, 0.0, 0.5), ..Pose::IDENTITY };
    Estimate { stamp: Stamp::from_secs_f64(secs), map_from_base, ..Estimate::default() }
}

fn tile(number: u8, level: u8, x: f32, points: u32) -> TileEntry {
    TileEntry {
        hash: TileHash([number; 32]),
        anchor: Anchor::Map,
        level,
        spacing: 0.4 / f32::from(1_u16 << level),
        bounds: Aabb { min: [x, -1.0, 0.0], max: [x + 2.0, 1.0, 2.0] },
        points,
        bytes: points * 3,
    }
}

fn eye_at(x: f64) -> Viewpoint {
    Viewpoint { position: [x, 0.0, 1.0], forward: [1.0, 0.0, 0.0], focal_px: 900.0, corner_cos: 0.8 }
}

fn decided(from: u32, to: u32, verdict: api::LoopVerdict) -> api::LoopDecision {
    api::LoopDecision {
        from: KeyframeId(from),
        to: KeyframeId(to),
        source: api::LoopSource::Appearance(0.2),
        verdict,
        by_hand: false,
        reason: "It fits.".into(),
        overlap: [0.9; 2],
        residual: 0.01,
        through: [0.0; 2],
        rival: 0.0,
        guess: Pose::IDENTITY,
        from_from_to: Pose { position: Vec3::new(0.0, 0.3, 0.0), ..Pose::IDENTITY },
    }
}
