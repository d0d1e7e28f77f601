//! How much two objects look like one thing.

use crate::Descriptor;

/// What is compared of an object.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectShape {
    /// The sides of its box, in any order, metres.
    pub size_m: [f64; 3],
    /// Its descriptor, if there is one.
    pub descriptor: Option<Descriptor>,
}

/// The logarithm of the ratio of two likelihoods of what was seen of two objects, that they are one thing and that they are two: linear in the distance of their descriptors and in the
/// difference of their sizes. The values are fitted to pairs of simulated objects by `cargo xtask bench object_identity --fit`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairModel {
    /// Its value for two objects that look the same.
    pub at_zero: f64,
    /// What a distance of 1 between the descriptors takes from it.
    pub per_distance: f64,
    /// What a difference of 1 between the sizes ([`sorted_size_difference`]) takes from it.
    pub per_size_difference: f64,
}

impl PairModel {
    /// Of sizes alone.
    pub const SIZES: Self = Self { at_zero: 1.66, per_distance: 0.0, per_size_difference: 2.40 };
    /// Of the geometric descriptor. Given the sizes, its distance says nothing more.
    pub const GEOMETRIC: Self = Self::SIZES;
    /// Of a network that was trained as the one that is shipped. Given its distance, the sizes say nothing more.
    pub const NETWORK: Self = Self { at_zero: 5.91, per_distance: 6.86, per_size_difference: 0.0 };

    /// The model for descriptors of a name; that of sizes for others.
    fn of_name(name: &str) -> Self {
        match name {
            crate::geometric::NAME => Self::GEOMETRIC,
            name if name.starts_with(crate::network::NAME) => Self::NETWORK,
            _ => Self::SIZES,
        }
    }

    /// The logarithm for two objects.
    pub fn log_likelihood_ratio(a: &ObjectShape, b: &ObjectShape) -> f64 {
        let difference = sorted_size_difference(&a.size_m, &b.size_m);
        let compared = a.descriptor.as_ref().zip(b.descriptor.as_ref()).and_then(|(a, b)| {
            a.distance(b).map(|distance| Self::of_name(&a.name).value(distance, difference))
        });
        compared.unwrap_or_else(|| Self::SIZES.value(0.0, difference))
    }

    /// Its value at a distance of descriptors and a difference of sizes.
    pub fn value(&self, distance: f64, size_difference: f64) -> f64 {
        self.at_zero - self.per_distance * distance - self.per_size_difference * size_difference
    }
}

/// Added to a side before its logarithm is taken, metres: the error of a side does not shrink with it.
const SIDE_ERROR_M: f64 = 0.05;

/// Sum of the differences of the logarithms of the sides, each list sorted by length, because a thing may have been turned over.
pub fn sorted_size_difference(a_m: &[f64; 3], b_m: &[f64; 3]) -> f64 {
    let sides = sorted(a_m).into_iter().zip(sorted(b_m));
    sides.map(|(a_m, b_m)| ((a_m.max(0.0) + SIDE_ERROR_M) / (b_m.max(0.0) + SIDE_ERROR_M)).ln().abs()).sum()
}

fn sorted(sides_m: &[f64; 3]) -> [f64; 3] {
    let mut sides_m = *sides_m;
    sides_m.sort_by(f64::total_cmp);
    sides_m
}

/// Parameters of an association.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AssociationConfig {
    /// Odds that an object which is gone is one of those that are new at the same place, before anything of it is compared. Chosen: two thirds of what is gone are put elsewhere near.
    pub prior_odds: f64,
    /// Share of other things that are of the same make, such as cartons and chairs: however alike two objects are, they are one thing with a probability below one. Chosen: one in twenty.
    pub same_make_share: f64,
    /// What each metre between two places takes from the logarithm of the odds, up to [`Self::far_m`]. Chosen: a thing is moved 5 m about a third as often as it is moved a little. Of two things of one
    /// make, the nearer is more likely (the given sessions of docs/benchmarks/changes.md have such two).
    pub per_m: f64,
    /// Farther places are not less likely, metres. Chosen: beyond a room, how far a thing was taken says nothing.
    pub far_m: f64,
    /// Two objects may be one thing if each of their sides, sorted by length, differs at most by this share of the longer one, or by [`Self::max_difference_m`]. Source: docs/benchmarks/changes.md; the likelihood
    /// alone paired boxes of 0.3 and 0.5 m.
    pub max_difference_share: f64,
    /// See [`Self::max_difference_share`], metres.
    pub max_difference_m: f64,
}

impl Default for AssociationConfig {
    fn default() -> Self {
        Self {
            prior_odds: 2.0,
            same_make_share: 0.05,
            per_m: 0.2,
            far_m: 10.0,
            max_difference_share: 0.2,
            max_difference_m: 0.1,
        }
    }
}

impl AssociationConfig {
    /// The logarithm of the odds that two objects are one thing, with the likelihood ratio of what was seen, if their places are this far from each other, metres.
    pub fn log_odds(&self, a: &ObjectShape, b: &ObjectShape, distance_m: f64) -> f64 {
        if self.may_be_same(&a.size_m, &b.size_m) {
            self.log_odds_of(PairModel::log_likelihood_ratio(a, b), distance_m)
        } else {
            f64::NEG_INFINITY
        }
    }

    /// Whether boxes of these sides may be of one thing.
    fn may_be_same(&self, a_m: &[f64; 3], b_m: &[f64; 3]) -> bool {
        let is_near = |(a, b): (&f64, f64)| {
            (a - b).abs() <= (self.max_difference_share * a.max(b)).max(self.max_difference_m)
        };
        sorted(a_m).iter().zip(sorted(b_m)).all(is_near)
    }

    /// The same with a ratio of the likelihoods of something else that is known of both objects: infinite if it is only known that they look alike.
    pub fn log_odds_of(&self, log_likelihood_ratio: f64, distance_m: f64) -> f64 {
        let ratio = log_likelihood_ratio.min(50.0).exp();
        // Of the things that are two, a share has the same likelihood as if they were one.
        let bounded = ratio / (1.0 - self.same_make_share + self.same_make_share * ratio);
        (self.prior_odds * bounded).ln() - self.per_m * distance_m.min(self.far_m)
    }
}
