//! Work that is too long for a step, as it leaves the stack.

use crate::loops::plain;
use mapping::{Comparison, Gates, compare};
use messages::{JobResult, LoopTask, VisitTask};

/// What a job takes, owned: may run anywhere and at any time. Its result goes back as `Input::JobDone`.
#[derive(Debug)]
pub struct Work {
    asked: Asked,
    comparison: Comparison,
    gates: Gates,
}

/// What was asked of a job.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Asked {
    Loop(LoopTask),
    Visit(VisitTask),
}

impl Asked {
    /// Whether it is about a pair of keyframes.
    pub fn is_pair(&self) -> bool {
        matches!(self, Self::Loop(_))
    }
}

impl Work {
    pub(crate) fn new(asked: Asked, comparison: Comparison, gates: Gates) -> Self {
        Self { asked, comparison, gates }
    }

    /// Does the work: a pure function of what it owns. 5 to 25 ms.
    pub fn run(self) -> JobResult {
        let compared = compare(&self.comparison, &self.gates);
        match &self.asked {
            Asked::Loop(asked) => {
                JobResult::LoopVerified(Box::new(plain::verified_to_plain(asked, &compared)))
            }
            Asked::Visit(asked) => {
                JobResult::VisitCompared(Box::new(plain::compared_to_plain(asked, &compared)))
            }
        }
    }
}
