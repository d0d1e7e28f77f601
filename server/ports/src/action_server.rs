//! Interface to whoever performs actions: a robot behind its link, or another program. ROS 2 calls this an action server.

use crossbeam_channel::Receiver;
use serde::{Deserialize, Serialize};
use vocab::{ActionCallId, Span};

/// Actions that may be under way at a time, at a robot and in the core.
pub const MAX_OPEN_ACTIONS: usize = 16;

/// Largest result of one action with all its files, bytes.
pub const MAX_ACTION_RESULT_BYTES: usize = 16 << 20;

/// Longest parameters of an action, bytes of JSON.
pub const MAX_ACTION_PARAMETER_BYTES: usize = 2 << 10;

/// What is known of an action before it is called.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ActionRegistration {
    /// Name under which it is called, such as `photo`.
    pub name: String,
    /// Shown to people.
    pub title: String,
    /// JSON Schema of its parameters.
    pub parameter_schema: String,
    /// How long it is expected to take with the parameters that the schema has as defaults.
    pub expected: Span,
    /// Energy that it is expected to take then besides what the standing robot takes, joules.
    pub expected_energy_j: u32,
    /// Whether it can be repeated without harm.
    pub is_idempotent: bool,
}

/// A call of an action.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ActionCall {
    /// Its id. A server that gets a call twice performs it once.
    pub id: ActionCallId,
    /// Name of the action.
    pub action: String,
    /// Parameters as JSON, as the action's schema has it.
    pub parameters: String,
}

/// What an action server says of a call.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ActionEvent {
    /// It is under way.
    Feedback {
        /// Which call.
        call: ActionCallId,
        /// Share that is done, 0 to 1, if it is known.
        progress: Option<f32>,
        /// Its present step, for people.
        text: String,
    },
    /// It has ended. Nothing comes after this.
    Ended {
        /// Which call.
        call: ActionCallId,
        /// How.
        end: ActionEnd,
    },
}

/// How a call ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ActionEnd {
    /// It was done.
    Succeeded {
        /// What was found, without files: an `ActionReport` of crate `site_model` as JSON. Whoever called completes it.
        report: String,
        /// What was gathered.
        files: Vec<ActionFile>,
    },
    /// It could not be done, or nobody knows whether it was.
    Failed {
        /// One sentence for people.
        reason: String,
    },
    /// It was cancelled before it was done.
    Cancelled,
}

/// A file that an action has gathered.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ActionFile {
    /// For people, with an ending: `photo.jpg`.
    pub name: String,
    /// What it is, such as `image/jpeg`.
    pub media_type: String,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// Performs actions. Dropping it cancels them.
pub trait ActionServer: Send + Sync {
    /// The actions that it performs.
    fn actions(&self) -> Vec<ActionRegistration>;

    /// Begins an action. Never blocks. Unless it is refused, exactly one [`ActionEvent::Ended`] follows, also when the server dies.
    ///
    /// # Errors
    /// One sentence with the reason why it was not begun.
    fn start(&self, call: ActionCall) -> Result<(), String>;

    /// Asks for the end of a call. Never blocks. It may succeed all the same.
    fn cancel(&self, call: ActionCallId);

    /// Where it says what becomes of calls. Bounded: feedback that finds it full is left out, and there is always room for the end of each call.
    fn events(&self) -> Receiver<ActionEvent>;
}
