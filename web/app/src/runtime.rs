//! The runtime of the client: the model with its connections and timers. It does not depend on frames.
//!
//! A slow machine may draw one frame a second, and a browser draws none of a hidden tab. Between frames a timer of the page handles
//! pings, responses and driving. Decoding and drawing wait for the next frame.

use crate::browser;
use crate::decode_queue::{DecodeQueue, EncodedKeyframeScan, EncodedScan};
use crate::effects::{EffectExecutor, SceneEffect};
use crate::inbox::{InboundMessage, Inbox};
use crate::scene_sync::SceneSync;
use crate::viewport::Viewport;
use client_model::{ClientCommand, ClientEvent, ClientTime, Model};
use gloo_events::{EventListener, EventListenerOptions};
use gloo_timers::callback::Interval;
use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

/// Parameters of [`ClientRuntime`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RuntimeConfig {
    /// Period of the page's timer, ms: half the period of drive commands, so that none is late.
    timer_period_ms: u32,
    /// Age of the last frame from which the page's own events decide whether keys and pointer are still held, ms. Chosen: longer than frames of a slow machine, which are
    /// 130 ms apart ([`scene::FramePacingConfig::max_interval_s`]).
    late_frame_ms: f64,
    /// Age of the last frame from which driving stops, ms: the operator no longer sees the robot's motion. Chosen: longer than a frame of a software device at full
    /// quality, 1 s.
    max_blind_drive_ms: f64,
    /// Longest wait for the tile list before the first frame, ms. A local server answers in half this time. Chosen: twice that.
    max_list_wait_ms: f64,
    /// Longest wait for the first tile before the first frame, ms. Without a tile the first image is empty, and on a software device the
    /// next image takes longer than this wait. Chosen: shorter than the second from which people notice a wait.
    max_tile_wait_ms: f64,
    /// Period of the check for the tile during that wait. Chosen: far below both waits.
    wait_period: Duration,
}

impl Default for RuntimeConfig {
    fn default() -> Self {
        Self {
            timer_period_ms: 50,
            late_frame_ms: 150.0,
            max_blind_drive_ms: 2500.0,
            max_list_wait_ms: 200.0,
            max_tile_wait_ms: 600.0,
            wait_period: Duration::from_millis(5),
        }
    }
}

/// The model with its connections.
pub(crate) struct ClientRuntime {
    pub(crate) model: Model,
    pub(crate) effects: EffectExecutor,
    pub(crate) decode_queue: DecodeQueue,
    config: RuntimeConfig,
    inbox: Inbox,
    last_frame_ms: f64,
}

impl ClientRuntime {
    /// Begins to connect.
    pub(crate) fn new(config: RuntimeConfig, mut model: Model) -> Self {
        let inbox = Inbox::default();
        let mut effects = Vec::new();
        model.connect(&mut effects);
        let mut runtime = Self {
            model,
            effects: EffectExecutor::new(&inbox),
            decode_queue: DecodeQueue::default(),
            config,
            inbox,
            last_frame_ms: browser::now_ms(),
        };
        for effect in effects {
            runtime.effects.execute(effect, &mut runtime.decode_queue);
        }
        runtime
    }

    /// Whether the first image would show a part of the map, or there is no map to wait for.
    fn is_first_image_ready(&mut self) -> bool {
        self.process_inbox();
        if let Some(viewpoint) = crate::viewport::first_viewpoint(&self.model) {
            self.apply(ClientEvent::ViewpointChanged(viewpoint));
        }
        let tiles = &self.model.displayed_map().tiles;
        self.decode_queue.has_tiles() || (tiles.listed() && tiles.is_empty())
    }

    /// Sets the context whose frames later inbound messages request.
    pub(crate) fn set_context(&self, ctx: &egui::Context) {
        self.inbox.set_context(ctx);
    }

    /// Lets the model handle an event and executes the effects. No other function changes the model.
    pub(crate) fn apply(&mut self, event: ClientEvent) {
        let mut effects = Vec::new();
        self.model.handle_event(now(), event, &mut effects);
        for effect in effects {
            self.effects.execute(effect, &mut self.decode_queue);
        }
    }

    /// Executes the effects that waited for a frame, oldest first.
    pub(crate) fn execute_scene_effects(&mut self, scene: &SceneSync, viewport: &mut Viewport) {
        while let Some(effect) = self.effects.pop_scene_effect() {
            match effect {
                SceneEffect::RemoveTile(hash) => scene.remove_tile(hash),
                SceneEffect::MoveCamera(to) => {
                    if let Some(settings) = viewport.move_camera(&to, &self.model, scene) {
                        self.apply(ClientEvent::Command(ClientCommand::EditView(settings)));
                    }
                }
            }
        }
    }

