//! Training: views of one object are drawn together, and those of different objects apart.

use super::features::{PAIR_FEATURES, WHOLE_FEATURES};
use super::layers::{Dense, normalise, rectify};
use super::{PointNetwork, UNITS, ViewFeatures};
use geometry::{Rng, RngTree};

/// Parameters of [`train`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrainingConfig {
    /// Steps of the optimiser. Source: docs/benchmarks/changes.md; the shares on other sites no longer grew.
    pub steps: usize,
    /// Objects of a step, two views each: each view is told from those of all others. Chosen: the time of a step is in proportion to it.
    pub objects: usize,
    /// Temperature of the loss: smaller ones look at the most similar wrong objects only. Source: He and others, *Momentum contrast*, 2020, has 0.07.
    pub temperature: f32,
    /// Length of the first steps. Source: Kingma and Ba, *Adam*, 2015, has 0.001; it falls to zero along half a cosine.
    pub rate: f32,
    /// Seed of the first weights and of the order of the views: the same one gives the same network.
    pub seed: u64,
}

impl Default for TrainingConfig {
    fn default() -> Self {
        Self { steps: 5_000, objects: 48, temperature: 0.1, rate: 0.002, seed: 1 }
    }
}

/// Trains a network on the views of objects, a list for each object; objects of fewer than two views are left out. `watch` gets the number of the step and its loss. None without two objects.
/// The loss is that of Oord and others, *Representation learning with contrastive predictive coding*, 2018; the optimiser is Adam.
pub fn train(
    objects: &[Vec<ViewFeatures>],
    config: &TrainingConfig,
    mut watch: impl FnMut(usize, f32),
) -> Option<PointNetwork> {
    let objects: Vec<&Vec<ViewFeatures>> = objects.iter().filter(|views| views.len() > 1).collect();
    if objects.len() < 2 {
        return None;
    }
    let tree = RngTree::new(config.seed).child("point network");
    let mut rng = tree.child("weights").rng();
    let [a, b, c, d] = PointNetwork::shapes().map(|shape| Dense::random(shape, &mut rng));
    let mut network = PointNetwork::new([a, b], [c, d]);
    let mut rng = tree.child("views").rng();
    let mut optimiser = Adam::default();
    for step in 0..config.steps {
        let views = draw_views(&objects, config.objects, &mut rng);
        let passes: Vec<Pass> = views.iter().map(|view| Pass::new(&network, view)).collect();
        let (loss, by_outputs) = contrastive_loss(&passes, config.temperature);
        watch(step, loss);
        let mut gradient = PointNetwork::shapes().map(Dense::zeros);
        for ((view, pass), by_output) in views.iter().zip(&passes).zip(&by_outputs) {
            pass.backward(&network, view, by_output, &mut gradient);
        }
        let share = step as f32 / config.steps as f32;
        let rate = config.rate * 0.5 * (1.0 + (std::f32::consts::PI * share).cos());
        optimiser.update(&mut network, &gradient, rate);
    }
    Some(PointNetwork::new(network.pair, network.whole))
}

/// Two views of each of some objects, one after the other.
fn draw_views<'a>(objects: &[&'a Vec<ViewFeatures>], count: usize, rng: &mut Rng) -> Vec<&'a ViewFeatures> {
    let mut below = |count: usize| ((rng.uniform() * count as f64) as usize).min(count - 1);
    let mut order: Vec<usize> = (0..objects.len()).collect();
    let count = count.min(order.len());
    for place in 0..count {
        let other = place + below(order.len() - place);
        order.swap(place, other);
    }
    let mut views = Vec::new();
    for object in &order[..count] {
        let of_object = objects[*object];
        let first = below(of_object.len());
        let second = (first + 1 + below(of_object.len() - 1)) % of_object.len();
        views.extend([&of_object[first], &of_object[second]]);
    }
    views
}

/// What a view became in each layer.
struct Pass {
    /// Of each pair, after the first and the second layer.
    first: Vec<f32>,
    second: Vec<f32>,
    /// The pair that has the maximum, for each unit of the second layer.
    most: Vec<usize>,
    pooled: Vec<f32>,
    third: Vec<f32>,
    output: Vec<f32>,
    length: f32,
}

