//! The edit of the site that puts the changes of a comparison into it.

use super::physical_objects::{object_change, physical_objects, upright_box};
use crate::ledger::raised;
use changes::{IdentityConfig, ObservedChange, RecurrenceConfig, find_recurrences, is_undone_by};
use ports::FoundChange;
use site_model::{
    Alert, AlertCause, AlertId, AlertSeverity, Change, EarlierVisit, Edit, EditId, Object, ObjectId,
    OrientedBox, PhysicalObject, PhysicalObjectId, ReviewState, RunId, SceneChange, SceneChangeClouds,
    SceneChangeId, SceneChangeKind, Site, Utc, changes_of_versions,
};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use uuid::Uuid;
use vocab::MapId;

/// Parameters of [`edit_with_changes`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SiteChangesConfig {
    /// When a known change is found again.
    pub recurrence: RecurrenceConfig,
    /// When a change is of a known thing. Source: docs/benchmarks/changes.md.
    pub identity: IdentityConfig,
    /// A change comes and goes if it and one that takes it back were both found at least this number of times. Chosen: what happens once in each direction is news, what happens
    /// again the same way is a habit.
    pub routine_times: u32,
    /// Changes that a site has at most. Beyond it, those on which people have decided go, the one that was not seen for longest first; the ledger keeps their revisions. Chosen: a
    /// year of results, and less than half of the objects that a site may have.
    pub max_changes: usize,
}

impl Default for SiteChangesConfig {
    fn default() -> Self {
        Self {
            recurrence: RecurrenceConfig::default(),
            identity: IdentityConfig::default(),
            routine_times: 2,
            max_changes: 20_000,
        }
    }
}

/// Number of the first new thing in the ids that follow from a run: beyond those of its changes.
const FIRST_OBJECT_NUMBER: u64 = 1 << 32;

/// The same of the first alert.
const FIRST_ALERT_NUMBER: u64 = 2 << 32;

/// A comparison of a run with an earlier visit.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    pub run: RunId,
    pub map: MapId,
    pub before: EarlierVisit,
    /// When the run ended.
    pub at: Utc,
    /// What it found, each with its clouds, if they were kept.
    pub found: Vec<(FoundChange, Option<SceneChangeClouds>)>,
}

/// The edit that puts what a comparison found into the site, each with the thing that it is of, and how many of it were new. The same run gives an edit of the same id, so that it counts once.
pub fn edit_with_changes(site: &Site, comparison: &Comparison, config: &SiteChangesConfig) -> (Edit, usize) {
    let known: Vec<&SceneChange> =
        site.scene_changes().filter(|change| change.map == comparison.map).collect();
    let of_known = |change: &&SceneChange| observed(&change.kind, &change.place);
    let of_found = |(found, _): &(FoundChange, _)| observed(&found.kind, &found.place);
    let recurrences = find_recurrences(
        &known.iter().map(of_known).collect::<Vec<_>>(),
        &comparison.found.iter().map(of_found).collect::<Vec<_>>(),
        &config.recurrence,
    );
    // What is found again is of the thing of which it was.
    let is_new = |place: &usize| {
        recurrences[*place].is_none_or(|known_place| known[known_place].physical_object.is_none())
    };
    let unknown: Vec<usize> = (0..comparison.found.len()).filter(is_new).collect();
    let found: Vec<&FoundChange> = unknown.iter().map(|place| &comparison.found[*place].0).collect();
    let new_id = |number| PhysicalObjectId(derived_id(comparison.run, FIRST_OBJECT_NUMBER + number as u64));
    let earlier = changes_of_versions(site.scene_changes(), comparison.map);
    let things = physical_objects(&earlier, &found, &config.identity, new_id);
    let things: BTreeMap<usize, PhysicalObject> = unknown.into_iter().zip(things).collect();
    let mut edit = Edit { id: EditId(derived_id(comparison.run, 0)), changes: Vec::new() };
    let (mut new, mut changes) = (0, Vec::new());
    for (place, ((found, clouds), recurrence)) in comparison.found.iter().zip(&recurrences).enumerate() {
        let number = place as u64 + 1;
        let earlier = recurrence.map(|place| known[place]);
        new += usize::from(earlier.is_none());
        let change = SceneChange {
            id: earlier.map_or(SceneChangeId(derived_id(comparison.run, number)), |known| known.id),
            map: comparison.map,
            kind: found.kind,
            place: found.place,
            points: found.points,
            confidence: found.confidence,
            before: comparison.before,
            after: comparison.run,
            first_seen: earlier.map_or(comparison.at, |known| known.first_seen),
            last_seen: comparison.at,
            times_seen: earlier.map_or(0, |known| known.times_seen).saturating_add(1),
            review: earlier.map(|known| known.review.clone()).unwrap_or_default(),
            comment: earlier.map(|known| known.comment.clone()).unwrap_or_default(),
            clouds: clouds.or(earlier.and_then(|known| known.clouds)),
            physical_object: things.get(&place).copied().or(earlier.and_then(|known| known.physical_object)),
            descriptor: found.descriptor.clone().or(earlier.and_then(|known| known.descriptor.clone())),
        };
        changes.push(change);
    }
    let settled = settle_routine(&known, &mut changes, config);
    changes.extend(settled);
    let alerts = alerts_of_watched(site, &changes, comparison);
    for change in changes {
        edit.changes.extend(site.put(edit.id, Object::SceneChange(change)).changes);
    }
    for alert in alerts {
        edit.changes.extend(site.put(edit.id, Object::Alert(alert)).changes);
    }
    edit.changes.extend(removals(site, new, &edit, config));
    (edit, new)
}

