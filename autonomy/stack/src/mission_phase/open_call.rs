//! An action that was called and has not ended.

use messages::StackEffect;
use vocab::{ActionCallId, GoalId, LegId};

/// The call, and how often the body has turned for it.
#[derive(Clone, Debug)]
pub(super) struct OpenCall {
    action: String,
    /// As JSON.
    parameters: String,
    /// Turns of the body for it, the present one included.
    pub turns: u32,
    /// The turn of the body that is under way: a leg of the goal for which the action is called, or a goal of its own.
    pub turn: Option<LegId>,
}

/// How a turn of the body ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TurnEnd {
    /// The body has the heading.
    Turned,
    /// There was no room.
    Blocked,
    /// Motion was stopped, somebody drives, or asked for another goal.
    MotionTaken,
}

/// The id of a turn as a goal of its own.
pub(super) fn turn_goal(turn: LegId) -> GoalId {
    GoalId(turn.0)
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