impl Pass {
    fn new(network: &PointNetwork, view: &ViewFeatures) -> Self {
        let count = view.pairs.len();
        let (mut first, mut second) = (vec![0.0; count * UNITS[0]], vec![0.0; count * UNITS[1]]);
        let (mut pooled, mut most) = (vec![0.0; 2 * UNITS[1]], vec![0; UNITS[1]]);
        let rows = first.chunks_exact_mut(UNITS[0]).zip(second.chunks_exact_mut(UNITS[1]));
        for (place, (pair, (first, second))) in view.pairs.iter().zip(rows).enumerate() {
            network.pair[0].forward(pair, first);
            rectify(first);
            network.pair[1].forward(first, second);
            rectify(second);
            for unit in 0..UNITS[1] {
                pooled[unit] += second[unit] / count as f32;
                if second[unit] > pooled[UNITS[1] + unit] {
                    pooled[UNITS[1] + unit] = second[unit];
                    most[unit] = place;
                }
            }
        }
        pooled.extend(view.whole);
        let (mut third, mut output) = (vec![0.0; UNITS[2]], vec![0.0; UNITS[3]]);
        network.whole[0].forward(&pooled, &mut third);
        rectify(&mut third);
        network.whole[1].forward(&third, &mut output);
        let length = normalise(&mut output);
        Self { first, second, most, pooled, third, output, length }
    }

    fn backward(
        &self,
        network: &PointNetwork,
        view: &ViewFeatures,
        by_output: &[f32],
        gradient: &mut [Dense; 4],
    ) {
        let [of_first, of_second, of_third, of_last] = gradient;
        // Through the length that was made one.
        let along: f32 = self.output.iter().zip(by_output).map(|(at, by)| at * by).sum();
        let by_last: Vec<f32> =
            self.output.iter().zip(by_output).map(|(at, by)| (by - along * at) / self.length).collect();
        let mut by_third = vec![0.0; UNITS[2]];
        network.whole[1].backward(&self.third, &by_last, of_last, &mut by_third);
        rectified(&self.third, &mut by_third);
        let mut by_pooled = vec![0.0; 2 * UNITS[1] + WHOLE_FEATURES];
        network.whole[0].backward(&self.pooled, &by_third, of_third, &mut by_pooled);
        let count = view.pairs.len();
        let (mut by_second, mut by_first) = (vec![0.0; UNITS[1]], vec![0.0; UNITS[0]]);
        let mut by_input = [0.0; PAIR_FEATURES];
        let rows = self.first.chunks_exact(UNITS[0]).zip(self.second.chunks_exact(UNITS[1]));
        for (place, (pair, (first, second))) in view.pairs.iter().zip(rows).enumerate() {
            for unit in 0..UNITS[1] {
                let of_most = if self.most[unit] == place { by_pooled[UNITS[1] + unit] } else { 0.0 };
                by_second[unit] = by_pooled[unit] / count as f32 + of_most;
            }
            rectified(second, &mut by_second);
            network.pair[1].backward(first, &by_second, of_second, &mut by_first);
            rectified(first, &mut by_first);
            network.pair[0].backward(pair, &by_first, of_first, &mut by_input);
        }
    }
}

/// The derivative through [`rectify`], by what it left.
fn rectified(values: &[f32], by: &mut [f32]) {
    for (value, by) in values.iter().zip(by) {
        if *value <= 0.0 {
            *by = 0.0;
        }
    }
}

/// The mean over all views of the negative logarithm of the probability of their partner, and its derivatives by the outputs. Views are in pairs.
fn contrastive_loss(passes: &[Pass], temperature: f32) -> (f32, Vec<Vec<f32>>) {
    let count = passes.len();
    let mut by_outputs = vec![vec![0.0; UNITS[3]]; count];
    let mut loss = 0.0;
    for of_view in 0..count {
        let partner = of_view ^ 1;
        let similarity = |other: usize| {
            let (a, b) = (&passes[of_view].output, &passes[other].output);
            a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>() / temperature
        };
        let similarities: Vec<f32> = (0..count).map(similarity).collect();
        let others = || (0..count).filter(|other| *other != of_view);
        let most = others().map(|other| similarities[other]).fold(f32::NEG_INFINITY, f32::max);
        let sum: f32 = others().map(|other| (similarities[other] - most).exp()).sum();
        loss += most + sum.ln() - similarities[partner];
        for other in others() {
            let share = (similarities[other] - most).exp() / sum - f32::from(u8::from(other == partner));
            let weight = share / (temperature * count as f32);
            for unit in 0..UNITS[3] {
                by_outputs[of_view][unit] += weight * passes[other].output[unit];
                by_outputs[other][unit] += weight * passes[of_view].output[unit];
            }
        }
    }
    (loss / count as f32, by_outputs)
}

