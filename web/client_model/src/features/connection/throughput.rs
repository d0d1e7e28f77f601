//! Bytes that come in per second.

use crate::ClientTime;
use std::collections::VecDeque;

/// Length of the window over which bytes are counted, seconds: tiles come in bursts, and the figure shall not flicker.
const WINDOW_S: f64 = 3.0;

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
            && now.since(at) > WINDOW_S
        {
            self.recent.pop_front();
            self.sum -= bytes;
        }
    }

    /// Bits per second, mean of the last three seconds.
    pub fn bits_per_s(&self) -> f64 {
        self.sum as f64 * 8.0 / WINDOW_S
    }
}
