//! An action that was called and has not ended.

use messages::StackEffect;
use vocab::{ActionCallId, GoalId};

/// The call, and how often the body has turned for it.
#[derive(Clone, Debug)]
pub(super) struct OpenCall {
    action: String,
    /// As JSON.
    parameters: String,
    /// Turns of the body for it, the present one included.
    pub turns: u32,
    /// The goal by which the body turns now.
    pub turn: Option<GoalId>,
}

impl OpenCall {
    pub fn new(action: String, parameters: String) -> Self {
        Self { action, parameters, turns: 0, turn: None }
    }

    /// The effect by which it is called, once more if the body has turned.
    pub fn effect(&self, call: ActionCallId) -> StackEffect {
        let (action, parameters) = (self.action.clone(), self.parameters.clone());
        StackEffect::CallAction { call, action, parameters }
    }
}
