//! One socket's life: opening, connected, lost, and when to try again.

use crate::ClientTime;

/// State of a socket.
#[derive(Clone, Debug, PartialEq)]
pub enum SocketState {
    /// Being opened.
    Connecting {
        /// Since when.
        since: ClientTime,
    },
    /// Open, and welcomed by the server.
    Connected {
        /// Since when.
        since: ClientTime,
    },
    /// Closed; the next attempt is at `retry_at`.
    Lost {
        /// When it was lost, or when the first attempt failed.
        since: ClientTime,
        /// When the next attempt is due.
        retry_at: ClientTime,
    },
    /// The server refused this client; another attempt would not help.
    Refused {
        /// The server's sentence.
        reason: String,
    },
}

/// When a socket counts as dead and when it is opened again.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinkConfig {
    /// Wait before the first attempt, seconds. It doubles with every failure. Chosen: a gateway that restarts is back in about that time.
    pub(crate) retry_first_s: f64,
    /// Longest wait between two attempts, seconds, before the jitter. Chosen: people do not wait longer, and a robot that comes back is not flooded.
    pub(crate) retry_longest_s: f64,
    /// An open link without a message for longer than this counts as dead, seconds: three pings. Chosen: shorter than the 10 s after which the gateway closes a silent
    /// socket.
    pub(crate) max_silence_s: f64,
    /// Time for opening and for the welcome, seconds. Chosen: longer than TLS takes on a slow radio link.
    pub(crate) max_opening_s: f64,
}

impl Default for LinkConfig {
    fn default() -> Self {
        Self { retry_first_s: 0.25, retry_longest_s: 8.0, max_silence_s: 6.0, max_opening_s: 5.0 }
    }
}

/// A socket's state with its back-off.
#[derive(Clone, Debug)]
pub struct ReconnectingSocket {
    state: SocketState,
    failures: u32,
    last_received: ClientTime,
    lost_since: Option<ClientTime>,
    config: LinkConfig,
}

impl ReconnectingSocket {
    /// A link that is being opened.
    pub(crate) fn new(now: ClientTime, config: LinkConfig) -> Self {
        Self {
            state: SocketState::Connecting { since: now },
            failures: 0,
            last_received: now,
            lost_since: None,
            config,
        }
    }

    /// Its state.
    pub fn state(&self) -> &SocketState {
        &self.state
    }

    /// Whether it is open and welcomed.
    pub fn is_connected(&self) -> bool {
        matches!(self.state, SocketState::Connected { .. })
    }

    /// Since when there has been no connection; also while one is being opened again.
    pub fn lost_since(&self) -> Option<ClientTime> {
        self.lost_since
    }

    /// A message came.
    pub(crate) fn on_received(&mut self, now: ClientTime) {
        self.last_received = now;
    }

    /// This client stood still for `stall_s` seconds. Messages of that time are still to be read, so the server was not silent.
    pub(crate) fn discount_stall(&mut self, stall_s: f64) {
        self.last_received = self.last_received.after(stall_s);
        if let SocketState::Connecting { since } = &mut self.state {
            *since = since.after(stall_s);
        }
    }

    pub(crate) fn on_opening(&mut self, now: ClientTime) {
        self.state = SocketState::Connecting { since: now };
    }

    pub(crate) fn on_welcome(&mut self, now: ClientTime) {
        self.last_received = now;
        self.failures = 0;
        self.lost_since = None;
        self.state = SocketState::Connected { since: now };
    }

    pub(crate) fn refuse(&mut self, reason: String) {
        self.state = SocketState::Refused { reason };
    }

    /// The socket closed. The wait doubles with each failure; `jitter` (0 to 1) scales it by 0.5 to 1.5, so that many clients do
    /// not come back at once.
    pub(crate) fn on_closed(&mut self, now: ClientTime, jitter: f64) {
        if matches!(self.state, SocketState::Refused { .. }) {
            return;
        }
        let since = *self.lost_since.get_or_insert(now);
        let doubled = self.config.retry_first_s * f64::from(1_u32 << self.failures.min(16));
        let wait_s = doubled.min(self.config.retry_longest_s) * (0.5 + jitter.clamp(0.0, 1.0));
        self.failures = self.failures.saturating_add(1);
        self.state = SocketState::Lost { since, retry_at: now.after(wait_s) };
    }

    /// Whether the next attempt is due.
    pub(crate) fn is_retry_due(&self, now: ClientTime) -> bool {
        matches!(self.state, SocketState::Lost { retry_at, .. } if now >= retry_at)
    }

    /// Whether a link that is open, or being opened, has been silent for too long.
    pub(crate) fn is_dead(&self, now: ClientTime) -> bool {
        match self.state {
            SocketState::Connecting { since } => now.since(since) > self.config.max_opening_s,
            SocketState::Connected { .. } => now.since(self.last_received) > self.config.max_silence_s,
            SocketState::Lost { .. } | SocketState::Refused { .. } => false,
        }
    }
}
