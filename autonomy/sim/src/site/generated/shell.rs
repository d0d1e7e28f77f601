//! Floors, walls, windows, doors, stairs and roof of a generated building, and what is fixed to its ceilings.

use super::choice::{chance, pick};
use super::layout::{
    BuildingLayout, LOWER_FLIGHT, Rect, RoomUse, SLAB, STAIRS_APPROACH, STEP_RUN, UPPER_FLIGHT,
};
use crate::shape::Material;
use crate::site::parts::{Builder, Opening, at};
use geometry::Vector3;

/// Thickness of the outer walls, metres.
const OUTER_WALL: f64 = 0.3;
/// Width of a flight, metres.
const FLIGHT_WIDTH: f64 = 1.35;
/// Extent of the ground outside the building, metres.
const GROUND_MARGIN: f64 = 4.0;

/// Materials and thicknesses that are the same in the whole building.
struct Finish {
    outer: Material,
    inner: Material,
    hall: Material,
    floor: Material,
    wall: f64,
}

/// A wall that stands, along one axis.
struct Wall {
    /// Axis that it runs along.
    axis: usize,
    /// Coordinate across it.
    across: f64,
    /// Extent along it.
    along: [f64; 2],
    /// Heights of foot and head.
    height: [f64; 2],
}

/// Builds everything but furniture.
pub(super) fn build(b: &mut Builder, layout: &BuildingLayout) {
    let finish = Finish {
        outer: pick(&mut b.rng, &[Material::Concrete, Material::Concrete, Material::WhiteSheet]),
        inner: pick(&mut b.rng, &[Material::Plaster, Material::Plaster, Material::Concrete]),
        hall: pick(&mut b.rng, &[Material::WhiteSheet, Material::Concrete, Material::Plaster]),
        floor: pick(&mut b.rng, &[Material::Floor, Material::Floor, Material::Concrete]),
        wall: b.rng.range(0.12, 0.22),
    };
    floors(b, layout, &finish);
    outer_walls(b, layout, &finish);
    inner_walls(b, layout, &finish);
    stairs(b, layout);
    beams(b, layout);
    services(b, layout);
}

fn floors(b: &mut Builder, layout: &BuildingLayout, finish: &Finish) {
    let (length, width, roof) = (layout.length, layout.width, layout.roof());
    let (low, high) = (-GROUND_MARGIN, GROUND_MARGIN);
    b.aligned_box(at(low, low, -0.3), at(length + high, width + high, 0.0), finish.floor);
    let over = OUTER_WALL + 0.1;
    b.aligned_box(at(-over, -over, roof), at(length + over, width + over, roof + 0.3), Material::Concrete);
    // The upper floor, with an opening over the stairs, and over a hall that takes both floors.
    let east = layout.hall().filter(|_| layout.hall_is_double).map_or(length, |hall| hall.rect.min[0]);
    let (stairs, top) = (&layout.stairs, layout.storey_height);
    let foot = stairs.min[1] + STAIRS_APPROACH;
    for (x, y) in [
        ([0.0, east], [0.0, foot]),
        ([0.0, stairs.min[0]], [foot, width]),
        ([stairs.max[0], east], [foot, width]),
    ] {
        if x[1] - x[0] > 1e-6 {
            b.aligned_box(at(x[0], y[0], top - SLAB), at(x[1], y[1], top), finish.floor);
        }
    }
}

fn outer_walls(b: &mut Builder, layout: &BuildingLayout, finish: &Finish) {
    let middle = OUTER_WALL / 2.0;
    for storey in [0, 1] {
        let foot = layout.floor(storey);
        let height = if storey == 0 { layout.storey_height } else { layout.upper_height };
        for axis in [0, 1] {
            for is_far in [false, true] {
                let extent = [layout.length, layout.width];
                let across = if is_far { extent[1 - axis] + middle } else { -middle };
                let windows = windows(b, layout, storey, axis, is_far);
                // The walls along x close the corners.
                let beyond = if axis == 0 { OUTER_WALL } else { 0.0 };
                let place = |along: f64, z: f64| {
                    if axis == 0 { at(along, across, z) } else { at(across, along, z) }
                };
                let to = place(extent[axis] + beyond, foot);
                let shifted: Vec<Opening> =
                    windows.iter().map(|w| Opening { along: w.along + beyond, ..*w }).collect();
                b.wall(place(-beyond, foot), [to.x, to.y], height, OUTER_WALL, &shifted, finish.outer);
                for window in &windows {
                    glaze(b, window, foot, &place);
                }
            }
        }
    }
}

/// A pane of glass in a frame.
fn glaze(b: &mut Builder, window: &Opening, foot: f64, place: &dyn Fn(f64, f64) -> Vector3) {
    let (low, high) = (foot + window.sill, foot + window.head);
    let (from, to) = (window.along, window.along + window.width);
    let middle = (low + high) / 2.0;
    b.beam(place(from, middle), place(to, middle), 0.02, high - low, Material::Glass);
    for z in [low + 0.03, high - 0.03] {
        b.beam(place(from, z), place(to, z), 0.1, 0.06, Material::Galvanised);
    }
    let bars = (window.width / 1.3).ceil() as usize;
    for bar in 0..=bars {
        let along = from + 0.03 + (to - from - 0.06) * bar as f64 / bars as f64;
        b.beam(place(along, low), place(along, high), 0.06, 0.06, Material::Galvanised);
    }
}

