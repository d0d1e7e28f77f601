//! Random loose objects beside the round of a site, which are put, taken, moved and turned between two visits. What changed is truth for scorers only.

use crate::shape::Material;
use crate::site::{LooseObject, ObjectChange, SimulatedSite};
use geometry::{Rng, RngTree, Vector3};
use std::f64::consts::TAU;

/// Parameters of random loose objects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LooseObjectsConfig {
    /// Share of small objects: cubes of [`Self::small_side_m`]. Chosen: one fifth, so that most are of the size that has to be found (docs/benchmarks/changes.md).
    pub small_share: f64,
    /// Sides of a small object, metres. Chosen: the smallest thing that the comparison is asked for (docs/benchmarks/changes.md).
    pub small_side_m: f64,
    /// Least and greatest length of the others, metres. Their width is at least 0.3 m too, and at most their length. Chosen: from a bucket to a pallet.
    pub length_m: [f64; 2],
    /// Least and greatest height of the others, metres. Chosen: from a bucket to a cabinet on wheels.
    pub height_m: [f64; 2],
    /// Least and greatest distance of an object's side from the nearest route, metres. Chosen: the nearer one leaves room for the robot (0.38 m); farther away, few rays
    /// meet a small object.
    pub beside_route_m: [f64; 2],
    /// Distance of an object's side from the paths of people and from everything else, metres. Chosen: objects stay apart as single things, and people do not walk into
    /// them.
    pub clearance_m: f64,
    /// Points of the round, 2 m apart, from which an object is seen at least: nobody can find what is hidden. Chosen: 4 m of walk.
    pub min_viewpoints: usize,
    /// Height of those points above the floor, metres: the LiDAR of the simulated robot.
    pub viewpoint_height_m: f64,
    /// A moved object stands at least this far from where it stood, metres. Chosen: more than twice the distance within which a change counts as the same (0.3 m).
    pub min_move_m: f64,
    /// Least and greatest angle by which an object is turned, radians. Chosen: from 29 to 63 degrees, so that the sides do not come to lie as before.
    pub turn_rad: [f64; 2],
    /// Places that are tried for an object. Chosen: it bounds the time at crowded sites; what finds no place is left out.
    pub max_tries: usize,
}

impl Default for LooseObjectsConfig {
    fn default() -> Self {
        Self {
            small_share: 0.2,
            small_side_m: 0.15,
            length_m: [0.3, 1.2],
            height_m: [0.3, 1.4],
            beside_route_m: [0.6, 6.0],
            clearance_m: 0.25,
            min_viewpoints: 3,
            viewpoint_height_m: 0.7,
            min_move_m: 1.0,
            turn_rad: [0.5, 1.1],
            max_tries: 2_000,
        }
    }
}

/// Distance between the points of a route that objects keep clear of, metres.
const ROUTE_STEP_M: f64 = 0.2;
/// Steps of the walk between two viewpoints: 2 m.
const STEPS_OF_VIEWPOINT: usize = 10;
/// Greatest step between two points of a route, metres: a stair.
const MAX_STEP_M: f64 = 0.4;
/// Greatest distance from which an object counts as seen, metres.
const SEEN_WITHIN_M: f64 = 10.0;
/// Most unevenness of the floor under an object, metres.
const FLAT_M: f64 = 0.02;

impl SimulatedSite {
    /// The site with further loose objects beside its round, as many of `count` as find a place. The same seed gives the same objects.
    pub fn with_loose_objects(&self, seed: u64, count: usize, config: &LooseObjectsConfig) -> Self {
        let mut rng = RngTree::new(seed).child("loose objects").rng();
        let places = RoutePoints::new(self);
        let mut site = self.clone();
        for _ in 0..count {
            let object = draw_object(&mut rng, config);
            let placed = site.place(object, &places, &mut rng, config, |_| true);
            site = placed.map_or(site.clone(), |object| site.with_changes(&[ObjectChange::Put(object)]));
        }
        site
    }

