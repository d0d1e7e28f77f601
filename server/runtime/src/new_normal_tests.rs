//! What becomes of the changes of a site when some are made normal.

use super::*;
use site_model::{EarlierVisit, OrientedBox, SceneChangeKind, Utc};
use vocab::Vec3;

const OLD: MapId = MapId(Uuid::from_u128(1));
const NEW: MapId = MapId(Uuid::from_u128(2));
const OTHER: MapId = MapId(Uuid::from_u128(3));

fn change(number: u128, map: MapId, review: ReviewState) -> SceneChange {
    SceneChange {
        id: SceneChangeId(Uuid::from_u128(number)),
        map,
        kind: SceneChangeKind::Appeared,
        place: OrientedBox { centre_m: Vec3::default(), size_m: [1.0; 3], yaw_rad: 0.0 },
        points: 100,
        confidence: 0.99,
        before: EarlierVisit::Map(map),
        after: RunId(Uuid::from_u128(number % 2)),
        first_seen: Utc(0),
        last_seen: Utc(number as i64),
        times_seen: 1,
        review,
        comment: String::new(),
        clouds: None,
        physical_object: None,
        descriptor: None,
    }
}

#[test]
fn changes_of_one_map_come_with_their_runs_and_those_of_several_are_refused() {
    let of = |maps: &[MapId]| {
        of_one_map((1..).zip(maps).map(|(number, map)| change(number, *map, ReviewState::New)).collect())
    };
    let accepted = of(&[OLD, OLD, OLD]).expect("of one map");
    assert_eq!((accepted.map, accepted.changes.len(), accepted.runs.len()), (OLD, 3, 2));
    assert_eq!(of(&[OLD, OTHER]).expect_err("two maps"), texts::CHANGES_OF_SEVERAL_MAPS);
    assert_eq!(of(&[]).expect_err("none"), texts::NO_SUCH_CHANGES);
}

#[test]
fn what_is_normal_stays_with_the_old_map_and_what_is_open_goes_to_the_new_one() {
    let mut site = Site::default();
    let dismissed = ReviewState::Dismissed { reason: "ours".to_owned() };
    let earlier = ReviewState::Normal { map: OLD };
    for (number, map, review) in [
        (1, OLD, ReviewState::Acknowledged),
        (2, OLD, ReviewState::New),
        (3, OLD, dismissed.clone()),
        (4, OTHER, ReviewState::New),
        (5, OLD, earlier.clone()),
    ] {
        let edit = site.put(EditId(Uuid::nil()), Object::SceneChange(change(number, map, review)));
        site.apply(&edit, EditId(Uuid::nil())).expect("of this state");
    }
    let normal = BTreeSet::from([SceneChangeId(Uuid::from_u128(1))]);
    let edit = edit_of(&site, EditId(Uuid::from_u128(9)), OLD, NEW, &normal);
    site.apply(&edit, EditId(Uuid::nil())).expect("of this state");
    let mut now: Vec<_> =
        site.scene_changes().map(|change| (change.last_seen.0, change.map, change.review.clone())).collect();
    now.sort_by_key(|(number, ..)| *number);
    assert_eq!(
        now,
        [
            (1, OLD, ReviewState::Normal { map: NEW }),
            (2, NEW, ReviewState::New),
            (3, NEW, dismissed),
            (4, OTHER, ReviewState::New),
            (5, OLD, earlier),
        ]
    );
}