/// The windows in one side of a storey, from the start of its wall.
fn windows(
    b: &mut Builder,
    layout: &BuildingLayout,
    storey: usize,
    axis: usize,
    is_far: bool,
) -> Vec<Opening> {
    let side = if is_far { [layout.length, layout.width][1 - axis] } else { 0.0 };
    let touches = |rect: &Rect| {
        let edge = if is_far { rect.max[1 - axis] } else { rect.min[1 - axis] };
        (edge - side).abs() < 1e-6
    };
    let mut windows = Vec::new();
    for room in layout.rooms.iter().filter(|room| room.storey == storey && touches(&room.rect)) {
        let share = match room.usage {
            RoomUse::Store | RoomUse::Archive | RoomUse::PlantRoom => 0.3,
            RoomUse::Hall | RoomUse::Workshop => 0.7,
            _ => 0.95,
        };
        if chance(&mut b.rng, share) {
            let (low, high) = (room.rect.min[axis], room.rect.max[axis]);
            let width = ((high - low) * b.rng.range(0.35, 0.75)).min(5.0);
            let sill = if room.usage == RoomUse::Hall { 1.6 } else { b.rng.range(0.8, 1.1) };
            let head = sill + b.rng.range(0.9, 1.3);
            windows.push(Opening { along: (low + high - width) / 2.0, width, sill, head });
        }
    }
    if axis == 1 && chance(&mut b.rng, 0.6) {
        // A window at the end of a corridor.
        for corridor in
            layout.corridor_areas().iter().filter(|area| touches(area) && area.size(0) > area.size(1))
        {
            let along = corridor.center()[1] - 0.6;
            windows.push(Opening { along, width: 1.2, sill: 0.9, head: 2.1 });
        }
    }
    windows.sort_by(|a, b| a.along.total_cmp(&b.along));
    windows
}

/// The walls round every room. A wall that two rooms share is built once.
fn inner_walls(b: &mut Builder, layout: &BuildingLayout, finish: &Finish) {
    let extent = [layout.length, layout.width];
    let mut standing: Vec<Wall> = Vec::new();
    let stairwells = [0, 1].map(|storey| {
        let mouth = Opening { along: 0.15, width: layout.stairs.size(0) - 0.3, sill: 0.0, head: 2.5 };
        (storey, layout.stairs, None, Some(mouth), false)
    });
    let mut rooms: Vec<_> = (layout.rooms.iter())
        .map(|room| (room.storey, room.rect, Some(room.door), None, room.usage == RoomUse::Hall))
        .collect();
    // The hall comes first, because its walls are the longest.
    rooms.sort_by_key(|room| !room.4);
    for (storey, rect, door, mouth, is_hall) in rooms.into_iter().chain(stairwells) {
        let foot = layout.floor(storey);
        let head = if storey == 1 || (is_hall && layout.hall_is_double) {
            layout.roof()
        } else {
            layout.storey_height - SLAB
        };
        for axis in [0, 1] {
            for is_far in [false, true] {
                let across = if is_far { rect.max[1 - axis] } else { rect.min[1 - axis] };
                let along = [rect.min[axis], rect.max[axis]];
                let is_outer = across < 1e-6 || across > extent[1 - axis] - 1e-6;
                let covers = |wall: &Wall| {
                    wall.axis == axis
                        && (wall.across - across).abs() < 1e-6
                        && wall.along[0] <= along[0] + 1e-6
                        && wall.along[1] >= along[1] - 1e-6
                        && wall.height[0] <= foot + 1e-6
                        && wall.height[1] >= head - 1e-6
                };
                if is_outer || standing.iter().any(covers) {
                    continue;
                }
                let has_door = door.filter(|door| {
                    door.inward[axis].abs() < 0.5 && (door.at[1 - axis] - across).abs() < 1e-6
                });
                let mut openings = Vec::new();
                if let Some(door) = has_door {
                    let start = door.at[axis] - along[0] - door.width / 2.0;
                    openings.push(Opening { along: start, width: door.width, sill: 0.0, head: door.height });
                } else if let Some(mouth) = mouth
                    && axis == 0
                    && !is_far
                {
                    openings.push(mouth);
                }
                let place = |along: f64| if axis == 0 { [along, across] } else { [across, along] };
                let (from, to) = (place(along[0]), place(along[1]));
                let material = if is_hall { finish.hall } else { finish.inner };
                b.wall(at(from[0], from[1], foot), to, head - foot, finish.wall, &openings, material);
                standing.push(Wall { axis, across, along, height: [foot, head] });
            }
        }
    }
}

