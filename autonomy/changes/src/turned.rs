//! Things that were turned where they stand, or moved by less than their size: most of their surface is where a surface was before, so that only parts of them differ.

use crate::clusters::clusters;
use crate::heading::{Evidence, SideNoise, evidence_of_heading, evidence_of_shape};
use crate::join::{Join, alternately};
use crate::moves::is_same_size;
use crate::passing::Passing;
use crate::side::{Side, ground_below};
use crate::standing::{StandingThing, standing_things};
use crate::{ChangesConfig, UprightBox};
use geometry::Vector3;
use std::f64::consts::{FRAC_PI_2, PI};

/// A thing that stands otherwise than before.
pub(crate) struct TurnedThing {
    pub(crate) from: UprightBox,
    pub(crate) place: UprightBox,
    /// Its points in the later visit.
    pub(crate) points: Vec<[f32; 3]>,
}

/// The thing of which these parts are new and gone: groups of points of the later and of the earlier visit that the other one looked through. It stands free in both visits, and is
/// as large as before. `sides` are the earlier and the later visit. Linear in the points around.
pub(crate) fn find_turned(
    new_part: &[[f32; 3]],
    gone_parts: &[Vec<[f32; 3]>],
    sides: [&Side; 2],
    config: &ChangesConfig,
) -> Option<TurnedThing> {
    let part = UprightBox::around(new_part, &config.box_fit)?;
    let (points, place) = standing_free(&part, new_part, sides, 1, config)?;
    let is_of_thing = |gone: &&Vec<[f32; 3]>| {
        let near = gone.iter().filter(|point| place.holds(&at(point), config.grow_m)).count();
        2 * near > gone.len()
    };
    let gone_part = gone_parts.iter().filter(is_of_thing).max_by_key(|gone| gone.len())?;
    let (_, from) = standing_free(&place, gone_part, sides, 0, config)?;
    let is_same = is_same_size(&from, &place, config.turned_size_share, config.same_size_m);
    (is_same && stands_otherwise(&from, &place, config)).then_some(TurnedThing { from, place, points })
}

/// Things that have another heading than before, though no part of them may differ by [`ChangesConfig::same_surface_m`]: what stands free in the later visit is looked at in both. Linear in the cells of the
/// later visit, and in the points around each thing.
pub(crate) fn find_turned_as_a_whole(
    sides: [&Side; 2],
    join: &impl Join,
    config: &ChangesConfig,
) -> Vec<TurnedThing> {
    let things = standing_things(&sides[1].surfaces, config);
    let turned = alternately(&things, join, |thing| turned_as_a_whole(thing, sides, config));
    turned.into_iter().flatten().collect()
}

/// The thing of these points of the later visit, if it was turned: it stands free in both visits, is as large as before, and the points of each visit are much likelier on the sides of a box with their own heading
/// than on those of one with the other heading.
fn turned_as_a_whole(
    thing: &StandingThing,
    sides: [&Side; 2],
    config: &ChangesConfig,
) -> Option<TurnedThing> {
    // Most things have their heading of before, which few points tell.
    let place = UprightBox::around(&thing.points, &config.turned_first_fit)?;
    let holds = place.holder(config.turned_gap_m);
    let above_m = thing.ground_m + config.standing_clearance_m;
    let is_of_thing = |point: &&[f32; 3]| f64::from(point[2]) >= above_m && holds(&at(point));
    let around = sides[0].surfaces.columns().around(&place, config.turned_gap_m);
    let before: Vec<[f32; 3]> = around.filter(is_of_thing).copied().collect();
    if !is_turned(&UprightBox::around(&before, &config.turned_first_fit)?, &place, config) {
        return None;
    }
    let (before, from) = connected(&place, &before, above_m, sides[0], config)?;
    let (after, place) = connected(&place, &thing.points, above_m, sides[1], config)?;
    let [from, place] = [from, place].map(|place| place.down_to(thing.ground_m));
    let noise = SideNoise {
        deviation_m: config.range_noise_m.hypot(config.resolution_m),
        most_deviations: config.same_surface_deviations,
        stray_share: config.turned_stray_share,
    };
    let is_clear = |points: &[[f32; 3]], own: &UprightBox, other: &UprightBox| {
        let headings = [own.yaw_rad, other.yaw_rad];
        let Evidence { log_ratio, points: used } =
            evidence_of_heading(points, headings, &noise, &config.box_fit);
        let shape = evidence_of_shape(points, own.yaw_rad, &noise, &config.box_fit);
        log_ratio >= config.min_evidence
            && log_ratio >= config.min_turn_evidence_of_point * used as f64
            && shape.corners >= config.min_corner_evidence
            && shape.on_sides >= config.min_side_share
    };
    let is_turned = is_same_size(&from, &place, config.turned_size_share, config.same_size_m)
        && is_turned(&from, &place, config)
        // The upper part of a higher thing was not looked at.
        && from.size_m[2].max(place.size_m[2]) < config.standing_height_m
        && is_clear(&before, &from, &place)
        && is_clear(&after, &place, &from)
        && stayed(&before, sides[0], config)
        && stayed(&after, sides[1], config);
    is_turned.then_some(TurnedThing { from, place, points: after })
}

