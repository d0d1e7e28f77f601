//! Which object that is new at one place is one that is gone from another.

use crate::UprightBox;

/// Pairs of removed and appeared boxes, by their places in the lists, that are likely the same thing: those that may be, the nearest first, each box once. Cubic in the boxes at
/// worst.
pub(crate) fn moves(
    removed: &[UprightBox],
    appeared: &[UprightBox],
    may_be_same: impl Fn(usize, usize) -> bool,
) -> Vec<(usize, usize)> {
    let mut candidates: Vec<(f64, usize, usize)> = Vec::new();
    for (gone, from) in removed.iter().enumerate() {
        for (new, to) in appeared.iter().enumerate() {
            if may_be_same(gone, new) {
                candidates.push(((from.centre_m - to.centre_m).norm(), gone, new));
            }
        }
    }
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut pairs: Vec<(usize, usize)> = Vec::new();
    for (_, gone, new) in candidates {
        if pairs.iter().all(|(other_gone, other_new)| *other_gone != gone && *other_new != new) {
            pairs.push((gone, new));
        }
    }
    pairs
}

/// Whether two boxes have one size: each side differs at most by a share of the larger, or by a distance, metres.
pub(crate) fn is_same_size(a: &UprightBox, b: &UprightBox, share: f64, distance_m: f64) -> bool {
    a.size_m.iter().zip(b.size_m).all(|(a, b)| (a - b).abs() <= (share * a.max(b)).max(distance_m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Vector3;

    fn of(x: f64, size_m: [f64; 3]) -> UprightBox {
        UprightBox { centre_m: Vector3::new(x, 0.0, 0.5), size_m, yaw_rad: 0.0 }
    }

    #[test]
    fn the_nearest_of_one_size_was_moved() {
        let removed = [of(0.0, [0.6, 0.4, 1.0]), of(1.0, [2.0, 0.4, 1.0])];
        let appeared = [of(9.0, [0.6, 0.4, 1.0]), of(5.0, [0.62, 0.38, 0.98]), of(2.0, [0.6, 0.4, 0.5])];
        assert_eq!(
            moves(&removed, &appeared, |gone, new| is_same_size(&removed[gone], &appeared[new], 0.2, 0.05)),
            [(0, 1)]
        );
        assert_eq!(moves(&[], &appeared, |_, _| true), []);
    }
}