/// The optimiser's memory of earlier gradients.
#[derive(Default)]
struct Adam {
    step: i32,
    /// Mean of the derivative and of its square, for each weight.
    means: Vec<[f32; 2]>,
}

impl Adam {
    fn update(&mut self, network: &mut PointNetwork, gradient: &[Dense; 4], rate: f32) {
        self.step += 1;
        self.means.resize(network.weights(), [0.0; 2]);
        let kept = [0.9_f32, 0.999];
        let unbiased = kept.map(|kept| 1.0 - kept.powi(self.step));
        let layers = network.pair.iter_mut().chain(&mut network.whole).zip(gradient);
        let weights = layers.flat_map(|(layer, by)| layer.values.iter_mut().zip(&by.values));
        for ((weight, by), means) in weights.zip(&mut self.means) {
            *means =
                [kept[0] * means[0] + (1.0 - kept[0]) * by, kept[1] * means[1] + (1.0 - kept[1]) * by * by];
            *weight -= rate * (means[0] / unbiased[0]) / ((means[1] / unbiased[1]).sqrt() + 1e-8);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Views of boxes of a few sizes: points on all sides.
    fn boxes(views: usize) -> Vec<Vec<ViewFeatures>> {
        let mut rng = RngTree::new(3).rng();
        let sizes = [[0.4, 0.4, 0.4], [1.0, 0.5, 0.3], [0.6, 0.5, 1.2], [1.2, 1.1, 0.2]];
        let mut view = |size: [f64; 3]| {
            let mut point = || {
                let mut at = [0, 1, 2].map(|axis| (rng.uniform() - 0.5) * size[axis]);
                let side = (rng.uniform() * 3.0) as usize % 3;
                at[side] = size[side] / 2.0;
                at.map(|at| at as f32)
            };
            ViewFeatures::new(&(0..150).map(|_| point()).collect::<Vec<_>>()).expect("enough points")
        };
        sizes.map(|size| (0..views).map(|_| view(size)).collect()).into()
    }

    #[test]
    fn training_draws_views_of_one_object_together_and_is_repeatable() {
        let config = TrainingConfig { steps: 40, objects: 4, ..TrainingConfig::default() };
        let mut losses = Vec::new();
        let objects = boxes(6);
        let network = train(&objects, &config, |_, loss| losses.push(loss)).expect("objects");
        assert!(losses[39] < 0.7 * losses[0], "{losses:?}");
        assert_eq!(train(&objects, &config, |_, _| {}), Some(network));
        assert_eq!(train(&objects[..1], &config, |_, _| {}), None);
    }

    #[test]
    fn derivatives_are_those_of_small_steps() {
        let objects = boxes(2);
        let views: Vec<&ViewFeatures> = objects.iter().flatten().collect();
        let mut rng = RngTree::new(5).rng();
        let [a, b, c, d] = PointNetwork::shapes().map(|shape| Dense::random(shape, &mut rng));
        let mut network = PointNetwork::new([a, b], [c, d]);
        let loss = |network: &PointNetwork| {
            let passes: Vec<Pass> = views.iter().map(|view| Pass::new(network, view)).collect();
            contrastive_loss(&passes, 0.5)
        };
        let passes: Vec<Pass> = views.iter().map(|view| Pass::new(&network, view)).collect();
        let (_, by_outputs) = loss(&network);
        let mut gradient = PointNetwork::shapes().map(Dense::zeros);
        for ((view, pass), by) in views.iter().zip(&passes).zip(&by_outputs) {
            pass.backward(&network, view, by, &mut gradient);
        }
        for layer in 0..4 {
            // The weight with the greatest derivative stands out of the noise of f32.
            let values = &gradient[layer].values;
            let place = (0..values.len())
                .max_by(|a, b| values[*a].abs().total_cmp(&values[*b].abs()))
                .expect("weights");
            let mut at = |offset: f32| {
                let of_layer = match layer {
                    0 | 1 => &mut network.pair[layer],
                    _ => &mut network.whole[layer - 2],
                };
                of_layer.values[place] += offset;
                let value = loss(&network).0;
                let of_layer = match layer {
                    0 | 1 => &mut network.pair[layer],
                    _ => &mut network.whole[layer - 2],
                };
                of_layer.values[place] -= offset;
                value
            };
            let step = 2e-3;
            let measured = (at(step) - at(-step)) / (2.0 * step);
            let computed = gradient[layer].values[place];
            assert!(
                (measured - computed).abs() < 0.1 * computed.abs() + 1e-3,
                "{layer}: {measured} {computed}"
            );
        }
    }
}