    /// Random changes of loose objects beside the round: some put, some taken, some moved, some turned; at most `count`. Each object changes once. The same seed gives the same
    /// changes.
    pub fn random_changes(&self, seed: u64, count: usize, config: &LooseObjectsConfig) -> Vec<ObjectChange> {
        let mut rng = RngTree::new(seed).child("changes between visits").rng();
        let places = RoutePoints::new(self);
        let (mut site, mut changes) = (self.clone(), Vec::new());
        let mut unchanged = self.loose_objects().to_vec();
        for _ in 0..count {
            let kind = rng.uniform();
            let chosen = (kind >= 0.3 && !unchanged.is_empty()).then(|| {
                let place = (rng.uniform() * unchanged.len() as f64) as usize;
                unchanged.remove(place.min(unchanged.len() - 1))
            });
            let change = match chosen {
                None => {
                    let object = draw_object(&mut rng, config);
                    site.place(object, &places, &mut rng, config, |_| true).map(ObjectChange::Put)
                }
                Some(from) if kind < 0.6 => Some(ObjectChange::Taken(from)),
                Some(from) if kind < 0.9 => {
                    let is_elsewhere =
                        |to: &LooseObject| (to.foot - from.foot).norm() >= config.min_move_m + from.reach_m();
                    let to = site.place(from, &places, &mut rng, config, is_elsewhere);
                    to.map(|to| ObjectChange::Moved { from, to })
                }
                Some(from) => {
                    let turn_rad = rng.range(config.turn_rad[0], config.turn_rad[1]);
                    let to = LooseObject { yaw_rad: from.yaw_rad + turn_rad, ..from };
                    Some(ObjectChange::Turned { from, to })
                }
            };
            if let Some(change) = change {
                site = site.with_changes(&[change]);
                changes.push(change);
            }
        }
        changes
    }

    /// The object at a random free place with a random heading; none if none was found.
    fn place(
        &self,
        object: LooseObject,
        places: &RoutePoints,
        rng: &mut Rng,
        config: &LooseObjectsConfig,
        is_wanted: impl Fn(&LooseObject) -> bool,
    ) -> Option<LooseObject> {
        let [nearest_m, farthest_m] = config.beside_route_m.map(|beside_m| beside_m + object.reach_m());
        for _ in 0..config.max_tries {
            let at = places.points.get((rng.uniform() * places.points.len() as f64) as usize)?;
            let (away_m, toward) = (rng.range(nearest_m, farthest_m), rng.range(0.0, TAU));
            let beside = at + Vector3::new(toward.cos(), toward.sin(), 0.0) * away_m;
            let yaw_rad = rng.range(0.0, TAU);
            let Some(foot) = self.floor_below(&beside) else { continue };
            let placed = LooseObject { foot, yaw_rad, ..object };
            let is_beside = places.distance_m(&foot) >= nearest_m;
            if is_beside
                && is_wanted(&placed)
                && self.is_place_free(&placed, config)
                && self.is_seen(&placed, places, config)
            {
                return Some(placed);
            }
        }
        None
    }

    /// The floor at most one step below or above a point; none where there is none.
    pub(crate) fn floor_below(&self, point: &Vector3) -> Option<Vector3> {
        let from = point + Vector3::z() * MAX_STEP_M;
        let (down_m, _) = self.cast_ray(&from, &-Vector3::z(), 2.0 * MAX_STEP_M)?;
        Some(from - Vector3::z() * down_m)
    }

    /// Whether an object stands on a flat floor inside the site, away from everything else and from the paths of people.
    fn is_place_free(&self, object: &LooseObject, config: &LooseObjectsConfig) -> bool {
        let reach_m = object.reach_m() + config.clearance_m;
        let is_flat = (0..4).all(|corner| {
            let toward = f64::from(corner) * TAU / 4.0 + object.yaw_rad;
            let at = object.foot + Vector3::new(toward.cos(), toward.sin(), 0.0) * object.reach_m();
            self.floor_below(&at).is_some_and(|floor| (floor.z - object.foot.z).abs() <= FLAT_M)
        });
        let heights = (1..).map(|step| 0.15 * f64::from(step)).take_while(|z| *z < object.size_m[2] + 0.3);
        let is_clear = |z: f64| {
            let at = object.foot + Vector3::z() * z;
            self.distance(&at, reach_m).is_none_or(|distance| distance >= reach_m.min(z - FLAT_M))
        };
        let is_path_free = self.pedestrian_paths().iter().all(|path| {
            let next = path.iter().cycle().skip(1);
            path.iter().zip(next).all(|(a, b)| {
                let along = b - a;
                let share = ((object.foot - a).dot(&along) / along.norm_squared().max(1e-9)).clamp(0.0, 1.0);
                let nearest = a + along * share - object.foot;
                nearest.xy().norm() >= reach_m + config.clearance_m || nearest.z.abs() > 2.0
            })
        });
        is_flat && self.is_inside(&object.foot) && heights.into_iter().all(is_clear) && is_path_free
    }

