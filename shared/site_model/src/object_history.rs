//! Where a thing was when.

use crate::{OrientedBox, ReviewState, SceneChange, SceneChangeKind, Utc};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use vocab::MapId;

/// That a thing was at a place for a time. `T` says when comparisons were: by the ends of their runs, or by their numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectStay<T = Utc> {
    /// Where, frame of the map.
    pub place: OrientedBox,
    /// The run that saw it there first; none: it was there before the first comparison.
    pub from: Option<T>,
    /// The run that saw it there no more; none: it is there.
    pub until: Option<T>,
    /// Probability that it was the same thing as before, 0 to 1.
    pub probability: f64,
}

/// Middles of boxes of one place are at most this far from each other, metres: as of changes that are found again (`changes::RecurrenceConfig`).
const SAME_PLACE_M: f64 = 0.3;

/// Where a thing was, the earliest first, by the changes of it. `O(n log n)` in them.
pub fn object_history<'a>(changes: impl IntoIterator<Item = &'a SceneChange>) -> Vec<ObjectStay> {
    let mut changes: Vec<&SceneChange> = changes.into_iter().collect();
    changes.sort_by_key(|change| (change.first_seen, change.id));
    let mut stays: Vec<ObjectStay> = Vec::new();
    for change in changes {
        let probability = change.physical_object.map_or(1.0, |object| object.probability);
        record_stay(&mut stays, &change.kind, &change.place, change.first_seen, probability);
    }
    stays
}

/// Adds a change of a thing, later than all before, to its history. Linear in its stays.
pub fn record_stay<T>(
    stays: &mut Vec<ObjectStay<T>>,
    kind: &SceneChangeKind,
    place: &OrientedBox,
    at: T,
    probability: f64,
) where
    T: Copy,
{
    let (left, reached) = match *kind {
        SceneChangeKind::Appeared => (None, Some(*place)),
        SceneChangeKind::Removed => (Some(*place), None),
        SceneChangeKind::Moved { from } => (Some(from), Some(*place)),
    };
    // It cannot be at two places.
    if let Some(open) = stays.last_mut().filter(|stay| stay.until.is_none()) {
        open.until = Some(at);
    } else if let Some(place) = left
        && !stays.iter().any(|stay| is_same_place(&stay.place, &place))
    {
        // Nothing is said of the first place.
        let probability = if stays.is_empty() { 1.0 } else { probability };
        stays.push(ObjectStay { place, from: None, until: Some(at), probability });
    }
    stays.extend(reached.map(|place| ObjectStay { place, from: Some(at), until: None, probability }));
}

/// The changes of a map and those of earlier versions of it that became normal in it: all have one frame. `O(n)` for each version.
pub fn changes_of_versions<'a>(
    changes: impl Iterator<Item = &'a SceneChange> + Clone,
    map: MapId,
) -> Vec<&'a SceneChange> {
    let mut versions = BTreeSet::from([map]);
    loop {
        let is_earlier = |change: &&SceneChange| matches!(change.review, ReviewState::Normal { map } if versions.contains(&map));
        let earlier: BTreeSet<MapId> = changes.clone().filter(is_earlier).map(|change| change.map).collect();
        if earlier.is_subset(&versions) {
            return changes.filter(|change| versions.contains(&change.map)).collect();
        }
        versions.extend(earlier);
    }
}

fn is_same_place(a: &OrientedBox, b: &OrientedBox) -> bool {
    let [a, b] = [a, b].map(|place| place.centre_m);
    (a.x - b.x).hypot(a.y - b.y).hypot(a.z - b.z) <= SAME_PLACE_M
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{EarlierVisit, PhysicalObject, PhysicalObjectId, RunId, SceneChangeId};
    use uuid::Uuid;
    use vocab::Vec3;

    fn at(x: f64) -> OrientedBox {
        OrientedBox { centre_m: Vec3::new(x, 0.0, 0.5), size_m: [0.6, 0.4, 1.0], yaw_rad: 0.0 }
    }

    fn change(seen: i64, kind: SceneChangeKind, x: f64, probability: f64) -> SceneChange {
        let id = PhysicalObjectId(Uuid::from_u128(5));
        let map = MapId(Uuid::from_u128(1));
        SceneChange {
            id: SceneChangeId(Uuid::from_u128(seen as u128)),
            map,
            kind,
            place: at(x),
            points: 90,
            confidence: 0.99,
            before: EarlierVisit::Map(map),
            after: RunId(Uuid::from_u128(6)),
            first_seen: Utc(seen),
            last_seen: Utc(seen + 50),
            times_seen: 1,
            review: ReviewState::New,
            comment: String::new(),
            clouds: None,
            physical_object: Some(PhysicalObject { id, probability }),
            descriptor: None,
        }
    }

    fn stays(changes: &[SceneChange]) -> Vec<(f64, Option<i64>, Option<i64>)> {
        let of =
            |stay: ObjectStay| (stay.place.centre_m.x, stay.from.map(|at| at.0), stay.until.map(|at| at.0));
        object_history(changes).into_iter().map(of).collect()
    }

    #[test]
    fn a_thing_that_was_taken_away_and_put_elsewhere_has_one_history() {
        let moved = SceneChangeKind::Moved { from: at(7.1) };
        let mut changes = [
            change(4, SceneChangeKind::Appeared, 7.0, 0.9),
            change(1, SceneChangeKind::Removed, 3.0, 1.0),
            change(8, moved, 9.0, 0.8),
            change(9, SceneChangeKind::Removed, 9.0, 0.98),
        ];
        let expected = [(3.0, None, Some(1)), (7.0, Some(4), Some(8)), (9.0, Some(8), Some(9))];
        assert_eq!(stays(&changes), expected);
        changes.reverse();
        assert_eq!(stays(&changes), expected);
        let certain: Vec<f64> = object_history(&changes).iter().map(|stay| stay.probability).collect();
        assert_eq!(certain, [1.0, 0.9, 0.8]);
    }

    #[test]
    fn a_thing_is_at_one_place_at_a_time() {
        let moved = |x| SceneChangeKind::Moved { from: at(x) };
        // Both were compared with the map, which has it at 1 m.
        let changes = [change(1, moved(1.0), 5.0, 0.9), change(2, moved(1.0), 8.0, 0.9)];
        assert_eq!(stays(&changes), [(1.0, None, Some(1)), (5.0, Some(1), Some(2)), (8.0, Some(2), None)]);
        assert_eq!(stays(&[]), []);
    }

    #[test]
    fn changes_that_became_normal_belong_to_the_version() {
        let version = |number| MapId(Uuid::from_u128(number));
        let mut changes: Vec<SceneChange> =
            (1..=4).map(|seen| change(seen, SceneChangeKind::Removed, seen as f64, 1.0)).collect();
        for (change, map) in changes.iter_mut().zip([1, 2, 3, 9]) {
            change.map = version(map);
        }
        changes[0].review = ReviewState::Normal { map: version(2) };
        changes[1].review = ReviewState::Normal { map: version(3) };
        let found = |map| {
            let found = changes_of_versions(changes.iter(), version(map));
            found.iter().map(|change| change.first_seen.0).collect::<Vec<_>>()
        };
        assert_eq!((found(3), found(2), found(9)), (vec![1, 2, 3], vec![1, 2], vec![4]));
    }
}
