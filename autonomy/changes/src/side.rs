//! A visit, prepared for questions: its surfaces, its rays, and the ground below a place.

use crate::join::Join;
use crate::ray_image::{PassingRays, RayImage, Sphere};
use crate::surfaces::{SurfaceTolerance, Surfaces};
use crate::{ChangesConfig, UprightBox, Visit};
use geometry::Vector3;
use points::hash::{CellKey, CellTable};
use std::cell::Cell;
use std::collections::BTreeMap;

/// Side of the cubes in which places are told together that no ray of a view reaches, metres. Chosen: as small as what stands beside a way, so that a view sees all of it or nothing of it; 0.5 m takes
/// the same time.
const BLOCK_M: f32 = 1.0;

/// A visit, prepared for questions.
pub(crate) struct Side {
    /// What it saw.
    pub(crate) surfaces: Surfaces,
    /// Its rays.
    pub(crate) images: Vec<RayImage>,
}

impl Side {
    /// The visit with its surfaces, and its rays as [`images`] gives them. `O(n log n)`.
    pub(crate) fn new(
        visit: &Visit,
        images: Vec<RayImage>,
        tolerance: &SurfaceTolerance,
        config: &ChangesConfig,
    ) -> Self {
        let points = visit.points_within(config.min_range_m, config.max_range_m);
        Self { surfaces: Surfaces::new(points, tolerance.clone()), images }
    }

    /// The rays that passed each of these places closely, of as many views as are asked. The places are on these surfaces.
    pub(crate) fn passing(
        &self,
        places: &[[f32; 3]],
        surfaces: &Surfaces,
        join: &impl Join,
        config: &ChangesConfig,
    ) -> Vec<PassingRays> {
        self.ask_views(places, surfaces, config.ray_reach_m, join, config, |sum: &mut PassingRays, rays| {
            *sum += rays;
            rays.through + rays.ended > 0
        })
    }

    /// Whether what was at each of these places was there for a part of the visit only, such as a person: from most of the views that tell of the place, nearly all rays went through it. Views
    /// count, not rays, because a person who stands beside the robot for a moment meets more rays than all others; and nearly all rays of a view, because at the edge of a thing that stays
    /// half of them pass.
    pub(crate) fn was_passing(
        &self,
        places: &[[f32; 3]],
        join: &impl Join,
        config: &ChangesConfig,
    ) -> Vec<bool> {
        let tells = |[free, telling]: &mut [u32; 2], rays: PassingRays| {
            let PassingRays { through, ended, blocked } = rays;
            // Rays that ended nearer than the place: something stands in front of it, and rays past its edge do not see the place.
            let is_free = through >= config.min_free_rays
                && is_stray(ended + blocked, through + ended + blocked, config);
            let is_telling = is_free || ended > 0;
            *free += u32::from(is_free);
            *telling += u32::from(is_telling);
            is_telling
        };
        let views = self.ask_views(places, &self.surfaces, config.own_ray_reach_m, join, config, tells);
        let is_mostly =
            |[free, telling]: [u32; 2]| f64::from(free) > config.moving_share * f64::from(telling);
        views.into_iter().map(is_mostly).collect()
    }

    /// Asks view after view for the rays that passed places within a distance, until [`ChangesConfig::enough_views`] have told of a place: `tells` adds rays to what is known of a place, and answers whether
    /// they tell of it. The order of the views is spread over the visit, so that those that are asked stand for all. View by view, because the rays of one view stay in the processor's cache: with the
    /// places in the outer loop this took two to three times as long. A view of which no ray reaches a block of places is not asked for each of them. Linear in the blocks for each view, and in the places
    /// and the rays towards those that it may tell of.
    fn ask_views<T: Clone + Default + Send>(
        &self,
        places: &[[f32; 3]],
        surfaces: &Surfaces,
        reach_m: f64,
        join: &impl Join,
        config: &ChangesConfig,
        tells: impl Fn(&mut T, PassingRays) -> bool + Sync,
    ) -> Vec<T> {
        let ask = |mut blocks: Vec<Block<T>>| {
            let mut closed: Vec<Question<T>> = Vec::new();
            for image in spread(&self.images) {
                for Block { sphere, open } in &mut blocks {
                    if image.is_out_of_sight(sphere, reach_m, config) {
                        continue;
                    }
                    open.retain_mut(|question| {
                        let known = Cell::new(question.normal);
                        let normal = || {
                            let of_place = || surfaces.normal(&question.place, config.min_normal_points);
                            let normal = known.get().unwrap_or_else(of_place);
                            known.set(Some(normal));
                            normal
                        };
                        let rays = image.passing(&question.place, &normal, reach_m, config);
                        question.normal = known.get();
                        if rays != PassingRays::default() {
                            question.views += usize::from(tells(&mut question.known, rays));
                        }
                        let is_open = question.views < config.enough_views;
                        if !is_open {
                            closed.push(question.clone());
                        }
                        is_open
                    });
                }
                blocks.retain(|block| !block.open.is_empty());
            }
            closed.extend(blocks.into_iter().flat_map(|block| block.open));
            closed
        };
        let [first, second] = blocks(places);
        let (first, second) = join.join(|| ask(first), || ask(second));
        let mut known = vec![T::default(); places.len()];
        for question in first.into_iter().chain(second) {
            known[question.index as usize] = question.known;
        }
        known
    }
}

