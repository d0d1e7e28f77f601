//! The whole autonomy behind one entrance: [`Stack::step`].
//!
//! The stack is a pure, single-threaded, clockless function of its inputs: the only time it knows is `at`, and the only
//! way anything reaches it is an [`Input`]. What it wants done comes out as [`Effect`]s. A recording of the inputs
//! therefore repeats a run bit for bit.

use messages::{Effect, Input};
use vocab::Stamp;

/// State of the robot's autonomy.
#[derive(Default)]
pub struct Stack {}

impl Stack {
    /// A stack that has heard nothing yet. The first input must be [`Input::Boot`].
    pub fn new() -> Self {
        Self::default()
    }

    /// The only way in. `at` is the only clock and never decreases; effects are appended in the order to be done.
    pub fn step(&mut self, at: Stamp, input: Input, effects: &mut Vec<Effect>) {
        let _ = (at, input, effects);
    }
}