/// The alerts of what people watch and what was found again: they wanted to know. Linear in the product of the changes and the alerts of the site.
fn alerts_of_watched(site: &Site, found: &[SceneChange], comparison: &Comparison) -> Vec<Alert> {
    let watched = (0_u64..).zip(found).filter(|(_, change)| change.review == ReviewState::Watched);
    let alert = |(number, change): (u64, &SceneChange)| {
        let id = AlertId(derived_id(comparison.run, FIRST_ALERT_NUMBER + number));
        raised(site, id, &AlertCause::SceneChange(change.id), AlertSeverity::Information, comparison.at)
    };
    watched.map(alert).collect()
}

/// Notes of the changes that were found which of them come and go. Returns those of the known ones that take them back, and come and go too. What people have decided stays. Linear in the product of
/// their numbers.
fn settle_routine(
    known: &[&SceneChange],
    found: &mut [SceneChange],
    config: &SiteChangesConfig,
) -> Vec<SceneChange> {
    let of = |change: &SceneChange| observed(&change.kind, &change.place);
    let is_known_well = |change: &SceneChange| change.times_seen >= config.routine_times;
    let found_ids: BTreeSet<SceneChangeId> = found.iter().map(|change| change.id).collect();
    let mut others: BTreeMap<SceneChangeId, SceneChange> = BTreeMap::new();
    for change in found.iter_mut().filter(|change| is_known_well(change)) {
        let takes_back = |other: &&&SceneChange| {
            is_known_well(other) && is_undone_by(&of(change), &of(other), &config.recurrence)
        };
        let Some(other) = known.iter().find(takes_back) else { continue };
        if other.review == ReviewState::New && !found_ids.contains(&other.id) {
            others.insert(other.id, SceneChange { review: ReviewState::Routine, ..(*other).clone() });
        }
        if change.review == ReviewState::New {
            change.review = ReviewState::Routine;
        }
    }
    others.into_values().collect()
}

/// Removals of old changes on which people have decided: as many as the site would have too many.
fn removals(site: &Site, new: usize, edit: &Edit, config: &SiteChangesConfig) -> Vec<Change> {
    let excess = (site.scene_changes().count() + new).saturating_sub(config.max_changes);
    if excess == 0 {
        return Vec::new();
    }
    let is_decided = |change: &&SceneChange| match change.review {
        ReviewState::New | ReviewState::Watched => false,
        ReviewState::Acknowledged
        | ReviewState::Dismissed { .. }
        | ReviewState::Normal { .. }
        | ReviewState::Routine => true,
    };
    let is_kept = |id: ObjectId| edit.changes.iter().any(|change| change.object_id() == id);
    let mut decided: Vec<&SceneChange> = site.scene_changes().filter(is_decided).collect();
    decided.sort_by_key(|change| Reverse(change.last_seen));
    let mut removals = Vec::new();
    while removals.len() < excess
        && let Some(oldest) = decided.pop()
    {
        let object = ObjectId::SceneChange(oldest.id);
        if !is_kept(object) {
            removals.extend(site.removal(edit.id, object).changes);
        }
    }
    removals
}

/// An id that follows from a run and a number.
fn derived_id(run: RunId, number: u64) -> Uuid {
    let (high, low) = run.0.as_u64_pair();
    // The constant of the golden ratio spreads the numbers over all bits.
    Uuid::from_u64_pair(high ^ (number + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15), low)
}