    /// Handles all inbound messages, then advances the model's time.
    pub(crate) fn process_inbox(&mut self) {
        while let Some(message) = self.inbox.pop() {
            match message {
                InboundMessage::Tile { hash, bytes } => self.decode_queue.push_tile(hash, bytes),
                InboundMessage::KeyframeScan { session, keyframe, bytes } => {
                    let scan = EncodedKeyframeScan { session, keyframe, bytes };
                    self.decode_queue.push_keyframe_scan(scan);
                }
                InboundMessage::Event(ClientEvent::Scan { mut frame, bytes }) => {
                    // Only the latest of several scans is drawn.
                    let points = std::mem::take(&mut frame.points);
                    let (map_from_base, sequence) = (frame.map_from_base, frame.sequence);
                    self.decode_queue.set_live_scan(EncodedScan { points, map_from_base, sequence });
                    self.apply(ClientEvent::Scan { frame, bytes });
                }
                InboundMessage::Event(event) => self.apply(event),
            }
        }
        self.apply(ClientEvent::Tick);
    }

    /// Begins a frame: records its time and handles inbound messages. `stream_interval`: time to the next frame that only shows what the robot sends.
    pub(crate) fn begin_frame(&mut self, stream_interval: Duration) {
        self.last_frame_ms = browser::now_ms();
        self.process_inbox();
        // While a saved map is shown, the frames for shown ages are enough for the robot's state.
        let is_robot_shown = self.model.viewed_map().is_none();
        self.inbox.set_periodic_delay(is_robot_shown.then_some(stream_interval));
    }

    /// The live scan to draw. Taking it acknowledges it, and the server sends the next one.
    pub(crate) fn take_live_scan(&mut self) -> Option<EncodedScan> {
        let scan = self.decode_queue.take_live_scan()?;
        self.effects.send_stream_request(&api::StreamRequest::Acknowledge { sequence: scan.sequence });
        Some(scan)
    }

    /// Handles an event of the page's timer.
    fn on_timer(&mut self) {
        if browser::hidden() || browser::now_ms() - self.last_frame_ms > self.config.max_blind_drive_ms {
            self.stop_driving();
        }
        self.process_inbox();
    }

    /// Handles the release of a key or the pointer while frames are late. Frames in time detect it themselves.
    fn on_release(&mut self) {
        if browser::now_ms() - self.last_frame_ms > self.config.late_frame_ms {
            self.stop_driving();
        }
    }

    fn stop_driving(&mut self) {
        if self.model.driven_velocity().is_some() {
            self.apply(ClientEvent::Command(ClientCommand::SetVelocity(None)));
        }
    }
}

/// Waits until the first image can show a part of the map, within the limits of [`RuntimeConfig`].
pub(crate) async fn wait_for_first_tile(runtime: &Rc<RefCell<ClientRuntime>>) {
    let started_ms = browser::now_ms();
    loop {
        let (ready, max_wait_ms, period) = {
            let mut runtime = runtime.borrow_mut();
            let ready = runtime.is_first_image_ready();
            let (listed, config) = (runtime.model.displayed_map().tiles.listed(), runtime.config);
            let max_wait_ms = if listed { config.max_tile_wait_ms } else { config.max_list_wait_ms };
            (ready, max_wait_ms, config.wait_period)
        };
        // Waits also when ready, because the browser sends requests only while the client pauses.
        gloo_timers::future::sleep(period).await;
        if ready || browser::now_ms() - started_ms >= max_wait_ms {
            return;
        }
    }
}

/// Installs the timer and the event listeners that drive the runtime. They live as long as the page.
pub(crate) fn install_page_events(runtime: &Rc<RefCell<ClientRuntime>>) {
    let Some(window) = browser::window() else { return };
    let on_timer = with_runtime(runtime, ClientRuntime::on_timer);
    let period_ms = runtime.borrow().config.timer_period_ms;
    Interval::new(period_ms, on_timer).forget();
    for event in ["keyup", "pointerup", "pointercancel", "blur"] {
        let mut on_release = with_runtime(runtime, ClientRuntime::on_release);
        // In the capture phase, before a listener can stop the event.
        let options = EventListenerOptions::run_in_capture_phase();
        EventListener::new_with_options(&window, event, options, move |_| on_release()).forget();
    }
}

fn with_runtime(runtime: &Rc<RefCell<ClientRuntime>>, act: fn(&mut ClientRuntime)) -> impl FnMut() + 'static {
    let runtime = Rc::clone(runtime);
    move || {
        // The runtime is borrowed only during a frame, which does the same work.
        if let Ok(mut runtime) = runtime.try_borrow_mut() {
            act(&mut runtime);
        }
    }
}

/// Time since the page was opened.
pub(crate) fn now() -> ClientTime {
    ClientTime(browser::now_ms() * 1e-3)
}