fn stairs(b: &mut Builder, layout: &BuildingLayout) {
    let (stairs, top) = (&layout.stairs, layout.storey_height);
    let [west, east] = [stairs.min[0], stairs.max[0]];
    let (steps, rise) = (layout.steps_per_flight, layout.rise());
    let (foot, landing, half) = (stairs.min[1] + STAIRS_APPROACH, layout.landing(), top / 2.0);
    b.stairs(at(west + LOWER_FLIGHT, foot, 0.0), Vector3::y(), FLIGHT_WIDTH, steps, rise, STEP_RUN);
    b.stairs(at(west + UPPER_FLIGHT, landing, half), -Vector3::y(), FLIGHT_WIDTH, steps, rise, STEP_RUN);
    b.aligned_box(at(west, landing, half - 0.15), at(east, stairs.max[1], half), Material::Galvanised);
    // Between the flights, and on the upper floor over the lower flight.
    let between = west + (LOWER_FLIGHT + UPPER_FLIGHT) / 2.0;
    b.railing(&[at(west + 0.1, foot, top), at(between - 0.05, foot, top)], Material::YellowPaint);
}

/// Beams under the floors across the building.
fn beams(b: &mut Builder, layout: &BuildingLayout) {
    let depth = b.rng.range(0.15, 0.3);
    let hall = layout.hall().filter(|_| layout.hall_is_double).map(|hall| hall.rect.min[0]);
    let spacing = b.rng.range(3.6, 6.4);
    let count = (layout.length / spacing) as usize;
    for i in 1..=count {
        let x = spacing * i as f64;
        let is_over_stairs = (layout.stairs.min[0] - 0.2..layout.stairs.max[0] + 0.2).contains(&x);
        for under in [layout.storey_height - SLAB, layout.roof()] {
            let is_lower = under < layout.storey_height;
            if x > layout.length - 0.3
                || (is_lower && (is_over_stairs || hall.is_some_and(|hall| x > hall - 0.2)))
            {
                continue;
            }
            let z = under - depth / 2.0;
            b.beam(at(x, 0.0, z), at(x, layout.width, z), 0.2, depth, Material::Concrete);
        }
    }
}

/// Pipes, cable trays, ducts and lamps under the ceilings of corridors and rooms.
fn services(b: &mut Builder, layout: &BuildingLayout) {
    for storey in [0, 1] {
        let ceiling = if storey == 0 { layout.storey_height - SLAB } else { layout.roof() };
        for corridor in layout.corridor_areas() {
            let axis = usize::from(corridor.size(1) > corridor.size(0));
            let run = |share: f64, z: f64, margin: f64| {
                let across = corridor.min[1 - axis] + corridor.size(1 - axis) * share;
                [corridor.min[axis] + margin, corridor.max[axis] - margin]
                    .map(|along| if axis == 0 { at(along, across, z) } else { at(across, along, z) })
            };
            if chance(&mut b.rng, 0.6) {
                let [from, to] = run(b.rng.range(0.2, 0.35), ceiling - 0.42, 0.3);
                b.tray(from, to, layout.corridor_width / 5.0);
            }
            if chance(&mut b.rng, 0.6) {
                let (share, radius) = (b.rng.range(0.7, 0.9), b.rng.range(0.03, 0.1));
                b.pipe(&run(share, ceiling - 0.4, 0.2), radius, Material::Galvanised);
            }
            let [from, to] = run(0.5, ceiling - 0.05, 0.8);
            lamps(b, from, to);
        }
        for room in layout.rooms.iter().filter(|room| room.storey == storey) {
            let (rect, ceiling) = (room.rect.inset(0.4), layout.ceiling(room));
            let y = rect.center()[1];
            let z = ceiling - 0.05;
            lamps(b, at(rect.min[0] + 0.5, y, z), at(rect.max[0] - 0.5, y, z));
            let is_technical = matches!(
                room.usage,
                RoomUse::Hall | RoomUse::PlantRoom | RoomUse::Workshop | RoomUse::Laboratory
            );
            if is_technical && chance(&mut b.rng, 0.7) {
                let y = b.rng.range(rect.min[1] + 0.5, rect.max[1] - 0.5);
                let z = ceiling - 0.6;
                b.duct(at(rect.min[0], y, z), at(rect.max[0], y, z), 0.5, 0.35);
            }
            if is_technical {
                let z = ceiling - b.rng.range(0.3, 0.6);
                let [low, high] = [rect.min, rect.max];
                let radius = b.rng.range(0.03, 0.09);
                b.pipe(
                    &[at(low[0], low[1], z), at(high[0], low[1], z), at(high[0], y, z)],
                    radius,
                    Material::Steel,
                );
            }
        }
    }
}

/// A row of lamps along a segment under a ceiling.
fn lamps(b: &mut Builder, from: Vector3, to: Vector3) {
    let length = (to - from).norm();
    if length < 0.5 {
        return;
    }
    let unit = (to - from) / length;
    for i in 0..(length / 2.8).ceil() as usize {
        let middle = from + unit * (length.min(2.8) * (i as f64 + 0.5)).min(length);
        b.beam(middle - unit * 0.6, middle + unit * 0.6, 0.14, 0.08, Material::WhiteSheet);
    }
}