/// The rays of a visit. Linear in its points.
pub(crate) fn images(visit: &Visit, config: &ChangesConfig) -> Vec<RayImage> {
    visit.views.iter().map(|view| RayImage::new(view, config)).collect()
}

/// Places near each other.
struct Block<T> {
    /// Around all of them.
    sphere: Sphere,
    /// Those of which more views have to tell.
    open: Vec<Question<T>>,
}

/// A place of which views are asked.
#[derive(Clone)]
struct Question<T> {
    index: u32,
    /// Metres, map frame. Here, so that the places of a block stand one after the other in memory.
    place: [f32; 3],
    /// Of the surface there, once it was asked for.
    normal: Option<Option<[f32; 3]>>,
    /// Views that told of it.
    views: usize,
    known: T,
}

/// Places in cubes of [`BLOCK_M`], of which every second one is in either half. Linear in the places.
fn blocks<T: Default>(places: &[[f32; 3]]) -> [Vec<Block<T>>; 2] {
    let mut table = CellTable::default();
    let mut blocks: Vec<Vec<Question<T>>> = Vec::new();
    for (index, place) in places.iter().enumerate() {
        let cell = CellKey::of_point(place, 1.0 / BLOCK_M);
        let (block, is_new) = table.get_or_insert(cell, blocks.len() as u32);
        if is_new {
            blocks.push(Vec::new());
        }
        let question =
            Question { index: index as u32, place: *place, normal: None, views: 0, known: T::default() };
        blocks[block as usize].push(question);
    }
    let mut halves = [Vec::new(), Vec::new()];
    for (number, open) in blocks.into_iter().enumerate() {
        let sphere = Sphere::around(open.iter().map(|question| &question.place));
        halves[number % 2].push(Block { sphere, open });
    }
    halves
}

/// All items in an order of which every part from the beginning is spread evenly over them: by their indices with the bits reversed.
fn spread<T>(items: &[T]) -> impl Iterator<Item = &T> {
    // One at least, because a shift by all bits is none.
    let bits = items.len().next_power_of_two().trailing_zeros().max(1);
    (0..1_u64 << bits).filter_map(move |index| items.get((index.reverse_bits() >> (64 - bits)) as usize))
}

/// Whether so few of the rays that tell of a place ended there that they did so by chance.
pub(crate) fn is_stray(ended: usize, telling: usize, config: &ChangesConfig) -> bool {
    ended as f64 <= config.stray_share * telling as f64
}

/// Height of the level surface below a box, metres, down to a distance below its lower end: the most common height of what the other visit saw in its place, or else of what both saw
/// around it. Linear in the points of both visits around.
pub(crate) fn ground_below(
    place: &UprightBox,
    down_to_m: f64,
    sides: [&Side; 2],
    config: &ChangesConfig,
) -> Option<f64> {
    let bottom_m = place.bottom_m();
    let heights_m = bottom_m - down_to_m..=bottom_m + config.ground_bin_m;
    // The footprint at all heights.
    let column = UprightBox { size_m: [place.size_m[0], place.size_m[1], f64::INFINITY], ..*place };
    let at = |point: &[f32; 3]| Vector3::from(point.map(f64::from));
    let [inside, within_reach, near] =
        [0.0, config.ground_reach_m, config.grow_m].map(|margin_m| column.holder(margin_m));
    let under = sides[1].surfaces.columns().around(place, 0.0).map(at).filter(inside);
    let around = sides
        .into_iter()
        .flat_map(|side| side.surfaces.columns().around(place, config.ground_reach_m))
        .map(at);
    // What stands in the footprint is no ground around it.
    let around = around.filter(|at| within_reach(at) && !near(at));
    most_common_height(under, &heights_m, config).or_else(|| most_common_height(around, &heights_m, config))
}