fn observed(kind: &SceneChangeKind, place: &OrientedBox) -> ObservedChange {
    ObservedChange { change: object_change(kind), place: upright_box(place) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vocab::Vec3;

    const MAP: MapId = MapId(Uuid::from_u128(1));

    fn found(kind: SceneChangeKind, x: f64) -> (FoundChange, Option<SceneChangeClouds>) {
        let place = OrientedBox { centre_m: Vec3::new(x, 0.0, 0.5), size_m: [0.6, 0.4, 1.0], yaw_rad: 0.2 };
        let move_probability = matches!(kind, SceneChangeKind::Moved { .. }).then_some(0.9);
        let cloud = "object-1.ply".into();
        (
            FoundChange {
                kind,
                place,
                points: 80,
                confidence: 0.99,
                cloud,
                move_probability,
                descriptor: None,
            },
            None,
        )
    }

    fn comparison(run: u128, found: Vec<(FoundChange, Option<SceneChangeClouds>)>) -> Comparison {
        let (run, at) = (RunId(Uuid::from_u128(run)), Utc(run as i64));
        Comparison { run, map: MAP, before: EarlierVisit::Map(MAP), at, found }
    }

    /// Applies what a comparison found. Returns the number of new changes.
    fn apply(site: &mut Site, comparison: &Comparison, max_changes: usize) -> usize {
        let config = SiteChangesConfig { max_changes, ..SiteChangesConfig::default() };
        let (edit, new) = edit_with_changes(site, comparison, &config);
        site.apply(&edit, EditId(Uuid::nil())).expect("of this state");
        new
    }

    fn decide(site: &mut Site, x: f64, review: ReviewState) {
        let known = site.scene_changes().find(|change| (change.place.centre_m.x - x).abs() < 0.2);
        decide_on(site, known.expect("known").id, review);
    }

    fn decide_on(site: &mut Site, id: SceneChangeId, review: ReviewState) {
        let known = site.scene_changes().find(|change| change.id == id);
        let change = SceneChange { review, comment: "ours".to_owned(), ..known.expect("known").clone() };
        let edit = site.put(EditId(Uuid::from_u128(9)), Object::SceneChange(change));
        site.apply(&edit, EditId(Uuid::nil())).expect("of this state");
    }

    #[test]
    fn what_is_found_again_is_the_same_change_with_what_people_said_of_it() {
        let mut site = Site::default();
        let appeared = SceneChangeKind::Appeared;
        assert_eq!(
            apply(&mut site, &comparison(10, vec![found(appeared, 0.0), found(appeared, 3.0)]), 99),
            2
        );
        let dismissed = ReviewState::Dismissed { reason: "stored there".to_owned() };
        decide(&mut site, 3.0, dismissed.clone());
        let again = comparison(11, vec![found(appeared, 3.1), found(SceneChangeKind::Removed, 0.0)]);
        assert_eq!(apply(&mut site, &again, 99), 1);
        let mut changes: Vec<&SceneChange> = site.scene_changes().collect();
        changes.sort_by_key(|change| change.first_seen);
        assert_eq!(changes.len(), 3);
        let known = changes.iter().find(|change| change.times_seen == 2).expect("found twice");
        assert_eq!((known.first_seen, known.last_seen), (Utc(10), Utc(11)));
        assert_eq!((&known.review, known.comment.as_str()), (&dismissed, "ours"));
        assert!((known.place.centre_m.x - 3.1).abs() < 1e-9);
        assert_eq!(changes[2].kind, SceneChangeKind::Removed);
    }

    #[test]
    fn old_changes_that_were_decided_make_room_and_open_ones_never() {
        let mut site = Site::default();
        let appeared = SceneChangeKind::Appeared;
        apply(&mut site, &comparison(10, vec![found(appeared, 0.0), found(appeared, 3.0)]), 99);
        decide(&mut site, 3.0, ReviewState::Acknowledged);
        apply(&mut site, &comparison(11, vec![found(appeared, 6.0), found(appeared, 9.0)]), 2);
        let mut places: Vec<f64> = site.scene_changes().map(|change| change.place.centre_m.x).collect();
        places.sort_by(f64::total_cmp);
        assert_eq!(places, [0.0, 6.0, 9.0]);
    }

    /// A place in metres along x, from and until, by run.
    type Stay = (f64, Option<i64>, Option<i64>);

    /// Where each thing of the site was.
    fn histories(site: &Site) -> Vec<Vec<Stay>> {
        let mut things: BTreeMap<PhysicalObjectId, Vec<&SceneChange>> = BTreeMap::new();
        for change in site.scene_changes() {
            things.entry(change.physical_object.expect("assigned").id).or_default().push(change);
        }
        let of_thing = |changes: Vec<&SceneChange>| {
            let stays = site_model::object_history(changes);
            let plain = |at: Option<Utc>| at.map(|at| at.0);
            stays.iter().map(|stay| (stay.place.centre_m.x, plain(stay.from), plain(stay.until))).collect()
        };
        let mut histories: Vec<Vec<_>> = things.into_values().map(of_thing).collect();
        histories.sort_by(|a, b| a[0].0.total_cmp(&b[0].0));
        histories
    }

    #[test]
    fn what_is_taken_away_and_put_elsewhere_three_runs_later_is_one_thing() {
        let mut site = Site::default();
        let (removed, appeared) = (SceneChangeKind::Removed, SceneChangeKind::Appeared);
        let moved = |x| SceneChangeKind::Moved { from: found(appeared, x).0.place };
        for (run, changes) in [
            (10, vec![found(removed, 2.0)]),
            (11, vec![]),
            (12, vec![]),
            (13, vec![found(appeared, 30.0)]),
            (14, vec![found(moved(30.1), 44.0)]),
            (15, vec![found(removed, 44.1)]),
        ] {
            apply(&mut site, &comparison(run, changes), 99);
        }
        let expected = vec![(2.0, None, Some(10)), (30.0, Some(13), Some(14)), (44.0, Some(14), Some(15))];
        assert_eq!(histories(&site), [expected]);
        let probabilities =
            site.scene_changes().map(|change| change.physical_object.expect("assigned").probability);
        let mut probabilities: Vec<f64> = probabilities.collect();
        probabilities.sort_by(f64::total_cmp);
        assert!(probabilities[0] > 0.5 && probabilities[2] < 1.0, "{probabilities:?}");
        assert_eq!(probabilities[3], 1.0, "nothing is said of the first one");
    }

    #[test]
    fn what_is_put_and_taken_again_and_again_comes_and_goes() {
        let mut site = Site::default();
        let (removed, appeared) = (SceneChangeKind::Removed, SceneChangeKind::Appeared);
        let reviews = |site: &Site| -> Vec<ReviewState> {
            site.scene_changes().map(|change| change.review.clone()).collect()
        };
        for (run, kind) in [(10, appeared), (11, removed), (12, appeared)] {
            apply(&mut site, &comparison(run, vec![found(kind, 2.0)]), 99);
            assert!(reviews(&site).iter().all(|review| *review == ReviewState::New), "{run}");
        }
        // Elsewhere, something stays away.
        apply(&mut site, &comparison(13, vec![found(removed, 2.1), found(removed, 9.0)]), 99);
        let routine =
            |site: &Site| reviews(site).into_iter().filter(|review| *review == ReviewState::Routine).count();
        assert_eq!((routine(&site), site.scene_changes().count()), (2, 3));
        // What people decide stays.
        let watched = site.scene_changes().find(|change| change.kind == appeared).expect("there").id;
        decide_on(&mut site, watched, ReviewState::Watched);
        apply(&mut site, &comparison(14, vec![found(appeared, 2.0)]), 99);
        assert_eq!(
            site.scene_changes().find(|change| change.id == watched).expect("there").review,
            ReviewState::Watched
        );
        assert_eq!(routine(&site), 1);
    }

    #[test]
    fn what_is_watched_and_found_again_raises_one_alert() {
        let mut site = Site::default();
        let seen = |site: &mut Site, run, x| {
            apply(site, &comparison(run, vec![found(SceneChangeKind::Appeared, x)]), 99);
            let alerts =
                site.alerts().map(|alert| (alert.cause.clone(), alert.times_raised, alert.last_raised));
            alerts.collect::<Vec<_>>()
        };
        assert_eq!(seen(&mut site, 10, 2.0), []);
        assert_eq!(seen(&mut site, 11, 2.0), [], "nobody watches it");
        let watched = site.scene_changes().next().expect("there").id;
        decide_on(&mut site, watched, ReviewState::Watched);
        let cause = AlertCause::SceneChange(watched);
        assert_eq!(seen(&mut site, 12, 2.05), [(cause.clone(), 1, Utc(12))]);
        assert_eq!(seen(&mut site, 13, 9.0), [(cause.clone(), 1, Utc(12))], "something else");
        assert_eq!(seen(&mut site, 14, 2.0), [(cause, 2, Utc(14))]);
    }

    #[test]
    fn two_things_of_one_make_stay_two_and_a_change_that_is_found_again_keeps_its_thing() {
        let mut site = Site::default();
        let (removed, appeared) = (SceneChangeKind::Removed, SceneChangeKind::Appeared);
        apply(&mut site, &comparison(10, vec![found(removed, 2.0), found(removed, 5.0)]), 99);
        apply(&mut site, &comparison(11, vec![found(appeared, 3.5)]), 99);
        let three = histories(&site);
        assert_eq!(three.len(), 3, "{three:?}");
        apply(&mut site, &comparison(12, vec![found(appeared, 3.55), found(removed, 2.05)]), 99);
        assert_eq!(histories(&site).len(), 3);
        assert_eq!(site.scene_changes().count(), 3);
    }
}
