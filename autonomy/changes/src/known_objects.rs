//! Which of the things that are known from earlier comparisons a change is of.

use crate::moves::is_same_size;
use crate::{Change, RecurrenceConfig, UprightBox};
use object_identity::{AssociationConfig, Descriptor, ObjectShape, associate};
use std::cmp::Reverse;

/// Parameters of [`identify_objects`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IdentityConfig {
    /// When two boxes are of one thing at one place. Source: that of changes that are found again.
    pub same_place: RecurrenceConfig,
    /// Probability that what is taken from a place is what was put there. Chosen: nobody sees when a thing is exchanged for one of its make, which is rare.
    pub same_place_probability: f64,
    /// How things that were taken away are known again elsewhere. Source: that of things that were moved between two visits.
    pub association: AssociationConfig,
    /// A thing is known again only with at least this probability. Chosen: with less, another thing, or none, is more likely.
    pub min_probability: f64,
}

impl Default for IdentityConfig {
    fn default() -> Self {
        Self {
            same_place: RecurrenceConfig::default(),
            same_place_probability: 0.98,
            association: AssociationConfig::default(),
            min_probability: 0.5,
        }
    }
}

/// A thing that is known from earlier comparisons.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownObject {
    /// Where it was, the newest place last.
    pub places: Vec<UprightBox>,
    /// Whether it is at the newest one.
    pub is_there: bool,
    /// Its descriptor.
    pub descriptor: Option<Descriptor>,
}

/// A change of a thing.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectSighting {
    /// What became of it.
    pub change: Change,
    /// Where it is, or was if it is gone.
    pub place: UprightBox,
    /// Its descriptor.
    pub descriptor: Option<Descriptor>,
    /// Of a moved one, the probability that one thing was at both places.
    pub move_probability: Option<f64>,
}

/// That a change is of a known thing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Identification {
    /// Its place in the list of those that are known.
    pub known: usize,
    /// Probability that it is that thing.
    pub probability: f64,
}

/// For each change of a comparison, the known thing that it is of; none if it is likely of another one. What was taken from a place, or moved from it, is what was put there. What appears is likely one of the
/// things that were taken away earlier, by shape and size; of several that look alike, none is likely enough. Each known thing is found once. Cubic in the things that appeared and were taken away.
pub fn identify_objects(
    known: &[KnownObject],
    found: &[ObjectSighting],
    config: &IdentityConfig,
) -> Vec<Option<Identification>> {
    let mut identified = by_place(known, found, config);
    let is_taken = |of: &[Option<Identification>], place: usize| {
        of.iter().flatten().any(|identification| identification.known == place)
    };
    let away: Vec<usize> =
        (0..known.len()).filter(|place| !known[*place].is_there && !is_taken(&identified, *place)).collect();
    let appeared: Vec<usize> =
        (0..found.len()).filter(|place| found[*place].change == Change::Appeared).collect();
    let log_odds: Vec<Vec<f64>> = away
        .iter()
        .map(|known_place| {
            let of = |new: &usize| log_odds(&known[*known_place], &found[*new], config);
            appeared.iter().map(of).collect()
        })
        .collect();
    for association in associate(&log_odds) {
        let [known, new] = association.pair;
        if association.probability >= config.min_probability {
            identified[appeared[new]] =
                Some(Identification { known: away[known], probability: association.probability });
        }
    }
    identified
}

/// The known things at the places from which things were taken or moved: those that are there before those that were there, and the nearest first.
fn by_place(
    known: &[KnownObject],
    found: &[ObjectSighting],
    config: &IdentityConfig,
) -> Vec<Option<Identification>> {
    let mut candidates = Vec::new();
    for (number, sighting) in found.iter().enumerate() {
        let from = match &sighting.change {
            Change::Appeared => continue,
            Change::Removed => &sighting.place,
            Change::Moved { from } => from,
        };
        for (place, object) in known.iter().enumerate() {
            let last = object.places.len().saturating_sub(1);
            for (stay, at) in object.places.iter().enumerate() {
                let is_now = object.is_there && stay == last;
                if let Some(distance_m) = distance_at_place_m(from, at, &config.same_place) {
                    candidates.push((Reverse(is_now), distance_m, number, place));
                }
            }
        }
    }
    candidates.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then((a.2, a.3).cmp(&(b.2, b.3))));
    let mut identified: Vec<Option<Identification>> = vec![None; found.len()];
    for (_, _, number, place) in candidates {
        let is_taken = identified.iter().flatten().any(|identification| identification.known == place);
        if identified[number].is_none() && !is_taken {
            let moved = found[number].move_probability.unwrap_or(1.0);
            let probability = config.same_place_probability * moved;
            identified[number] = Some(Identification { known: place, probability });
        }
    }
    identified
}