/// Whether most points of a thing were there all the time of its visit, as those of a person are not.
fn stayed(points: &[[f32; 3]], visit: &Side, config: &ChangesConfig) -> bool {
    let step = points.len().div_ceil(config.max_asked_points).max(1);
    let asked: Vec<[f32; 3]> = points.iter().step_by(step).copied().collect();
    let passing = Passing::new(visit, config).at(&asked).filter(|is_passing| *is_passing).count();
    2 * passing < asked.len()
}

/// The points of one of the visits that are connected with a part of it, above the ground, and their box down to the ground; none if they reach farther than a loose thing does.
fn standing_free(
    around: &UprightBox,
    part: &[[f32; 3]],
    sides: [&Side; 2],
    visit: usize,
    config: &ChangesConfig,
) -> Option<(Vec<[f32; 3]>, UprightBox)> {
    let ground_m = ground_below(around, config.ground_depth_m, sides, config)?;
    let (thing, place) = connected(around, part, ground_m + config.ground_clearance_m, sides[visit], config)?;
    Some((thing, place.down_to(ground_m)))
}

/// The points of a visit above a height, metres, that are connected with a part of it, and their box; none if they reach farther than a loose thing does.
fn connected(
    around: &UprightBox,
    part: &[[f32; 3]],
    above_m: f64,
    visit: &Side,
    config: &ChangesConfig,
) -> Option<(Vec<[f32; 3]>, UprightBox)> {
    let reach_m = config.turned_reach_m;
    let is_around =
        |point: &&[f32; 3]| f64::from(point[2]) > above_m && (at(point) - around.centre_m).norm() <= reach_m;
    let points: Vec<[f32; 3]> =
        visit.surfaces.columns().around(around, reach_m).filter(is_around).copied().collect();
    let bits = |point: &[f32; 3]| point.map(f32::to_bits);
    let of_part: std::collections::BTreeSet<[u32; 3]> = part.iter().map(bits).collect();
    let groups = clusters(&points, config.turned_gap_m as f32);
    let of_group =
        |group: &Vec<usize>| group.iter().filter(|place| of_part.contains(&bits(&points[**place]))).count();
    let group = groups.iter().max_by_key(|group| of_group(group)).filter(|group| of_group(group) > 0)?;
    let thing: Vec<[f32; 3]> = group.iter().map(|place| points[*place]).collect();
    let is_free =
        thing.iter().all(|point| (at(point) - around.centre_m).norm() < reach_m - config.turned_gap_m);
    if !is_free || thing.len() < config.min_points {
        return None;
    }
    let place = UprightBox::around(&thing, &config.box_fit)?;
    Some((thing, place))
}

/// Whether a box has another heading or place than before, by more than noise.
fn stands_otherwise(from: &UprightBox, to: &UprightBox, config: &ChangesConfig) -> bool {
    is_turned(from, to, config) || (to.centre_m - from.centre_m).xy().norm() >= config.min_shift_m
}

/// Whether a box has another heading than before, by more than noise.
fn is_turned(from: &UprightBox, to: &UprightBox, config: &ChangesConfig) -> bool {
    let [length, width, _] = to.size_m;
    // A square looks the same after a quarter turn, other boxes after half a turn.
    let period_rad = if length - width <= config.same_size_m { FRAC_PI_2 } else { PI };
    let turn_rad = (to.yaw_rad - from.yaw_rad).rem_euclid(period_rad);
    let turn_rad = turn_rad.min(period_rad - turn_rad);
    turn_rad >= config.min_turn_rad
}

fn at(point: &[f32; 3]) -> Vector3 {
    Vector3::from(point.map(f64::from))
}
