//! What a visit has that another one does not have.

use crate::clusters::clusters;
use crate::columns::Columns;
use crate::join::{Join, alternately};
use crate::passing::Passing;
use crate::penetration::{
    evidence_of_absence, explains_absence, penetration, was_looked_through, was_there, without_passing,
};
use crate::ray_image::PassingRays;
use crate::side::{Side, ground_below};
use crate::{ChangesConfig, UprightBox};
use geometry::Vector3;
use points::hash::{CellKey, CellTable};
use std::collections::BTreeSet;

/// An object of one visit that the other one does not have.
pub(crate) struct UnmatchedObject {
    pub(crate) place: UprightBox,
    pub(crate) points: Vec<[f32; 3]>,
    pub(crate) confidence: f64,
}

/// A visit that is compared with another one.
pub(crate) struct Compared<'a> {
    visit: &'a Side,
    other: &'a Side,
    /// Of each point of the visit, whether the other one has a surface near it.
    pub(crate) are_near: Vec<bool>,
}

impl<'a> Compared<'a> {
    /// Linear in the points of the visit, and in those of the other one around them.
    pub(crate) fn new([visit, other]: [&'a Side; 2], join: &impl Join) -> Self {
        Self { visit, other, are_near: other.surfaces.are_near(&visit.surfaces, join) }
    }

    fn sides(&self) -> [&'a Side; 2] {
        [self.visit, self.other]
    }

    /// The points in a box, metres larger on all sides, each with whether the other visit has a surface near it. Linear in the points around.
    fn inside(&self, place: &UprightBox, margin_m: f64) -> impl Iterator<Item = ([f32; 3], bool)> {
        let holds = place.holder(margin_m);
        let points = self.visit.surfaces.points();
        let around = self.visit.surfaces.columns().ranges_around(place, margin_m).flatten();
        around.map(|index| (points[index], self.are_near[index])).filter(move |(point, _)| holds(&at(point)))
    }
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
/// place that it looked through, something was there for a part of its own visit only, or all the time.
fn candidates(compared: &Compared, join: &impl Join, config: &ChangesConfig) -> CandidatePoints {
    let Compared { visit, other, are_near } = compared;
    let mut cells = CellTable::default();
    let mut places: Vec<[f32; 3]> = Vec::new();
    let mut of_places: Vec<(u32, [f32; 3])> = Vec::new();
    let without = visit.surfaces.points().iter().zip(are_near).filter(|(_, is_near)| !**is_near);
    for (point, _) in without {
        let cell = CellKey::of_point(point, 1.0 / config.candidate_cell_m as f32);
        let (place, is_new) = cells.get_or_insert(cell, places.len() as u32);
        if is_new {
            places.push(*point);
        }
        of_places.push((place, *point));
    }

    let is_free = |rays: PassingRays| {
        rays.through >= config.min_free_rays
            && rays.through as f64 >= config.min_free_share * (rays.through + rays.ended) as f64
    };
    let passing = other.passing(&places, &visit.surfaces, join, config);
    let is_free: Vec<bool> = passing.into_iter().map(is_free).collect();
    let free = places.iter().zip(&is_free).filter(|(_, is_free)| **is_free);
    let free: Vec<[f32; 3]> = free.map(|(place, _)| *place).collect();
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
pub(crate) struct Differences {
    pub(crate) objects: Vec<UnmatchedObject>,
    /// Groups of points of things of which the other visit has a part too.
    pub(crate) parts: Vec<Vec<[f32; 3]>>,
}

/// The differences of a visit from the other one.
pub(crate) fn differing(compared: &Compared, join: &impl Join, config: &ChangesConfig) -> Differences {
    let CandidatePoints { mut changed, unknown } = candidates(compared, join, config);
    let hidden = hidden_by_passing(&changed, compared, join, config);
    changed.extend(hidden);
    let mut groups = clusters(&changed, config.gap_m as f32);
    groups.retain(|group| group.len() >= config.min_points);
    groups.sort_by_key(|group| std::cmp::Reverse(group.len()));
    let points_of =
        |group: &Vec<usize>| -> Vec<[f32; 3]> { group.iter().map(|place| changed[*place]).collect() };
    let cores: Vec<Vec<[f32; 3]>> = groups.iter().map(points_of).collect();
    let around = Around { changed: Columns::new(changed.iter().copied()), unknown: Columns::new(unknown) };
    // Large ones and small ones for both halves. A few of them are parts of others, and are looked at for nothing.
    let of_groups = alternately(&cores, join, |core| object(core, &around, compared, config));
    let mut found = Differences::default();
    for (core, of_group) in cores.into_iter().zip(of_groups) {
        let Some(of_group) = of_group else { continue };
        // A part of an object that was grown to it already.
        let is_part = |point: &&[f32; 3]| {
            found.objects.iter().any(|object| object.place.holds(&at(point), config.same_surface_m))
        };
        if 2 * core.iter().filter(is_part).count() > core.len() {
            continue;
        }
        match of_group {
            Group::Object(object) => found.objects.push(object),
            Group::Part => found.parts.push(core),
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
fn object(core: &[[f32; 3]], around: &Around, compared: &Compared, config: &ChangesConfig) -> Option<Group> {
    let sides = compared.sides();
    let (mut points, place) = grown(core, around, sides, config)?;
    let mut sorted = place.size_m;
    sorted.sort_by(f64::total_cmp);
    let (standing, mut stands) = down_to_ground(place, sides, config);
    if sorted[1] < config.min_size_m || points.len().min(core.len()) < min_points(&place, stands, config) {
        return None;
    }
    let mut place = standing;
    if same_share(&place, compared, config) > config.max_same_share {
        let (kept, own) = above_ground(core, sides, config)?;
        if points.len() as f64 > (1.0 + config.stray_growth_share) * kept.len() as f64 {
            return Some(Group::Part);
        }
        points = kept;
        (place, stands) = down_to_ground(own, sides, config);
        let is_thin = place.size_m[0].min(place.size_m[1]) < config.min_size_m;
        if !stands || is_thin || same_share(&place, compared, config) > config.max_same_share {
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
        let (in_column, near) = (column.holder(config.same_surface_m), place.holder(config.grow_m));
        let is_stacked = |point: &&[f32; 3]| in_column(&at(point));
        let is_near = |point: &&[f32; 3]| near(&at(point)) || is_stacked(point);
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
    let holds = place.holder(0.0);
    let cells = |columns: &Columns| -> BTreeSet<CellKey> {
        let inside = columns.around(place, 0.0).filter(|point| holds(&at(point)));
        inside.map(|point| CellKey::of_point(point, 1.0 / config.known_cell_m as f32)).collect()
    };
    let (changed, unknown) = (cells(&around.changed), cells(&around.unknown));
    let all = changed.union(&unknown).count();
    changed.len() as f64 / all.max(1) as f64
}

/// Share of the points in a box that have a surface of the other visit near them, without those so low that the ground is near them: a thing is gone as a whole. Linear in the points around.
fn same_share(place: &UprightBox, compared: &Compared, config: &ChangesConfig) -> f64 {
    let middle: [f32; 3] = place.centre_m.map(|at| at as f32).into();
    let noise_m = config.same_surface_deviations * config.range_noise_m;
    // The ground is near what is lower.
    let above_m = place.bottom_m() + f64::from(compared.other.surfaces.tolerance_m(&middle)) + noise_m;
    let (mut inside, mut same) = (0_usize, Vec::new());
    for (point, is_near) in compared.inside(place, 0.0).filter(|(point, _)| f64::from(point[2]) > above_m) {
        inside += 1;
        same.extend(is_near.then_some(point));
    }
    let share = same.len() as f64 / inside.max(1) as f64;
    if share <= config.max_same_share {
        return share;
    }
    let step = same.len().div_ceil(config.max_asked_points);
    let asked: Vec<[f32; 3]> = same.into_iter().step_by(step).collect();
    let staying = Passing::new(compared.other, config).at(&asked).filter(|is_passing| !is_passing).count();
    share * staying as f64 / asked.len() as f64
}

/// Points near changed ones that have a surface of the other visit near them for the only reason that something passed there during that visit, such as a person: they join what is left of
/// a thing on both sides of it. For each group of changed points linear in the points around, in each of [`ChangesConfig::grow_rounds`] rounds.
fn hidden_by_passing(
    changed: &[[f32; 3]],
    compared: &Compared,
    join: &impl Join,
    config: &ChangesConfig,
) -> Vec<[f32; 3]> {
    let mut groups = clusters(changed, config.gap_m as f32);
    groups.retain(|group| group.len() >= config.min_points_of_others);
    let of_groups = |first: usize| {
        let mut passing = Passing::new(compared.other, config);
        let mut found: BTreeSet<[u32; 3]> = BTreeSet::new();
        for group in groups.iter().skip(first).step_by(2) {
            let group = group.iter().map(|place| changed[*place]).collect();
            found.extend(hidden_near(group, &mut passing, compared, config));
        }
        found
    };
    // Every second group in either half, because groups beside each other are about as large.
    let (mut found, others) = join.join(|| of_groups(0), || of_groups(1));
    found.extend(others);
    found.into_iter().map(|bits| bits.map(f32::from_bits)).collect()
}

/// The same of one group: bits of the coordinates.
fn hidden_near(
    mut group: Vec<[f32; 3]>,
    passing: &mut Passing,
    compared: &Compared,
    config: &ChangesConfig,
) -> BTreeSet<[u32; 3]> {
    let mut found = BTreeSet::new();
    for _ in 0..config.grow_rounds {
        let Some(wide) = extent(&group, config.gap_m) else { break };
        let same = compared.inside(&wide, 0.0).filter(|(_, is_near)| *is_near);
        let same: Vec<[f32; 3]> = same.map(|(point, _)| point).collect();
        let known = group.len();
        let hidden = same.iter().zip(passing.at(&same)).filter(|(_, is_passing)| *is_passing);
        group.extend(hidden.map(|(point, _)| *point).filter(|point| found.insert(point.map(f32::to_bits))));
        if group.len() == known {
            break;
        }
    }
    found
}

/// The smallest box along the axes that reaches `margin_m` metres beyond all points; none of no points.
fn extent(points: &[[f32; 3]], margin_m: f64) -> Option<UprightBox> {
    let points = points.iter().map(at);
    let [least, most] =
        points.map(|at| [at, at]).reduce(|[least, most], [low, high]| [least.inf(&low), most.sup(&high)])?;
    let size = (most - least).add_scalar(2.0 * margin_m);
    Some(UprightBox { centre_m: (least + most) / 2.0, size_m: size.into(), yaw_rad: 0.0 })
}

fn at(point: &[f32; 3]) -> Vector3 {
    Vector3::from(point.map(f64::from))
}
