//! Routes and pedestrian paths through a generated building. A route visits rooms along a closed tour of the corridors.

use super::choice::chance;
use super::layout::{BuildingLayout, Corridors, LOWER_FLIGHT, Rect, Room, UPPER_FLIGHT};
use crate::route::{SiteRoute, Start};
use geometry::{Rng, Vector3, vec_to_plain};

/// Walking speed on the routes, m/s.
const SPEED_M_S: f64 = 1.1;
/// Time that slowing down, turning and starting again takes at a corner, in the mean, seconds: measured with the simulated body.
const CORNER_S: f64 = 1.75;
/// Distance of a docked robot from the wall behind it, metres.
const DOCK_DEPTH_M: f64 = 1.1;
/// Rooms of at least these extents along and across the door wall are walked round, metres.
const MIN_ROUND_M: [f64; 2] = [5.6, 5.2];
/// Distance into a room at which the walk may leave the axis of the door, metres.
const ENTRANCE_M: f64 = 1.2;
/// Depth of the path over the landing, metres.
const LANDING_PATH_M: f64 = 0.85;

/// A corner of a walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Corner {
    pub(super) at: [f64; 2],
    /// The storey; `None` on the stairs.
    pub(super) storey: Option<usize>,
}

/// The walks of a building.
pub(super) struct Walks {
    pub(super) routes: Vec<SiteRoute>,
    /// The corners of the round. Furniture stays off it.
    pub(super) round: Vec<Corner>,
    pub(super) pedestrian_paths: Vec<Vec<Vector3>>,
    /// Positions of docked robots on the floor, with their headings. The routes begin at the first one.
    pub(super) docks: Vec<(Vector3, f64)>,
}

/// A point of the corridors' tour, with the room whose door is there.
#[derive(Clone, Copy)]
struct Stop<'a> {
    at: [f64; 2],
    room: Option<&'a Room>,
}

/// Makes the routes and paths.
pub(super) fn walks(layout: &BuildingLayout, rng: &mut Rng) -> Walks {
    let docks: Vec<_> =
        layout.rooms.iter().filter(|room| room.has_dock).map(|room| dock(layout, room)).collect();
    // `set_docks` marks a room of the ground floor in every building.
    let home = layout.rooms.iter().find(|room| room.has_dock && room.storey == 0).unwrap_or(&layout.rooms[0]);
    let first = dock(layout, home);
    let (home_stop, stairs_stop) = (corridor_point(layout, home), stairs_mouth(layout, LOWER_FLIGHT));
    let upper_stop = stairs_mouth(layout, UPPER_FLIGHT);

    let on = |storey: usize, points: Vec<[f64; 2]>| {
        points.into_iter().map(move |at| Corner { at, storey: Some(storey) })
    };
    let leave: Vec<[f64; 2]> = leave_dock(home);
    let enter: Vec<[f64; 2]> = leave.iter().rev().copied().collect();
    let visit_home = visit(home, rng);
    let mut round: Vec<Corner> = Vec::new();
    round.extend(on(0, leave.clone()));
    round.extend(on(0, visit_home));
    round.extend(on(0, vec![home_stop]));
    round.extend(on(0, tour(layout, 0, home_stop, Some(home), rng)));
    round.extend(on(0, corridor_path(layout, home_stop, stairs_stop)));
    round.extend(climb(layout));
    round.extend(on(1, tour(layout, 1, upper_stop, None, rng)));
    round.extend(climb(layout).into_iter().rev());
    round.extend(on(0, corridor_path(layout, stairs_stop, home_stop)));
    round.extend(on(0, enter.clone()));
    round.dedup_by(|b, a| a.at == b.at);

    let mut short: Vec<Corner> = Vec::new();
    short.extend(on(0, leave));
    short.extend(on(0, vec![home_stop]));
    short.extend(on(0, corridor_path(layout, home_stop, stairs_stop)));
    short.extend(climb(layout));
    short.extend(climb(layout).into_iter().rev());
    short.extend(on(0, corridor_path(layout, stairs_stop, home_stop)));
    short.extend(on(0, enter));
    short.dedup_by(|b, a| a.at == b.at);

    let start = Start { position: vec_to_plain(&first.0), yaw: first.1 };
    let route = |name, corners: &[Corner]| SiteRoute {
        name,
        start,
        waypoints: corners.iter().map(|corner| corner.at).collect(),
        speed: SPEED_M_S,
    };
    Walks {
        routes: vec![route("round", &round), route("short", &short)],
        round,
        pedestrian_paths: pedestrian_paths(layout, rng),
        docks: std::iter::once(first).chain(docks.into_iter().filter(|other| *other != first)).collect(),
    }
}

