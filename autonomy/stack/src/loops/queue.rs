//! Pairs waiting to be compared, and those being compared: both bounded, the least promising are left out first.

use crate::work::{Asked, ComputeJob};
use mapping::{CandidateSource, Comparison, VerificationConfig};
use messages::{Job, StackEffect};
use std::collections::BTreeMap;

/// Pairs under verification at a time: they share a thread with the keeping of clouds.
const RUNNING: usize = 4;
/// Pairs that may wait: what a walk through an old corridor proposes in half a minute.
const WAITING: usize = 32;

/// ComputeJob of one session.
#[derive(Debug, Default)]
pub(crate) struct Queue {
    /// In the order of arrival.
    waiting: Vec<(Asked, Comparison)>,
    /// By job: what was asked, and what it takes until that is fetched.
    running: BTreeMap<u64, (Asked, Option<Comparison>)>,
    left_out: u64,
}

impl Queue {
    /// Lets a pair wait; if too many do, the least promising is left out.
    pub fn push(&mut self, asked: Asked, comparison: Comparison) {
        self.waiting.push((asked, comparison));
        if self.waiting.len() > WAITING {
            // Of equals the oldest.
            let last = (0..self.waiting.len()).min_by(|&a, &b| {
                promise(&self.waiting[a]).total_cmp(&promise(&self.waiting[b])).then(a.cmp(&b))
            });
            if let Some(last) = last {
                let (asked, _) = self.waiting.remove(last);
                self.left_out += u64::from(asked.is_pair());
            }
        }
    }

    /// Starts as many as may run, the most promising first and of equals the oldest. `jobs` counts all jobs of the stack.
    pub fn start(&mut self, jobs: &mut u64, effects: &mut Vec<StackEffect>) {
        while self.running.len() < RUNNING {
            let best = (0..self.waiting.len()).max_by(|&a, &b| {
                promise(&self.waiting[a]).total_cmp(&promise(&self.waiting[b])).then(b.cmp(&a))
            });
            let Some(best) = best else { return };
            let (asked, comparison) = self.waiting.remove(best);
            let work = match asked {
                Asked::Loop(task) => Job::VerifyLoop(task),
                Asked::Revisit(task) => Job::CompareRevisit(task),
            };
            effects.push(StackEffect::StartJob { job: *jobs, work });
            self.running.insert(*jobs, (asked, Some(comparison)));
            *jobs += 1;
        }
    }

    /// What a job takes; once.
    pub fn take(&mut self, job: u64, gates: &VerificationConfig) -> Option<ComputeJob> {
        let (asked, comparison) = self.running.get_mut(&job)?;
        Some(ComputeJob::new(*asked, comparison.take()?, *gates))
    }

    /// A job has ended. Says what had been asked of it, if it was one of these.
    pub fn end(&mut self, job: u64) -> Option<Asked> {
        self.running.remove(&job).map(|(asked, _)| asked)
    }

    /// A job has ended without a result.
    pub fn leave_out(&mut self) {
        self.left_out += 1;
    }

    /// Whether nothing waits and nothing runs.
    pub fn is_empty(&self) -> bool {
        self.waiting.is_empty() && self.running.is_empty()
    }

    /// Forgets all: results of what runs are not wanted any more.
    pub fn clear(&mut self) {
        let asked =
            self.waiting.iter().map(|(asked, _)| asked).chain(self.running.values().map(|(asked, _)| asked));
        self.left_out += asked.filter(|asked| asked.is_pair()).count() as u64;
        self.waiting.clear();
        self.running.clear();
    }

    /// Pairs that were never verified.
    pub fn left_out(&self) -> u64 {
        self.left_out
    }
}

