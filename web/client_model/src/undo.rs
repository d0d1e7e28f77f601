//! Undo by keeping what was: small documents, whole copies.

use crate::ClientTime;

/// What setting a value came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Changed {
    /// It was so already.
    No,
    /// It belongs to the last step.
    Merged,
    /// It is a step of its own.
    Step,
}

/// A value with its past and its undone future.
#[derive(Clone, Debug)]
pub struct Undo<T> {
    present: T,
    past: Vec<T>,
    future: Vec<T>,
    changed: ClientTime,
}

/// Changes closer together than this become one step: a dragged slider is one change.
const MERGE_S: f64 = 0.7;
const STEPS_MAX: usize = 100;

impl<T: Clone + PartialEq> Undo<T> {
    /// Starts with nothing to undo.
    pub fn new(present: T) -> Self {
        Self { present, past: Vec::new(), future: Vec::new(), changed: ClientTime(f64::NEG_INFINITY) }
    }

    /// The value now.
    pub fn get(&self) -> &T {
        &self.present
    }

    /// Changes the value; returns what that came to.
    pub fn set(&mut self, now: ClientTime, value: T) -> Changed {
        if value == self.present {
            return Changed::No;
        }
        let previous = std::mem::replace(&mut self.present, value);
        let step = now.since(self.changed) > MERGE_S;
        if step {
            self.past.push(previous);
            if self.past.len() > STEPS_MAX {
                self.past.remove(0);
            }
        }
        self.changed = now;
        self.future.clear();
        if step { Changed::Step } else { Changed::Merged }
    }

    /// Goes back one step; returns whether there was one.
    pub fn undo(&mut self) -> bool {
        let Some(previous) = self.past.pop() else { return false };
        self.future.push(std::mem::replace(&mut self.present, previous));
        self.changed = ClientTime(f64::NEG_INFINITY);
        true
    }

    /// Goes forward one step; returns whether there was one.
    pub fn redo(&mut self) -> bool {
        let Some(next) = self.future.pop() else { return false };
        self.past.push(std::mem::replace(&mut self.present, next));
        self.changed = ClientTime(f64::NEG_INFINITY);
        true
    }

    /// Whether there is a step back.
    pub fn can_undo(&self) -> bool {
        !self.past.is_empty()
    }

    /// Whether there is a step forward.
    pub fn can_redo(&self) -> bool {
        !self.future.is_empty()
    }
}