/// Estimated duration of a walk, seconds: the distance at walking speed, and a share for each corner.
pub(super) fn duration_s(corners: &[Corner]) -> f64 {
    let apart = |pair: &[Corner]| (pair[1].at[0] - pair[0].at[0]).hypot(pair[1].at[1] - pair[0].at[1]);
    corners.windows(2).map(|pair| apart(pair) / SPEED_M_S + CORNER_S).sum()
}

/// Position and heading of a robot at the dock of a room: before the wall opposite the door, looking at the door.
fn dock(layout: &BuildingLayout, room: &Room) -> (Vector3, f64) {
    let (_, along) = room.axes();
    let [x, y] = room.point(depth(room) - DOCK_DEPTH_M, room.door.at[along]);
    let [dx, dy] = room.door.inward;
    (Vector3::new(x, y, layout.floor(room.storey)), (-dy).atan2(-dx))
}

/// Extent of a room across its door wall, metres.
fn depth(room: &Room) -> f64 {
    room.rect.size(room.axes().0)
}

/// The point from which the robot walks into the dock.
fn dock_front(room: &Room) -> [f64; 2] {
    room.point(depth(room) - DOCK_DEPTH_M - 1.0, room.door.at[room.axes().1])
}

/// From the dock of a room to its door.
fn leave_dock(room: &Room) -> Vec<[f64; 2]> {
    let lateral = room.door.at[room.axes().1];
    vec![dock_front(room), room.point(ENTRANCE_M, lateral)]
}

/// The point of the corridor's axis before the door of a room.
fn corridor_point(layout: &BuildingLayout, room: &Room) -> [f64; 2] {
    room.point(-layout.corridor_width / 2.0, room.door.at[room.axes().1])
}

fn stairs_mouth(layout: &BuildingLayout, flight: f64) -> [f64; 2] {
    [layout.stairs.min[0] + flight, layout.stairs.min[1] - layout.corridor_width / 2.0]
}

/// From the corridor of the ground floor up the stairs to that of the upper floor.
fn climb(layout: &BuildingLayout) -> Vec<Corner> {
    let landing = layout.landing() + LANDING_PATH_M;
    let [lower, upper] = [LOWER_FLIGHT, UPPER_FLIGHT].map(|flight| layout.stairs.min[0] + flight);
    vec![
        Corner { at: stairs_mouth(layout, LOWER_FLIGHT), storey: Some(0) },
        Corner { at: [lower, landing], storey: None },
        Corner { at: [upper, landing], storey: None },
        Corner { at: stairs_mouth(layout, UPPER_FLIGHT), storey: Some(1) },
    ]
}

/// The walk through a room, from its door and back to it. Larger rooms are walked round.
fn visit(room: &Room, rng: &mut Rng) -> Vec<[f64; 2]> {
    let (_, along) = room.axes();
    let (door, rect, depth) = (room.door.at[along], &room.rect, depth(room));
    let entrance = room.point(ENTRANCE_M, door);
    let mut walk = vec![entrance];
    if rect.size(along) >= MIN_ROUND_M[0] && depth >= MIN_ROUND_M[1] {
        // The robot walks past a dock, not over its guide rails.
        let least = if room.has_dock { 2.3 } else { 1.5 };
        let inset = (0.28 * rect.size(along).min(depth)).clamp(least, 2.4);
        let (low, high) = (rect.min[along] + inset, rect.max[along] - inset);
        let near = door.clamp(low, high);
        let mut corners = [(inset, low), (depth - inset, low), (depth - inset, high), (inset, high)];
        if chance(rng, 0.5) {
            corners.reverse();
        }
        let to_loop = (inset, near);
        walk.extend(std::iter::once(to_loop).chain(corners).chain([to_loop]).map(|(d, l)| room.point(d, l)));
    } else {
        let middle = rect.center()[along];
        walk.push(room.point((depth - 1.5).max(0.55 * depth), middle));
    }
    if room.has_dock {
        let front = dock_front(room);
        walk.extend([entrance, front]);
    }
    walk.push(entrance);
    walk
}

