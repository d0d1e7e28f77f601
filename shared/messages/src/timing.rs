//! Times that the robot, the stack and the server keep between them.

use vocab::Span;

/// Time between two ticks of the stack, on the robot's clock.
pub const TICK_PERIOD: Span = Span::from_millis(50);

/// Longest gap in the robot's clock that is filled with ticks. A longer gap means that the clock was set, or that the recording pauses.
pub const MAX_TICK_GAP: Span = Span::from_millis(2_000);

/// A drive command expires after this time on the robot's clock: the robot stops by itself when none follows.
pub const DRIVE_LIFETIME: Span = Span::from_millis(500);
