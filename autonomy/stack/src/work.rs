//! Work that is too long for a step, as it leaves the stack.

use crate::loops::plain;
use mapping::{Gates, Task, verify};
use messages::{JobResult, LoopTask};

/// What a job takes, owned: may run anywhere and at any time. Its result goes back as `Input::JobDone`.
#[derive(Debug)]
pub struct Work {
    asked: LoopTask,
    task: Task,
    gates: Gates,
}

impl Work {
    pub(crate) fn new(asked: LoopTask, task: Task, gates: Gates) -> Self {
        Self { asked, task, gates }
    }

    /// Does the work: a pure function of what it owns. 5 to 25 ms.
    pub fn run(self) -> JobResult {
        let verified = verify(&self.task, &self.gates);
        JobResult::LoopVerified(Box::new(plain::verified_to_plain(&self.asked, &verified)))
    }
}
