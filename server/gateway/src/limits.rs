//! Limits on what one client may use. Every queue, buffer and wait of this crate has its bound here.

use std::time::{Duration, Instant};

/// Bounds on clients. The defaults suit a robot on a site network; tests shorten the waits.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// TCP connections at a time, WebSockets included. Further ones get 503 and are closed.
    pub connections: usize,
    /// Control sockets at a time; the same number applies to stream sockets. Further ones are refused with a sentence.
    pub clients: usize,
    /// Time limit for the head of a request, and for an idle connection.
    pub header_timeout: Duration,
    /// Time without a message after which a WebSocket is closed.
    pub silence: Duration,
    /// Time without progress of a write after which a connection is closed.
    pub write_stall: Duration,
    /// Mean rate of commands from one socket; a burst may hold twice as many. Stop motion is counted apart.
    pub commands_per_second: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            connections: 512,
            clients: 64,
            header_timeout: Duration::from_secs(10),
            silence: Duration::from_secs(10),
            write_stall: Duration::from_secs(10),
            commands_per_second: 50.0,
        }
    }
}

/// Age up to which a scan is live. LiDARs scan 2 to 20 times a second.
pub(crate) const LIVE_SCAN_AGE_MAX: Duration = Duration::from_secs(1);
/// Longest message from a client, bytes. The longest regular one is a command with a name in it.
pub(crate) const MAX_CLIENT_MESSAGE_BYTES: usize = 16 << 10;
/// Longest head of a request, bytes.
pub(crate) const MAX_REQUEST_HEAD_BYTES: usize = 32 << 10;
/// Header fields in a request.
pub(crate) const MAX_REQUEST_HEADERS: usize = 64;
/// Bytes that the kernel holds unsent for a client. The rest waits in this process, where newer state replaces older.
pub(crate) const UNSENT_BYTES: u32 = 16 << 10;
/// Answers and pongs that wait for one client.
pub(crate) const MAX_ANSWERS: usize = 256;
/// Commands of one client that the core has not answered.
pub(crate) const MAX_PENDING: usize = 256;
/// Commands of all clients in the queue to the core.
pub(crate) const COMMAND_QUEUE: usize = 256;
/// Places in that queue that are kept for Stop motion.
pub(crate) const COMMAND_QUEUE_FOR_STOPS: usize = 64;
/// Changes of the graph kept for clients that read slowly. A client further behind gets the whole graph.
pub(crate) const MAX_GRAPH_CHANGES: usize = 256;
/// Least time between two whole graphs that one client asks for. A client needs one after lost changes, which is rare; 5,000 keyframes are 0.5 MB.
pub(crate) const GRAPH_ANSWER_PERIOD: Duration = Duration::from_secs(5);
/// Tiles in one event: about 50 kB, so that a pose does not wait for a large map to be sent.
pub(crate) const MAX_TILES_PER_EVENT: usize = 512;
/// Decisions on loops in one event: about 40 kB.
pub(crate) const MAX_LOOPS_PER_EVENT: usize = 100;

/// Longest file from a client, bytes: about 400 million points.
pub(crate) const MAX_UPLOAD_BYTES: u64 = 16 << 30;
/// Files that may wait to be imported.
pub(crate) const MAX_UPLOADS_KEPT: usize = 4;
/// Uploads at a time.
pub(crate) const UPLOADS_AT_A_TIME: usize = 1;

/// A token bucket.
pub(crate) struct RateLimit {
    per_second: f64,
    tokens: f64,
    filled: Instant,
}

impl RateLimit {
    /// Allows `per_second` in the mean and twice as many in a burst.
    pub(crate) fn new(per_second: f64, now: Instant) -> Self {
        Self { per_second, tokens: 2.0 * per_second, filled: now }
    }

    /// Takes one token, if there is one.
    pub(crate) fn allow(&mut self, now: Instant) -> bool {
        let elapsed = now.saturating_duration_since(self.filled).as_secs_f64();
        self.filled = now;
        self.tokens = (self.tokens + elapsed * self.per_second).min(2.0 * self.per_second);
        let allowed = self.tokens >= 1.0;
        if allowed {
            self.tokens -= 1.0;
        }
        allowed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_burst_then_the_mean_rate() {
        let start = Instant::now();
        let mut limit = RateLimit::new(50.0, start);
        assert_eq!((0..1000).filter(|_| limit.allow(start)).count(), 100);
        let later = start + Duration::from_secs(1);
        assert_eq!((0..1000).filter(|_| limit.allow(later)).count(), 50);
        let much_later = start + Duration::from_secs(3600);
        assert_eq!((0..1000).filter(|_| limit.allow(much_later)).count(), 100);
    }
}
