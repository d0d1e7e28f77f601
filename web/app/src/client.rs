//! The running client: takes what came in, lets the model decide, carries out its effects, draws.

use crate::fetch::Fetches;
use crate::inbox::{Arrival, Inbox};
use crate::inputs::Inputs;
use crate::sockets::Sockets;
use crate::stage::Stage;
use crate::viewport::Viewport;
use crate::{aria, browser, gpu};
use client_model::{ClientTime, Command, Effect, Event, Ids, Model, Socket, Theme, ViewSettings};
use panels::PanelState;
use panels::theme::{self, Tokens};
use std::collections::VecDeque;
use std::time::Duration;
use vocab::ClientId;

/// Time spent on decoding tiles in one frame, milliseconds; a tile that is begun is finished.
const DECODE_MS: f64 = 4.0;
/// While nothing moves, ages and countdowns still have to.
const IDLE_REPAINT: Duration = Duration::from_millis(500);
/// While the hand is on the stick, orders go out ten times a second.
const DRIVE_REPAINT: Duration = Duration::from_millis(50);
const CLIENT_KEY: &str = "autoinspect.client";
const VIEW_KEY: &str = "autoinspect.view";

/// The client.
pub(crate) struct Client {
    model: Model,
    panels: PanelState,
    stage: Stage,
    viewport: Viewport,
    sockets: Sockets,
    fetches: Fetches,
    inputs: Inputs,
    inbox: Inbox,
    undecoded: VecDeque<(api::TileHash, Vec<u8>)>,
    commands: Vec<Command>,
    effects: VecDeque<Effect>,
    theme: Option<Theme>,
}

type CreateError = Box<dyn std::error::Error + Send + Sync>;

impl Client {
    /// Makes the client and begins to connect.
    pub(crate) fn create(context: &eframe::CreationContext<'_>) -> Result<Box<dyn eframe::App>, CreateError> {
        let device = context.wgpu_render_state.as_ref().ok_or("the browser gave no graphics device")?;
        let ctx = &context.egui_ctx;
        theme::install_fonts(ctx);
        aria::install(ctx);
        let inbox = Inbox::new(ctx.clone());
        let ids = Ids::new(browser::random_u128());
        let mut model = Model::new(client_id(), ids, kept_view(), now());
        let mut effects = Vec::new();
        model.start(&mut effects);
        let stage = Stage::new(scene::Renderer::new(&device.device, &device.queue, device.target_format));
        device.renderer.write().callback_resources.insert(stage.renderer.clone());
        Ok(Box::new(Self {
            model,
            panels: PanelState::for_page(browser::utc_offset_s()),
            stage,
            viewport: Viewport::new(gpu::pace(&device.adapter.get_info())),
            sockets: Sockets::new(inbox.clone()),
            fetches: Fetches::new(inbox.clone()),
            inputs: Inputs::new(ctx.clone()),
            inbox,
            undecoded: VecDeque::new(),
            commands: Vec::new(),
            effects: effects.into(),
            theme: None,
        }))
    }

    /// The one place that changes the model.
    fn apply(&mut self, event: Event) {
        let mut effects = Vec::new();
        self.model.apply(now(), event, &mut effects);
        self.effects.extend(effects);
    }

    fn receive(&mut self) {
        let mut scan = None;
        while let Some(arrival) = self.inbox.take() {
            match arrival {
                Arrival::Tile { hash, bytes } => self.undecoded.push_back((hash, bytes)),
                Arrival::Event(Event::Scan { mut frame, bytes }) => {
                    // Only the latest of several is drawn.
                    let points = std::mem::take(&mut frame.points);
                    scan = Some((points, frame.map_from_base, frame.sequence));
                    self.apply(Event::Scan { frame, bytes });
                }
                Arrival::Event(event) => self.apply(event),
            }
        }
        if let Some((points, map_from_base, sequence)) = scan {
            if self.model.viewed().is_none() {
                match map_codec::decode(&points) {
                    Ok(chunk) => self.stage.show_scan(&chunk, &map_from_base),
                    Err(error) => browser::complain(&format!("a scan could not be decoded: {error}")),
                }
            }
            let acknowledgement = api::encode(&api::StreamRequest::Acknowledge { sequence });
            self.sockets.send(Socket::Stream, &acknowledgement);
        }
    }

    /// Decodes tiles for a few milliseconds. Returns whether some are left.
    fn decode(&mut self) -> bool {
        let begun = browser::now_ms();
        while let Some((hash, bytes)) = self.undecoded.pop_front() {
            let event = match map_codec::decode(&bytes) {
                Ok(chunk) => {
                    if let Some((entry, _)) = self.model.shown().tiles.get(&hash) {
                        self.stage.add_tile(hash, &chunk, entry, self.model.shown());
                    }
                    Event::TileReady { hash, bytes: bytes.len() }
                }
                Err(error) => {
                    browser::complain(&format!("tile {hash} could not be decoded: {error}"));
                    Event::TileFailed { hash }
                }
            };
            self.apply(event);
            if browser::now_ms() - begun > DECODE_MS {
                break;
            }
        }
        !self.undecoded.is_empty()
    }

