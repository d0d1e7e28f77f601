//! The comparison of two visits.

use crate::clusters::clusters;
use crate::look::{Evidence, LookImage};
use crate::moves::{is_same_size, moves};
use crate::penetration::{evidence_of_absence, penetration};
use crate::surfaces::Surfaces;
use crate::{ChangesConfig, UprightBox, Visit};
use geometry::Vector3;
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
}

/// What changed between two visits.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// Objects, those with most points first.
    pub objects: Vec<ChangedObject>,
}

/// Compares two visits in one map frame. Cost: `O(n log n)` in the points, and for each point without a surface of the other visit near it a step for each look of both
/// visits within [`ChangesConfig::range_max_m`].
pub fn detect_changes(before: &Visit, after: &Visit, config: &ChangesConfig) -> Changes {
    let sides = [before, after].map(|visit| Side::new(visit, config));
    let removed = differing(&sides[0], &sides[1], config);
    let appeared = differing(&sides[1], &sides[0], config);
    let boxes = |objects: &[Differing]| objects.iter().map(|object| object.place).collect::<Vec<_>>();
    let (gone, new) = (boxes(&removed), boxes(&appeared));
    let pairs = moves(&gone, &new, |from, to| {
        is_same_size(&gone[from], &new[to], config.same_size_share, config.same_surface_m / 2.0)
    });
    merged(removed, appeared, &pairs)
}

/// The changes of objects that are gone and that are new, of which these pairs (gone, new) are one object each.
pub(crate) fn merged(removed: Vec<Differing>, appeared: Vec<Differing>, pairs: &[(usize, usize)]) -> Changes {
    let gone_of: BTreeMap<usize, usize> = pairs.iter().map(|(gone, new)| (*new, *gone)).collect();
    let from: Vec<UprightBox> = removed.iter().map(|object| object.place).collect();
    let of = |object: Differing, change| ChangedObject {
        change,
        place: object.place,
        points: object.points,
        confidence: object.confidence,
    };
    let new = appeared.into_iter().enumerate().map(|(new, object)| match gone_of.get(&new) {
        Some(gone) => of(object, Change::Moved { from: from[*gone] }),
        None => of(object, Change::Appeared),
    });
    let gone = removed
        .into_iter()
        .enumerate()
        .filter(|(gone, _)| pairs.iter().all(|(paired, _)| paired != gone))
        .map(|(_, object)| of(object, Change::Removed));
    let mut objects: Vec<ChangedObject> = new.chain(gone).collect();
    objects.sort_by_key(|object| std::cmp::Reverse(object.points.len()));
    Changes { objects }
}

/// A visit, prepared for questions.
struct Side<'a> {
    visit: &'a Visit,
    surfaces: Surfaces,
    images: Vec<LookImage>,
}

impl<'a> Side<'a> {
    fn new(visit: &'a Visit, config: &ChangesConfig) -> Self {
        let points = visit.points_within(config.range_min_m, config.range_max_m);
        Self {
            visit,
            surfaces: Surfaces::new(points, config.same_surface_m as f32),
            images: visit.looks.iter().map(|look| LookImage::new(look, config)).collect(),
        }
    }

    /// In how many looks rays went through a place, and in how many one ended there.
    fn evidence(&self, place: &[f32; 3], config: &ChangesConfig) -> (usize, usize) {
        self.images.iter().fold((0, 0), |(free, occupied), image| match image.evidence(place, config) {
            Evidence::Free => (free + 1, occupied),
            Evidence::Occupied => (free, occupied + 1),
            Evidence::Unknown => (free, occupied),
        })
    }
}

/// An object of one visit that the other one does not have.
pub(crate) struct Differing {
    pub(crate) place: UprightBox,
    pub(crate) points: Vec<[f32; 3]>,
    pub(crate) confidence: f64,
}

/// The objects of a visit that the other one does not have.
fn differing(visit: &Side<'_>, other: &Side<'_>, config: &ChangesConfig) -> Vec<Differing> {
    let mut changed: Vec<[f32; 3]> = Vec::new();
    let mut unknown: Vec<[f32; 3]> = Vec::new();
    for point in visit.surfaces.points().iter().filter(|point| !other.surfaces.is_near(point)) {
        let (free, occupied) = other.evidence(point, config);
        let is_free =
            free >= config.free_looks_min && free as f64 >= config.free_share_min * (free + occupied) as f64;
        if is_free {
            let (free, occupied) = visit.evidence(point, config);
            let is_moving = free as f64 > config.moving_share * (free + occupied) as f64;
            if !is_moving {
                changed.push(*point);
            }
        } else {
            unknown.push(*point);
        }
    }
    let groups =
        clusters(&changed, config.gap_m as f32).into_iter().filter(|group| group.len() >= config.points_min);
    groups.filter_map(|group| object(&group, &changed, &unknown, [visit, other], config)).collect()
}

/// The object of a group of changed points; none if it is too small.
fn object(
    group: &[usize],
    changed: &[[f32; 3]],
    unknown: &[[f32; 3]],
    sides: [&Side<'_>; 2],
    config: &ChangesConfig,
) -> Option<Differing> {
    let mut points: Vec<[f32; 3]> = group.iter().map(|place| changed[*place]).collect();
    let core = UprightBox::around(&points, &config.box_fit)?;
    points.extend(
        unknown.iter().filter(|point| core.holds(&Vector3::from(point.map(f64::from)), config.grow_m)),
    );
    let place = UprightBox::around(&points, &config.box_fit)?;
    let mut sorted = place.size_m;
    sorted.sort_by(f64::total_cmp);
    if sorted[1] < config.size_min_m {
        return None;
    }
    let ground_m = ground_below(&place, sides, config);
    let stands = ground_m.filter(|ground_m| place.bottom_m() - ground_m <= config.stands_within_m);
    let place = stands.map_or(place, |ground_m| place.down_to(ground_m));
    let [own, met] = sides.map(|side| penetration(&place, side.visit, config));
    let evidence = evidence_of_absence(own, met, config);
    if evidence < config.evidence_min {
        return None;
    }
    let confidence = 1.0 / (1.0 + (-evidence).exp());
    Some(Differing { place, points, confidence })
}

/// Height of the level surface below a box, metres: the most common one of the points round it and below. Linear in the points of both visits.
fn ground_below(place: &UprightBox, sides: [&Side<'_>; 2], config: &ChangesConfig) -> Option<f64> {
    let reach_m = place.size_m[0] / 2.0 + config.ground_reach_m;
    let bottom_m = place.bottom_m();
    let (lowest_m, highest_m) = (bottom_m - config.stands_within_m, bottom_m + config.ground_bin_m);
    let mut bins: BTreeMap<i64, (usize, f64)> = BTreeMap::new();
    for point in sides.into_iter().flat_map(|side| side.surfaces.points()) {
        let at = Vector3::from(point.map(f64::from));
        if (lowest_m..=highest_m).contains(&at.z) && (at - place.centre_m).xy().norm() <= reach_m {
            let bin = bins.entry((at.z / config.ground_bin_m).floor() as i64).or_default();
            *bin = (bin.0 + 1, bin.1 + at.z);
        }
    }
    let (count, sum) = bins.into_values().max_by_key(|(count, _)| *count)?;
    (count >= config.ground_points_min).then(|| sum / count as f64)
}

#[cfg(test)]
#[path = "detect_tests.rs"]
mod tests;
