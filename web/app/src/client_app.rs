//! The running client: takes what came in, lets the model decide, draws.

use crate::runtime::{ClientRuntime, Cloud, install_page_events, now};
use crate::scene_sync::SceneSync;
use crate::text_inputs::Inputs;
use crate::viewport::{Viewport, ViewportConfig};
use crate::{aria, browser, graphics};
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
pub(crate) fn connect() -> Rc<RefCell<ClientRuntime>> {
    let ids = Ids::new(browser::random_u128());
    let model = Model::new(load_client_id(), ids, load_view_settings(), now());
    let runtime = Rc::new(RefCell::new(ClientRuntime::new(model)));
    install_page_events(&runtime);
    runtime
}

/// The client.
pub(crate) struct ClientApp {
    runtime: Rc<RefCell<ClientRuntime>>,
    panels: PanelState,
    scene: SceneSync,
    viewport: Viewport,
    inputs: Inputs,
    commands: Vec<ClientCommand>,
    theme: Option<Theme>,
    start: StartupStage,
    /// Whether the frame to come is the first.
    bare: bool,
}

/// How far the page has come since it was opened; each step is noted once in the browser's timeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StartupStage {
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

impl ClientApp {
    /// Makes the client that draws what `runtime` knows.
    pub(crate) fn create(
        runtime: Rc<RefCell<ClientRuntime>>,
        context: &eframe::CreationContext<'_>,
    ) -> Result<Box<dyn eframe::App>, CreateError> {
        let device = context.wgpu_render_state.as_ref().ok_or("the browser gave no graphics device")?;
        let ctx = &context.egui_ctx;
        theme::install_fonts(ctx);
        browser::add_font("Inter", theme::INTER_REGULAR);
        aria::install(ctx);
        runtime.borrow().wake(ctx);
        let mut renderer = scene::Renderer::new(&device.device, &device.queue, device.target_format);
        renderer.defer_overlay();
        let scene = SceneSync::new(renderer);
        device.renderer.write().callback_resources.insert(scene.renderer.clone());
        Ok(Box::new(Self {
            runtime,
            panels: PanelState::for_page(browser::utc_offset_s()),
            scene,
            viewport: Viewport::new(
                ViewportConfig::default(),
                graphics::initial_frame_pacer(&device.adapter.get_info()),
            ),
            inputs: Inputs::new(ctx.clone()),
            commands: Vec::new(),
            theme: None,
            start: StartupStage::Opened,
            bare: true,
        }))
    }

    fn set_live_scan(&mut self, runtime: &mut ClientRuntime) {
        let Some(scan) = runtime.take_scan() else { return };
        if runtime.model.viewed_map().is_some() {
            return;
        }
        match map_codec::decode(&scan.points) {
            Ok(chunk) => self.scene.set_live_scan(&chunk, &scan.map_from_base),
            Err(error) => browser::log_warning(&format!("a scan could not be decoded: {error}")),
        }
    }

    /// Decodes tiles for a few milliseconds.
    fn decode_tiles(&mut self, runtime: &mut ClientRuntime) {
        let begun = browser::now_ms();
        while let Some((hash, bytes)) = runtime.next_tile() {
            let event = match map_codec::decode(&bytes) {
                Ok(chunk) => {
                    let map = runtime.model.displayed_map();
                    if let Some((entry, _)) = map.tiles.get(&hash) {
                        self.scene.add_tile(hash, &chunk, entry, map);
                        if self.start == StartupStage::Framed {
                            self.start = StartupStage::Mapping;
                        }
                    }
                    ClientEvent::TileReady { hash, bytes: bytes.len() }
                }
                Err(error) => {
                    browser::log_warning(&format!("tile {hash} could not be decoded: {error}"));
                    ClientEvent::TileFailed { hash }
                }
            };
            runtime.apply(event);
            if browser::now_ms() - begun > DECODE_MS {
                break;
            }
        }
    }

    /// Decodes scans of keyframes: two at a time at most, and quick.
    fn decode_clouds(&mut self, runtime: &mut ClientRuntime) {
        while let Some(Cloud { session, keyframe, bytes }) = runtime.next_cloud() {
            let result = match map_codec::decode(&bytes) {
                Ok(chunk) => {
                    self.scene.insert_keyframe_scan(keyframe, chunk);
                    Ok(())
                }
                Err(error) => {
                    browser::log_warning(&format!(
                        "the scan of keyframe {} could not be decoded: {error}",
                        keyframe.0
                    ));
                    Err(format!("The scan of keyframe {} cannot be read. Reload the page.", keyframe.0))
                }
            };
            runtime.apply(ClientEvent::CloudFetched { session, keyframe, result });
        }
    }

