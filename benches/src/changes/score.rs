//! Compares changes with the boxes that were put in.

use super::sessions::{Inserted, Truth};
use changes::{Change, ChangedObject, UprightBox};

/// A changed box with at least this number of points has to be found.
pub const POINTS_REQUIRED: usize = 150;
/// A box is found if its centre is at most this far off, metres, and each side at most by this share.
const MAX_CENTRE_M: f64 = 0.2;
const MAX_SIZE_SHARE: f64 = 0.2;

/// Lengths of the longest side by which boxes are counted, metres: those below the first one, those between two, and those of the last one and more.
pub const SIZE_LIMITS_M: [f64; 2] = [0.5, 1.0];

/// Numbers of changed boxes of one size that have to be found.
#[derive(Clone, Copy, Debug, Default)]
pub struct OfSize {
    pub required: usize,
    pub required_found: usize,
}

/// Numbers of boxes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Score {
    /// By size, the smallest first.
    pub by_size: [OfSize; SIZE_LIMITS_M.len() + 1],
    /// Changed boxes that have to be found, and those of them that are.
    pub required: usize,
    pub required_found: usize,
    /// All changed boxes, and those of them that are found. A moved box counts once.
    pub changed: usize,
    pub found: usize,
    /// Objects that are named and are no changed box.
    pub wrong: usize,
    /// Unchanged boxes, and those of them at which an object is named.
    pub unchanged: usize,
    pub unchanged_named: usize,
}

impl Score {
    /// Adds another score.
    pub fn add(&mut self, other: &Self) {
        for (of_size, other) in self.by_size.iter_mut().zip(&other.by_size) {
            of_size.required += other.required;
            of_size.required_found += other.required_found;
        }
        self.required += other.required;
        self.required_found += other.required_found;
        self.changed += other.changed;
        self.found += other.found;
        self.wrong += other.wrong;
        self.unchanged += other.unchanged;
        self.unchanged_named += other.unchanged_named;
    }
}

/// Scores the objects of a comparison. What was not found or should not have been named is said to `explain`.
pub fn score(objects: &[ChangedObject], truth: &[Truth], mut explain: impl FnMut(String)) -> Score {
    let mut score = Score::default();
    let mut is_right = vec![false; objects.len()];
    for truth in truth {
        if let Truth::Unchanged(inserted) = truth {
            score.unchanged += 1;
            let is_named =
                |object: &&ChangedObject| (object.place.centre_m - inserted.place.centre_m).xy().norm() < 0.5;
            score.unchanged_named += usize::from(objects.iter().any(|object| is_named(&object)));
            continue;
        }
        let found = objects.iter().position(|object| is_found(object, truth));
        let is_required = points(truth) >= POINTS_REQUIRED;
        score.changed += 1;
        score.required += usize::from(is_required);
        let of_size = &mut score.by_size[size_class(truth)];
        of_size.required += usize::from(is_required);
        of_size.required_found += usize::from(is_required && found.is_some());
        match found {
            Some(place) => {
                is_right[place] = true;
                score.found += 1;
                score.required_found += usize::from(is_required);
            }
            None => explain(format!("not found, {} points: {truth:?}", points(truth))),
        }
    }
    for (object, _) in objects.iter().zip(&is_right).filter(|(_, is_right)| !**is_right) {
        score.wrong += 1;
        let UprightBox { centre_m, size_m, .. } = object.place;
        let kind = match object.change {
            Change::Appeared => "appeared",
            Change::Removed => "removed",
            Change::Moved { .. } => "moved",
        };
        explain(format!(
            "wrong: {kind} at {:.2} {:.2} {:.2}, {size_m:.2?}, {} points, confidence {}",
            centre_m.x,
            centre_m.y,
            centre_m.z,
            object.points.len(),
            object.confidence
        ));
    }
    score
}

/// Points at a changed box: those at the end of a moved one that has fewer.
fn points(truth: &Truth) -> usize {
    match truth {
        Truth::Appeared(inserted) => inserted.points[1],
        Truth::Removed(inserted) | Truth::Unchanged(inserted) => inserted.points[0],
        Truth::Moved { from, to } => from.points[0].min(to.points[1]),
    }
}

/// Place of a box among those by size.
fn size_class(truth: &Truth) -> usize {
    let (Truth::Appeared(inserted)
    | Truth::Removed(inserted)
    | Truth::Unchanged(inserted)
    | Truth::Moved { from: inserted, .. }) = truth;
    let longest_m = inserted.place.size_m.into_iter().fold(0.0, f64::max);
    SIZE_LIMITS_M.iter().filter(|limit_m| longest_m >= **limit_m).count()
}

fn is_found(object: &ChangedObject, truth: &Truth) -> bool {
    match (&object.change, truth) {
        (Change::Appeared, Truth::Appeared(inserted)) | (Change::Removed, Truth::Removed(inserted)) => {
            is_at(&object.place, inserted)
        }
        (Change::Moved { from }, Truth::Moved { from: was, to }) => {
            is_at(from, was) && is_at(&object.place, to)
        }
        _ => false,
    }
}

fn is_at(found: &UprightBox, inserted: &Inserted) -> bool {
    let place = inserted.place;
    (found.centre_m - place.centre_m).norm() <= MAX_CENTRE_M
        && found.size_m.iter().zip(place.size_m).all(|(a, b)| (a - b).abs() <= MAX_SIZE_SHARE * b)
}
