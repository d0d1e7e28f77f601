//! When a client may be sent its next scan: credits, the rate it asked for, and a window that follows its delay.
//!
//! At most [`MAX_UNACKNOWLEDGED`] frames are under way. That alone would let a slow link hold four old frames, so the
//! window also follows delay, as TCP Vegas does (Brakmo and Peterson, 1995): it shrinks while acknowledgements take much
//! longer than the link's own delay, and grows by one frame per window otherwise. The link's own delay is the least seen,
//! drifting up slowly so that a changed route is learnt.

use api::MAX_UNACKNOWLEDGED;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Greatest rate a client is given, per second. Scans come at 10 to 20.
const MAX_HZ: f32 = 60.0;
/// Delay beyond twice the link's own that counts as a queue: below it a browser is merely busy drawing.
const QUEUE_TOLERANCE: Duration = Duration::from_millis(60);
/// Share of the difference by which the link's own delay follows a longer delay, per frame.
const DRIFT: f64 = 0.01;

/// Flow control of one stream socket.
#[derive(Debug)]
pub(crate) struct Pacer {
    interval: Option<Duration>,
    window: f64,
    link_delay: Option<Duration>,
    /// Number and time of the frames under way, oldest first.
    under_way: VecDeque<(u64, Instant)>,
    last_sent: Option<Instant>,
    sequence: u64,
}

/// What to do about the latest scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Permission {
    /// Send it now.
    Send,
    /// Ask again then.
    At(Instant),
    /// Ask again after the next message of the client.
    AfterMessage,
}

/// The client acknowledged a frame that was never sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct UnknownFrame;

impl Pacer {
    /// Paused until [`Pacer::set_rate`].
    pub(crate) fn new() -> Self {
        Self {
            interval: None,
            window: MAX_UNACKNOWLEDGED as f64,
            link_delay: None,
            under_way: VecDeque::new(),
            last_sent: None,
            sequence: 0,
        }
    }

    /// Frames per second at most; zero, negative or NaN pauses.
    pub(crate) fn set_rate(&mut self, max_hz: f32) {
        // The least rate keeps the interval representable.
        self.interval = (max_hz > 0.0).then(|| Duration::from_secs_f32(1.0 / max_hz.clamp(1e-3, MAX_HZ)));
    }

    /// Whether the client wants scans at all.
    pub(crate) fn wants_scans(&self) -> bool {
        self.interval.is_some()
    }

    /// Whether the latest scan may go now.
    pub(crate) fn permission(&self, now: Instant) -> Permission {
        let Some(interval) = self.interval else { return Permission::AfterMessage };
        if self.under_way.len() >= self.window as usize {
            return Permission::AfterMessage;
        }
        match self.last_sent.map(|last| last + interval) {
            Some(next) if next > now => Permission::At(next),
            _ => Permission::Send,
        }
    }

    /// Counts a frame as sent and returns its number.
    pub(crate) fn sent(&mut self, now: Instant) -> u64 {
        self.sequence += 1;
        self.under_way.push_back((self.sequence, now));
        self.last_sent = Some(now);
        self.sequence
    }

    /// The client has drawn or dropped frame `sequence` and all before.
    pub(crate) fn acknowledged(&mut self, sequence: u64, now: Instant) -> Result<(), UnknownFrame> {
        if sequence == 0 || sequence > self.sequence {
            return Err(UnknownFrame);
        }
        while self.under_way.front().is_some_and(|(number, _)| *number <= sequence) {
            let Some((number, sent)) = self.under_way.pop_front() else { break };
            if number == sequence {
                self.learn(now.saturating_duration_since(sent));
            }
        }
        Ok(())
    }

    fn learn(&mut self, delay: Duration) {
        let link_delay = match self.link_delay {
            Some(known) if known < delay => known + (delay - known).mul_f64(DRIFT),
            _ => delay,
        };
        self.link_delay = Some(link_delay);
        let queued = delay > 2 * link_delay + QUEUE_TOLERANCE;
        let change = if queued { -self.window / 2.0 } else { 1.0 / self.window };
        self.window = (self.window + change).clamp(1.0, MAX_UNACKNOWLEDGED as f64);
    }
}

#[cfg(test)]
#[path = "pacer_tests.rs"]
mod tests;
