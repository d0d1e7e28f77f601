//! Bytes that come in per second.

use crate::ClientTime;
use std::collections::VecDeque;

/// Parameters of [`Throughput`].
struct ThroughputConfig {
    /// Length of the window over which bytes are counted, seconds. Chosen: tiles come in bursts, and the figure shall not flicker.
    window_s: f64,
}

const CONFIG: ThroughputConfig = ThroughputConfig { window_s: 3.0 };

/// Bytes that came in during the last seconds.
#[derive(Clone, Debug, Default)]
pub struct Throughput {
    recent: VecDeque<(ClientTime, usize)>,
    sum: usize,
}

impl Throughput {
    pub(crate) fn add(&mut self, now: ClientTime, bytes: usize) {
        self.recent.push_back((now, bytes));
        self.sum += bytes;
        self.expire(now);
    }

    pub(crate) fn expire(&mut self, now: ClientTime) {
        while let Some(&(at, bytes)) = self.recent.front()
            && now.since(at) > CONFIG.window_s
        {
            self.recent.pop_front();
            self.sum -= bytes;
        }
    }

    /// Bits per second, mean of the last three seconds.
    pub fn bits_per_s(&self) -> f64 {
        self.sum as f64 * 8.0 / CONFIG.window_s
    }
}
