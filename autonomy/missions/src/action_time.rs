//! How long an action may take before it is cancelled.

use vocab::Span;

/// Parameters of the time limit of actions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ActionTimeConfig {
    /// An action may take this many times its expected time. Chosen: expected times are means.
    pub ratio: i64,
    /// Time for any action, whatever is expected of it.
    pub margin: Span,
}

impl Default for ActionTimeConfig {
    fn default() -> Self {
        Self { ratio: 3, margin: Span::from_millis(60_000) }
    }
}

impl ActionTimeConfig {
    /// The time limit of an action of this expected time.
    pub fn limit(&self, expected: Span) -> Span {
        expected * self.ratio + self.margin
    }
}
