//! The edit of the site that puts the changes of a comparison into it.

use changes::{Change as ObjectChange, ObservedChange, RecurrenceConfig, UprightBox, find_recurrences};
use geometry::vec_from_plain;
use ports::FoundChange;
use site_model::{
    Change, EarlierVisit, Edit, EditId, Object, ObjectId, OrientedBox, ReviewState, RunId, SceneChange,
    SceneChangeClouds, SceneChangeId, SceneChangeKind, Site, Utc,
};
use std::cmp::Reverse;
use uuid::Uuid;
use vocab::MapId;

/// Parameters of [`edit_with_changes`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SiteChangesConfig {
    /// When a known change is found again.
    pub recurrence: RecurrenceConfig,
    /// Changes that a site has at most. Beyond it, those on which people have decided go, the one that was not seen for longest first; the ledger keeps their revisions. Chosen: a
    /// year of results, and less than half of the objects that a site may have.
    pub max_changes: usize,
}

impl Default for SiteChangesConfig {
    fn default() -> Self {
        Self { recurrence: RecurrenceConfig::default(), max_changes: 20_000 }
    }
}

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

/// The edit that puts what a comparison found into the site, and how many of it were new. The same run gives an edit of the same id, so that it counts once.
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
    let mut edit = Edit { id: EditId(derived_id(comparison.run, 0)), changes: Vec::new() };
    let mut new = 0;
    for (number, ((found, clouds), recurrence)) in (1..).zip(comparison.found.iter().zip(&recurrences)) {
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
        };
        edit.changes.extend(site.put(edit.id, Object::SceneChange(change)).changes);
    }
    edit.changes.extend(removals(site, new, &edit, config));
    (edit, new)
}

/// Removals of old changes on which people have decided: as many as the site would have too many.
fn removals(site: &Site, new: usize, edit: &Edit, config: &SiteChangesConfig) -> Vec<Change> {
    let excess = (site.scene_changes().count() + new).saturating_sub(config.max_changes);
    if excess == 0 {
        return Vec::new();
    }
    let is_decided = |change: &&SceneChange| match change.review {
        ReviewState::Acknowledged | ReviewState::Dismissed { .. } | ReviewState::Normal { .. } => true,
        ReviewState::New | ReviewState::Watched => false,
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
    let change = match kind {
        SceneChangeKind::Appeared => ObjectChange::Appeared,
        SceneChangeKind::Removed => ObjectChange::Removed,
        SceneChangeKind::Moved { from } => ObjectChange::Moved { from: upright_box(from) },
    };
    ObservedChange { change, place: upright_box(place) }
}

fn upright_box(place: &OrientedBox) -> UprightBox {
    UprightBox { centre_m: vec_from_plain(place.centre_m), size_m: place.size_m, yaw_rad: place.yaw_rad }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vocab::Vec3;

    const MAP: MapId = MapId(Uuid::from_u128(1));

    fn found(kind: SceneChangeKind, x: f64) -> (FoundChange, Option<SceneChangeClouds>) {
        let place = OrientedBox { centre_m: Vec3::new(x, 0.0, 0.5), size_m: [0.6, 0.4, 1.0], yaw_rad: 0.2 };
        (FoundChange { kind, place, points: 80, confidence: 0.99, cloud: "object-1.ply".into() }, None)
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
}
