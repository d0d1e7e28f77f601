//! Properties that generated buildings have for every seed.

use super::ideal_blind;
use super::run;
use crate::site::generated::{BuildingLayout, Room, layout};
use crate::{RouteFollower, SimulatedSite, Simulator, SiteName};
use geometry::{RngTree, Vector3};
use std::sync::Arc;

/// Seeds whose buildings are checked as plans of solids.
const SEEDS: std::ops::Range<u64> = 0..60;
/// Distance between the points of a route that are checked, metres.
const STEP_M: f64 = 0.2;

/// The points of a route on flat floors, with their storey. The storey changes on the stairs.
fn flat_points(layout: &BuildingLayout, site: &SimulatedSite, route: &str) -> Vec<(Vector3, usize)> {
    let route = site.route(route).unwrap();
    let mut last = [route.start.position.x, route.start.position.y];
    let (mut storey, mut was_on_stairs) = (0, false);
    let mut points = Vec::new();
    for to in &route.waypoints {
        let steps = ((to[0] - last[0]).hypot(to[1] - last[1]) / STEP_M).ceil().max(1.0) as usize;
        for step in 0..=steps {
            let [x, y] = [0, 1].map(|axis| last[axis] + (to[axis] - last[axis]) * step as f64 / steps as f64);
            let is_on_stairs = layout.stairs.contains([x, y]);
            if was_on_stairs && !is_on_stairs {
                storey = 1 - storey;
            }
            was_on_stairs = is_on_stairs;
            if !is_on_stairs {
                points.push((Vector3::new(x, y, layout.floor(storey)), storey));
            }
        }
        last = *to;
    }
    points
}

fn generated(seed: u64) -> (BuildingLayout, SimulatedSite) {
    (layout(seed), SimulatedSite::new(SiteName::Generated(seed)))
}

#[test]
fn the_same_seed_gives_the_same_building_and_another_gives_another() {
    for seed in [0, 7, u64::MAX] {
        let [one, again, other] =
            [seed, seed, seed ^ 1].map(|seed| SimulatedSite::new(SiteName::Generated(seed)));
        assert_eq!(one.solids(), again.solids());
        assert_eq!(one.routes(), again.routes());
        assert_eq!(one.docks(), again.docks());
        assert!(one.solids() != other.solids());
    }
    let name = SiteName::Generated(7);
    assert_eq!(name.to_string(), "generated:7");
    assert_eq!("generated:7".parse(), Ok(name));
    let text = "generated:x".parse::<SiteName>().unwrap_err().to_string();
    assert!(text.contains("the seed after \"generated:\" is a whole number"), "{text}");
}

#[test]
fn the_robot_has_room_along_every_route() {
    for seed in SEEDS {
        let (layout, site) = generated(seed);
        for route in ["round", "short"] {
            for (point, _) in flat_points(&layout, &site, route) {
                assert!(site.has_room(&point), "seed {seed}, {route}: no room at {point}");
            }
        }
    }
}

#[test]
fn the_round_visits_every_room_and_begins_at_a_dock() {
    for seed in SEEDS {
        let (layout, site) = generated(seed);
        let points = flat_points(&layout, &site, "round");
        for room in &layout.rooms {
            let inner = room.rect.inset(1.0);
            let is_visited = |(point, storey): &(Vector3, usize)| {
                *storey == room.storey && inner.contains([point.x, point.y])
            };
            assert!(points.iter().any(is_visited), "seed {seed}: {room:?} is not visited");
        }
        for storey in [0, 1] {
            let short = flat_points(&layout, &site, "short");
            assert!(short.iter().any(|point| point.1 == storey), "seed {seed}: short misses floor {storey}");
        }
        for dock in site.docks() {
            let feet = geometry::vec_from_plain(dock.position);
            let front = feet + Vector3::new(dock.yaw.cos(), dock.yaw.sin(), 0.0) * 0.5;
            let near = points.iter().map(|(point, _)| (point - front).norm()).fold(f64::INFINITY, f64::min);
            assert!(near < 0.6, "seed {seed}: the dock at {feet} is {near} m from the round");
        }
        assert_eq!(site.routes()[0].start, site.start(), "seed {seed}");
    }
}

