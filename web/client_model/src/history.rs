//! What can be taken back, in the order in which it was done: changes of the view, and decisions on loops.
//!
//! Changes of the view are kept as documents ([`crate::Undo`]); a decision on a loop is kept as the command that undoes
//! it, because its document is on the robot.

use crate::LoopPair;
use vocab::CommandId;

const STEPS_MAX: usize = 200;

/// A decision on a loop that a person made here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoopEdit {
    /// Which loop.
    pub pair: LoopPair,
    /// Whether it was accepted; else it was rejected. The one undoes the other.
    pub accepted: bool,
    /// The command that was sent for it last.
    pub(crate) command: CommandId,
}

/// Something done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// The view was changed.
    View,
    /// A loop was decided on.
    Loop(LoopEdit),
}

/// What was done, and what was undone of it.
#[derive(Clone, Debug, Default)]
pub(crate) struct History {
    past: Vec<Step>,
    future: Vec<Step>,
}

impl History {
    /// Something was done: what was undone before cannot be done again.
    pub(crate) fn add(&mut self, step: Step) {
        self.future.clear();
        self.past.push(step);
        if self.past.len() > STEPS_MAX {
            self.past.remove(0);
        }
    }

    /// The last step done, which is to be undone and then handed to [`Self::undone`].
    pub(crate) fn take_last(&mut self) -> Option<Step> {
        self.past.pop()
    }

    /// The last decision on a loop, as [`Self::take_last`] takes the last step.
    pub(crate) fn take_last_loop(&mut self) -> Option<LoopEdit> {
        let at = self.past.iter().rposition(|step| matches!(step, Step::Loop(_)))?;
        match self.past.remove(at) {
            Step::Loop(step) => Some(step),
            Step::View => None,
        }
    }

    /// The last step undone, which is to be done again and then handed to [`Self::redone`].
    pub(crate) fn take_undone(&mut self) -> Option<Step> {
        self.future.pop()
    }

    /// A step was undone.
    pub(crate) fn undone(&mut self, step: Step) {
        self.future.push(step);
    }

    /// A step was done again.
    pub(crate) fn redone(&mut self, step: Step) {
        self.past.push(step);
    }

    /// The decision on a loop that would be undone next.
    pub(crate) fn last_loop(&self) -> Option<&LoopEdit> {
        self.past.iter().rev().find_map(|step| match step {
            Step::Loop(step) => Some(step),
            Step::View => None,
        })
    }

    /// The robot refused a command: what it stood for was neither done nor undone.
    pub(crate) fn refused(&mut self, command: CommandId) {
        self.retain(|step| step.command != command);
    }

    /// Another map: its keyframes have other numbers.
    pub(crate) fn forget_loops(&mut self) {
        self.retain(|_| false);
    }

    fn retain(&mut self, keep: impl Fn(&LoopEdit) -> bool) {
        for steps in [&mut self.past, &mut self.future] {
            steps.retain(|step| match step {
                Step::Loop(step) => keep(step),
                Step::View => true,
            });
        }
    }
}
