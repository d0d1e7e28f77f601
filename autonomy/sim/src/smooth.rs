//! Low-pass filters that make the body's motion smooth enough to differentiate twice.

use crate::TICK_SECONDS;

/// Three equal first-order filters in a row. The answer to bounded steps is continuous in acceleration, and always lies
/// within the range of recent inputs, so a filtered path cuts corners but never swings past them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Smooth {
    stages: [f64; 3],
    gain: f64,
}

impl Smooth {
    /// Settled at `value`; each stage has the time constant `seconds`.
    pub(crate) fn new(value: f64, seconds: f64) -> Self {
        Self { stages: [value; 3], gain: 1.0 - (-TICK_SECONDS / seconds).exp() }
    }

    /// One tick towards `input`; returns the filtered value.
    pub(crate) fn step(&mut self, input: f64) -> f64 {
        let mut level = input;
        for stage in &mut self.stages {
            *stage += self.gain * (level - *stage);
            level = *stage;
        }
        level
    }

    /// The value now.
    pub(crate) fn value(&self) -> f64 {
        self.stages[2]
    }
}