#[test]
fn rooms_of_a_floor_do_not_overlap_and_floors_lie_above_each_other() {
    for seed in SEEDS {
        let (layout, _) = generated(seed);
        assert!(layout.ceiling(&layout.rooms[0]) < layout.floor(1), "seed {seed}");
        assert!(layout.storey_height > 3.2 && layout.upper_height > 2.8, "seed {seed}");
        for storey in [0, 1] {
            let rooms: Vec<&Room> = layout.rooms.iter().filter(|room| room.storey == storey).collect();
            assert!((4..=20).contains(&rooms.len()), "seed {seed}: {} rooms", rooms.len());
            let mut areas: Vec<_> = rooms.iter().map(|room| room.rect).collect();
            areas.extend(layout.corridor_areas());
            areas.push(layout.stairs);
            for (index, area) in areas.iter().enumerate() {
                assert!(area.size(0) > 1.5 && area.size(1) > 1.5, "seed {seed}: {area:?}");
                let inside = area.min.iter().all(|c| *c >= -1e-9)
                    && area.max[0] <= layout.length + 1e-9
                    && area.max[1] <= layout.width + 1e-9;
                assert!(inside, "seed {seed}: {area:?} is outside");
                for other in &areas[..index] {
                    assert!(!area.overlaps(other), "seed {seed}: {area:?} and {other:?}");
                }
            }
        }
    }
}

#[test]
fn no_ray_from_inside_leaves_the_building() {
    for seed in SEEDS {
        let (layout, site) = generated(seed);
        let mut rng = RngTree::new(seed).child("rays").rng();
        for (point, _) in flat_points(&layout, &site, "round").into_iter().step_by(25) {
            for _ in 0..40 {
                let direction = Vector3::new(rng.normal(), rng.normal(), rng.normal()).normalize();
                let eye = point + Vector3::z() * 0.8;
                let hit = site.cast_ray(&eye, &direction, 120.0);
                let end = hit.map(|(range, _)| eye + direction * range);
                let is_inside = end.is_some_and(|end| {
                    (-0.35..layout.length + 0.35).contains(&end.x)
                        && (-0.35..layout.width + 0.35).contains(&end.y)
                        && (-0.1..layout.roof() + 0.1).contains(&end.z)
                });
                assert!(is_inside, "seed {seed}: from {eye} along {direction} to {end:?}");
            }
        }
    }
}

#[test]
fn people_walk_where_no_furniture_stands() {
    for seed in SEEDS {
        let site = SimulatedSite::new(SiteName::Generated(seed));
        assert!(site.pedestrian_paths().len() >= 4, "seed {seed}");
        for path in site.pedestrian_paths() {
            for (from, to) in path.iter().zip(path.iter().cycle().skip(1)) {
                for step in 0..=20 {
                    let chest = from + (to - from) * (f64::from(step) / 20.0) + Vector3::z() * 0.9;
                    let gap = site.distance(&chest, 0.2);
                    assert!(gap.is_none(), "seed {seed}: a person at {chest} is {gap:?} m from something");
                }
            }
        }
    }
}

#[test]
fn furniture_moves_on_another_day_and_leaves_the_routes_free() {
    for seed in 0..8 {
        let (layout, usual) = generated(seed);
        let changed = usual.on_another_day(5, 0.25);
        assert!(changed.solids() != usual.solids(), "seed {seed}");
        for (point, _) in flat_points(&layout, &changed, "round") {
            assert!(changed.has_room(&point), "seed {seed}: no room at {point}");
        }
    }
}

/// Walks a route with the simulated body; returns the time it takes, seconds, and the greatest height of the base, metres.
fn walk(seed: u64, route: &str) -> (f64, f64) {
    let name = SiteName::Generated(seed);
    let site = Arc::new(SimulatedSite::new(name));
    let route = site.route(route).cloned().unwrap();
    let mut simulator = Simulator::new(ideal_blind(site));
    let mut walker = RouteFollower::new(route);
    let mut highest = f64::NEG_INFINITY;
    while let Some(command) = walker.drive(&simulator.truth()) {
        run(&mut simulator, command, 1);
        highest = highest.max(simulator.truth().site_from_base.position.z);
        let elapsed = simulator.elapsed().secs_f64();
        assert!(elapsed < 1200.0, "seed {seed}: stuck at {:?}", (walker.progress(), simulator.truth()));
    }
    (simulator.elapsed().secs_f64(), highest)
}

#[test]
fn the_robot_walks_the_short_route_over_the_stairs() {
    for seed in 0..6 {
        let (seconds, highest) = walk(seed, "short");
        let upper = layout(seed).floor(1);
        assert!((60.0..200.0).contains(&seconds), "seed {seed}: {seconds} s");
        assert!(highest > upper + 0.4, "seed {seed}: the robot came up to {highest} m only");
    }
}

#[test]
fn the_robot_walks_the_round_within_ten_minutes() {
    for seed in 0..4 {
        let (seconds, _) = walk(seed, "round");
        assert!((300.0..600.0).contains(&seconds), "seed {seed}: {seconds} s");
    }
}

mod nightly {
    use super::walk;

    #[test]
    fn the_robot_walks_the_rounds_of_all_benchmarked_sites() {
        for seed in 0..20 {
            let (seconds, _) = walk(seed, "round");
            assert!((240.0..600.0).contains(&seconds), "seed {seed}: {seconds} s");
        }
    }
}
