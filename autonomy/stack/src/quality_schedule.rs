//! When the quality of a map under construction is computed.

use vocab::{Span, Stamp};

/// Parameters of [`QualitySchedule`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct QualityScheduleConfig {
    /// Time between two computations of the quality of a map that changes. Chosen: people see the figures change while they walk.
    pub period: Span,
    /// The period grows by itself each time the graph has grown by this number of keyframes, because the cost grows with them. Chosen: ten minutes of walking over new
    /// ground.
    pub keyframes: usize,
}

impl Default for QualityScheduleConfig {
    fn default() -> Self {
        Self { period: Span::from_millis(2_000), keyframes: 500 }
    }
}

/// The schedule of one session. At most one job runs at a time.
#[derive(Debug, Default)]
pub(crate) struct QualitySchedule {
    config: QualityScheduleConfig,
    /// When the last computation was started, and the revision of the graph then.
    last: Option<(Stamp, u64)>,
    /// The job that runs.
    job: Option<u64>,
}

impl QualitySchedule {
    /// Starts the job of this number, if a computation is due for a graph of this size and revision. Returns whether it did.
    pub fn start(&mut self, at: Stamp, job: u64, keyframes: usize, revision: u64) -> bool {
        let period = self.config.period * (1 + keyframes / self.config.keyframes) as i64;
        let is_too_early = |(last, known): (Stamp, u64)| known == revision || at - last < period;
        if self.job.is_some() || self.last.is_some_and(is_too_early) {
            return false;
        }
        self.last = Some((at, revision));
        self.job = Some(job);
        true
    }

    /// Whether this job runs.
    pub fn is_running(&self, job: u64) -> bool {
        self.job == Some(job)
    }

    /// The job has ended. Returns whether it was the one that ran.
    pub fn end(&mut self, job: u64) -> bool {
        self.job.take_if(|running| *running == job).is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quality_is_computed_for_a_graph_that_changed_and_at_most_once_a_period() {
        let mut schedule = QualitySchedule::default();
        let at = |ms: i64| Stamp::EPOCH + Span::from_millis(ms);
        assert!(schedule.start(at(0), 0, 10, 1));
        assert!(!schedule.start(at(9_000), 1, 10, 2), "one job at a time");
        assert!(!schedule.end(7) && schedule.is_running(0) && schedule.end(0));
        assert!(!schedule.start(at(9_000), 1, 10, 1), "the graph is the same");
        assert!(!schedule.start(at(1_999), 1, 10, 2) && schedule.start(at(2_000), 1, 10, 2));
        assert!(schedule.end(1));
        // A graph of 500 keyframes takes two periods.
        assert!(!schedule.start(at(5_999), 2, 500, 3) && schedule.start(at(6_000), 2, 500, 3));
    }
}
