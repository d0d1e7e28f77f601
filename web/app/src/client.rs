//! The running client: takes what came in, lets the model decide, draws.

use crate::core::{Cloud, Core, keep_alive, now};
use crate::inputs::Inputs;
use crate::stage::Stage;
use crate::viewport::Viewport;
use crate::{aria, browser, gpu};
use client_model::{ClientCommand, ClientEffect, ClientEvent, Ids, Model, Theme, ViewSettings};
use panels::PanelState;
use panels::theme::{self, Tokens};
use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;
use vocab::ClientId;

/// Time spent on decoding tiles in one frame, milliseconds; a tile that is begun is finished.
const DECODE_MS: f64 = 4.0;
/// While nothing moves, ages and countdowns still have to.
const IDLE_REPAINT: Duration = Duration::from_millis(500);
/// While the hand is on the stick, the velocity it wants is looked at this often.
const DRIVE_REPAINT: Duration = Duration::from_millis(50);
const CLIENT_KEY: &str = "autoinspect.client";
const VIEW_KEY: &str = "autoinspect.view";

/// Begins to connect. Before there is anything to draw with: the server answers while the browser looks for graphics.
pub(crate) fn connect() -> Rc<RefCell<Core>> {
    let ids = Ids::new(browser::random_u128());
    let model = Model::new(client_id(), ids, kept_view(), now());
    let core = Rc::new(RefCell::new(Core::new(model)));
    keep_alive(&core);
    core
}

/// The client.
pub(crate) struct Client {
    core: Rc<RefCell<Core>>,
    panels: PanelState,
    stage: Stage,
    viewport: Viewport,
    inputs: Inputs,
    commands: Vec<ClientCommand>,
    theme: Option<Theme>,
    start: Start,
    /// Whether the frame to come is the first.
    bare: bool,
}

/// How far the page has come since it was opened; each step is noted once in the browser's timeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Start {
    /// Nothing is drawn yet.
    Opened,
    /// Frames are drawn, without a map.
    Framed,
    /// The frame being made is the first with points of a map in it.
    Mapping,
    /// A map was drawn.
    Mapped,
}

type CreateError = Box<dyn std::error::Error + Send + Sync>;

impl Client {
    /// Makes the client that draws what `core` knows.
    pub(crate) fn create(
        core: Rc<RefCell<Core>>,
        context: &eframe::CreationContext<'_>,
    ) -> Result<Box<dyn eframe::App>, CreateError> {
        let device = context.wgpu_render_state.as_ref().ok_or("the browser gave no graphics device")?;
        let ctx = &context.egui_ctx;
        theme::install_fonts(ctx);
        browser::add_font("Inter", theme::INTER_REGULAR);
        aria::install(ctx);
        core.borrow().wake(ctx);
        let mut renderer = scene::Renderer::new(&device.device, &device.queue, device.target_format);
        renderer.hurry();
        let stage = Stage::new(renderer);
        device.renderer.write().callback_resources.insert(stage.renderer.clone());
        Ok(Box::new(Self {
            core,
            panels: PanelState::for_page(browser::utc_offset_s()),
            stage,
            viewport: Viewport::new(gpu::pace(&device.adapter.get_info())),
            inputs: Inputs::new(ctx.clone()),
            commands: Vec::new(),
            theme: None,
            start: Start::Opened,
            bare: true,
        }))
    }

    fn show_scan(&mut self, core: &mut Core) {
        let Some(scan) = core.take_scan() else { return };
        if core.model.viewed_map().is_some() {
            return;
        }
        match map_codec::decode(&scan.points) {
            Ok(chunk) => self.stage.show_scan(&chunk, &scan.map_from_base),
            Err(error) => browser::complain(&format!("a scan could not be decoded: {error}")),
        }
    }

    /// Decodes tiles for a few milliseconds.
    fn decode_tiles(&mut self, core: &mut Core) {
        let begun = browser::now_ms();
        while let Some((hash, bytes)) = core.next_tile() {
            let event = match map_codec::decode(&bytes) {
                Ok(chunk) => {
                    let map = core.model.displayed_map();
                    if let Some((entry, _)) = map.tiles.get(&hash) {
                        self.stage.add_tile(hash, &chunk, entry, map);
                        if self.start == Start::Framed {
                            self.start = Start::Mapping;
                        }
                    }
                    ClientEvent::TileReady { hash, bytes: bytes.len() }
                }
                Err(error) => {
                    browser::complain(&format!("tile {hash} could not be decoded: {error}"));
                    ClientEvent::TileFailed { hash }
                }
            };
            core.apply(event);
            if browser::now_ms() - begun > DECODE_MS {
                break;
            }
        }
    }

