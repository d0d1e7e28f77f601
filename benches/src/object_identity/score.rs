//! How often an object is matched with itself.

use geometry::{Rng, RngTree};
use object_identity::{
    AssociationConfig, Descriptor, ObjectShape, PairModel, associate, pairs_by_clusters,
    sorted_size_difference,
};

/// Objects of a comparison that were moved, that are gone, and that are new: drawn from 0 or 1 to these numbers.
const MOVED: usize = 4;
const ALONE: usize = 3;

/// A view that was described.
#[derive(Clone, Debug)]
pub struct DescribedView {
    pub object: usize,
    pub shape: ObjectShape,
}

/// How views are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    Sizes,
    Descriptor,
    Likelihood,
}

impl Measure {
    /// How unlike two views are.
    fn distance(self, a: &ObjectShape, b: &ObjectShape) -> f64 {
        match self {
            Self::Sizes => sorted_size_difference(&a.size_m, &b.size_m),
            Self::Descriptor => {
                let both = a.descriptor.as_ref().zip(b.descriptor.as_ref());
                both.and_then(|(a, b)| a.distance(b)).unwrap_or(f64::INFINITY)
            }
            Self::Likelihood => -PairModel::log_likelihood_ratio(a, b),
        }
    }
}

/// Share of the views whose nearest one is of the same object, if they are compared with one view of each of `others` further objects and one further view of their own, all random.
pub fn nearest_share(views: &[Vec<DescribedView>], measure: Measure, others: usize, seed: u64) -> f64 {
    let mut rng = RngTree::new(seed).child("nearest").rng();
    let (mut right, mut asked) = (0, 0);
    for (object, of_object) in views.iter().enumerate() {
        for (number, view) in of_object.iter().enumerate() {
            let own = &of_object[(number + 1 + below(&mut rng, of_object.len() - 1)) % of_object.len()];
            let own_distance = measure.distance(&view.shape, &own.shape);
            let is_nearest = (0..others).all(|_| {
                let other = (object + 1 + below(&mut rng, views.len() - 1)) % views.len();
                let other = &views[other][below(&mut rng, views[other].len())];
                measure.distance(&view.shape, &other.shape) > own_distance
            });
            right += usize::from(is_nearest);
            asked += 1;
        }
    }
    right as f64 / f64::from(asked.max(1))
}

/// Pairs of simulated comparisons.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PairScore {
    pub moved: usize,
    pub right: usize,
    pub wrong: usize,
    /// Sum over the named pairs of the probability that each was given.
    pub probability: f64,
}

impl PairScore {
    fn count(&mut self, gone: &[&DescribedView], new: &[&DescribedView], pairs: &[([usize; 2], f64)]) {
        self.moved += gone.iter().filter(|view| new.iter().any(|other| other.object == view.object)).count();
        for ([a, b], probability) in pairs {
            if gone[*a].object == new[*b].object {
                self.right += 1;
            } else {
                self.wrong += 1;
            }
            self.probability += probability;
        }
    }
}

/// Ways to find pairs.
pub struct PairScores {
    /// The nearest in place of those whose sides, unsorted, differ by at most a tenth or 7.5 cm, as before.
    pub by_box: PairScore,
    pub by_clusters: PairScore,
    pub by_assignment: PairScore,
    /// The same without a limit of the difference of sizes, and without regard to places.
    pub by_open_assignment: PairScore,
}

/// Comparisons of visits in which random objects were moved, are gone and are new.
pub fn pair_scores(views: &[Vec<DescribedView>], comparisons: usize, seed: u64) -> PairScores {
    let mut rng = RngTree::new(seed).child("comparisons").rng();
    let mut scores = PairScores {
        by_box: PairScore::default(),
        by_clusters: PairScore::default(),
        by_assignment: PairScore::default(),
        by_open_assignment: PairScore::default(),
    };
    let config = AssociationConfig::default();
    let open = AssociationConfig { per_m: 0.0, max_difference_share: f64::INFINITY, ..config };
    for _ in 0..comparisons {
        let (moved, gone, new) =
            (1 + below(&mut rng, MOVED), below(&mut rng, ALONE + 1), below(&mut rng, ALONE + 1));
        let mut objects: Vec<usize> = Vec::new();
        while objects.len() < moved + gone + new {
            let object = below(&mut rng, views.len());
            if !objects.contains(&object) {
                objects.push(object);
            }
        }
        let (mut before, mut after) = (Vec::new(), Vec::new());
        for (place, object) in objects.iter().enumerate() {
            let of_object = &views[*object];
            let first = below(&mut rng, of_object.len());
            if place < moved + gone {
                before.push(&of_object[first]);
            }
            if !(moved..moved + gone).contains(&place) {
                after.push(&of_object[(first + 1) % of_object.len()]);
            }
        }
        let places = |rng: &mut Rng, count: usize| -> Vec<[f64; 2]> {
            (0..count).map(|_| [rng.range(0.0, 40.0), rng.range(0.0, 40.0)]).collect()
        };
        let (from, to) = (places(&mut rng, before.len()), places(&mut rng, after.len()));
        let distance_m = |a: usize, b: usize| (from[a][0] - to[b][0]).hypot(from[a][1] - to[b][1]);
        scores.by_box.count(&before, &after, &certain(&nearest_of_one_size(&before, &after, distance_m)));
        let descriptors = |views: &[&DescribedView]| -> Vec<Descriptor> {
            views.iter().filter_map(|view| view.shape.descriptor.clone()).collect()
        };
        let clustered = pairs_by_clusters(&descriptors(&before), &descriptors(&after));
        scores.by_clusters.count(&before, &after, &certain(&clustered));
        let assigned = |config: &AssociationConfig| -> Vec<([usize; 2], f64)> {
            let row = |(a, one): (usize, &&DescribedView)| -> Vec<f64> {
                let of = |(b, other): (usize, &&DescribedView)| {
                    config.log_odds(&one.shape, &other.shape, distance_m(a, b))
                };
                after.iter().enumerate().map(of).collect()
            };
            let log_odds: Vec<Vec<f64>> = before.iter().enumerate().map(row).collect();
            associate(&log_odds).into_iter().map(|found| (found.pair, found.probability)).collect()
        };
        scores.by_assignment.count(&before, &after, &assigned(&config));
        scores.by_open_assignment.count(&before, &after, &assigned(&open));
    }
    scores
}