    /// What the model left for the frame to do.
    fn execute_effects(&mut self, runtime: &mut ClientRuntime) {
        while let Some(effect) = runtime.next_effect() {
            match effect {
                ClientEffect::RemoveTile(hash) => self.scene.remove_tile(hash),
                ClientEffect::MoveCamera(to) => {
                    if let Some(settings) = self.viewport.move_camera(&to, &runtime.model) {
                        runtime.apply(ClientEvent::Command(ClientCommand::EditView(settings)));
                    }
                }
                ClientEffect::SaveSettings(settings) => save_view_settings(&settings),
                // The runtime carries out all others by itself.
                _ => {}
            }
        }
    }

    /// Notes in the browser's timeline how far the page has come.
    fn mark_startup(&mut self) {
        let (moment, next) = match self.start {
            StartupStage::Opened => ("autoinspect: first frame begins", StartupStage::Framed),
            StartupStage::Mapping => ("autoinspect: first map drawn", StartupStage::Mapped),
            StartupStage::Framed | StartupStage::Mapped => return,
        };
        browser::mark(moment);
        self.start = next;
    }

    fn apply_theme(&mut self, ctx: &egui::Context, theme: Theme) {
        if self.theme != Some(theme) {
            self.theme = Some(theme);
            theme::install(ctx, theme);
        }
    }
}

impl eframe::App for ClientApp {
    fn logic(&mut self, ctx: &egui::Context, _frame: &mut eframe::Frame) {
        let runtime = Rc::clone(&self.runtime);
        let mut runtime = runtime.borrow_mut();
        self.mark_startup();
        runtime.frame();
        // What was dropped goes before what came: it may be the same tile, fetched again.
        self.execute_effects(&mut runtime);
        self.scene.switch_map(&runtime.model);
        self.set_live_scan(&mut runtime);
        self.decode_tiles(&mut runtime);
        self.decode_clouds(&mut runtime);
        self.inputs.read(&mut self.panels);
        if runtime.has_tiles() {
            ctx.request_repaint();
        }
        let driving = runtime.model.driven_velocity().is_some();
        ctx.request_repaint_after(if driving { DRIVE_REPAINT } else { IDLE_REPAINT });
    }

    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        let runtime = Rc::clone(&self.runtime);
        let mut runtime = runtime.borrow_mut();
        let ctx = ui.ctx().clone();
        let theme = runtime.model.view_settings().theme;
        self.apply_theme(&ctx, theme);
        let tokens = Tokens::of(theme);
        let mut commands = std::mem::take(&mut self.commands);
        self.scene.follow(&runtime.model, self.viewport.dragged_pose());
        self.viewport.show(ui, &runtime.model, &self.scene, &mut commands);
        if let Some(viewpoint) = self.viewport.viewpoint() {
            runtime.apply(ClientEvent::ViewpointChanged(viewpoint));
        }
        if std::mem::take(&mut self.bare) {
            // The map first: shaping all text for the first time takes as long as all else, and can follow a frame later.
            ctx.request_repaint();
        } else {
            panels::show_labels(ui, &tokens, &self.viewport.labels(&runtime.model), &mut commands);
            panels::show(&ctx, &runtime.model, &mut self.panels, &mut commands);
            self.inputs.lay(&self.panels, &tokens);
        }
        for command in commands.drain(..) {
            // What a command changes is drawn at once; driving changes nothing that is drawn.
            if !matches!(command, ClientCommand::SetVelocity(_)) {
                ctx.request_repaint();
            }
            runtime.apply(ClientEvent::Command(command));
        }
        self.commands = commands;
        self.execute_effects(&mut runtime);
    }

    fn clear_color(&self, _visuals: &egui::Visuals) -> [f32; 4] {
        Tokens::of(self.theme.unwrap_or_default()).ground.to_normalized_gamma_f32()
    }
}

/// This tab's id: kept over reloads, so that a reload keeps control of the robot.
fn load_client_id() -> ClientId {
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

fn load_view_settings() -> ViewSettings {
    browser::lasting_storage()
        .and_then(|storage| storage.get_item(VIEW_KEY).ok().flatten())
        .and_then(|text| serde_json::from_str(&text).ok())
        .unwrap_or_default()
}

fn save_view_settings(settings: &ViewSettings) {
    if let (Some(storage), Ok(text)) = (browser::lasting_storage(), serde_json::to_string(settings)) {
        // A full or forbidden storage only means that the next visit starts afresh.
        let _ = storage.set_item(VIEW_KEY, &text);
    }
}