    /// Decodes scans of keyframes: two at a time at most, and quick.
    fn decode_clouds(&mut self, core: &mut Core) {
        while let Some(Cloud { session, keyframe, bytes }) = core.next_cloud() {
            let result = match map_codec::decode(&bytes) {
                Ok(chunk) => {
                    self.stage.keep_cloud(keyframe, chunk);
                    Ok(())
                }
                Err(error) => {
                    browser::complain(&format!(
                        "the scan of keyframe {} could not be decoded: {error}",
                        keyframe.0
                    ));
                    Err(format!("The scan of keyframe {} cannot be read. Reload the page.", keyframe.0))
                }
            };
            core.apply(ClientEvent::CloudFetched { session, keyframe, result });
        }
    }

    /// What the model left for the frame to do.
    fn carry_out(&mut self, core: &mut Core) {
        while let Some(effect) = core.next_effect() {
            match effect {
                ClientEffect::RemoveTile(hash) => self.stage.drop_tile(hash),
                ClientEffect::MoveCamera(to) => {
                    if let Some(settings) = self.viewport.go(&to, &core.model) {
                        core.apply(ClientEvent::Command(ClientCommand::EditView(settings)));
                    }
                }
                ClientEffect::SaveSettings(settings) => keep_view(&settings),
                // The core carries out all others by itself.
                _ => {}
            }
        }
    }

    /// Notes in the browser's timeline how far the page has come.
    fn note_start(&mut self) {
        let (moment, next) = match self.start {
            Start::Opened => ("autoinspect: first frame begins", Start::Framed),
            Start::Mapping => ("autoinspect: first map drawn", Start::Mapped),
            Start::Framed | Start::Mapped => return,
        };
        browser::mark(moment);
        self.start = next;
    }

    fn dress(&mut self, ctx: &egui::Context, theme: Theme) {
        if self.theme != Some(theme) {
            self.theme = Some(theme);
            theme::install(ctx, theme);
        }
    }
}

impl eframe::App for Client {
    fn logic(&mut self, ctx: &egui::Context, _frame: &mut eframe::Frame) {
        let core = Rc::clone(&self.core);
        let mut core = core.borrow_mut();
        self.note_start();
        core.frame();
        // What was dropped goes before what came: it may be the same tile, fetched again.
        self.carry_out(&mut core);
        self.stage.change_map(&core.model);
        self.show_scan(&mut core);
        self.decode_tiles(&mut core);
        self.decode_clouds(&mut core);
        self.inputs.read(&mut self.panels);
        if core.has_tiles() {
            ctx.request_repaint();
        }
        let driving = core.model.driven_velocity().is_some();
        ctx.request_repaint_after(if driving { DRIVE_REPAINT } else { IDLE_REPAINT });
    }

    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        let core = Rc::clone(&self.core);
        let mut core = core.borrow_mut();
        let ctx = ui.ctx().clone();
        let theme = core.model.view_settings().theme;
        self.dress(&ctx, theme);
        let tokens = Tokens::of(theme);
        let mut commands = std::mem::take(&mut self.commands);
        self.stage.follow(&core.model, self.viewport.placing());
        self.viewport.show(ui, &core.model, &self.stage, &mut commands);
        if let Some(eye) = self.viewport.eye() {
            core.apply(ClientEvent::ViewpointChanged(eye));
        }
        if std::mem::take(&mut self.bare) {
            // The map first: shaping all text for the first time takes as long as all else, and can follow a frame later.
            ctx.request_repaint();
        } else {
            panels::show_labels(ui, &tokens, &self.viewport.labels(&core.model), &mut commands);
            panels::show(&ctx, &core.model, &mut self.panels, &mut commands);
            self.inputs.lay(&self.panels, &tokens);
        }
        for command in commands.drain(..) {
            // What a command changes is drawn at once; driving changes nothing that is drawn.
            if !matches!(command, ClientCommand::SetVelocity(_)) {
                ctx.request_repaint();
            }
            core.apply(ClientEvent::Command(command));
        }
        self.commands = commands;
        self.carry_out(&mut core);
    }

    fn clear_color(&self, _visuals: &egui::Visuals) -> [f32; 4] {
        Tokens::of(self.theme.unwrap_or_default()).ground.to_normalized_gamma_f32()
    }
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