/// People know best; then where the robot is now; then what the estimates say; then what looks most alike.
fn promise((asked, comparison): &(Asked, Comparison)) -> f32 {
    match (asked, comparison.source) {
        (_, CandidateSource::Person) => 3.0,
        (Asked::Revisit(_), _) => 2.0,
        (Asked::Loop(_), CandidateSource::Geometry) => 1.0,
        (Asked::Loop(_), CandidateSource::Appearance(distance)) => -distance,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loops::plain;
    use mapping::submap::LazySubmap;
    use mapping::{Revisit, VerificationTask};
    use std::sync::Arc;
    use uuid::Uuid;
    use vocab::{KeyframeId, SessionId, Stamp};

    fn push(queue: &mut Queue, to: u32, source: CandidateSource) {
        let nothing = Arc::new(LazySubmap::new(Vec::new(), 0));
        let (older, newer) = (nothing.clone(), nothing);
        let comparison = Comparison { source, guesses: Vec::new(), expected: None, older, newer };
        let task = VerificationTask { from: KeyframeId(0), to: KeyframeId(to), comparison };
        let asked = Asked::Loop(plain::task_to_plain(SessionId(Uuid::nil()), &task));
        queue.push(asked, task.comparison);
    }

    fn visit(queue: &mut Queue, number: u64) {
        let nothing = Arc::new(LazySubmap::new(Vec::new(), 0));
        let (older, newer, source) = (nothing.clone(), nothing, CandidateSource::Geometry);
        let comparison = Comparison { source, guesses: Vec::new(), expected: None, older, newer };
        let visit = Revisit { number, keyframe: KeyframeId(0), comparison };
        let asked = Asked::Revisit(plain::visit_to_plain(SessionId(Uuid::nil()), Stamp::EPOCH, &visit));
        queue.push(asked, visit.comparison);
    }

    /// The newer keyframes of pairs that were started, and the numbers of visits.
    fn started(queue: &mut Queue, jobs: &mut u64) -> Vec<u32> {
        let mut effects = Vec::new();
        queue.start(jobs, &mut effects);
        let to = |effect: &StackEffect| match effect {
            StackEffect::StartJob { work: Job::VerifyLoop(task), .. } => task.to.0,
            StackEffect::StartJob { work: Job::CompareRevisit(task), .. } => task.visit as u32,
            other => panic!("{other:?}"),
        };
        effects.iter().map(to).collect()
    }

    #[test]
    fn few_run_at_a_time_the_best_first() {
        let (mut queue, mut jobs) = (Queue::default(), 10);
        for (to, source) in [
            (1, CandidateSource::Appearance(0.4)),
            (2, CandidateSource::Geometry),
            (3, CandidateSource::Appearance(0.1)),
            (5, CandidateSource::Person),
        ] {
            push(&mut queue, to, source);
        }
        visit(&mut queue, 4);
        assert_eq!(started(&mut queue, &mut jobs), [5, 4, 2, 3]);
        assert!(started(&mut queue, &mut jobs).is_empty());
        assert!(
            queue.take(12, &VerificationConfig::default()).is_some()
                && queue.take(12, &VerificationConfig::default()).is_none()
        );
        let ended = |asked: Option<Asked>| match asked {
            Some(Asked::Loop(task)) => task.to.0,
            other => panic!("{other:?}"),
        };
        assert_eq!(ended(queue.end(12)), 2);
        assert!(queue.end(12).is_none() && queue.end(9).is_none());
        assert_eq!((started(&mut queue, &mut jobs), jobs), (vec![1], 15));
    }

    #[test]
    fn of_too_many_the_least_alike_are_left_out_and_counted() {
        let mut queue = Queue::default();
        push(&mut queue, 1, CandidateSource::Person);
        push(&mut queue, 2, CandidateSource::Appearance(0.4));
        for to in 0..WAITING as u32 {
            push(&mut queue, 100 + to, CandidateSource::Geometry);
        }
        assert_eq!((queue.left_out(), queue.waiting.len()), (2, WAITING));
        let first: Vec<u32> = queue
            .waiting
            .iter()
            .take(3)
            .map(|(asked, _)| match asked {
                Asked::Loop(task) => task.to.0,
                Asked::Revisit(_) => 0,
            })
            .collect();
        assert_eq!(first, [1, 101, 102], "what looked alike, then the oldest");
        queue.clear();
        assert_eq!((queue.left_out(), started(&mut queue, &mut 0).len()), (2 + WAITING as u64, 0));
    }
}
