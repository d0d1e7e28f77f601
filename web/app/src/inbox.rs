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
    /// Delay of the frame that an inbound message requests. Several messages often come together. Chosen: a tenth of a second less the time of a frame.
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
    /// Delay of the frame that a periodic message requests; without one it waits for the next frame.
    periodic_delay: Rc<Cell<Option<Duration>>>,
}

impl Inbox {
    /// Sets the context whose frames later messages request.
    pub(crate) fn set_context(&self, ctx: &egui::Context) {
        // There is one client and one context: a second call has the same context.
        let _ = self.ctx.set(ctx.clone());
    }

    /// Sets the delay of the frame that a periodic message requests; without one it requests none.
    pub(crate) fn set_periodic_delay(&self, delay: Option<Duration>) {
        self.periodic_delay.set(delay);
    }

    /// Adds a message and requests a frame for it.
    pub(crate) fn push(&self, message: InboundMessage) {
        let delay =
            if message.is_periodic() { self.periodic_delay.get() } else { Some(self.config.repaint_delay) };
        self.queue.borrow_mut().push_back(message);
        if let (Some(ctx), Some(delay)) = (self.ctx.get(), delay) {
            ctx.request_repaint_after(delay);
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
