//! The comparison of two visits.

use crate::alignment::align;
use crate::clusters::clusters;
use crate::columns::Columns;
use crate::join::{InTurn, Join};
use crate::moves::moves;
use crate::passing::Passing;
use crate::penetration::{
    evidence_of_absence, explains_absence, penetration, was_looked_through, was_there, without_passing,
};
use crate::ray_image::PassingRays;
use crate::side::{ProbedPlace, Side, ground_below};
use crate::size_likelihood::log_likelihood_ratio;
use crate::surfaces::SurfaceTolerance;
use crate::turned::{TurnedThing, find_turned};
use crate::{ChangesConfig, UprightBox, Visit};
use geometry::Vector3;
use object_identity::{Association, Descriptor, GeometricDescriptor, ObjectDescriptor, PointNetwork};
use points::hash::{CellKey, CellTable};
use std::collections::{BTreeMap, BTreeSet};

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
    let aligned = align(before, after, join, &config.alignment);
    let tolerance = SurfaceTolerance::new(aligned.errors, config);
    let side = |visit| Side::new(visit, &tolerance, config);
    let (before, after) = join.join(|| side(before), || side(&aligned.visit));
    let differing = |visit: &Side, other: &Side| {
        let are_near = other.surfaces.are_near(&visit.surfaces, join);
        (differing(visit, other, &are_near, join, config), are_near)
    };
    let ((mut removed, _), (mut appeared, are_near)) =
        join.join(|| differing(&before, &after), || differing(&after, &before));
    let turned = turned_things(&mut removed, &mut appeared, [&before, &after], config);
    let (removed, appeared) = (removed.objects, appeared.objects);
    let boxes = |objects: &[UnmatchedObject]| objects.iter().map(|object| object.place).collect::<Vec<_>>();
    let (gone, new) = (boxes(&removed), boxes(&appeared));
    let log_ratio = |from: usize, to: usize| {
        log_likelihood_ratio(&gone[from].size_m, &new[to].size_m, &config.size_likelihood)
    };
    let pairs = moves(&gone, &new, log_ratio, &config.association);
    let unchanged = unchanged(&after, &are_near, config);
    let Changes { mut objects, .. } = merged(removed, appeared, &pairs);
    objects.extend(turned);
    for object in &mut objects {
        object.descriptor = descriptor.describe(&object.points);
    }
    objects.sort_by_key(|object| std::cmp::Reverse(object.points.len()));
    Changes { objects, unchanged }
}

