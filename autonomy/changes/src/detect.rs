//! The comparison of two visits.

use crate::alignment::{align, planes};
use crate::differences::{Compared, Differences, UnmatchedObject, differing};
use crate::join::{InTurn, Join};
use crate::moves::moves;
use crate::side::{Side, images};
use crate::size_likelihood::log_likelihood_ratio;
use crate::surfaces::SurfaceTolerance;
use crate::turned::{TurnedThing, find_turned, find_turned_as_a_whole};
use crate::{ChangesConfig, UprightBox, Visit};
use geometry::Vector3;
use object_identity::{Association, Descriptor, GeometricDescriptor, ObjectDescriptor, PointNetwork};
use points::hash::{CellKey, CellTable};
use std::collections::BTreeMap;

/// What became of an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// It is there after, and was not before.
    Appeared,
    /// It was there before, and is not after.
    Removed,
    /// It was there, and is elsewhere after.
    Moved {
        /// Where it was.
        from: UprightBox,
    },
}

/// An object that changed.
#[derive(Clone, Debug, PartialEq)]
pub struct ChangedObject {
    /// What became of it.
    pub change: Change,
    /// Where it is, or was if it is gone.
    pub place: UprightBox,
    /// Its points, metres, map frame: those of the visit that saw it there.
    pub points: Vec<[f32; 3]>,
    /// Probability that it changed, 0 to 1, from the rays of the other visit that met its place, if as many objects of the places that were compared have changed as have not.
    pub confidence: f64,
    /// Of a moved one, the probability that one thing was at both places: things of one make cannot be told apart.
    pub move_probability: Option<f64>,
    /// Descriptor of its points; none of an image of a depth camera, and of too few points.
    pub descriptor: Option<Descriptor>,
}

/// What changed between two visits.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// Objects, those with most points first.
    pub objects: Vec<ChangedObject>,
    /// What both visits saw: points of the later one on surfaces of the earlier one, one for each cell of [`ChangesConfig::unchanged_cell_m`], metres, map frame.
    pub unchanged: Vec<[f32; 3]>,
}

/// Compares two visits in one map frame. The later one is aligned with the earlier one first, view by view; so results are in the frame of the earlier one. Cost: `O(n log n)` in the points, and for each point without a surface of the other visit near it a step for each view of both
/// visits within [`ChangesConfig::max_range_m`].
pub fn detect_changes(before: &Visit, after: &Visit, config: &ChangesConfig) -> Changes {
    detect_changes_with(before, after, &*shipped_descriptor(), &InTurn, config)
}

/// The way to know things again that comes with the program.
pub fn shipped_descriptor() -> Box<dyn ObjectDescriptor> {
    match PointNetwork::shipped() {
        Ok(network) => Box::new(network),
        // Only if the program was built with a damaged file.
        Err(_) => Box::new(GeometricDescriptor::default()),
    }
}

/// [`detect_changes`] with another way to know things again, and another way to compute what is independent of each other. The result does not depend on `join`.
pub fn detect_changes_with(
    before: &Visit,
    after: &Visit,
    descriptor: &dyn ObjectDescriptor,
    join: &impl Join,
    config: &ChangesConfig,
) -> Changes {
    let (planes, images_before) = join.join(|| planes(before, &config.alignment), || images(before, config));
    let aligned = align(before, &planes, after, join, &config.alignment);
    let after = &aligned.visit;
    let tolerance = SurfaceTolerance::new(aligned.errors, config);
    let (before, after) = join.join(
        || Side::new(before, images_before, &tolerance, config),
        || Side::new(after, images(after, config), &tolerance, config),
    );
    let of_before = || differing(&Compared::new([&before, &after], join), join, config);
    let of_after = || {
        let compared = Compared::new([&after, &before], join);
        let differing = differing(&compared, join, config);
        (differing, unchanged(&after, &compared.are_near, config))
    };
    let (mut removed, (mut appeared, unchanged)) = join.join(of_before, of_after);
    let as_a_whole = find_turned_as_a_whole([&before, &after], join, config);
    let turned = turned_things(&mut removed, &mut appeared, as_a_whole, [&before, &after], config);
    let (removed, appeared) = (removed.objects, appeared.objects);
    let boxes = |objects: &[UnmatchedObject]| objects.iter().map(|object| object.place).collect::<Vec<_>>();
    let (gone, new) = (boxes(&removed), boxes(&appeared));
    let log_ratio = |from: usize, to: usize| {
        log_likelihood_ratio(&gone[from].size_m, &new[to].size_m, &config.size_likelihood)
    };
    let pairs = moves(&gone, &new, log_ratio, &config.association);
    let Changes { mut objects, .. } = merged(removed, appeared, &pairs);
    objects.extend(turned);
    for object in &mut objects {
        object.descriptor = descriptor.describe(&object.points);
    }
    objects.sort_by_key(|object| std::cmp::Reverse(object.points.len()));
    Changes { objects, unchanged }
}

