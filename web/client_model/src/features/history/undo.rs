//! Undo of one small value: each step keeps a whole copy.

use crate::ClientTime;

/// What setting a value led to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EditResult {
    /// The value was the same before.
    Unchanged,
    /// The edit joined the last step.
    Merged,
    /// The edit is a step of its own.
    NewStep,
}

/// How edits become steps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct UndoConfig {
    /// Edits closer together than this become one step, so that a dragged slider is one. Seconds. Chosen: longer than the pauses within one drag, shorter than those
    /// between two edits.
    pub(crate) merge_s: f64,
    /// Steps kept. Chosen: more than anybody takes back one by one.
    pub(crate) max_steps: usize,
}

impl Default for UndoConfig {
    fn default() -> Self {
        Self { merge_s: 0.7, max_steps: 100 }
    }
}

/// A value with its past and its undone future.
#[derive(Clone, Debug)]
pub struct ValueHistory<T> {
    present: T,
    past: Vec<T>,
    future: Vec<T>,
    edited: ClientTime,
    config: UndoConfig,
}

impl<T: Clone + PartialEq> ValueHistory<T> {
    /// Starts with nothing to undo.
    pub fn new(present: T) -> Self {
        Self {
            present,
            past: Vec::new(),
            future: Vec::new(),
            edited: ClientTime(f64::NEG_INFINITY),
            config: UndoConfig::default(),
        }
    }

    /// The value now.
    pub fn get(&self) -> &T {
        &self.present
    }

    /// Changes the value.
    pub fn set(&mut self, now: ClientTime, value: T) -> EditResult {
        if value == self.present {
            return EditResult::Unchanged;
        }
        let previous = std::mem::replace(&mut self.present, value);
        let step = now.since(self.edited) > self.config.merge_s;
        if step {
            self.past.push(previous);
            if self.past.len() > self.config.max_steps {
                self.past.remove(0);
            }
        }
        self.edited = now;
        self.future.clear();
        if step { EditResult::NewStep } else { EditResult::Merged }
    }

    /// Goes back one step; returns whether there was one.
    pub fn undo(&mut self) -> bool {
        let Some(previous) = self.past.pop() else { return false };
        self.future.push(std::mem::replace(&mut self.present, previous));
        self.edited = ClientTime(f64::NEG_INFINITY);
        true
    }

    /// Goes forward one step; returns whether there was one.
    pub fn redo(&mut self) -> bool {
        let Some(next) = self.future.pop() else { return false };
        self.past.push(std::mem::replace(&mut self.present, next));
        self.edited = ClientTime(f64::NEG_INFINITY);
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Undo and redo are inverse.
        #[test]
        fn undo_then_redo_changes_nothing(values in proptest::collection::vec(0_u32..5, 1..40)) {
            let mut undo = ValueHistory::new(0_u32);
            for (at, value) in values.iter().enumerate() {
                undo.set(ClientTime(at as f64), *value);
            }
            let last = *undo.get();
            let mut steps = 0;
            while undo.undo() { steps += 1; }
            prop_assert_eq!(*undo.get(), 0);
            for _ in 0..steps { prop_assert!(undo.redo()); }
            prop_assert_eq!(*undo.get(), last);
            prop_assert!(!undo.can_redo());
        }
    }
}
