//! Compares what a comparison of two visits found with what was changed.

use changes::{Change, ChangedObject, UprightBox, Visit};
use geometry::Vector3;
use sim::{LooseObject, ObjectChange};

/// An object is found if its middle is at most this far off, metres.
const MAX_CENTRE_M: f64 = 0.3;
/// What is found within this distance of the side of a changed object is that object, though perhaps wrong, metres.
const NEAR_M: f64 = 0.5;
/// Objects with a side of at least this length are large, metres.
const LARGE_M: f64 = 0.3;

/// A visit has passed an object if it has at least this number of points of it: as many as an object of [`changes::ChangesConfig::min_points`] needs.
const PASSED_POINTS: usize = 30;

/// Numbers of objects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VisitScore {
    /// Comparisons.
    pub visits: usize,
    /// Objects of at least 0.3 m that were put, taken or moved, and those of them that are found: both ends of a moved one.
    pub large: usize,
    pub large_found: usize,
    /// The same of smaller ones.
    pub small: usize,
    pub small_found: usize,
    /// Changed ones, of an end of which its visit has fewer than [`PASSED_POINTS`] points: the walk has not passed them. They are not counted otherwise, found or not.
    pub unseen: usize,
    /// Large ones that were moved, and those of them that are named as moved from there.
    pub moved: usize,
    pub matched: usize,
    /// Named as moved though the two ends are of different things.
    pub wrongly_matched: usize,
    /// Large ones that were turned where they stand, and those of them of which something is named.
    pub turned: usize,
    pub turned_found: usize,
    /// The same of smaller ones.
    pub small_turned: usize,
    pub small_turned_found: usize,
    /// Named objects at a changed one, and those where nothing has changed.
    pub right: usize,
    pub wrong: usize,
}

impl VisitScore {
    /// Adds another score.
    pub fn add(&mut self, other: &Self) {
        self.visits += other.visits;
        self.large += other.large;
        self.large_found += other.large_found;
        self.small += other.small;
        self.small_found += other.small_found;
        self.unseen += other.unseen;
        self.moved += other.moved;
        self.matched += other.matched;
        self.wrongly_matched += other.wrongly_matched;
        self.turned += other.turned;
        self.turned_found += other.turned_found;
        self.small_turned += other.small_turned;
        self.small_turned_found += other.small_turned_found;
        self.right += other.right;
        self.wrong += other.wrong;
    }
}

/// Scores the objects of a comparison. What was not found or is wrong is said to `explain`.
pub fn score_visit(
    objects: &[ChangedObject],
    truth: &[ObjectChange],
    visits: [&Visit; 2],
    mut explain: impl FnMut(String),
) -> VisitScore {
    let mut score = VisitScore { visits: 1, ..VisitScore::default() };
    let is_gone_from = |at: &UprightBox| {
        objects.iter().any(|object| match &object.change {
            Change::Removed => is_at(&object.place, at),
            Change::Moved { from } => is_at(from, at),
            Change::Appeared => false,
        })
    };
    let is_new_at = |at: &UprightBox| {
        objects.iter().any(|object| object.change != Change::Removed && is_at(&object.place, at))
    };
    for change in truth {
        let (object, is_found) = match change {
            ObjectChange::Put(object) => (object, is_new_at(&place(object))),
            ObjectChange::Taken(object) => (object, is_gone_from(&place(object))),
            ObjectChange::Moved { from, to } => (from, is_gone_from(&place(from)) && is_new_at(&place(to))),
            ObjectChange::Turned { from, to } => {
                let at = place(from);
                let seen = points_of(change, visits);
                if seen < PASSED_POINTS {
                    score.unseen += 1;
                    continue;
                }
                let is_named = objects.iter().any(|object| is_near(&object.place, &at));
                let (count, found) = if is_large(from) {
                    (&mut score.turned, &mut score.turned_found)
                } else {
                    (&mut score.small_turned, &mut score.small_turned_found)
                };
                *count += 1;
                *found += usize::from(is_named);
                if !is_named {
                    explain(format!(
                        "not found: turned at {:.2?}, {:.2?}, from {:.2} to {:.2} rad, {seen} points",
                        at.centre_m.as_slice(),
                        at.size_m,
                        at.yaw_rad,
                        place(to).yaw_rad
                    ));
                }
                continue;
            }
        };
        let seen = points_of(change, visits);
        if seen < PASSED_POINTS {
            score.unseen += 1;
            continue;
        }
        let (count, found) = if is_large(object) {
            (&mut score.large, &mut score.large_found)
        } else {
            (&mut score.small, &mut score.small_found)
        };
        *count += 1;
        *found += usize::from(is_found);
        if let (ObjectChange::Moved { from, to }, true) = (change, is_large(object)) {
            let (from, to) = (place(from), place(to));
            let is_matched = objects.iter().any(|object| {
                matches!(&object.change, Change::Moved { from: was } if is_at(was, &from))
                    && is_at(&object.place, &to)
            });
            score.moved += 1;
            score.matched += usize::from(is_matched);
            if is_found && !is_matched {
                explain(format!(
                    "not matched: {:.2?} to {:.2?}, named {}",
                    from,
                    to,
                    named_near(objects, [&from, &to])
                ));
            }
        }
        if !is_found {
            let at = place(object);
            let to = ends(change).last().map(|end| format!(" to {:.2?}", place(end).centre_m.as_slice()));
            explain(format!(
                "not found: {} at {:.2?}{}, {:.2?}, {seen} points",
                name(change),
                at.centre_m.as_slice(),
                to.filter(|_| matches!(change, ObjectChange::Moved { .. })).unwrap_or_default(),
                at.size_m
            ));
        }
    }
    let ends: Vec<UprightBox> = truth.iter().flat_map(ends).map(|object| place(&object)).collect();
    for object in objects {
        let from = match &object.change {
            Change::Moved { from } => Some(from),
            Change::Appeared | Change::Removed => None,
        };
        let is_of_one = |from: &UprightBox| {
            truth.iter().any(|change| match change {
                ObjectChange::Moved { from: was, to } | ObjectChange::Turned { from: was, to } => {
                    is_near(from, &place(was)) && is_near(&object.place, &place(to))
                }
                ObjectChange::Put(_) | ObjectChange::Taken(_) => false,
            })
        };
        if let Some(from) = from
            && !is_of_one(from)
        {
            score.wrongly_matched += 1;
            explain(format!(
                "wrongly matched: {:.2?} {:.2?} to {:.2?} {:.2?}, probability {:.2}",
                from.centre_m.as_slice(),
                from.size_m,
                object.place.centre_m.as_slice(),
                object.place.size_m,
                object.move_probability.unwrap_or_default()
            ));
        }
        let is_right = [Some(&object.place), from]
            .into_iter()
            .flatten()
            .all(|at| ends.iter().any(|end| is_near(at, end)));
        if is_right {
            score.right += 1;
        } else {
            score.wrong += 1;
            explain(format!(
                "wrong: {} at {:.2?}, {:.2?}, {} points, confidence {:.4}",
                match object.change {
                    Change::Appeared => "appeared",
                    Change::Removed => "removed",
                    Change::Moved { .. } => "moved",
                },
                object.place.centre_m.as_slice(),
                object.place.size_m,
                object.points.len(),
                object.confidence
            ));
        }
    }
    score
}