/// Things that were turned where they stand. What they explain is taken from the other objects.
fn turned_things(
    removed: &mut Differences,
    appeared: &mut Differences,
    sides: [&Side; 2],
    config: &ChangesConfig,
) -> Vec<ChangedObject> {
    let mut found: Vec<TurnedThing> = Vec::new();
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

/// An object of one visit that the other one does not have.
pub(crate) struct UnmatchedObject {
    pub(crate) place: UprightBox,
    pub(crate) points: Vec<[f32; 3]>,
    pub(crate) confidence: f64,
}

/// Points of a visit without a surface of the other one near them, without those of what passed.
#[derive(Default)]
struct CandidatePoints {
    /// The other visit looked through their places.
    changed: Vec<[f32; 3]>,
    /// The other visit does not say what is in their places.
    unknown: Vec<[f32; 3]>,
}

/// The points of a visit that may have changed. What is known of the first point of a small cell holds for all of it: the other visit looked through its place, or does not say what is there; and of a
/// place that it looked through, something was there for a part of its own visit only, or all the time. `are_near` says which points have a surface of the other visit near them.
fn candidates(
    visit: &Side,
    other: &Side,
    are_near: &[bool],
    join: &impl Join,
    config: &ChangesConfig,
) -> CandidatePoints {
    let mut cells = CellTable::default();
    let mut places: Vec<ProbedPlace> = Vec::new();
    let mut of_places: Vec<(u32, [f32; 3])> = Vec::new();
    let without = visit.surfaces.points().iter().zip(are_near).filter(|(_, is_near)| !**is_near);
    for (point, _) in without {
        let cell = CellKey::of_point(point, 1.0 / config.candidate_cell_m as f32);
        let (place, is_new) = cells.get_or_insert(cell, places.len() as u32);
        if is_new {
            places.push(visit.probed(point, config));
        }
        of_places.push((place, *point));
    }

    let is_free = |rays: PassingRays| {
        rays.through >= config.min_free_rays
            && rays.through as f64 >= config.min_free_share * (rays.through + rays.ended) as f64
    };
    let is_free: Vec<bool> = other.passing(&places, join, config).into_iter().map(is_free).collect();
    let free: Vec<ProbedPlace> = places
        .iter()
        .zip(&is_free)
        .filter(|(_, is_free)| **is_free)
        .map(|(place, _)| place.clone())
        .collect();
    let mut was_passing = visit.was_passing(&free, join, config).into_iter();
    // Of the places that are not free nothing is known.
    let kinds: Vec<Option<bool>> =
        is_free.into_iter().map(|is_free| is_free.then(|| was_passing.next() == Some(true))).collect();
    let mut found = CandidatePoints::default();
    for (place, point) in of_places {
        match kinds[place as usize] {
            None => found.unknown.push(point),
            Some(false) => found.changed.push(point),
            Some(true) => {}
        }
    }
    found
}

/// The candidates near an object.
struct Around {
    changed: Columns,
    unknown: Columns,
}

/// What a visit has that the other one does not have.
#[derive(Default)]
struct Differences {
    objects: Vec<UnmatchedObject>,
    /// Groups of points of things of which the other visit has a part too.
    parts: Vec<Vec<[f32; 3]>>,
}

/// The differences of a visit from the other one.
fn differing(
    visit: &Side,
    other: &Side,
    are_near: &[bool],
    join: &impl Join,
    config: &ChangesConfig,
) -> Differences {
    let CandidatePoints { mut changed, unknown } = candidates(visit, other, are_near, join, config);
    let hidden = hidden_by_passing(&changed, [visit, other], config);
    changed.extend(hidden);
    let mut groups = clusters(&changed, config.gap_m as f32);
    groups.sort_by_key(|group| std::cmp::Reverse(group.len()));
    let around = Around { changed: Columns::new(changed.iter().copied()), unknown: Columns::new(unknown) };
    let mut found = Differences::default();
    for group in groups.iter().take_while(|group| group.len() >= config.min_points) {
        // A part of an object that was grown to it already.
        let is_part = |place: &usize| {
            let at = Vector3::from(changed[*place].map(f64::from));
            found.objects.iter().any(|object| object.place.holds(&at, config.same_surface_m))
        };
        if 2 * group.iter().filter(|place| is_part(place)).count() <= group.len() {
            let core: Vec<[f32; 3]> = group.iter().map(|place| changed[*place]).collect();
            match object(&core, &around, [visit, other], config) {
                Some(Group::Object(object)) => found.objects.push(object),
                Some(Group::Part) => found.parts.push(core),
                None => {}
            }
        }
    }
    found
}

/// What a group of changed points is.
enum Group {
    /// An object that the other visit does not have.
    Object(UnmatchedObject),
    /// A part of a thing of which the other visit has another part.
    Part,
}

/// The object of a group of changed points; none if it is too small, was not there all the time of its visit, or if the rays of the other visit do not say that it was not there.
fn object(core: &[[f32; 3]], around: &Around, sides: [&Side; 2], config: &ChangesConfig) -> Option<Group> {
    let (mut points, place) = grown(core, around, sides, config)?;
    let mut sorted = place.size_m;
    sorted.sort_by(f64::total_cmp);
    let (standing, mut stands) = down_to_ground(place, sides, config);
    if sorted[1] < config.min_size_m || points.len().min(core.len()) < min_points(&place, stands, config) {
        return None;
    }
    let mut place = standing;
    if same_share(&place, sides, config) > config.max_same_share {
        let (kept, own) = above_ground(core, sides, config)?;
        if points.len() as f64 > (1.0 + config.stray_growth_share) * kept.len() as f64 {
            return Some(Group::Part);
        }
        points = kept;
        (place, stands) = down_to_ground(own, sides, config);
        let is_thin = place.size_m[0].min(place.size_m[1]) < config.min_size_m;
        if !stands || is_thin || same_share(&place, sides, config) > config.max_same_share {
            return Some(Group::Part);
        }
    }
    let is_large = place.size_m.iter().any(|side_m| *side_m > config.large_m);
    if is_large && known_share(&place, around, config) < config.min_known_share {
        return None;
    }
    let [own, met] = sides.map(|side| penetration(&place, &side.images, config));
    let met_by_staying = without_passing(&place, &met, config);
    let evidence = evidence_of_absence(own.iter().sum(), met_by_staying, config);
    let is_gone = evidence >= config.min_evidence
        && explains_absence(met_by_staying, config)
        && was_looked_through(&place, &met, config);
    let confidence = 1.0 / (1.0 + (-evidence).exp());
    (is_gone && was_there(&place, stands, &own, config)).then_some(Group::Object(UnmatchedObject {
        place,
        points,
        confidence,
    }))
}

/// The points of a group that are not those of the ground, and their box. None without points.
fn above_ground(
    core: &[[f32; 3]],
    sides: [&Side; 2],
    config: &ChangesConfig,
) -> Option<(Vec<[f32; 3]>, UprightBox)> {
    let place = UprightBox::around(core, &config.box_fit)?;
    let ground_m = ground_below(&place, config.ground_depth_m, sides, config).unwrap_or(f64::NEG_INFINITY);
    let is_above = |point: &&[f32; 3]| f64::from(point[2]) > ground_m + config.ground_clearance_m;
    let points: Vec<[f32; 3]> = core.iter().filter(is_above).copied().collect();
    let place = UprightBox::around(&points, &config.box_fit)?;
    Some((points, place))
}

/// A box down to the ground if it stands on it, and whether it does.
fn down_to_ground(place: UprightBox, sides: [&Side; 2], config: &ChangesConfig) -> (UprightBox, bool) {
    ground_below(&place, config.stands_within_m, sides, config)
        .filter(|ground_m| place.bottom_m() - ground_m <= config.stands_within_m)
        .map_or((place, false), |ground_m| (place.down_to(ground_m), true))
}

/// Points that a group and its object have at least: a thin one may be a strip between two rays, a high one a person, and one that does not stand on the ground what is left of a part of a building.
fn min_points(place: &UprightBox, stands: bool, config: &ChangesConfig) -> usize {
    let [length, width, height] = place.size_m;
    let is_low_and_thick = length.min(width) >= config.min_size_m && height < config.walking_height_m;
    if stands && is_low_and_thick { config.min_points } else { config.min_points_of_others }
}

/// The points of an object and its box: the group, points of unknown places near its box, and all that differs above and below it, again and again, without those
/// of the ground. None without points.
fn grown(
    core: &[[f32; 3]],
    around: &Around,
    sides: [&Side; 2],
    config: &ChangesConfig,
) -> Option<(Vec<[f32; 3]>, UprightBox)> {
    let bits = |point: &[f32; 3]| point.map(f32::to_bits);
    let of_core: BTreeSet<[u32; 3]> = core.iter().map(bits).collect();
    let mut place = UprightBox::around(core, &config.box_fit)?;
    let mut points: Vec<[f32; 3]> = Vec::new();
    for _ in 0..config.grow_rounds {
        let ground_m =
            ground_below(&place, config.ground_depth_m, sides, config).unwrap_or(f64::NEG_INFINITY);
        let is_above = |point: &&[f32; 3]| f64::from(point[2]) > ground_m + config.ground_clearance_m;
        let [length, width, height] = place.size_m;
        let column = UprightBox { size_m: [length, width, height + 2.0 * config.grow_up_m], ..place };
        let at = |point: &[f32; 3]| Vector3::from(point.map(f64::from));
        let is_stacked = |point: &&[f32; 3]| column.holds(&at(point), config.same_surface_m);
        let is_near = |point: &&[f32; 3]| place.holds(&at(point), config.grow_m) || is_stacked(point);
        let is_other = |point: &&[f32; 3]| !of_core.contains(&bits(point));
        let next: Vec<[f32; 3]> = core
            .iter()
            .chain(around.changed.around(&place, config.same_surface_m).filter(is_other).filter(is_stacked))
            .chain(around.unknown.around(&place, config.grow_m).filter(is_near))
            .filter(is_above)
            .copied()
            .collect();
        if next.len() == points.len() {
            break;
        }
        points = next;
        place = UprightBox::around(&points, &config.box_fit)?;
    }
    Some((points, place))
}

/// Share of the cells with points of an object in which the other visit looked through a point of it, of those in which a point has no surface of the other visit near it. Linear in
/// the points around.
fn known_share(place: &UprightBox, around: &Around, config: &ChangesConfig) -> f64 {
    let cells = |columns: &Columns| -> BTreeSet<CellKey> {
        let inside =
            columns.around(place, 0.0).filter(|point| place.holds(&Vector3::from(point.map(f64::from)), 0.0));
        inside.map(|point| CellKey::of_point(point, 1.0 / config.known_cell_m as f32)).collect()
    };
    let (changed, unknown) = (cells(&around.changed), cells(&around.unknown));
    let all = changed.union(&unknown).count();
    changed.len() as f64 / all.max(1) as f64
}

/// Share of the points in a box that have a surface of the other visit near them: a thing is gone as a whole. Linear in the points around.
fn same_share(place: &UprightBox, sides: [&Side; 2], config: &ChangesConfig) -> f64 {
    let [inside, same] = inside_and_same(place, sides, config);
    let share = same.len() as f64 / inside.len().max(1) as f64;
    if share <= config.max_same_share {
        return share;
    }
    let step = same.len().div_ceil(config.max_asked_points);
    let asked: Vec<[f32; 3]> = same.into_iter().step_by(step).collect();
    let staying = Passing::new(sides[1], config).at(&asked).filter(|is_passing| !is_passing).count();
    share * staying as f64 / asked.len() as f64
}

/// Points near changed ones that have a surface of the other visit near them for the only reason that something passed there during that visit, such as a person: they join what is left of
/// a thing on both sides of it. For each group of changed points linear in the points around, in each of [`ChangesConfig::grow_rounds`] rounds.
fn hidden_by_passing(changed: &[[f32; 3]], sides: [&Side; 2], config: &ChangesConfig) -> Vec<[f32; 3]> {
    let [visit, other] = sides;
    let mut passing = Passing::new(other, config);
    let mut found: BTreeSet<[u32; 3]> = BTreeSet::new();
    let groups = clusters(changed, config.gap_m as f32).into_iter();
    for group in groups.filter(|group| group.len() >= config.min_points_of_others) {
        let mut group: Vec<[f32; 3]> = group.iter().map(|place| changed[*place]).collect();
        for _ in 0..config.grow_rounds {
            let Some(wide) = extent(&group, config.gap_m) else { break };
            let is_same = |point: &&[f32; 3]| {
                wide.holds(&Vector3::from(point.map(f64::from)), 0.0) && other.surfaces.is_near(point)
            };
            let same = visit.surfaces.columns().around(&wide, 0.0).filter(is_same);
            let same: Vec<[f32; 3]> = same.copied().collect();
            let known = group.len();
            let hidden = same.iter().zip(passing.at(&same)).filter(|(_, is_passing)| *is_passing);
            group.extend(
                hidden.map(|(point, _)| *point).filter(|point| found.insert(point.map(f32::to_bits))),
            );
            if group.len() == known {
                break;
            }
        }
    }
    found.into_iter().map(|bits| bits.map(f32::from_bits)).collect()
}

/// The smallest box along the axes that reaches `margin_m` metres beyond all points; none of no points.
fn extent(points: &[[f32; 3]], margin_m: f64) -> Option<UprightBox> {
    let points = points.iter().map(|point| Vector3::from(point.map(f64::from)));
    let [least, most] =
        points.map(|at| [at, at]).reduce(|[least, most], [low, high]| [least.inf(&low), most.sup(&high)])?;
    let size = (most - least).add_scalar(2.0 * margin_m);
    Some(UprightBox { centre_m: (least + most) / 2.0, size_m: size.into(), yaw_rad: 0.0 })
}

/// The points in a box, and those of them that have a surface of the other visit near them, without those so low that the ground is near them.
fn inside_and_same(
    place: &UprightBox,
    [visit, other]: [&Side; 2],
    config: &ChangesConfig,
) -> [Vec<[f32; 3]>; 2] {
    let middle: [f32; 3] = place.centre_m.map(|at| at as f32).into();
    let noise_m = config.same_surface_deviations * config.range_noise_m;
    let above_m = place.bottom_m() + f64::from(other.surfaces.tolerance_m(&middle)) + noise_m;
    let is_inside = |point: &&[f32; 3]| {
        let at = Vector3::from(point.map(f64::from));
        at.z > above_m && place.holds(&at, 0.0)
    };
    let inside: Vec<[f32; 3]> =
        visit.surfaces.columns().around(place, 0.0).filter(is_inside).copied().collect();
    let same = inside.iter().filter(|point| other.surfaces.is_near(point)).copied().collect();
    [inside, same]
}

#[cfg(test)]
#[path = "detect_tests.rs"]
mod tests;
