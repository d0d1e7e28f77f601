//! The eframe application: every frame it decodes downloads, updates the scene, draws the viewport and the panels, and applies commands.

use crate::camera_inset::CameraInset;
use crate::decode_queue::EncodedKeyframeScan;
use crate::runtime::{ClientRuntime, RuntimeConfig, install_page_events, now};
use crate::scene_sync::SceneSync;
use crate::text_inputs::TextInputElements;
use crate::viewport::{Viewport, ViewportConfig};
use crate::{aria, browser, graphics, storage, texts};
use client_model::{ClientCommand, ClientEvent, Ids, Model, Theme};
use panels::PanelState;
use panels::theme::{self, Tokens};
use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

/// Parameters of [`ClientApp`].
#[derive(Clone, Copy, Debug, PartialEq)]
struct ClientAppConfig {
    /// Time for decoding tiles in one frame, ms. The last tile may exceed it. Chosen: a quarter of a frame at 60 Hz.
    decode_ms: f64,
    /// Interval of frames while nothing moves: shown ages and countdowns still change. Chosen: ages and countdowns are shown in seconds.
    idle_repaint: Duration,
    /// Interval of frames while the robot is driven by hand: its velocity is read from joystick and keys in every frame. Chosen: half the period of drive commands.
    drive_repaint: Duration,
}

impl Default for ClientAppConfig {
    fn default() -> Self {
        Self {
            decode_ms: 4.0,
            idle_repaint: Duration::from_millis(500),
            drive_repaint: Duration::from_millis(50),
        }
    }
}

/// Begins to connect. This precedes the graphics device, so that the server answers while the browser makes it.
pub(crate) fn connect() -> Rc<RefCell<ClientRuntime>> {
    let ids = Ids::new(browser::random_u128());
    let mut model = Model::new(storage::load_lease_token(), ids, storage::load_view_settings(), now());
    model.restore_draft(storage::load_draft());
    let runtime = Rc::new(RefCell::new(ClientRuntime::new(RuntimeConfig::default(), model)));
    install_page_events(&runtime);
    runtime
}

/// The application.
pub(crate) struct ClientApp {
    config: ClientAppConfig,
    runtime: Rc<RefCell<ClientRuntime>>,
    panels: PanelState,
    scene: SceneSync,
    viewport: Viewport,
    camera_inset: CameraInset,
    text_inputs: TextInputElements,
    commands: Vec<ClientCommand>,
    theme: Option<Theme>,
    startup: StartupStage,
    /// Whether no frame has been drawn yet.
    is_first_frame: bool,
}

/// Progress of the page's start. Each stage is marked once in the browser's performance timeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StartupStage {
    /// Nothing is drawn yet.
    Opened,
    /// Frames are drawn, without a map.
    Framed,
    /// The current frame is the first with points of a map.
    DrawingMap,
    /// A map was drawn.
    MapDrawn,
}

type CreateError = Box<dyn std::error::Error + Send + Sync>;

impl ClientApp {
    /// The application of a runtime that is connecting already.
    pub(crate) fn create(
        runtime: Rc<RefCell<ClientRuntime>>,
        context: &eframe::CreationContext<'_>,
    ) -> Result<Box<dyn eframe::App>, CreateError> {
        let device = context.wgpu_render_state.as_ref().ok_or("the browser gave no graphics device")?;
        let ctx = &context.egui_ctx;
        theme::install_fonts(ctx);
        browser::add_font("Inter", theme::INTER_REGULAR);
        aria::install(ctx);
        runtime.borrow().set_context(ctx);
        let mut renderer = scene::Renderer::new(&device.device, &device.queue, device.target_format);
        renderer.defer_overlay();
        let scene = SceneSync::new(renderer);
        device.renderer.write().callback_resources.insert(scene.renderer.clone());
        let frame_pacer =
            graphics::initial_frame_pacer(graphics::GraphicsConfig::default(), &device.adapter.get_info());
        Ok(Box::new(Self {
            config: ClientAppConfig::default(),
            runtime,
            panels: PanelState::for_page(browser::clock()),
            scene,
            viewport: Viewport::new(ViewportConfig::default(), frame_pacer),
            camera_inset: CameraInset::default(),
            text_inputs: TextInputElements::new(ctx.clone()),
            commands: Vec::new(),
            theme: None,
            startup: StartupStage::Opened,
            is_first_frame: true,
        }))
    }

    fn update_live_scan(&mut self, runtime: &mut ClientRuntime) {
        let Some(scan) = runtime.take_live_scan() else { return };
        if runtime.model.viewed_map().is_some() {
            return;
        }
        match map_codec::decode(&scan.points) {
            Ok(chunk) => self.scene.set_live_scan(&chunk, &scan.map_from_base),
            Err(error) => browser::log_warning(&format!("a scan could not be decoded: {error}")),
        }
    }