/// The most common height of points within a range, metres; none of too few points, and none if they do not lie at one height: the sides of a thing, or of a person who was there on the other
/// visit, are no ground.
fn most_common_height(
    points: impl Iterator<Item = Vector3>,
    heights_m: &std::ops::RangeInclusive<f64>,
    config: &ChangesConfig,
) -> Option<f64> {
    let mut bins: BTreeMap<i64, (usize, f64)> = BTreeMap::new();
    for at in points.filter(|at| heights_m.contains(&at.z)) {
        let bin = bins.entry((at.z / config.ground_bin_m).floor() as i64).or_default();
        *bin = (bin.0 + 1, bin.1 + at.z);
    }
    let (&at, &(count, sum)) = bins.iter().max_by_key(|(_, (count, _))| *count)?;
    let within = |bins_away: i64| -> usize {
        bins.range(at - bins_away..=at + bins_away).map(|(_, (count, _))| count).sum()
    };
    let reach = (config.level_reach_m / config.ground_bin_m).round() as i64;
    let is_level = within(1) as f64 >= config.min_level_share * within(reach) as f64;
    (count >= config.min_ground_points && is_level).then(|| sum / count as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::InTurn;
    use crate::room::{at, visit};

    #[test]
    fn the_first_views_of_an_order_are_spread_over_all_and_each_comes_once() {
        for count in [0, 1, 2, 5, 37, 64, 249] {
            let items: Vec<usize> = (0..count).collect();
            let order: Vec<usize> = spread(&items).copied().collect();
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, items);
            for first in 1..=count {
                let mut places = order[..first].to_vec();
                places.extend([count]);
                places.sort_unstable();
                // At worst half of the parts are halved already.
                let widest = places.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or(0);
                assert!(widest <= (4 * count).div_ceil(first), "{first} of {count}: {widest}");
            }
        }
    }

    #[test]
    fn blocks_of_places_are_told_the_same_as_each_place_by_itself() {
        let (gone, new) = (at(0.5, 0.5, [0.8, 0.5, 0.6], 0.2), at(3.0, 0.0, [0.4; 3], 0.7));
        let config = ChangesConfig { enough_views: 3, ..ChangesConfig::default() };
        let side = |boxes: &[UprightBox]| {
            let visit = visit(boxes, 5.0);
            Side::new(&visit, images(&visit, &config), &SurfaceTolerance::uniform(0.08), &config)
        };
        let (before, after) = (side(&[gone]), side(&[new]));
        let places: Vec<[f32; 3]> = before.surfaces.points().iter().step_by(7).copied().collect();
        let alone = |place: &[f32; 3]| {
            let normal = || before.surfaces.normal(place, config.min_normal_points);
            let mut sum = PassingRays::default();
            let mut views = 0;
            for image in spread(&after.images) {
                let rays = image.passing(place, &normal, config.ray_reach_m, &config);
                views += usize::from(rays.through + rays.ended > 0);
                sum += rays;
                if views == config.enough_views {
                    break;
                }
            }
            (sum.through, sum.ended)
        };
        let found = after.passing(&places, &before.surfaces, &InTurn, &config);
        let found: Vec<(usize, usize)> = found.iter().map(|rays| (rays.through, rays.ended)).collect();
        assert_eq!(found, places.iter().map(alone).collect::<Vec<_>>());
        assert!(found.iter().filter(|(through, _)| *through > 2).count() > 20);
        assert!(found.iter().filter(|(_, ended)| *ended > 2).count() > 200);
    }

    #[test]
    fn a_floor_is_ground_and_the_side_of_a_person_is_not() {
        let config = ChangesConfig::default();
        let height = |points: &[Vector3]| most_common_height(points.iter().copied(), &(-0.4..=1.0), &config);
        let at = |z: f64| Vector3::new(0.0, 0.0, z);
        let floor: Vec<Vector3> = (0..40).map(|index| at(0.02 + 0.0005 * f64::from(index))).collect();
        let side: Vec<Vector3> = (0..60).map(|index| at(0.4 + 0.01 * f64::from(index))).collect();
        assert!(height(&floor).is_some_and(|ground_m| (ground_m - 0.03).abs() < 0.01));
        assert_eq!(height(&side), None);
        assert!(height(&[floor.clone(), side].concat()).is_some_and(|ground_m| ground_m < 0.05));
        assert_eq!(height(&floor[..9]), None, "too few");
    }
}
