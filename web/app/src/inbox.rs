//! The queue of inbound messages: sockets, downloads and uploads push, the runtime pops.

use api::{Event, ServerMessage};
use client_model::ClientEvent;
use std::cell::{Cell, OnceCell, RefCell};
use std::collections::VecDeque;
use std::rc::Rc;
use std::time::Duration;

/// Parameters of an [`Inbox`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct InboxConfig {
    /// Delay of the frame that an inbound message requests. State arrives at 20 Hz and scans at 10 Hz. About 10 frames a second
    /// show them without loading the CPU more. Chosen: a tenth of a second less the time of a frame.
    repaint_delay: Duration,
}

impl Default for InboxConfig {
    fn default() -> Self {
        Self { repaint_delay: Duration::from_millis(90) }
    }
}

/// A message from outside the client.
#[derive(Debug)]
pub(crate) enum InboundMessage {
    /// An event for the model.
    Event(ClientEvent),
    /// A tile that was downloaded.
    Tile {
        /// Hash of its content.
        hash: api::TileHash,
        /// Its encoded points.
        bytes: Vec<u8>,
    },
    /// The scan of a keyframe that was downloaded.
    KeyframeScan {
        /// Session of the keyframe.
        session: vocab::SessionId,
        /// The keyframe.
        keyframe: vocab::KeyframeId,
        /// Its encoded points.
        bytes: Vec<u8>,
    },
}

impl InboundMessage {
    /// Whether messages of this kind come many times a second as long as the robot runs, whatever happens.
    fn is_periodic(&self) -> bool {
        match self {
            Self::Event(ClientEvent::Scan { .. }) => true,
            Self::Event(ClientEvent::Server { message, .. }) => matches!(
                message,
                ServerMessage::Pong { .. }
                    | ServerMessage::Event { event: Event::Estimate(_) | Event::Quality(_), .. }
            ),
            _ => false,
        }
    }
}

/// A queue that requests a frame for each pushed message.
#[derive(Clone, Default)]
pub(crate) struct Inbox {
    config: InboxConfig,
    queue: Rc<RefCell<VecDeque<InboundMessage>>>,
    ctx: Rc<OnceCell<egui::Context>>,
    /// Whether the robot's own map is out of sight: then periodic messages wait for the next frame instead of requesting one.
    is_robot_hidden: Rc<Cell<bool>>,
}

impl Inbox {
    /// Sets the context whose frames later messages request.
    pub(crate) fn set_context(&self, ctx: &egui::Context) {
        // There is one client and one context: a second call has the same context.
        let _ = self.ctx.set(ctx.clone());
    }

    /// Sets whether the page shows something else than the robot in its map.
    pub(crate) fn hide_robot(&self, is_hidden: bool) {
        self.is_robot_hidden.set(is_hidden);
    }

    /// Adds a message and requests a frame, unless it changes nothing that is in sight.
    pub(crate) fn push(&self, message: InboundMessage) {
        let can_wait = self.is_robot_hidden.get() && message.is_periodic();
        self.queue.borrow_mut().push_back(message);
        if !can_wait {
            self.request_frame();
        }
    }

    /// Requests a frame, for something that waits elsewhere.
    pub(crate) fn request_frame(&self) {
        if let Some(ctx) = self.ctx.get() {
            ctx.request_repaint_after(self.config.repaint_delay);
        }
    }

    /// Adds an event for the model and requests a frame.
    pub(crate) fn push_event(&self, event: ClientEvent) {
        self.push(InboundMessage::Event(event));
    }

    /// The oldest message.
    pub(crate) fn pop(&self) -> Option<InboundMessage> {
        self.queue.borrow_mut().pop_front()
    }
}