    /// Decodes tiles for [`ClientAppConfig::decode_ms`].
    fn decode_tiles(&mut self, runtime: &mut ClientRuntime) {
        let started_ms = browser::now_ms();
        while let Some((hash, bytes)) = runtime.decode_queue.pop_tile() {
            let event = match map_codec::decode(&bytes) {
                Ok(chunk) => {
                    let map = runtime.model.displayed_map();
                    if let Some((entry, _)) = map.tiles.get(&hash) {
                        self.scene.insert_tile(hash, &chunk, entry, map);
                        if self.startup == StartupStage::Framed {
                            self.startup = StartupStage::DrawingMap;
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
            if browser::now_ms() - started_ms > self.config.decode_ms {
                break;
            }
        }
    }

    /// Decodes scans of keyframes. At most two wait at a time, so this needs no time limit.
    fn decode_keyframe_scans(&mut self, runtime: &mut ClientRuntime) {
        while let Some(scan) = runtime.decode_queue.pop_keyframe_scan() {
            let EncodedKeyframeScan { session, keyframe, bytes } = scan;
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
                    Err(texts::scan_unreadable(keyframe))
                }
            };
            runtime.apply(ClientEvent::CloudFetched { session, keyframe, result });
        }
    }

    /// Marks the page's start in the browser's performance timeline.
    fn mark_startup(&mut self) {
        let (mark, next) = match self.startup {
            StartupStage::Opened => ("autoinspect: first frame begins", StartupStage::Framed),
            StartupStage::DrawingMap => ("autoinspect: first map drawn", StartupStage::MapDrawn),
            StartupStage::Framed | StartupStage::MapDrawn => return,
        };
        browser::mark(mark);
        self.startup = next;
    }

    fn apply_theme(&mut self, ctx: &egui::Context, theme: Theme) {
        if self.theme != Some(theme) {
            self.theme = Some(theme);
            theme::install(ctx, theme);
        }
    }
}

impl eframe::App for ClientApp {
    fn raw_input_hook(&mut self, _ctx: &egui::Context, raw_input: &mut egui::RawInput) {
        self.text_inputs.pass_wheel(raw_input);
    }

    fn logic(&mut self, ctx: &egui::Context, _frame: &mut eframe::Frame) {
        let runtime = Rc::clone(&self.runtime);
        let mut runtime = runtime.borrow_mut();
        self.mark_startup();
        runtime.begin_frame(self.viewport.stream_interval());
        self.scene.update_ground(&runtime.model);
        // Tiles are removed before others are inserted, because a tile may be removed and fetched again.
        runtime.execute_scene_effects(&self.scene, &mut self.viewport);
        self.scene.switch_map(&runtime.model);
        self.update_live_scan(&mut runtime);
        self.decode_tiles(&mut runtime);
        self.decode_keyframe_scans(&mut runtime);
        self.text_inputs.take_events(&mut self.panels.text_inputs);
        runtime.effects.result_files.put_in(ctx, &mut self.panels.files);
        if runtime.decode_queue.has_tiles() {
            ctx.request_repaint();
        }
        let driving = runtime.model.driven_velocity().is_some();
        ctx.request_repaint_after(if driving { self.config.drive_repaint } else { self.config.idle_repaint });
    }

    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        let runtime = Rc::clone(&self.runtime);
        let mut runtime = runtime.borrow_mut();
        let ctx = ui.ctx().clone();
        let theme = runtime.model.view_settings().theme;
        self.apply_theme(&ctx, theme);
        let tokens = Tokens::of(theme);
        let mut commands = std::mem::take(&mut self.commands);
        let ClientRuntime { model, effects, .. } = &mut *runtime;
        if let Some(clouds) = effects.change_clouds.update(model) {
            self.scene.set_changed(&clouds);
        }
        self.scene.update(&runtime.model, self.viewport.dragged_pose(), self.viewport.graph().preview());
        let free = self.panels.free_area(ctx.content_rect());
        let was_dragging = self.viewport.graph().is_dragging();
        self.viewport.show(ui, &runtime.model, &self.scene, free, &mut commands);
        if let Some(viewpoint) = self.viewport.viewpoint() {
            runtime.apply(ClientEvent::ViewpointChanged(viewpoint));
        }
        if std::mem::take(&mut self.is_first_frame) {
            // The first frame shows the map only, because the first layout of all texts takes as long as the rest of the frame.
            ctx.request_repaint();
        } else {
            let labels = self.viewport.labels(&runtime.model);
            panels::show_labels(ui, &runtime.model, &tokens, &labels, &mut commands);
            self.panels.set_scene_drag(self.viewport.graph().scene_drag(&runtime.model, was_dragging));
            self.panels.clock.utc = browser::utc();
            self.panels.is_motion_reduced = browser::reduced_motion();
            panels::show(&ctx, &runtime.model, &mut self.panels, &mut commands);
            if let Some(view) = self.viewport.view() {
                self.camera_inset.show(&ctx, &mut self.panels, &self.scene, &view);
            }
            self.text_inputs.update(&self.panels.text_inputs, &tokens);
            let wanted = self.panels.files.take_wanted().into_iter();
            commands.extend(wanted.map(|(blob, kind)| ClientCommand::FetchResultFile { blob, kind }));
        }
        for command in commands.drain(..) {
            // The effect of a command is drawn at once. A velocity command changes nothing that is drawn.
            if !matches!(command, ClientCommand::SetVelocity(_)) {
                ctx.request_repaint();
            }
            runtime.apply(ClientEvent::Command(command));
        }
        self.commands = commands;
        runtime.execute_scene_effects(&self.scene, &mut self.viewport);
    }

    fn clear_color(&self, _visuals: &egui::Visuals) -> [f32; 4] {
        Tokens::of(self.theme.unwrap_or_default()).ground.to_normalized_gamma_f32()
    }
}