/// The closed tour of a storey's corridors, which visits all rooms but `skipped` and begins and ends at `from`.
fn tour(
    layout: &BuildingLayout,
    storey: usize,
    from: [f64; 2],
    skipped: Option<&Room>,
    rng: &mut Rng,
) -> Vec<[f64; 2]> {
    let mut stops = stops(layout, storey);
    let position = |stop: &Stop<'_>| (stop.at[0] - from[0]).hypot(stop.at[1] - from[1]);
    let nearest = (0..stops.len()).min_by(|&a, &b| position(&stops[a]).total_cmp(&position(&stops[b])));
    stops.rotate_left(nearest.unwrap_or_default());
    let mut walk = vec![from];
    for stop in &stops {
        let is_skipped = |room: &Room| skipped.is_some_and(|skipped| std::ptr::eq(room, skipped));
        walk.push(stop.at);
        if let Some(room) = stop.room.filter(|room| !is_skipped(room)) {
            walk.extend(visit(room, rng));
            walk.push(stop.at);
        }
    }
    walk.extend(stops.first().map(|stop| stop.at));
    walk.push(from);
    walk
}

/// The doors and corners along the closed tour of a storey's corridors.
fn stops(layout: &BuildingLayout, storey: usize) -> Vec<Stop<'_>> {
    let rooms: Vec<Stop<'_>> = (layout.rooms.iter().filter(|room| room.storey == storey))
        .map(|room| Stop { at: corridor_point(layout, room), room: Some(room) })
        .collect();
    let side = |stop: &Stop<'_>| stop.room.map_or(0.0, |room| room.door.inward[1]);
    // The stops that fulfil a condition, from west to east.
    let eastwards = |belongs: &dyn Fn(&Stop<'_>) -> bool| {
        let mut chosen: Vec<Stop<'_>> = rooms.iter().copied().filter(|stop| belongs(stop)).collect();
        chosen.sort_by(|a, b| a.at[0].total_cmp(&b.at[0]));
        chosen
    };
    let corner = |x: f64, y: f64| Stop { at: [x, y], room: None };
    match layout.corridors {
        Corridors::Spine { y, west, east } => {
            // Not quite to the ends, where a wall or a window is.
            let mut tour = vec![corner(west + 1.2, y)];
            tour.extend(eastwards(&|stop| side(stop) > 0.0));
            tour.push(corner(east - 1.2, y));
            // The hall, which is entered from the end of the corridor.
            tour.extend(eastwards(&|stop| side(stop) == 0.0));
            tour.extend(eastwards(&|stop| side(stop) < 0.0).into_iter().rev());
            tour
        }
        Corridors::Ring { south, north, west, east } => {
            let middle = (south + north) / 2.0;
            let mut tour = vec![corner(west, south)];
            tour.extend(eastwards(&|stop| stop.at[1] < middle));
            tour.extend([corner(east, south), corner(east, north)]);
            tour.extend(eastwards(&|stop| stop.at[1] > middle).into_iter().rev());
            tour.push(corner(west, north));
            tour
        }
    }
}

/// A walk along the corridors between two points of their axes, the shorter way round.
fn corridor_path(layout: &BuildingLayout, from: [f64; 2], to: [f64; 2]) -> Vec<[f64; 2]> {
    let Corridors::Ring { south, north, west, east } = layout.corridors else { return vec![from, to] };
    if (from[1] - to[1]).abs() < 0.1 {
        return vec![from, to];
    }
    let [west_m, east_m] = [west, east].map(|x| (from[0] - x).abs() + (to[0] - x).abs());
    let x = if west_m < east_m { west } else { east };
    let opposite = if (from[1] - south).abs() < 0.1 { north } else { south };
    vec![from, [x, from[1]], [x, opposite], to]
}

/// Closed paths of people: along the corridors of both floors, and through the largest rooms.
fn pedestrian_paths(layout: &BuildingLayout, rng: &mut Rng) -> Vec<Vec<Vector3>> {
    let lane = layout.corridor_width * 0.16;
    let mut paths: Vec<Vec<Vector3>> = Vec::new();
    let closed = |storey: usize, rect: Rect| {
        let [low, high] = [rect.min, rect.max];
        [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]]
            .map(|[x, y]| Vector3::new(x, y, layout.floor(storey)))
            .to_vec()
    };
    let (west, east, y) = match layout.corridors {
        Corridors::Spine { y, west, east } => (west, east, y),
        Corridors::Ring { north, west, east, .. } => (west, east, north),
    };
    for storey in [0, 1] {
        let quarter = (east - west) / 4.0;
        paths.push(closed(storey, Rect::new([west + quarter, east - quarter], [y - lane, y + lane])));
        let mut rooms: Vec<&Room> = layout.rooms.iter().filter(|room| room.storey == storey).collect();
        rooms.sort_by(|a, b| (b.rect.size(0) * b.rect.size(1)).total_cmp(&(a.rect.size(0) * a.rect.size(1))));
        for room in rooms.into_iter().take(2) {
            let corners = visit(room, rng).into_iter();
            paths.push(corners.map(|[x, y]| Vector3::new(x, y, layout.floor(storey))).collect());
        }
    }
    paths
}
