//! When a client may be sent its next scan: credits, the rate it asked for, and a window that follows its delay.
//!
//! At most [`MAX_UNACKNOWLEDGED`] frames are sent without acknowledgement. A slow link would still hold that many old frames, so the window also
//! follows the delay, as in TCP Vegas (Brakmo and Peterson, 1995). It is halved when an acknowledgement takes much longer than the link's base
//! delay, and grows by one frame per window otherwise. The base delay is the least delay seen. It follows longer delays slowly, because the route
//! may have changed.

use api::MAX_UNACKNOWLEDGED;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Parameters of the [`Pacer`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PacerConfig {
    /// Lowest rate of scans, Hz. It keeps the interval representable. Chosen: one scan in a quarter of an hour.
    pub(crate) min_hz: f32,
    /// Greatest rate of scans for a client, Hz. LiDARs scan at 2 to 20 Hz. Chosen: what a screen shows.
    pub(crate) max_hz: f32,
    /// Delay beyond twice the base delay that counts as a queue. A browser that draws delays an acknowledgement by less. Chosen: about four frames at 60 Hz.
    pub(crate) queue_tolerance: Duration,
    /// Share of the difference by which the base delay follows a longer delay, per frame. Chosen: a longer path through the network is learned in a hundred frames, and a
    /// queue of a second hardly moves it.
    pub(crate) base_delay_gain: f64,
}

impl Default for PacerConfig {
    fn default() -> Self {
        Self { min_hz: 1e-3, max_hz: 60.0, queue_tolerance: Duration::from_millis(60), base_delay_gain: 0.01 }
    }
}

/// Flow control of one stream socket.
#[derive(Debug)]
pub(crate) struct Pacer {
    config: PacerConfig,
    interval: Option<Duration>,
    window: f64,
    base_delay: Option<Duration>,
    /// Number and time of the frames without acknowledgement, oldest first.
    unacknowledged: VecDeque<(u64, Instant)>,
    last_sent: Option<Instant>,
    sequence: u64,
}

/// Whether the latest scan may be sent.
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
    pub(crate) fn new(config: PacerConfig) -> Self {
        Self {
            config,
            interval: None,
            window: MAX_UNACKNOWLEDGED as f64,
            base_delay: None,
            unacknowledged: VecDeque::new(),
            last_sent: None,
            sequence: 0,
        }
    }

    /// Frames per second at most; zero, negative or NaN pauses.
    pub(crate) fn set_rate(&mut self, max_hz: f32) {
        self.interval = (max_hz > 0.0)
            .then(|| Duration::from_secs_f32(1.0 / max_hz.clamp(self.config.min_hz, self.config.max_hz)));
    }

    /// Whether the client wants scans at all.
    pub(crate) fn wants_scans(&self) -> bool {
        self.interval.is_some()
    }

    /// Whether the latest scan may go now.
    pub(crate) fn permission(&self, now: Instant) -> Permission {
        let Some(interval) = self.interval else { return Permission::AfterMessage };
        if self.unacknowledged.len() >= self.window as usize {
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
        self.unacknowledged.push_back((self.sequence, now));
        self.last_sent = Some(now);
        self.sequence
    }

    /// The client has drawn or dropped frame `sequence` and all before.
    pub(crate) fn acknowledged(&mut self, sequence: u64, now: Instant) -> Result<(), UnknownFrame> {
        if sequence == 0 || sequence > self.sequence {
            return Err(UnknownFrame);
        }
        while self.unacknowledged.front().is_some_and(|(number, _)| *number <= sequence) {
            let Some((number, sent)) = self.unacknowledged.pop_front() else { break };
            if number == sequence {
                self.adapt_window(now.saturating_duration_since(sent));
            }
        }
        Ok(())
    }

    /// Adapts base delay and window to the delay of an acknowledgement.
    fn adapt_window(&mut self, delay: Duration) {
        let base_delay = match self.base_delay {
            Some(known) if known < delay => known + (delay - known).mul_f64(self.config.base_delay_gain),
            _ => delay,
        };
        self.base_delay = Some(base_delay);
        let is_queued = delay > 2 * base_delay + self.config.queue_tolerance;
        let change = if is_queued { -self.window / 2.0 } else { 1.0 / self.window };
        self.window = (self.window + change).clamp(1.0, MAX_UNACKNOWLEDGED as f64);
    }
}

#[cfg(test)]
#[path = "pacer_tests.rs"]
mod tests;