fn is_large(object: &LooseObject) -> bool {
    object.size_m.into_iter().fold(0.0, f64::max) >= LARGE_M
}

/// The sizes of the found objects at these places.
fn named_near(objects: &[ChangedObject], places: [&UprightBox; 2]) -> String {
    let sizes = objects.iter().flat_map(|object| {
        let from = if let Change::Moved { from } = &object.change { Some(from) } else { None };
        [Some(&object.place), from].into_iter().flatten()
    });
    let near = sizes.filter(|place| places.iter().any(|other| is_near(place, other)));
    near.map(|place| format!("{:.2?}", place.size_m)).collect::<Vec<_>>().join(" and ")
}

fn name(change: &ObjectChange) -> &'static str {
    match change {
        ObjectChange::Put(_) => "put",
        ObjectChange::Taken(_) => "taken",
        ObjectChange::Moved { .. } => "moved",
        ObjectChange::Turned { .. } => "turned",
    }
}

/// Points that the visits have of a changed object, above its lower end; of a moved one at the end that has fewer. The first visit is the earlier one.
fn points_of(change: &ObjectChange, [before, after]: [&Visit; 2]) -> usize {
    let count = |object: &LooseObject, visit: &Visit| {
        let place = place(object);
        let above = place.down_to(place.bottom_m() + 0.05);
        let points = visit.views.iter().flat_map(|view| &view.points);
        points.filter(|point| above.holds(&Vector3::from(point.map(f64::from)), 0.02)).count()
    };
    match change {
        ObjectChange::Put(object) => count(object, after),
        ObjectChange::Taken(object) => count(object, before),
        ObjectChange::Moved { from, to } | ObjectChange::Turned { from, to } => {
            count(from, before).min(count(to, after))
        }
    }
}

fn ends(change: &ObjectChange) -> Vec<LooseObject> {
    match *change {
        ObjectChange::Put(object) | ObjectChange::Taken(object) => vec![object],
        ObjectChange::Moved { from, to } | ObjectChange::Turned { from, to } => vec![from, to],
    }
}

fn place(object: &LooseObject) -> UprightBox {
    UprightBox { centre_m: object.middle(), size_m: object.size_m, yaw_rad: object.yaw_rad }
}

fn is_at(found: &UprightBox, truth: &UprightBox) -> bool {
    (found.centre_m - truth.centre_m).norm() <= MAX_CENTRE_M
}

fn is_near(found: &UprightBox, truth: &UprightBox) -> bool {
    truth.holds(&found.centre_m, NEAR_M)
}
