//! Actions as missions and edges ask for them. What actions there are is registered while the robot runs.

use crate::Parameters;
use serde::{Deserialize, Serialize};

/// An action with its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActionRequest {
    /// Name under which the action is registered, such as `photo`.
    pub action: String,
    /// Parameters after the schema of the action.
    #[serde(default)]
    pub parameters: Parameters,
}