    fn carry_out(&mut self) {
        while let Some(effect) = self.effects.pop_front() {
            match effect {
                Effect::Open(socket) => self.sockets.open(socket),
                Effect::Close(socket) => self.sockets.close(socket),
                Effect::Send(message) => self.sockets.send(Socket::Control, &api::encode(&message)),
                Effect::SendStream(request) => self.sockets.send(Socket::Stream, &api::encode(&request)),
                Effect::LoadMap(map) => self.fetches.map(map),
                Effect::Fetch(hash) => self.fetches.tile(hash),
                Effect::CancelFetch(hash) => {
                    self.fetches.cancel(&hash);
                    self.undecoded.retain(|(other, _)| *other != hash);
                }
                Effect::Drop(hash) => self.stage.drop_tile(hash),
                Effect::Move(to) => {
                    if let Some(settings) = self.viewport.go(&to, &self.model, &self.stage) {
                        self.apply(Event::Command(Command::Edit(settings)));
                    }
                }
                Effect::Keep(settings) => keep_view(&settings),
            }
        }
    }

    fn dress(&mut self, ctx: &egui::Context) {
        let theme = self.model.view.get().theme;
        if self.theme != Some(theme) {
            self.theme = Some(theme);
            theme::install(ctx, theme);
        }
    }

    fn schedule(&self, ctx: &egui::Context, undecoded: bool) {
        if undecoded {
            ctx.request_repaint();
        } else if self.model.drive.wanted().is_some() {
            ctx.request_repaint_after(DRIVE_REPAINT);
        } else {
            ctx.request_repaint_after(IDLE_REPAINT);
        }
    }
}

impl eframe::App for Client {
    fn logic(&mut self, ctx: &egui::Context, _frame: &mut eframe::Frame) {
        self.receive();
        let undecoded = self.decode();
        self.inputs.read(&mut self.panels);
        if browser::hidden() && self.model.drive.wanted().is_some() {
            // Nobody sees where the robot goes.
            self.apply(Event::Command(Command::Drive(None)));
        }
        self.apply(Event::Tick);
        if let Some(eye) = self.viewport.eye() {
            self.apply(Event::Looked(eye));
        }
        self.carry_out();
        self.schedule(ctx, undecoded);
    }

    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        let ctx = ui.ctx().clone();
        self.dress(&ctx);
        let tokens = Tokens::of(self.model.view.get().theme);
        let mut commands = std::mem::take(&mut self.commands);
        self.stage.follow(&self.model);
        self.viewport.show(ui, &self.model, &self.stage, &mut commands);
        panels::show_labels(ui, &tokens, &self.viewport.labels(&self.model), &mut commands);
        panels::show(&ctx, &self.model, &mut self.panels, &mut commands);
        self.inputs.lay(&self.panels, &tokens);
        for command in commands.drain(..) {
            self.apply(Event::Command(command));
            // What a command changed is drawn at once.
            ctx.request_repaint();
        }
        self.commands = commands;
        self.carry_out();
    }

    fn clear_color(&self, _visuals: &egui::Visuals) -> [f32; 4] {
        Tokens::of(self.model.view.get().theme).ground.to_normalized_gamma_f32()
    }
}

fn now() -> ClientTime {
    ClientTime(browser::now_ms() * 1e-3)
}

/// This tab's id: kept over reloads, so that a reload keeps control of the robot.
fn client_id() -> ClientId {
    let storage = browser::tab_storage();
    let kept = storage.as_ref().and_then(|storage| storage.get_item(CLIENT_KEY).ok().flatten());
    if let Some(id) = kept.and_then(|text| text.parse().ok()) {
        return id;
    }
    let id = ClientId(uuid::Uuid::new_v4());
    if let Some(storage) = storage {
        // A browser that stores nothing gives a new id to every reload, which does no harm.
        let _ = storage.set_item(CLIENT_KEY, &id.to_string());
    }
    id
}

fn kept_view() -> ViewSettings {
    browser::lasting_storage()
        .and_then(|storage| storage.get_item(VIEW_KEY).ok().flatten())
        .and_then(|text| serde_json::from_str(&text).ok())
        .unwrap_or_default()
}

fn keep_view(settings: &ViewSettings) {
    if let (Some(storage), Ok(text)) = (browser::lasting_storage(), serde_json::to_string(settings)) {
        // A full or forbidden storage only means that the next visit starts afresh.
        let _ = storage.set_item(VIEW_KEY, &text);
    }
}