fn certain(pairs: &[[usize; 2]]) -> Vec<([usize; 2], f64)> {
    pairs.iter().map(|pair| (*pair, 1.0)).collect()
}

fn nearest_of_one_size(
    before: &[&DescribedView],
    after: &[&DescribedView],
    distance_m: impl Fn(usize, usize) -> f64,
) -> Vec<[usize; 2]> {
    let mut candidates = Vec::new();
    for (a, one) in before.iter().enumerate() {
        for (b, other) in after.iter().enumerate() {
            let mut sides = one.shape.size_m.iter().zip(&other.shape.size_m);
            if sides.all(|(a, b)| (a - b).abs() <= (0.1 * a.max(*b)).max(0.075)) {
                candidates.push((distance_m(a, b), [a, b]));
            }
        }
    }
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut pairs: Vec<[usize; 2]> = Vec::new();
    for (_, [a, b]) in candidates {
        if pairs.iter().all(|pair| pair[0] != a && pair[1] != b) {
            pairs.push([a, b]);
        }
    }
    pairs
}

/// The model of pairs that fits best to random pairs of views, half of them of one object: logistic regression by Newton's method.
pub fn fitted_model(views: &[Vec<DescribedView>], measure: Measure, pairs: usize, seed: u64) -> PairModel {
    let mut rng = RngTree::new(seed).child("fit").rng();
    let mut rows: Vec<(nalgebra::Vector3<f64>, f64)> = Vec::new();
    for number in 0..pairs {
        let is_same = number % 2 == 0;
        let a = below(&mut rng, views.len());
        let b = if is_same { a } else { (a + 1 + below(&mut rng, views.len() - 1)) % views.len() };
        let first = below(&mut rng, views[a].len());
        let second = if is_same {
            (first + 1 + below(&mut rng, views[a].len() - 1)) % views[a].len()
        } else {
            below(&mut rng, views[b].len())
        };
        let (one, other) = (&views[a][first].shape, &views[b][second].shape);
        let distance = if measure == Measure::Sizes { 0.0 } else { Measure::Descriptor.distance(one, other) };
        let row = nalgebra::Vector3::new(1.0, distance, sorted_size_difference(&one.size_m, &other.size_m));
        rows.push((row, f64::from(u8::from(is_same))));
    }
    let mut is_used = nalgebra::Vector3::repeat(1.0);
    loop {
        let weights = regression(&rows, &is_used);
        // What differs more never speaks for one thing: a weight of the wrong sign is left out.
        let Some(wrong) = (1..3).find(|place| weights[*place] > 0.0) else {
            return PairModel {
                at_zero: weights.x,
                per_distance: -weights.y,
                per_size_difference: -weights.z,
            };
        };
        is_used[wrong] = 0.0;
    }
}

/// The weights by Newton's method, without those that are not used.
fn regression(
    rows: &[(nalgebra::Vector3<f64>, f64)],
    is_used: &nalgebra::Vector3<f64>,
) -> nalgebra::Vector3<f64> {
    let mut weights = nalgebra::Vector3::zeros();
    for _ in 0..30 {
        let mut gradient = nalgebra::Vector3::zeros();
        // A little ridge keeps a weight of nothing at zero.
        let mut curvature = nalgebra::Matrix3::identity() * 1e-3;
        for (row, is_same) in rows {
            let row = row.component_mul(is_used);
            let probability = 1.0 / (1.0 + (-weights.dot(&row)).exp());
            gradient += row * (is_same - probability);
            curvature += row * row.transpose() * (probability * (1.0 - probability));
        }
        let Some(inverse) = curvature.try_inverse() else { break };
        weights += inverse * gradient;
    }
    weights
}

fn below(rng: &mut Rng, count: usize) -> usize {
    ((rng.uniform() * count as f64) as usize).min(count.saturating_sub(1))
}
