//! The queue of the thread that compares pictures.
//!
//! | what waits | policy |
//! | --- | --- |
//! | that there are new results | once, for all |
//! | pairs that clients ask for | refused beyond [`MAX_WAITING`] |

use crate::texts;
use crossbeam_channel::{Receiver, Sender};

/// Pairs that may wait. Chosen: each takes about a second, and nobody waits for longer than some ten.
const MAX_WAITING: usize = 8;

/// A pair that a client asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PicturePair {
    /// Number of the question.
    pub question: u64,
    /// Numbers of the results with the earlier and the later picture.
    pub results: [u64; 2],
}

/// The end of those who have work.
#[derive(Debug)]
pub struct PictureQueue {
    wake: Sender<()>,
    pairs: Sender<PicturePair>,
}

/// The thread's end.
pub struct PictureWork {
    pub wake: Receiver<()>,
    pub pairs: Receiver<PicturePair>,
}

impl PictureQueue {
    /// Both ends. The thread looks for photos at its start.
    pub fn new() -> (Self, PictureWork) {
        let ((wake, woken), (pairs, asked)) =
            (crossbeam_channel::bounded(1), crossbeam_channel::bounded(MAX_WAITING));
        let queue = Self { wake, pairs };
        queue.wake();
        (queue, PictureWork { wake: woken, pairs: asked })
    }

    /// There are new results. Never blocks.
    pub fn wake(&self) {
        // One that waits stands for all.
        let _ = self.wake.try_send(());
    }

    /// Asks for a pair. The answer goes to the gateway. Never blocks.
    ///
    /// # Errors
    /// Why it cannot wait, one sentence.
    pub fn ask(&self, pair: PicturePair) -> Result<(), &'static str> {
        self.pairs.try_send(pair).map_err(|_| texts::TOO_MANY_PICTURES_WAIT)
    }
}
