//! Low-pass filters that make the body's motion smooth enough to differentiate twice.

use crate::timing::TICK_SECONDS;

/// Three equal first-order filters in series. The response to bounded steps is continuous in acceleration, and always lies
/// within the range of recent inputs: a filtered path cuts corners and never overshoots them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LowPassFilter {
    stages: [f64; 3],
    gain: f64,
}

impl LowPassFilter {
    /// A filter at rest at `value`; each stage has the time constant `seconds`.
    pub(crate) fn new(value: f64, seconds: f64) -> Self {
        Self { stages: [value; 3], gain: 1.0 - (-TICK_SECONDS / seconds).exp() }
    }

    /// Advances by one tick towards `input` and returns the filtered value.
    pub(crate) fn update(&mut self, input: f64) -> f64 {
        let mut level = input;
        for stage in &mut self.stages {
            *stage += self.gain * (level - *stage);
            level = *stage;
        }
        level
    }

    /// The present output.
    pub(crate) fn value(&self) -> f64 {
        self.stages[2]
    }
}
