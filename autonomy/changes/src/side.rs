//! A visit, prepared for questions: its surfaces, its rays, and the ground below a place.

use crate::join::Join;
use crate::ray_image::{PassingRays, RayImage};
use crate::surfaces::{SurfaceTolerance, Surfaces};
use crate::{ChangesConfig, UprightBox, Visit};
use geometry::Vector3;
use std::collections::BTreeMap;
use std::sync::OnceLock;

/// A visit, prepared for questions.
pub(crate) struct Side {
    /// What it saw.
    pub(crate) surfaces: Surfaces,
    /// Its rays.
    pub(crate) images: Vec<RayImage>,
}

impl Side {
    /// The visit, with its surfaces and rays. `O(n log n)`.
    pub(crate) fn new(visit: &Visit, tolerance: &SurfaceTolerance, config: &ChangesConfig) -> Self {
        let points = visit.points_within(config.min_range_m, config.max_range_m);
        Self {
            surfaces: Surfaces::new(points, tolerance.clone()),
            images: visit.views.iter().map(|view| RayImage::new(view, config)).collect(),
        }
    }

    /// The rays that passed each of these places closely, of as many views as are asked. Each half of the places for itself.
    pub(crate) fn passing(
        &self,
        places: &[ProbedPlace],
        join: &impl Join,
        config: &ChangesConfig,
    ) -> Vec<PassingRays> {
        halves(places, join, |places| self.passing_of_half(places, config))
    }

    fn passing_of_half(&self, places: &[ProbedPlace], config: &ChangesConfig) -> Vec<PassingRays> {
        let mut sums = vec![PassingRays::default(); places.len()];
        self.ask_views(places, config.ray_reach_m, config, |place, rays| {
            sums[place] += rays;
            rays.through + rays.ended > 0
        });
        sums
    }

    /// Whether what was at each of these places was there for a part of the visit only, such as a person: from most of the views that tell of the place, nearly all rays went through it. Views
    /// count, not rays, because a person who stands beside the robot for a moment meets more rays than all others; and nearly all rays of a view, because at the edge of a thing that stays
    /// half of them pass.
    pub(crate) fn was_passing(
        &self,
        places: &[ProbedPlace],
        join: &impl Join,
        config: &ChangesConfig,
    ) -> Vec<bool> {
        halves(places, join, |places| self.was_passing_of_half(places, config))
    }

    fn was_passing_of_half(&self, places: &[ProbedPlace], config: &ChangesConfig) -> Vec<bool> {
        let mut views = vec![(0_usize, 0_usize); places.len()];
        self.ask_views(places, config.own_ray_reach_m, config, |place, rays| {
            let PassingRays { through, ended, blocked } = rays;
            // Rays that ended nearer than the place: something stands in front of it, and rays past its edge do not see the place.
            let is_free = through >= config.min_free_rays
                && is_stray(ended + blocked, through + ended + blocked, config);
            let is_telling = is_free || ended > 0;
            views[place].0 += usize::from(is_free);
            views[place].1 += usize::from(is_telling);
            is_telling
        });
        let is_mostly = |(free, telling): (usize, usize)| free as f64 > config.moving_share * telling as f64;
        views.into_iter().map(is_mostly).collect()
    }

    /// Asks view after view for the rays that passed places within a distance, until [`ChangesConfig::enough_views`] have told of a place: `tells` takes the place and the rays, and answers whether they
    /// did. The order of the views is spread over the visit, so that those that are asked stand for all. View by view, because the rays of one view stay in the processor's cache: with the places in the
    /// outer loop this took two to three times as long. Linear in the places for each view, and in the rays towards those within [`ChangesConfig::max_range_m`].
    fn ask_views(
        &self,
        places: &[ProbedPlace],
        reach_m: f64,
        config: &ChangesConfig,
        mut tells: impl FnMut(usize, PassingRays) -> bool,
    ) {
        let mut open: Vec<(usize, usize)> = (0..places.len()).map(|place| (place, 0)).collect();
        for image in spread(&self.images) {
            open.retain_mut(|(place, told)| {
                let rays = image.passing(&places[*place].place, &|| places[*place].normal(), reach_m, config);
                *told += usize::from(tells(*place, rays));
                *told < config.enough_views
            });
        }
    }

    /// A place on a surface of this visit.
    pub(crate) fn probed(&self, place: &[f32; 3], config: &ChangesConfig) -> ProbedPlace<'_> {
        ProbedPlace {
            place: *place,
            surfaces: &self.surfaces,
            min_normal_points: config.min_normal_points,
            normal: OnceLock::new(),
        }
    }
}

/// The answers of both halves of the items, in their order.
fn halves<T: Sync, A: Send>(items: &[T], join: &impl Join, answer: impl Fn(&[T]) -> Vec<A> + Sync) -> Vec<A> {
    let (first, second) = items.split_at(items.len() / 2);
    let (mut answers, others) = join.join(|| answer(first), || answer(second));
    answers.extend(others);
    answers
}

/// All items in an order of which every part from the beginning is spread evenly over them: by their indices with the bits reversed.
fn spread<T>(items: &[T]) -> impl Iterator<Item = &T> {
    // One at least, because a shift by all bits is none.
    let bits = items.len().next_power_of_two().trailing_zeros().max(1);
    (0..1_u64 << bits).filter_map(move |index| items.get((index.reverse_bits() >> (64 - bits)) as usize))
}

/// A place of which rays are asked.
#[derive(Clone)]
pub(crate) struct ProbedPlace<'a> {
    /// Metres, map frame.
    place: [f32; 3],
    surfaces: &'a Surfaces,
    min_normal_points: f64,
    /// Computed when it is needed first: past most places that the other visit did not see, no ray went.
    normal: OnceLock<Option<[f32; 3]>>,
}

impl ProbedPlace<'_> {
    /// Unit normal of the surface there, if there are points enough.
    fn normal(&self) -> Option<[f32; 3]> {
        *self.normal.get_or_init(|| self.surfaces.normal(&self.place, self.min_normal_points))
    }
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
    let under = sides[1].surfaces.columns().around(place, 0.0).map(at).filter(|at| column.holds(at, 0.0));
    let around = sides
        .into_iter()
        .flat_map(|side| side.surfaces.columns().around(place, config.ground_reach_m))
        .map(at);
    // What stands in the footprint is no ground around it.
    let around =
        around.filter(|at| column.holds(at, config.ground_reach_m) && !column.holds(at, config.grow_m));
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
