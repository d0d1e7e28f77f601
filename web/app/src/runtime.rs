//! The part of the client that must not wait for pictures: sockets, timers and orders to the robot.
//!
//! A slow machine may draw a picture every second, and a browser draws none of a hidden tab. Pings, answers and driving
//! go on meanwhile, moved by a timer of the page; what only concerns the picture is left for the next frame.

use crate::browser;
use crate::downloads::Downloads;
use crate::inbox::{InboundMessage, Inbox};
use crate::sockets::SocketConnections;
use crate::uploads::Uploads;
use client_model::{ClientCommand, ClientEffect, ClientEvent, ClientTime, Model, Socket};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use vocab::{KeyframeId, Pose, SessionId};
use wasm_bindgen::JsCast;
use wasm_bindgen::prelude::Closure;

/// Twice as often as driving needs, so that orders go out in time, milliseconds.
const BEAT_MS: i32 = 50;
/// A frame older than this is late: whether the hand is still on the stick is then asked of the page, milliseconds.
const LATE_MS: f64 = 150.0;
/// Without a frame for so long, nobody sees where the robot goes, milliseconds.
const BLIND_MS: f64 = 2500.0;

/// How long the start waits for word of the map: a local server has given it in half of this.
const REACH_MS: f64 = 200.0;
/// How long it waits for the first tile of a map that it knows of. Without it the first picture shows no map, and where
/// the processor draws, a picture more costs longer than this.
const REACH_TILE_MS: f64 = 600.0;
const REACH_EVERY_MS: i32 = 5;

/// The model with its connections.
pub(crate) struct ClientRuntime {
    pub(crate) model: Model,
    sockets: SocketConnections,
    fetches: Downloads,
    uploads: Uploads,
    inbox: Inbox,
    for_frame: VecDeque<ClientEffect>,
    tiles: VecDeque<(api::TileHash, Vec<u8>)>,
    scan: Option<Scan>,
    clouds: VecDeque<Cloud>,
    framed_ms: f64,
}

/// The latest live scan, still encoded.
pub(crate) struct Scan {
    pub(crate) points: Vec<u8>,
    pub(crate) map_from_base: Pose,
    sequence: u64,
}

/// The scan of a keyframe, still encoded.
pub(crate) struct Cloud {
    pub(crate) session: SessionId,
    pub(crate) keyframe: KeyframeId,
    pub(crate) bytes: Vec<u8>,
}

impl ClientRuntime {
    /// Begins to connect.
    pub(crate) fn new(mut model: Model) -> Self {
        let inbox = Inbox::default();
        let mut effects = Vec::new();
        model.connect(&mut effects);
        let (sockets, fetches) = (SocketConnections::new(inbox.clone()), Downloads::new(inbox.clone()));
        let mut runtime = Self {
            model,
            sockets,
            fetches,
            uploads: Uploads::new(inbox.clone()),
            inbox,
            for_frame: VecDeque::new(),
            tiles: VecDeque::new(),
            scan: None,
            clouds: VecDeque::new(),
            framed_ms: browser::now_ms(),
        };
        runtime.execute_effects(effects);
        runtime
    }

    /// Whether something of what the first picture shows is here, or there is nothing to wait for.
    fn is_first_image_ready(&mut self) -> bool {
        self.process_inbox();
        if let Some(viewpoint) = crate::viewport::first_viewpoint(&self.model) {
            self.apply(ClientEvent::ViewpointChanged(viewpoint));
        }
        let tiles = &self.model.displayed_map().tiles;
        self.has_tiles() || (tiles.listed() && tiles.is_empty())
    }

    /// There are frames from now on, and this makes them.
    pub(crate) fn wake(&self, ctx: &egui::Context) {
        self.inbox.wake(ctx);
    }

    /// The one place that changes the model.
    pub(crate) fn apply(&mut self, event: ClientEvent) {
        let mut effects = Vec::new();
        self.model.handle_event(now(), event, &mut effects);
        self.execute_effects(effects);
    }

    /// Takes what came in and lets time pass.
    pub(crate) fn process_inbox(&mut self) {
        while let Some(arrival) = self.inbox.take() {
            match arrival {
                InboundMessage::Tile { hash, bytes } => self.tiles.push_back((hash, bytes)),
                InboundMessage::Cloud { session, keyframe, bytes } => {
                    self.clouds.push_back(Cloud { session, keyframe, bytes });
                }
                InboundMessage::Event(ClientEvent::Scan { mut frame, bytes }) => {
                    // Only the latest of several is drawn.
                    let points = std::mem::take(&mut frame.points);
                    self.scan =
                        Some(Scan { points, map_from_base: frame.map_from_base, sequence: frame.sequence });
                    self.apply(ClientEvent::Scan { frame, bytes });
                }
                InboundMessage::Event(event) => self.apply(event),
            }
        }
        self.apply(ClientEvent::Tick);
    }

    /// A frame begins.
    pub(crate) fn frame(&mut self) {
        self.framed_ms = browser::now_ms();
        self.process_inbox();
    }

