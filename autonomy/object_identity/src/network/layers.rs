//! Dense layers. Sums are taken in a fixed order in plain loops, so that the bits are the same on each computer (docs/decisions/point-network.md).

use geometry::Rng;

/// A dense layer.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Dense {
    pub(super) inputs: usize,
    /// From each input to all outputs, and then the offsets of the outputs.
    pub(super) values: Vec<f32>,
}

impl Dense {
    pub(super) fn zeros([inputs, outputs]: [usize; 2]) -> Self {
        Self { inputs, values: vec![0.0; (inputs + 1) * outputs] }
    }

    /// Random weights (He and others, *Delving deep into rectifiers*, 2015).
    pub(super) fn random(shape: [usize; 2], rng: &mut Rng) -> Self {
        let mut layer = Self::zeros(shape);
        let sigma = (2.0 / shape[0] as f64).sqrt();
        for value in &mut layer.values[..shape[0] * shape[1]] {
            *value = (sigma * rng.normal()) as f32;
        }
        layer
    }

    pub(super) fn weights(&self) -> usize {
        self.values.len()
    }

    fn outputs(&self) -> usize {
        self.values.len() / (self.inputs + 1)
    }

    pub(super) fn forward(&self, input: &[f32], output: &mut [f32]) {
        let outputs = self.outputs();
        output.copy_from_slice(&self.values[self.inputs * outputs..]);
        for (value, weights) in input.iter().zip(self.values.chunks_exact(outputs)) {
            if *value != 0.0 {
                for (sum, weight) in output.iter_mut().zip(weights) {
                    *sum += value * weight;
                }
            }
        }
    }

    /// Adds the derivative by the weights to `gradient`, and writes that by the input.
    pub(super) fn backward(
        &self,
        input: &[f32],
        by_output: &[f32],
        gradient: &mut Self,
        by_input: &mut [f32],
    ) {
        let outputs = self.outputs();
        let rows = self.values.chunks_exact(outputs).zip(gradient.values.chunks_exact_mut(outputs));
        for ((value, by_value), (weights, by_weights)) in input.iter().zip(by_input).zip(rows) {
            let mut sum = 0.0;
            for ((weight, by_weight), by) in weights.iter().zip(by_weights).zip(by_output) {
                sum += weight * by;
                *by_weight += value * by;
            }
            *by_value = sum;
        }
        for (by_offset, by) in gradient.values[self.inputs * outputs..].iter_mut().zip(by_output) {
            *by_offset += by;
        }
    }
}

/// Negative values become zero.
pub(super) fn rectify(values: &mut [f32]) {
    for value in values {
        *value = value.max(0.0);
    }
}

/// Makes the length one. Returns the length before.
pub(super) fn normalise(values: &mut [f32]) -> f32 {
    let length = values.iter().map(|value| value * value).sum::<f32>().sqrt().max(1e-6);
    for value in values {
        *value /= length;
    }
    length
}
