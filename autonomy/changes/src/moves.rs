//! Which object that is new at one place is one that is gone from another.

use crate::UprightBox;
use object_identity::{Association, AssociationConfig, associate};

/// Pairs of removed and appeared objects, by their places in the lists: those with the greatest sum of logarithms of odds, each with its probability. `log_ratio` is the logarithm of the ratio of the
/// likelihoods of what was seen of two objects if they are one thing and if they are two; of two that look as alike, the nearer ones are likelier (docs/maths/object-identity.md).
pub(crate) fn moves(
    removed: &[UprightBox],
    appeared: &[UprightBox],
    log_ratio: impl Fn(usize, usize) -> f64,
    config: &AssociationConfig,
) -> Vec<Association> {
    let log_odds = |a: usize, b: usize| {
        let distance_m = (removed[a].centre_m - appeared[b].centre_m).norm();
        config.log_odds_of(log_ratio(a, b), distance_m)
    };
    let row = |a: usize| (0..appeared.len()).map(|b| log_odds(a, b)).collect();
    associate(&(0..removed.len()).map(row).collect::<Vec<_>>())
}

/// Whether two boxes have one size: each side differs at most by a share of the larger, or by a distance, metres.
pub(crate) fn is_same_size(a: &UprightBox, b: &UprightBox, share: f64, distance_m: f64) -> bool {
    a.size_m.iter().zip(b.size_m).all(|(a, b)| (a - b).abs() <= (share * a.max(b)).max(distance_m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::size_likelihood::{SizeLikelihoodConfig, log_likelihood_ratio};
    use geometry::Vector3;

    fn of(x: f64, size_m: [f64; 3]) -> UprightBox {
        UprightBox { centre_m: Vector3::new(x, 0.0, 0.5), size_m, yaw_rad: 0.0 }
    }

    fn found(removed: &[UprightBox], appeared: &[UprightBox]) -> Vec<Association> {
        let config = SizeLikelihoodConfig::default();
        let log_ratio =
            |a: usize, b: usize| log_likelihood_ratio(&removed[a].size_m, &appeared[b].size_m, &config);
        moves(removed, appeared, log_ratio, &AssociationConfig::default())
    }

    #[test]
    fn the_nearest_of_one_size_was_moved() {
        let removed = [of(0.0, [0.6, 0.4, 1.0]), of(1.0, [2.0, 0.4, 1.0])];
        let appeared = [of(9.0, [0.6, 0.4, 1.0]), of(5.0, [0.62, 0.38, 0.98]), of(2.0, [0.6, 0.4, 0.4])];
        let pairs = found(&removed, &appeared);
        assert_eq!(pairs.iter().map(|found| found.pair).collect::<Vec<_>>(), [[0, 1]]);
        assert!(pairs[0].probability > 0.5 && pairs[0].probability < 0.97, "{pairs:?}");
        assert_eq!(found(&[], &appeared), []);
    }

    #[test]
    fn of_things_of_one_make_the_nearer_ones_are_pairs_and_neither_is_certain() {
        let size_m = [0.6, 0.4, 0.4];
        let pairs = found(&[of(0.0, size_m), of(9.0, size_m)], &[of(5.5, size_m), of(4.5, size_m)]);
        assert_eq!(pairs.iter().map(|found| found.pair).collect::<Vec<_>>(), [[0, 1], [1, 0]]);
        assert!(pairs.iter().all(|found| found.probability < 0.75), "{pairs:?}");
        let alike = found(&[of(0.0, size_m)], &[of(1.0, size_m), of(3.0, size_m)]);
        assert!(alike.len() == 1 && alike[0].pair == [0, 0] && alike[0].probability < 0.6, "{alike:?}");
    }
}
