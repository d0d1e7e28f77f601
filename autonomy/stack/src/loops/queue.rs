//! Pairs waiting to be verified, and those being verified: both bounded, the least promising are left out first.

use super::plain;
use crate::work::Work;
use mapping::{Gates, Source, Task};
use messages::{Effect, Job, LoopTask};
use std::collections::BTreeMap;
use vocab::SessionId;

/// Pairs under verification at a time: they share a thread with the keeping of clouds.
const RUNNING: usize = 4;
/// Pairs that may wait: what a walk through an old corridor proposes in half a minute.
const WAITING: usize = 32;

/// Work of one session.
#[derive(Debug, Default)]
pub(crate) struct Queue {
    /// In the order of arrival.
    waiting: Vec<Task>,
    /// By job: what was asked, and what it takes until that is fetched.
    running: BTreeMap<u64, (LoopTask, Option<Task>)>,
    left_out: u64,
}

impl Queue {
    /// Lets a pair wait; if too many do, the least promising is left out.
    pub fn push(&mut self, task: Task) {
        self.waiting.push(task);
        if self.waiting.len() > WAITING {
            // Of equals the oldest.
            let last = (0..self.waiting.len()).min_by(|&a, &b| {
                promise(&self.waiting[a]).total_cmp(&promise(&self.waiting[b])).then(a.cmp(&b))
            });
            if let Some(last) = last {
                self.waiting.remove(last);
                self.left_out += 1;
            }
        }
    }

    /// Starts as many as may run, the most promising first and of equals the oldest. `jobs` counts all jobs of the stack.
    pub fn start(&mut self, session: SessionId, jobs: &mut u64, effects: &mut Vec<Effect>) {
        while self.running.len() < RUNNING {
            let best = (0..self.waiting.len()).max_by(|&a, &b| {
                promise(&self.waiting[a]).total_cmp(&promise(&self.waiting[b])).then(b.cmp(&a))
            });
            let Some(best) = best else { return };
            let task = self.waiting.remove(best);
            let asked = plain::task_to_plain(session, &task);
            effects.push(Effect::StartJob { job: *jobs, work: Job::VerifyLoop(asked) });
            self.running.insert(*jobs, (asked, Some(task)));
            *jobs += 1;
        }
    }

    /// What a job takes; once.
    pub fn take(&mut self, job: u64, gates: &Gates) -> Option<Work> {
        let (asked, task) = self.running.get_mut(&job)?;
        Some(Work::new(*asked, task.take()?, *gates))
    }

    /// A job has ended. Says what had been asked of it, if it was one of these.
    pub fn end(&mut self, job: u64) -> Option<LoopTask> {
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
        self.left_out += (self.waiting.len() + self.running.len()) as u64;
        self.waiting.clear();
        self.running.clear();
    }

    /// Pairs that were never verified.
    pub fn left_out(&self) -> u64 {
        self.left_out
    }
}

/// People know best; then what the estimates say; then what looks most alike.
fn promise(task: &Task) -> f32 {
    match task.source {
        Source::Person => 2.0,
        Source::Geometry => 1.0,
        Source::Appearance(distance) => -distance,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mapping::submap::LazySubmap;
    use std::sync::Arc;
    use uuid::Uuid;
    use vocab::KeyframeId;

    fn task(to: u32, source: Source) -> Task {
        let nothing = Arc::new(LazySubmap::new(Vec::new(), 0));
        Task {
            from: KeyframeId(0),
            to: KeyframeId(to),
            source,
            guesses: Vec::new(),
            expected: None,
            older: nothing.clone(),
            newer: nothing,
        }
    }

    fn started(queue: &mut Queue, jobs: &mut u64) -> Vec<u32> {
        let mut effects = Vec::new();
        queue.start(SessionId(Uuid::nil()), jobs, &mut effects);
        let to = |effect: &Effect| match effect {
            Effect::StartJob { work: Job::VerifyLoop(task), .. } => task.to.0,
            other => panic!("{other:?}"),
        };
        effects.iter().map(to).collect()
    }

    #[test]
    fn few_run_at_a_time_the_best_first() {
        let (mut queue, mut jobs) = (Queue::default(), 10);
        for (to, source) in [
            (1, Source::Appearance(0.4)),
            (2, Source::Geometry),
            (3, Source::Appearance(0.1)),
            (4, Source::Geometry),
            (5, Source::Person),
        ] {
            queue.push(task(to, source));
        }
        assert_eq!(started(&mut queue, &mut jobs), [5, 2, 4, 3]);
        assert!(started(&mut queue, &mut jobs).is_empty());
        assert!(queue.take(12, &Gates::default()).is_some() && queue.take(12, &Gates::default()).is_none());
        assert_eq!(queue.end(12).map(|asked| asked.to), Some(KeyframeId(4)));
        assert!(queue.end(12).is_none() && queue.end(9).is_none());
        assert_eq!((started(&mut queue, &mut jobs), jobs), (vec![1], 15));
    }

    #[test]
    fn of_too_many_the_least_alike_are_left_out_and_counted() {
        let mut queue = Queue::default();
        queue.push(task(1, Source::Person));
        queue.push(task(2, Source::Appearance(0.4)));
        for to in 0..WAITING as u32 {
            queue.push(task(100 + to, Source::Geometry));
        }
        assert_eq!((queue.left_out(), queue.waiting.len()), (2, WAITING));
        let first: Vec<u32> = queue.waiting.iter().take(3).map(|task| task.to.0).collect();
        assert_eq!(first, [1, 101, 102], "what looked alike, then the oldest");
        queue.clear();
        assert_eq!((queue.left_out(), started(&mut queue, &mut 0).len()), (2 + WAITING as u64, 0));
    }
}