/// How far two boxes of one thing at one place are from each other, metres; none if they are two.
fn distance_at_place_m(a: &UprightBox, b: &UprightBox, config: &RecurrenceConfig) -> Option<f64> {
    let distance_m = (a.centre_m - b.centre_m).norm();
    let is_same = is_same_size(a, b, config.same_size_share, config.same_place_m / 2.0);
    (distance_m <= config.same_place_m && is_same).then_some(distance_m)
}

fn log_odds(known: &KnownObject, found: &ObjectSighting, config: &IdentityConfig) -> f64 {
    let Some(last) = known.places.last() else { return f64::NEG_INFINITY };
    let shape = |place: &UprightBox, descriptor: &Option<Descriptor>| ObjectShape {
        size_m: place.size_m,
        descriptor: descriptor.clone(),
    };
    let distance_m = (last.centre_m - found.place.centre_m).norm();
    let (a, b) = (shape(last, &known.descriptor), shape(&found.place, &found.descriptor));
    config.association.log_odds(&a, &b, distance_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Vector3;

    const SIZE_M: [f64; 3] = [0.6, 0.4, 1.0];

    fn at(x: f64, size_m: [f64; 3]) -> UprightBox {
        UprightBox { centre_m: Vector3::new(x, 2.0, 0.5), size_m, yaw_rad: 0.3 }
    }

    fn known(x: &[f64], size_m: [f64; 3], is_there: bool) -> KnownObject {
        KnownObject { places: x.iter().map(|x| at(*x, size_m)).collect(), is_there, descriptor: None }
    }

    fn sighting(change: Change, x: f64, size_m: [f64; 3]) -> ObjectSighting {
        ObjectSighting { change, place: at(x, size_m), descriptor: None, move_probability: None }
    }

    fn identified(known: &[KnownObject], found: &[ObjectSighting]) -> Vec<Option<usize>> {
        let found = identify_objects(known, found, &IdentityConfig::default());
        assert!(found.iter().flatten().all(|one| (0.5..1.0).contains(&one.probability)), "{found:?}");
        found.into_iter().map(|one| one.map(|one| one.known)).collect()
    }

    #[test]
    fn what_is_taken_from_a_place_is_what_was_put_there() {
        let things =
            [known(&[1.0, 5.0], SIZE_M, true), known(&[9.0], SIZE_M, true), known(&[5.1], SIZE_M, false)];
        let moved = Change::Moved { from: at(9.05, SIZE_M) };
        let found = [sighting(Change::Removed, 5.1, SIZE_M), sighting(moved, 20.0, SIZE_M)];
        assert_eq!(identified(&things, &found), [Some(0), Some(1)]);
        // A comparison with the map tells of the place in the map.
        assert_eq!(identified(&things, &[sighting(Change::Removed, 1.0, SIZE_M)]), [Some(0)]);
        assert_eq!(identified(&things, &[sighting(Change::Removed, 1.0, [2.0, 0.4, 1.0])]), [None]);
    }

    #[test]
    fn what_was_taken_away_is_known_again_elsewhere_by_its_size() {
        let things = [
            known(&[1.0], SIZE_M, false),
            known(&[4.0], [1.2, 1.1, 0.3], false),
            known(&[8.0], SIZE_M, true),
        ];
        let found =
            [sighting(Change::Appeared, 30.0, [0.61, 0.39, 1.0]), sighting(Change::Appeared, 12.0, [0.3; 3])];
        assert_eq!(identified(&things, &found), [Some(0), None]);
    }

    #[test]
    fn two_of_one_make_cannot_be_told_apart() {
        let things = [known(&[1.0], SIZE_M, false), known(&[4.0], SIZE_M, false)];
        assert_eq!(identified(&things, &[sighting(Change::Appeared, 2.5, SIZE_M)]), [None]);
    }
}
