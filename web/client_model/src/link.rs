//! One socket's life: connecting, connected, lost, and when to try again.

use crate::ClientTime;
use std::collections::VecDeque;

/// Where a socket is in its life.
#[derive(Clone, Debug, PartialEq)]
pub enum LinkState {
    /// Being opened.
    Connecting {
        /// Since when.
        since: ClientTime,
    },
    /// Open and welcomed.
    Connected {
        /// Since when.
        since: ClientTime,
    },
    /// Closed; it is tried again at `retry_at`.
    Lost {
        /// When it was lost, or first tried in vain.
        since: ClientTime,
        /// When the next attempt is due.
        retry_at: ClientTime,
    },
    /// The server will not talk to this client; trying again would not help.
    Refused {
        /// The server's sentence.
        reason: String,
    },
}

/// A socket's state with its back-off.
#[derive(Clone, Debug)]
pub struct Link {
    state: LinkState,
    failures: u32,
    heard: ClientTime,
    lost_since: Option<ClientTime>,
}

const RETRY_FIRST_S: f64 = 0.25;
const RETRY_LONGEST_S: f64 = 8.0;
/// Silence after which a link that says it is open is taken for dead. Pings go out every 2 s.
const SILENCE_S_MAX: f64 = 6.0;
/// Time allowed for opening and the welcome.
const OPENING_S_MAX: f64 = 5.0;

impl Link {
    /// A link that is being opened.
    pub fn new(now: ClientTime) -> Self {
        Self { state: LinkState::Connecting { since: now }, failures: 0, heard: now, lost_since: None }
    }

    /// Where it is.
    pub fn state(&self) -> &LinkState {
        &self.state
    }

    /// Whether it is open and welcomed.
    pub fn connected(&self) -> bool {
        matches!(self.state, LinkState::Connected { .. })
    }

    /// Since when there has been no connection; also while one is being opened again.
    pub fn lost_since(&self) -> Option<ClientTime> {
        self.lost_since
    }

    /// When something last came.
    pub fn heard(&self) -> ClientTime {
        self.heard
    }

    pub(crate) fn hear(&mut self, now: ClientTime) {
        self.heard = now;
    }

    /// This client itself stood still for `seconds`: what came meanwhile is still to be read, so nobody was silent.
    pub(crate) fn excuse(&mut self, seconds: f64) {
        self.heard = self.heard.after(seconds);
        if let LinkState::Connecting { since } = &mut self.state {
            *since = since.after(seconds);
        }
    }

    pub(crate) fn connect(&mut self, now: ClientTime) {
        self.state = LinkState::Connecting { since: now };
    }

    pub(crate) fn welcome(&mut self, now: ClientTime) {
        self.heard = now;
        self.failures = 0;
        self.lost_since = None;
        self.state = LinkState::Connected { since: now };
    }

    pub(crate) fn refuse(&mut self, reason: String) {
        self.state = LinkState::Refused { reason };
    }

    /// The socket closed. Waits twice as long after each failure, spread by `jitter` (0..1) to half and one and a half.
    pub(crate) fn lose(&mut self, now: ClientTime, jitter: f64) {
        if matches!(self.state, LinkState::Refused { .. }) {
            return;
        }
        let since = *self.lost_since.get_or_insert(now);
        let wait = (RETRY_FIRST_S * f64::from(1_u32 << self.failures.min(16))).min(RETRY_LONGEST_S);
        self.failures = self.failures.saturating_add(1);
        self.state = LinkState::Lost { since, retry_at: now.after(wait * (0.5 + jitter.clamp(0.0, 1.0))) };
    }

    /// Whether the next attempt is due.
    pub(crate) fn retry_due(&self, now: ClientTime) -> bool {
        matches!(self.state, LinkState::Lost { retry_at, .. } if now >= retry_at)
    }

    /// Whether a link that calls itself open, or is being opened, has been silent for too long.
    pub(crate) fn dead(&self, now: ClientTime) -> bool {
        match self.state {
            LinkState::Connecting { since } => now.since(since) > OPENING_S_MAX,
            LinkState::Connected { .. } => now.since(self.heard) > SILENCE_S_MAX,
            LinkState::Lost { .. } | LinkState::Refused { .. } => false,
        }
    }
}

/// Bytes that came in during the last seconds.
#[derive(Clone, Debug, Default)]
pub struct Throughput {
    recent: VecDeque<(ClientTime, usize)>,
    sum: usize,
}

/// Long enough that tiles in bursts do not make the figure flicker.
const THROUGHPUT_WINDOW_S: f64 = 3.0;

impl Throughput {
    pub(crate) fn add(&mut self, now: ClientTime, bytes: usize) {
        self.recent.push_back((now, bytes));
        self.sum += bytes;
        self.expire(now);
    }

    pub(crate) fn expire(&mut self, now: ClientTime) {
        while let Some(&(at, bytes)) = self.recent.front()
            && now.since(at) > THROUGHPUT_WINDOW_S
        {
            self.recent.pop_front();
            self.sum -= bytes;
        }
    }

    /// Bits per second over the last seconds.
    pub fn bits_per_s(&self) -> f64 {
        self.sum as f64 * 8.0 / THROUGHPUT_WINDOW_S
    }
}