/// Things that were turned where they stand: these, and those of which parts differ. What they explain is taken from the other objects.
fn turned_things(
    removed: &mut Differences,
    appeared: &mut Differences,
    as_a_whole: Vec<TurnedThing>,
    sides: [&Side; 2],
    config: &ChangesConfig,
) -> Vec<ChangedObject> {
    let mut found = as_a_whole;
    let gone: Vec<Vec<[f32; 3]>> = removed
        .parts
        .iter()
        .cloned()
        .chain(removed.objects.iter().map(|object| object.points.clone()))
        .collect();
    let new = appeared.parts.iter().chain(appeared.objects.iter().map(|object| &object.points));
    for part in new {
        let is_known = |thing: &TurnedThing| {
            part.first()
                .is_some_and(|point| thing.place.holds(&Vector3::from(point.map(f64::from)), config.grow_m))
        };
        if !found.iter().any(is_known) {
            found.extend(find_turned(part, &gone, sides, config));
        }
    }
    for thing in &found {
        let is_other = |object: &UnmatchedObject| {
            ![&thing.from, &thing.place].iter().any(|place| place.holds(&object.place.centre_m, 0.0))
        };
        removed.objects.retain(is_other);
        appeared.objects.retain(is_other);
    }
    let changed = |TurnedThing { from, place, points }| ChangedObject {
        change: Change::Moved { from },
        place,
        points,
        confidence: config.turned_confidence,
        move_probability: Some(config.turned_confidence),
        descriptor: None,
    };
    found.into_iter().map(changed).collect()
}

/// Points of a visit on surfaces of the other one, the first of each cell. Linear in the points.
fn unchanged(visit: &Side, are_near: &[bool], config: &ChangesConfig) -> Vec<[f32; 3]> {
    let per_m = 1.0 / config.unchanged_cell_m as f32;
    let mut cells = CellTable::default();
    let near = visit.surfaces.points().iter().zip(are_near).filter(|(_, is_near)| **is_near);
    let first = near.filter(|(point, _)| cells.get_or_insert(CellKey::of_point(point, per_m), 0).1);
    first.map(|(point, _)| *point).collect()
}

/// The changes of objects that are gone and that are new, of which these pairs (gone, new) are likely one thing each.
pub(crate) fn merged(
    removed: Vec<UnmatchedObject>,
    appeared: Vec<UnmatchedObject>,
    pairs: &[Association],
) -> Changes {
    let gone_of: BTreeMap<usize, &Association> = pairs.iter().map(|found| (found.pair[1], found)).collect();
    let from: Vec<UprightBox> = removed.iter().map(|object| object.place).collect();
    let of = |object: UnmatchedObject, change, move_probability| ChangedObject {
        change,
        place: object.place,
        points: object.points,
        confidence: object.confidence,
        move_probability,
        descriptor: None,
    };
    let new = appeared.into_iter().enumerate().map(|(new, object)| match gone_of.get(&new) {
        Some(found) => of(object, Change::Moved { from: from[found.pair[0]] }, Some(found.probability)),
        None => of(object, Change::Appeared, None),
    });
    let gone = removed
        .into_iter()
        .enumerate()
        .filter(|(gone, _)| pairs.iter().all(|found| found.pair[0] != *gone))
        .map(|(_, object)| of(object, Change::Removed, None));
    let mut objects: Vec<ChangedObject> = new.chain(gone).collect();
    objects.sort_by_key(|object| std::cmp::Reverse(object.points.len()));
    Changes { objects, unchanged: Vec::new() }
}

#[cfg(test)]
#[path = "detect_tests.rs"]
mod tests;
