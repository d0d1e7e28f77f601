//! Comparisons that wait for a job or run in one. Both numbers are bounded; the least promising ones are dropped first.

use crate::Revisit;
use crate::verification::{CandidateSource, Comparison, VerificationTask};
use geometry::Isometry;
use std::collections::BTreeMap;
use vocab::{KeyframeId, Stamp};

/// Parameters of the queue of comparisons.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VerificationQueueConfig {
    /// Greatest number of comparisons that run at a time. They share the compute lane with relocalisation and map quality. Chosen: relocalisation waits for four of them
    /// at most.
    pub max_running: usize,
    /// Greatest number of comparisons that wait: what a walk through an old corridor proposes in half a minute.
    pub max_waiting: usize,
}

impl Default for VerificationQueueConfig {
    fn default() -> Self {
        Self { max_running: 4, max_waiting: 32 }
    }
}

/// What a comparison is about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum QueuedComparison {
    /// A pair of keyframes.
    Pair {
        /// The older keyframe.
        from: KeyframeId,
        /// The newer one.
        to: KeyframeId,
        /// Why it was proposed.
        source: CandidateSource,
        /// Guess of `to` in `from`.
        guess: Isometry,
    },
    /// A revisit of known ground.
    Revisit {
        /// Number of the waypoint.
        waypoint: u64,
        /// When the robot was there.
        stamp: Stamp,
        /// The keyframe.
        keyframe: KeyframeId,
        /// Guess of the base in it.
        guess: Isometry,
    },
}

impl QueuedComparison {
    /// Of a pair to be verified.
    pub fn of_pair(task: &VerificationTask) -> Self {
        let Comparison { source, guesses, .. } = &task.comparison;
        Self::Pair { from: task.from, to: task.to, source: *source, guess: first_guess(guesses) }
    }

    /// Of a revisit made at `stamp`.
    pub fn of_revisit(stamp: Stamp, revisit: &Revisit) -> Self {
        let guess = first_guess(&revisit.comparison.guesses);
        Self::Revisit { waypoint: revisit.waypoint, stamp, keyframe: revisit.keyframe, guess }
    }

    fn is_pair(&self) -> bool {
        matches!(self, Self::Pair { .. })
    }
}

fn first_guess(guesses: &[Isometry]) -> Isometry {
    guesses.first().copied().unwrap_or_else(Isometry::identity)
}

/// The comparisons of one session.
#[derive(Debug, Default)]
pub(crate) struct VerificationQueue {
    config: VerificationQueueConfig,
    /// In the order of arrival.
    waiting: Vec<(QueuedComparison, Comparison)>,
    /// By job, with the data until the job fetches it.
    running: BTreeMap<u64, (QueuedComparison, Option<Comparison>)>,
    skipped: u64,
}

impl VerificationQueue {
    /// An empty queue.
    pub fn new(config: VerificationQueueConfig) -> Self {
        Self { config, ..Self::default() }
    }

    /// Adds a comparison. If too many wait, the least promising is skipped.
    pub fn push(&mut self, queued: QueuedComparison, comparison: Comparison) {
        self.waiting.push((queued, comparison));
        if self.waiting.len() > self.config.max_waiting {
            // Of equally promising ones, the oldest is skipped.
            let last = (0..self.waiting.len()).min_by(|&a, &b| {
                priority(&self.waiting[a]).total_cmp(&priority(&self.waiting[b])).then(a.cmp(&b))
            });
            if let Some(last) = last {
                let (queued, _) = self.waiting.remove(last);
                self.skipped += u64::from(queued.is_pair());
            }
        }
    }

    /// Starts as many comparisons as may run, the most promising first and of equals the oldest. Returns their jobs, numbered from `next_job` on.
    pub fn start(&mut self, next_job: &mut u64) -> Vec<(u64, QueuedComparison)> {
        let mut started = Vec::new();
        while self.running.len() < self.config.max_running {
            let best = (0..self.waiting.len()).max_by(|&a, &b| {
                priority(&self.waiting[a]).total_cmp(&priority(&self.waiting[b])).then(b.cmp(&a))
            });
            let Some(best) = best else { break };
            let (queued, comparison) = self.waiting.remove(best);
            started.push((*next_job, queued));
            self.running.insert(*next_job, (queued, Some(comparison)));
            *next_job += 1;
        }
        started
    }

    /// The data of a job's comparison. They are returned only once.
    pub fn take(&mut self, job: u64) -> Option<(QueuedComparison, Comparison)> {
        let (queued, comparison) = self.running.get_mut(&job)?;
        Some((*queued, comparison.take()?))
    }

