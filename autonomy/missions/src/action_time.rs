//! How long an action may take before it is cancelled.

use vocab::Span;

/// Parameters of the time limit of actions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ActionTimeConfig {
    /// An action may take this many times its expected time. Chosen: expected times are means. With less, slow actions are cut off; with more, a robot waits longer for
    /// one that hangs.
    pub ratio: i64,
    /// Time for any action, whatever is expected of it. Chosen: a minute, for actions that first wait for their device.
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
