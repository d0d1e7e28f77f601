//! Where sockets and downloads leave what they bring until the next frame.

use client_model::ClientEvent;
use std::cell::{OnceCell, RefCell};
use std::collections::VecDeque;
use std::rc::Rc;
use std::time::Duration;

/// State comes at 20 Hz and scans at 10; ten pictures a second show them well and leave the processor alone.
const REPAINT: Duration = Duration::from_millis(90);

/// Something that came in.
#[derive(Debug)]
pub(crate) enum InboundMessage {
    /// For the model.
    Event(ClientEvent),
    /// Bytes of a tile, to be decoded.
    Tile {
        /// Its name.
        hash: api::TileHash,
        /// As encoded.
        bytes: Vec<u8>,
    },
    /// The scan of a keyframe, to be decoded.
    Cloud {
        /// Of which session.
        session: vocab::SessionId,
        /// Which.
        keyframe: vocab::KeyframeId,
        /// As encoded.
        bytes: Vec<u8>,
    },
}

/// A queue that wakes the client once there is something to wake.
#[derive(Clone, Default)]
pub(crate) struct Inbox {
    queue: Rc<RefCell<VecDeque<InboundMessage>>>,
    ctx: Rc<OnceCell<egui::Context>>,
}

impl Inbox {
    /// From now on what comes in asks for a frame.
    pub(crate) fn wake(&self, ctx: &egui::Context) {
        // Set before only by the same client, to the same context.
        let _ = self.ctx.set(ctx.clone());
    }

    /// Leaves something for the next frame, and sees to it that there is one.
    pub(crate) fn leave(&self, arrival: InboundMessage) {
        self.queue.borrow_mut().push_back(arrival);
        if let Some(ctx) = self.ctx.get() {
            ctx.request_repaint_after(REPAINT);
        }
    }

    /// The oldest of what is there.
    pub(crate) fn take(&self) -> Option<InboundMessage> {
        self.queue.borrow_mut().pop_front()
    }
}