    /// A job has ended. Returns what it was about, if it was one of this queue.
    pub fn end(&mut self, job: u64) -> Option<QueuedComparison> {
        self.running.remove(&job).map(|(queued, _)| queued)
    }

    /// Counts a pair whose job has ended without a result.
    pub fn count_skipped(&mut self) {
        self.skipped += 1;
    }

    /// Whether nothing waits and nothing runs.
    pub fn is_empty(&self) -> bool {
        self.waiting.is_empty() && self.running.is_empty()
    }

    /// Drops all comparisons. Results of running jobs are ignored.
    pub fn clear(&mut self) {
        let waiting = self.waiting.iter().map(|(queued, _)| queued);
        let running = self.running.values().map(|(queued, _)| queued);
        self.skipped += waiting.chain(running).filter(|queued| queued.is_pair()).count() as u64;
        self.waiting.clear();
        self.running.clear();
    }

    /// Number of pairs that were never verified.
    pub fn skipped(&self) -> u64 {
        self.skipped
    }
}

/// People's proposals come first, then the robot's own pose, then candidates by geometry, then what looks most alike.
fn priority((queued, comparison): &(QueuedComparison, Comparison)) -> f32 {
    match (queued, comparison.source) {
        (_, CandidateSource::Person) => 3.0,
        (QueuedComparison::Revisit { .. }, _) => 2.0,
        (QueuedComparison::Pair { .. }, CandidateSource::Geometry) => 1.0,
        (QueuedComparison::Pair { .. }, CandidateSource::Appearance(distance)) => -distance,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::submap::LazySubmap;
    use std::sync::Arc;

    fn comparison(source: CandidateSource) -> Comparison {
        let nothing = Arc::new(LazySubmap::new(Vec::new(), 0));
        let (older, newer) = (nothing.clone(), nothing);
        Comparison { source, guesses: Vec::new(), expected: None, tilt: None, older, newer }
    }

    fn push(queue: &mut VerificationQueue, to: u32, source: CandidateSource) {
        let task =
            VerificationTask { from: KeyframeId(0), to: KeyframeId(to), comparison: comparison(source) };
        queue.push(QueuedComparison::of_pair(&task), task.comparison);
    }

    fn push_revisit(queue: &mut VerificationQueue, waypoint: u64) {
        let comparison = comparison(CandidateSource::Geometry);
        let revisit = Revisit { waypoint, keyframe: KeyframeId(0), comparison };
        queue.push(QueuedComparison::of_revisit(Stamp::EPOCH, &revisit), revisit.comparison);
    }

    /// The newer keyframes of pairs, and the waypoints of revisits.
    fn number(queued: &QueuedComparison) -> u32 {
        match queued {
            QueuedComparison::Pair { to, .. } => to.0,
            QueuedComparison::Revisit { waypoint, .. } => *waypoint as u32,
        }
    }

    fn started(queue: &mut VerificationQueue, jobs: &mut u64) -> Vec<u32> {
        queue.start(jobs).iter().map(|(_, queued)| number(queued)).collect()
    }

    #[test]
    fn few_run_at_a_time_the_most_promising_first() {
        let (mut queue, mut jobs) = (VerificationQueue::default(), 10);
        for (to, source) in [
            (1, CandidateSource::Appearance(0.4)),
            (2, CandidateSource::Geometry),
            (3, CandidateSource::Appearance(0.1)),
            (5, CandidateSource::Person),
        ] {
            push(&mut queue, to, source);
        }
        push_revisit(&mut queue, 4);
        assert_eq!(started(&mut queue, &mut jobs), [5, 4, 2, 3]);
        assert!(started(&mut queue, &mut jobs).is_empty());
        assert!(queue.take(12).is_some() && queue.take(12).is_none());
        assert_eq!(queue.end(12).as_ref().map(number), Some(2));
        assert!(queue.end(12).is_none() && queue.end(9).is_none());
        assert_eq!((started(&mut queue, &mut jobs), jobs), (vec![1], 15));
    }

    #[test]
    fn of_too_many_the_least_alike_are_skipped_and_counted() {
        let mut queue = VerificationQueue::default();
        push(&mut queue, 1, CandidateSource::Person);
        push(&mut queue, 2, CandidateSource::Appearance(0.4));
        for to in 0..32 {
            push(&mut queue, 100 + to, CandidateSource::Geometry);
        }
        assert_eq!((queue.skipped(), queue.waiting.len()), (2, 32));
        let first: Vec<u32> = queue.waiting.iter().take(3).map(|(queued, _)| number(queued)).collect();
        assert_eq!(first, [1, 101, 102], "the one that looked alike is skipped first, then the oldest");
        queue.clear();
        assert_eq!((queue.skipped(), started(&mut queue, &mut 0).len()), (34, 0));
    }
}
