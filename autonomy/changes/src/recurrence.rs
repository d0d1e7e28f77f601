//! Which changes are known from earlier comparisons.

use crate::moves::is_same_size;
use crate::{Change, UprightBox};

/// Parameters of [`find_recurrences`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecurrenceConfig {
    /// The middles of the boxes of one change are at most this far from each other, metres. Chosen: twice the error of a box in docs/benchmarks/changes.md, and less than the
    /// distance between two things of a size that stand side by side.
    pub same_place_m: f64,
    /// Each side differs at most by this share of the larger one, or by half of [`Self::same_place_m`]. Chosen: a thing that was seen from one side looks thinner.
    pub same_size_share: f64,
}

impl Default for RecurrenceConfig {
    fn default() -> Self {
        Self { same_place_m: 0.3, same_size_share: 0.5 }
    }
}

/// A change, as one comparison found it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObservedChange {
    /// What became of the object.
    pub change: Change,
    /// Where it is, or was if it is gone.
    pub place: UprightBox,
}

/// For each change that was found, the place of the same one in the list of those that are known, if it is known: of one kind, at one place, of one size. The nearest are taken
/// first, each known one once. Linear in the product of their numbers.
pub fn find_recurrences(
    known: &[ObservedChange],
    found: &[ObservedChange],
    config: &RecurrenceConfig,
) -> Vec<Option<usize>> {
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (new, of_new) in found.iter().enumerate() {
        for (old, of_old) in known.iter().enumerate() {
            pairs.extend(distance_m(of_old, of_new, config).map(|distance_m| (distance_m, new, old)));
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut recurrences = vec![None; found.len()];
    for (_, new, old) in pairs {
        if recurrences[new].is_none() && !recurrences.contains(&Some(old)) {
            recurrences[new] = Some(old);
        }
    }
    recurrences
}

/// Whether one change takes the other one back: what appeared was removed, or what was moved there was moved back.
pub fn is_undone_by(change: &ObservedChange, later: &ObservedChange, config: &RecurrenceConfig) -> bool {
    let undone = match change.change {
        Change::Appeared => ObservedChange { change: Change::Removed, place: change.place },
        Change::Removed => ObservedChange { change: Change::Appeared, place: change.place },
        Change::Moved { from } => {
            ObservedChange { change: Change::Moved { from: change.place }, place: from }
        }
    };
    distance_m(&undone, later, config).is_some()
}

/// How far two changes are from each other, metres; none if they are two.
fn distance_m(a: &ObservedChange, b: &ObservedChange, config: &RecurrenceConfig) -> Option<f64> {
    let of_boxes = |a: &UprightBox, b: &UprightBox| {
        let distance_m = (a.centre_m - b.centre_m).norm();
        let is_same = is_same_size(a, b, config.same_size_share, config.same_place_m / 2.0);
        (distance_m <= config.same_place_m && is_same).then_some(distance_m)
    };
    let place_m = of_boxes(&a.place, &b.place)?;
    match (&a.change, &b.change) {
        (Change::Appeared, Change::Appeared) | (Change::Removed, Change::Removed) => Some(place_m),
        (Change::Moved { from: a }, Change::Moved { from: b }) => {
            of_boxes(a, b).map(|from_m| from_m + place_m)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Vector3;

    fn at(x: f64, length_m: f64) -> UprightBox {
        UprightBox { centre_m: Vector3::new(x, 2.0, 0.5), size_m: [length_m, 0.4, 1.0], yaw_rad: 0.3 }
    }

    fn of(change: Change, x: f64, length_m: f64) -> ObservedChange {
        ObservedChange { change, place: at(x, length_m) }
    }

    #[test]
    fn a_change_is_known_if_its_kind_place_and_size_are() {
        let (appeared, removed) = (Change::Appeared, Change::Removed);
        let moved = |x| Change::Moved { from: at(x, 0.6) };
        let known =
            [of(appeared, 0.0, 0.6), of(appeared, 0.4, 0.6), of(removed, 5.0, 0.6), of(moved(9.0), 7.0, 0.6)];
        let found = |one| find_recurrences(&known, &[one], &RecurrenceConfig::default())[0];
        assert_eq!(found(of(appeared, 0.1, 0.5)), Some(0));
        assert_eq!(found(of(appeared, 0.3, 0.6)), Some(1), "the nearest");
        assert_eq!(found(of(appeared, 5.0, 0.6)), None, "another kind");
        assert_eq!(found(of(removed, 5.4, 0.6)), None, "another place");
        assert_eq!(found(of(removed, 5.0, 1.6)), None, "another size");
        assert_eq!(found(of(moved(9.1), 7.1, 0.6)), Some(3));
        assert_eq!(found(of(moved(8.0), 7.0, 0.6)), None, "from elsewhere");
        let is_undone = |one, later| is_undone_by(&one, &later, &RecurrenceConfig::default());
        assert!(is_undone(known[0], of(removed, 0.1, 0.5)) && is_undone(known[2], of(appeared, 5.0, 0.6)));
        assert!(is_undone(known[3], of(moved(7.1), 9.0, 0.6)), "moved back");
        assert!(!is_undone(known[3], of(moved(7.1), 8.0, 0.6)) && !is_undone(known[0], known[0]));
        let twice = [of(appeared, 0.05, 0.6), of(appeared, 0.0, 0.6)];
        let both = find_recurrences(&known, &twice, &RecurrenceConfig::default());
        assert_eq!(both, [None, Some(0)], "one is known once");
    }
}