    /// Whether an object is seen from enough points of the round.
    fn is_seen(&self, object: &LooseObject, places: &RoutePoints, config: &LooseObjectsConfig) -> bool {
        let is_seen_from = |point: &&Vector3| {
            let eye = *point + Vector3::z() * config.viewpoint_height_m;
            let offset = object.middle() - eye;
            let distance_m = offset.norm();
            distance_m < SEEN_WITHIN_M
                && self
                    .cast_ray(&eye, &(offset / distance_m), distance_m)
                    .is_none_or(|(range_m, _)| range_m >= distance_m - object.reach_m())
        };
        let viewpoints = places.points.iter().step_by(STEPS_OF_VIEWPOINT);
        viewpoints.filter(is_seen_from).count() >= config.min_viewpoints
    }
}

/// Points on the floor along the round.
pub(crate) struct RoutePoints {
    pub(crate) points: Vec<Vector3>,
}

impl RoutePoints {
    pub(crate) fn new(site: &SimulatedSite) -> Self {
        let mut points = Vec::new();
        let Some(route) = site.route("round") else { return Self { points } };
        let start = route.start.position;
        let mut at = Vector3::new(start.x, start.y, start.z);
        for to in &route.waypoints {
            let along = Vector3::new(to[0] - at.x, to[1] - at.y, 0.0);
            let steps = (along.norm() / ROUTE_STEP_M).ceil().max(1.0) as usize;
            for _ in 0..steps {
                at += along / steps as f64;
                at.z = site.floor_below(&at).map_or(at.z, |floor| floor.z);
                points.push(at);
            }
        }
        Self { points }
    }

    /// Horizontal distance from a point to the nearest one on its floor, metres.
    pub(crate) fn distance_m(&self, point: &Vector3) -> f64 {
        let on_floor = self.points.iter().filter(|at| (at.z - point.z).abs() < 2.0);
        on_floor.map(|at| (at - point).xy().norm()).fold(f64::INFINITY, f64::min)
    }
}

/// A random object, without a place.
fn draw_object(rng: &mut Rng, config: &LooseObjectsConfig) -> LooseObject {
    let materials = [Material::Cardboard, Material::Wood, Material::Steel, Material::BluePaint];
    let material = materials[((rng.uniform() * 4.0) as usize).min(3)];
    let (is_small, length_m) =
        (rng.uniform() < config.small_share, rng.range(config.length_m[0], config.length_m[1]));
    let width_m = rng.range(config.length_m[0], length_m.max(config.length_m[0] + 1e-6));
    let height_m = rng.range(config.height_m[0], config.height_m[1]);
    let size_m = if is_small { [config.small_side_m; 3] } else { [length_m, width_m, height_m] };
    LooseObject { foot: Vector3::zeros(), size_m, yaw_rad: 0.0, material }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::site::SiteName;

    #[test]
    fn random_changes_are_the_same_for_a_seed_and_stand_free_beside_the_round() {
        let config = LooseObjectsConfig::default();
        let site = SimulatedSite::new(SiteName::B1).with_loose_objects(3, 6, &config);
        assert_eq!(site.loose_objects().len(), 6);
        let changes = site.random_changes(4, 5, &config);
        assert_eq!(changes, site.random_changes(4, 5, &config));
        assert_ne!(changes, site.random_changes(5, 5, &config));
        assert_eq!(changes.len(), 5);
        let after = site.with_changes(&changes);
        let route = RoutePoints::new(&after);
        for object in after.loose_objects() {
            assert!(route.distance_m(&object.foot) >= config.beside_route_m[0], "{object:?}");
            let above = object.foot + Vector3::z() * (object.size_m[2] + 0.1);
            let (down_m, _) = after.cast_ray(&above, &-Vector3::z(), 1.0).expect("its upper side");
            assert!((down_m - 0.1).abs() < 1e-3, "{object:?} {down_m}");
        }
    }

    #[test]
    fn scripted_changes_put_take_and_move() {
        let object = LooseObject {
            foot: Vector3::new(5.0, 5.0, 0.0),
            size_m: [0.6, 0.4, 1.0],
            yaw_rad: 0.3,
            material: Material::Wood,
        };
        let to = LooseObject { foot: Vector3::new(7.0, 5.0, 0.0), ..object };
        let site = SimulatedSite::new(SiteName::Twins);
        let bare = site.solids().len();
        let put = site.with_changes(&[ObjectChange::Put(object)]);
        assert_eq!((put.loose_objects(), put.solids().len()), ([object].as_slice(), bare + 1));
        let moved = put.with_changes(&[ObjectChange::Moved { from: object, to }]);
        assert_eq!(moved.loose_objects(), [to]);
        assert_eq!(moved.with_changes(&[ObjectChange::Taken(to)]).solids().len(), bare);
    }
}