    /// Something left for the frame to do.
    pub(crate) fn next_effect(&mut self) -> Option<ClientEffect> {
        self.for_frame.pop_front()
    }

    /// A tile to decode.
    pub(crate) fn next_tile(&mut self) -> Option<(api::TileHash, Vec<u8>)> {
        self.tiles.pop_front()
    }

    /// A keyframe's scan to decode.
    pub(crate) fn next_cloud(&mut self) -> Option<Cloud> {
        self.clouds.pop_front()
    }

    /// Whether there are tiles to decode.
    pub(crate) fn has_tiles(&self) -> bool {
        !self.tiles.is_empty()
    }

    /// The scan to draw, acknowledged by being taken.
    pub(crate) fn take_scan(&mut self) -> Option<Scan> {
        let scan = self.scan.take()?;
        let acknowledgement = api::StreamRequest::Acknowledge { sequence: scan.sequence };
        self.sockets.send(Socket::Stream, &api::encode(&acknowledgement));
        Some(scan)
    }

    /// The page's timer.
    fn on_timer(&mut self) {
        if browser::hidden() || browser::now_ms() - self.framed_ms > BLIND_MS {
            self.release_drive();
        }
        self.process_inbox();
    }

    /// A key or pointer was let go. Frames in time see that themselves, and better.
    fn on_release(&mut self) {
        if browser::now_ms() - self.framed_ms > LATE_MS {
            self.release_drive();
        }
    }

    fn release_drive(&mut self) {
        if self.model.driven_velocity().is_some() {
            self.apply(ClientEvent::Command(ClientCommand::SetVelocity(None)));
        }
    }

    fn execute_effects(&mut self, effects: Vec<ClientEffect>) {
        for effect in effects {
            match effect {
                ClientEffect::OpenSocket(socket) => self.sockets.open(socket),
                ClientEffect::CloseSocket(socket) => self.sockets.close(socket),
                ClientEffect::Send(message) => self.sockets.send(Socket::Control, &api::encode(&message)),
                ClientEffect::SendStream(request) => {
                    self.sockets.send(Socket::Stream, &api::encode(&request))
                }
                ClientEffect::LoadMap(map) => self.fetches.map(map),
                ClientEffect::FetchTile(hash) => self.fetches.tile(hash),
                ClientEffect::FetchCloud { session, keyframe } => self.fetches.cloud(session, keyframe),
                ClientEffect::OpenFileDialog => self.uploads.pick(),
                ClientEffect::CancelUpload(upload) => self.uploads.cancel(upload),
                ClientEffect::CancelTile(hash) => {
                    self.fetches.cancel(&hash);
                    self.tiles.retain(|(other, _)| *other != hash);
                }
                ClientEffect::RemoveTile(_) | ClientEffect::MoveCamera(_) | ClientEffect::SaveSettings(_) => {
                    self.for_frame.push_back(effect)
                }
            }
        }
    }
}

/// Waits for the first tile, so that the first picture shows a map, but not for long: others come while the page can do
/// nothing else.
pub(crate) async fn wait_for_first_tile(runtime: &Rc<RefCell<ClientRuntime>>) {
    let begun = browser::now_ms();
    loop {
        let (is_first_image_ready, listed) = {
            let mut runtime = runtime.borrow_mut();
            (runtime.is_first_image_ready(), runtime.model.displayed_map().tiles.listed())
        };
        // Also when is_first_image_ready: only a pause lets the requests out.
        browser::pause(REACH_EVERY_MS).await;
        let longest = if listed { REACH_TILE_MS } else { REACH_MS };
        if is_first_image_ready || browser::now_ms() - begun >= longest {
            return;
        }
    }
}

/// Moves the runtime from now on, frames or not. The listeners live as long as the page.
pub(crate) fn install_page_events(runtime: &Rc<RefCell<ClientRuntime>>) {
    let Some(window) = browser::window() else { return };
    let on_timer = with_runtime(runtime, ClientRuntime::on_timer);
    if window
        .set_interval_with_callback_and_timeout_and_arguments_0(on_timer.as_ref().unchecked_ref(), BEAT_MS)
        .is_ok()
    {
        on_timer.forget();
    }
    for event in ["keyup", "pointerup", "pointercancel", "blur"] {
        let on_release = with_runtime(runtime, ClientRuntime::on_release);
        // Before anything else hears of it, and whoever keeps it from the others.
        let listening = window.add_event_listener_with_callback_and_bool(
            event,
            on_release.as_ref().unchecked_ref(),
            true,
        );
        if listening.is_ok() {
            on_release.forget();
        }
    }
}

fn with_runtime(runtime: &Rc<RefCell<ClientRuntime>>, act: fn(&mut ClientRuntime)) -> Closure<dyn FnMut()> {
    let runtime = Rc::clone(runtime);
    Closure::new(move || {
        // Taken only while a frame is at it, which takes care of the same things.
        if let Ok(mut runtime) = runtime.try_borrow_mut() {
            act(&mut runtime);
        }
    })
}

/// Seconds since the page was opened.
pub(crate) fn now() -> ClientTime {
    ClientTime(browser::now_ms() * 1e-3)
}
