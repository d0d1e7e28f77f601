//! `b1`: a test hall of 60 m x 40 m. West: five rooms along a corridor, under a flat ceiling. North: pallet racking. South:
//! machines, a test rig and a pump room. East: tanks. A pipe bridge, a crane and the roof's girders run above.

use super::parts::{Builder, Opening, at, door, gate, window};
use super::plan::SitePlan;
use crate::route::{SiteRoute, Start};
use crate::shape::Material;
use geometry::Vector3;
use vocab::Vec3;

const LENGTH: f64 = 60.0;
const WIDTH: f64 = 40.0;
const HEIGHT: f64 = 9.0;
/// Height of the ceiling in the rooms, metres.
const ROOM_HEIGHT: f64 = 3.2;
const ROOM_WALL_X: f64 = 11.0;
const CORRIDOR_WALL_X: f64 = 14.0;

pub(super) fn plan() -> SitePlan {
    let mut b = Builder::new("b1");
    shell(&mut b);
    roof(&mut b);
    rooms(&mut b);
    racks(&mut b);
    machines(&mut b);
    test_rig(&mut b);
    pump_room(&mut b);
    tanks(&mut b);
    pipe_bridge(&mut b);
    clutter(&mut b);
    b.dock(at(16.4, 23.5, 0.0), 0.0);
    b.plan.outline = vec![[0.0, 0.0], [LENGTH, 0.0], [LENGTH, WIDTH], [0.0, WIDTH]];
    b.plan.routes = routes();
    b.plan.pedestrian_paths = pedestrian_paths();
    b.plan
}

fn shell(b: &mut Builder) {
    b.aligned_box(at(-6.0, -6.0, -0.3), at(LENGTH + 6.0, WIDTH + 6.0, 0.0), Material::Floor);
    let windows = [8.0, 20.0, 32.0, 44.0].map(|along| Opening { along, width: 6.0, sill: 5.2, head: 6.6 });
    let sheet = Material::WhiteSheet;
    b.wall(at(0.0, -0.15, 0.0), [LENGTH, -0.15], HEIGHT, 0.3, &windows, sheet);
    b.wall(at(0.0, WIDTH + 0.15, 0.0), [LENGTH, WIDTH + 0.15], HEIGHT, 0.3, &windows, sheet);
    b.wall(
        at(-0.15, 0.0, 0.0),
        [-0.15, WIDTH],
        HEIGHT,
        0.3,
        &[window(4.0, 3.0), window(20.0, 3.0), window(36.0, 3.0)],
        sheet,
    );
    b.wall(at(LENGTH + 0.15, 0.0, 0.0), [LENGTH + 0.15, WIDTH], HEIGHT, 0.3, &[gate(24.0)], sheet);
    // The gate is closed by a roller door, set back in its frame, with ribs.
    b.aligned_box(at(LENGTH + 0.1, 22.3, 0.0), at(LENGTH + 0.2, 25.7, 3.6), Material::Galvanised);
    for rib in 0..9 {
        let z = 0.2 + 0.4 * f64::from(rib);
        b.aligned_box(at(LENGTH + 0.06, 22.3, z), at(LENGTH + 0.1, 25.7, z + 0.12), Material::Galvanised);
    }
    // A concrete plinth runs round the hall.
    for (y, side) in [(0.0, 1.0), (WIDTH, -1.0)] {
        b.aligned_box(at(CORRIDOR_WALL_X, y, 0.0), at(LENGTH, y + 0.08 * side, 1.1), Material::Concrete);
        for i in 0..10 {
            let foot = at(3.0 + 6.0 * f64::from(i), y + 0.28 * side, 0.0);
            b.column(foot, HEIGHT, false, Material::BluePaint);
        }
    }
    for y in [10.0, 16.0, 30.0, 36.0] {
        b.column(at(LENGTH - 0.28, y, 0.0), HEIGHT, true, Material::BluePaint);
    }
}

fn roof(b: &mut Builder) {
    // Corrugated sheet with strips of roof light left open.
    for i in 0..5 {
        let x = 12.0 * f64::from(i);
        b.aligned_box(at(x, -0.3, HEIGHT), at(x + 10.4, WIDTH + 0.3, HEIGHT + 0.12), Material::Galvanised);
        b.aligned_box(at(x + 10.4, -0.3, HEIGHT), at(x + 12.0, 14.0, HEIGHT + 0.12), Material::Galvanised);
        b.aligned_box(
            at(x + 10.4, 26.0, HEIGHT),
            at(x + 12.0, WIDTH + 0.3, HEIGHT + 0.12),
            Material::Galvanised,
        );
    }
    for i in 0..10 {
        let x = 3.0 + 6.0 * f64::from(i);
        b.truss(at(x, 0.2, HEIGHT - 0.1), at(x, WIDTH - 0.2, HEIGHT - 0.1), 1.1, 16, Material::BluePaint);
    }
    for y in [8.0, 20.0, 32.0] {
        b.beam(at(0.0, y, HEIGHT - 0.1), at(LENGTH, y, HEIGHT - 0.1), 0.1, 0.16, Material::Galvanised);
    }
    for y in [12.0, 28.0] {
        b.duct(at(15.0, y, 7.1), at(58.0, y, 7.1), 0.9, 0.6);
        for i in 0..7 {
            let x = 18.0 + 6.0 * f64::from(i);
            b.aligned_box(at(x - 0.3, y - 0.3, 6.6), at(x + 0.3, y + 0.3, 6.8), Material::Galvanised);
        }
    }
    // Crane: rails on brackets, bridge, trolley and hook.
    for y in [1.0, WIDTH - 1.0] {
        b.beam(at(14.5, y, 6.6), at(59.5, y, 6.6), 0.3, 0.5, Material::YellowPaint);
    }
    for x in [39.2, 40.8] {
        b.beam(at(x, 1.0, 7.05), at(x, WIDTH - 1.0, 7.05), 0.35, 0.4, Material::YellowPaint);
    }
    b.aligned_box(at(39.0, 14.0, 7.2), at(41.0, 15.6, 7.75), Material::YellowPaint);
    b.cylinder(at(40.0, 14.8, 7.2), at(40.0, 14.8, 5.2), 0.03, Material::Steel);
    b.aligned_box(at(39.8, 14.65, 4.8), at(40.2, 14.95, 5.2), Material::DarkPaint);
    for i in 0..8 {
        for y in [6.0, 17.0, 23.5, 34.0] {
            let x = 17.0 + 5.5 * f64::from(i);
            b.aligned_box(at(x, y - 0.12, 6.2), at(x + 1.4, y + 0.12, 6.3), Material::WhiteSheet);
            b.cylinder(at(x + 0.7, y, 6.3), at(x + 0.7, y, HEIGHT), 0.01, Material::Steel);
        }
    }
}

/// Offices, control room, workshop and store along the corridor.
fn rooms(b: &mut Builder) {
    let plaster = Material::Plaster;
    let doors = [door(4.0), door(12.0), door(20.0), door(28.0), door(36.0)];
    b.wall(at(ROOM_WALL_X, 0.0, 0.0), [ROOM_WALL_X, WIDTH], ROOM_HEIGHT, 0.16, &doors, plaster);
    b.wall(
        at(CORRIDOR_WALL_X, 0.0, 0.0),
        [CORRIDOR_WALL_X, WIDTH],
        ROOM_HEIGHT,
        0.2,
        &[door(5.0), door(20.0), door(35.0)],
        plaster,
    );
    for y in [8.0, 16.0, 24.0, 32.0] {
        b.wall(at(0.0, y, 0.0), [ROOM_WALL_X, y], ROOM_HEIGHT, 0.14, &[], plaster);
    }
    b.aligned_box(
        at(0.0, 0.0, ROOM_HEIGHT),
        at(CORRIDOR_WALL_X + 0.1, WIDTH, ROOM_HEIGHT + 0.2),
        Material::Concrete,
    );
    for (i, y) in [4.0, 12.0, 20.0, 28.0, 36.0].into_iter().enumerate() {
        let swing = 2.75 + 0.12 * i as f64;
        b.leaf(at(ROOM_WALL_X - 0.1, y + 0.7, 0.0), swing, 1.3, 2.15, Material::Wood);
        b.sign(at(ROOM_WALL_X + 0.08, y - 1.1, 1.6), Vector3::x(), 0.25);
    }
    b.extinguisher(at(CORRIDOR_WALL_X - 0.1, 10.0, 0.0), -Vector3::x());
    b.extinguisher(at(CORRIDOR_WALL_X - 0.1, 27.0, 0.0), -Vector3::x());
    b.tray(at(11.6, 0.2, 2.8), at(11.6, 39.8, 2.8), 0.5);
    b.pipe(&[at(13.6, 0.2, 2.9), at(13.6, 39.8, 2.9)], 0.06, Material::Galvanised);
    b.pipe(&[at(13.35, 0.2, 2.9), at(13.35, 22.0, 2.9), at(11.0, 22.0, 2.9)], 0.04, Material::Steel);
    // Two offices.
    for y in [0.0, 8.0] {
        for (x, dy, yaw) in [(2.0, 2.0, 0.0), (2.0, 6.2, 0.1), (5.2, 6.4, 0.0)] {
            b.table(at(x, y + dy, 0.0), [1.6, 0.8], yaw);
            b.oriented_box(at(x, y + dy + 0.2, 0.76), at(0.6, 0.05, 0.4), yaw, Material::DarkPaint);
            b.chair(at(x + 0.1, y + dy - 0.75, 0.0), 1.4);
        }
        b.aligned_box(at(6.8, y + 0.15, 0.0), at(9.6, y + 0.55, 1.9), Material::Wood);
    }
    // Control room: consoles in a row, cabinets at the back.
    for i in 0..4 {
        let y = 17.4 + 1.7 * f64::from(i);
        b.table(at(3.4, y + 0.3, 0.0), [1.5, 0.9], 1.57);
        b.oriented_box(at(3.1, y + 0.3, 0.76), at(0.06, 1.2, 0.5), 0.0, Material::DarkPaint);
        b.chair(at(4.4, y + 0.4, 0.0), 3.0);
    }
    b.cabinets(at(0.2, 16.8, 0.0), 8, true);
    // Workshop.
    for (x, y) in [(2.2, 25.0), (5.2, 25.0), (2.2, 31.0)] {
        b.table(at(x, y, 0.0), [2.4, 0.8], 0.0);
    }
    b.machine(at(6.4, 30.6, 0.0), at(1.8, 1.1, 1.7), 0.0);
    b.drum(at(9.9, 31.3, 0.0), 0.28, 0.88);
    // Store.
    b.rack(at(0.3, 33.0, 0.0), 5.4, 1, true);
    for (x, y) in [(3.4, 33.2), (5.0, 33.2), (3.4, 38.8), (6.6, 38.7)] {
        b.pallet(at(x, y, 0.0), false, 1.3);
    }
}

fn racks(b: &mut Builder) {
    for y in [26.2, 30.6, 35.0] {
        b.rack(at(20.0, y, 0.0), 20.0, 3, false);
        // Ramming guards at the ends.
        for x in [19.7, 40.3] {
            b.aligned_box(at(x - 0.08, y, 0.0), at(x + 0.08, y + 1.1, 0.35), Material::YellowPaint);
        }
    }
    for (x, y) in [(43.4, 38.8), (15.0, 38.9), (16.4, 38.9)] {
        b.pallet(at(x, y, 0.0), false, 1.5);
    }
}

fn machines(b: &mut Builder) {
    for (i, x) in [21.5, 28.5, 35.0].into_iter().enumerate() {
        b.machine(at(x, 6.3, 0.0), at(3.6, 1.9, 2.3), 0.04 * i as f64);
        b.machine(at(x - 0.6, 13.6, 0.0), at(3.0 + 0.4 * i as f64, 2.0, 2.0), 0.03);
        b.pipe(
            &[at(x, 7.0, 2.9), at(x, 7.0, 5.0), at(x, 12.0, 5.0), at(x, 12.0, 7.0)],
            0.12,
            Material::Galvanised,
        );
    }
    b.cabinets(at(24.3, 0.35, 0.0), 4, false);
    b.cabinets(at(30.3, 0.35, 0.0), 4, false);
    b.vessel(at(31.0, 16.1, 1.1), Vector3::x(), 1.6, 0.45);
    b.drum(at(18.6, 12.3, 0.0), 0.3, 0.9);
    b.drum(at(18.4, 13.1, 0.0), 0.3, 0.9);
    b.drum(at(19.0, 14.0, 0.0), 0.3, 0.9);
    b.pallet(at(18.6, 6.2, 0.0), true, 1.1);
}

/// A steel frame with two platforms and a rig inside. It has a ladder but no stairs.
fn test_rig(b: &mut Builder) {
    let (x0, x1, y0, y1) = (41.5, 46.5, 6.0, 15.0);
    for x in [x0, x1] {
        for y in [y0, (y0 + y1) / 2.0, y1] {
            b.column(at(x, y, 0.0), 6.2, false, Material::YellowPaint);
        }
        for z in [2.9, 5.6] {
            b.beam(at(x, y0, z), at(x, y1, z), 0.14, 0.22, Material::YellowPaint);
        }
        b.beam(at(x, y0, 0.2), at(x, (y0 + y1) / 2.0, 2.8), 0.08, 0.08, Material::YellowPaint);
        b.beam(at(x, y1, 2.9), at(x, (y0 + y1) / 2.0, 5.5), 0.08, 0.08, Material::YellowPaint);
    }
    for (z, from) in [(3.0, y0), (5.7, 10.5)] {
        b.aligned_box(at(x0, from, z), at(x1, y1, z + 0.06), Material::Galvanised);
        let z = z + 0.06;
        b.railing(
            &[at(x0, from, z), at(x0, y1, z), at(x1, y1, z), at(x1, from, z), at(x0, from, z)],
            Material::YellowPaint,
        );
    }
    b.ladder(at(x0 - 0.25, 8.0, 0.0), 4.1, Vector3::y());
    b.cylinder(at(44.0, 9.0, 0.0), at(44.0, 9.0, 2.6), 0.9, Material::Steel);
    b.cylinder(at(44.0, 9.0, 2.6), at(44.0, 9.0, 2.75), 1.1, Material::Steel);
    b.cylinder(at(44.0, 12.8, 0.3), at(44.0, 12.8, 2.2), 0.6, Material::Galvanised);
    b.sphere(at(44.0, 12.8, 2.2), 0.6, Material::Galvanised);
    b.pipe(
        &[at(44.0, 9.0, 2.75), at(44.0, 9.0, 4.4), at(44.0, 12.8, 4.4), at(44.0, 12.8, 2.7)],
        0.14,
        Material::Galvanised,
    );
    b.pipe(
        &[
            at(44.5, 9.0, 1.0),
            at(45.8, 9.0, 1.0),
            at(45.8, 14.0, 1.0),
            at(44.0, 14.0, 1.6),
            at(44.0, 13.3, 1.6),
        ],
        0.08,
        Material::Steel,
    );
    b.valve(at(45.8, 11.4, 1.0), Vector3::x());
    b.machine(at(43.2, 13.0, 5.76), at(1.6, 1.2, 1.4), 0.2);
}

fn pump_room(b: &mut Builder) {
    b.wall(at(50.0, 0.0, 0.0), [50.0, 12.0], 4.0, 0.2, &[door(6.0)], Material::Concrete);
    b.wall(at(50.0, 12.0, 0.0), [LENGTH, 12.0], 4.0, 0.2, &[door(5.0)], Material::Concrete);
    b.leaf(at(50.1, 6.7, 0.0), 0.3, 1.3, 2.15, Material::Galvanised);
    for (i, y) in [1.6, 3.4].into_iter().enumerate() {
        b.pump(at(52.6 + 0.2 * i as f64, y, 0.0), false);
        b.pump(at(57.0, y, 0.0), false);
    }
    b.pump(at(58.2, 9.0, 0.0), true);
    b.pump(at(51.9, 9.6, 0.0), true);
    for (y, z, radius) in [(0.6, 2.8, 0.16), (1.1, 3.1, 0.11), (1.5, 3.4, 0.09)] {
        b.pipe(
            &[at(50.1, y, z), at(59.2, y, z), at(59.2, 11.6, z), at(50.4, 11.6, z)],
            radius,
            Material::Galvanised,
        );
    }
    b.pipe(&[at(59.0, 5.0, 0.3), at(59.0, 11.0, 0.3)], 0.12, Material::Steel);
    b.cabinets(at(56.9, 11.25, 0.0), 3, false);
    b.extinguisher(at(50.1, 4.6, 0.0), Vector3::x());
}

fn tanks(b: &mut Builder) {
    for (x, y, radius, height) in
        [(46.6, 29.6, 1.3, 4.6), (52.2, 29.6, 1.3, 4.6), (46.6, 35.2, 1.3, 5.2), (52.2, 35.2, 1.2, 3.6)]
    {
        b.tank(at(x, y, 0.0), radius, height);
    }
    b.pipe(
        &[at(46.6, 29.6, 5.5), at(46.6, 29.6, 6.1), at(52.2, 29.6, 6.1), at(52.2, 29.6, 5.5)],
        0.1,
        Material::Galvanised,
    );
    b.pipe(
        &[at(46.6, 35.2, 6.0), at(46.6, 35.2, 6.3), at(46.6, 19.5, 6.3), at(46.6, 19.5, 4.9)],
        0.12,
        Material::Galvanised,
    );
    b.pipe(
        &[at(52.2, 35.2, 4.2), at(52.2, 35.2, 5.6), at(59.4, 39.4, 5.6), at(59.4, 39.4, 0.0)],
        0.09,
        Material::Steel,
    );
    b.vessel(at(59.0, 33.0, 1.35), Vector3::y(), 2.6, 0.55);
    b.pump(at(43.6, 33.0, 0.0), true);
}

/// Pipes on portals along the middle of the hall.
fn pipe_bridge(b: &mut Builder) {
    for i in 0..6 {
        let x = 17.0 + 8.0 * f64::from(i);
        for y in [18.7, 20.3] {
            b.column(at(x, y, 0.0), 4.7, true, Material::Galvanised);
        }
        for z in [3.8, 4.7] {
            b.beam(at(x, 18.5, z), at(x, 20.5, z), 0.16, 0.16, Material::Galvanised);
        }
    }
    for (i, (y, radius)) in [(18.8, 0.16), (19.2, 0.09), (19.5, 0.07), (19.9, 0.2)].into_iter().enumerate() {
        let end = 58.0 - 3.0 * i as f64;
        b.pipe(
            &[at(14.2, y, 4.0 + radius), at(end, y, 4.0 + radius), at(end, y, 8.2)],
            radius,
            Material::Galvanised,
        );
    }
    b.tray(at(14.2, 19.1, 4.9), at(59.5, 19.1, 4.9), 0.6);
    b.tray(at(14.2, 20.0, 4.9), at(59.5, 20.0, 4.9), 0.6);
    for x in [22.0, 30.0, 38.0] {
        b.pipe(
            &[at(x, 18.8, 4.16), at(x, 17.6, 4.16), at(x - 1.0, 14.0, 3.2), at(x - 1.0, 14.0, 2.2)],
            0.07,
            Material::Steel,
        );
    }
}

/// Clutter. None of it reaches into an aisle that a route uses.
fn clutter(b: &mut Builder) {
    for (x, y) in [(48.6, 1.2), (47.0, 1.3), (58.6, 27.6), (40.6, 1.3), (15.2, 30.2), (15.3, 26.6)] {
        b.pallet(at(x, y, 0.0), x > 50.0, 1.2);
    }
    b.table(at(15.0, 14.2, 0.0), [0.8, 2.4], 0.0);
    b.cabinets(at(14.2, 15.9, 0.0), 3, true);
    b.extinguisher(at(14.1, 21.6, 0.0), Vector3::x());
    for (x, y) in [(14.1, 7.5), (14.1, 32.5)] {
        b.sign(at(x, y, 2.0), Vector3::x(), 0.5);
    }
    // A pallet truck, parked.
    b.oriented_box(at(15.4, 11.0, 0.06), at(0.5, 1.3, 0.08), 0.1, Material::YellowPaint);
    b.cylinder(at(15.4, 10.4, 0.1), at(15.2, 10.0, 1.15), 0.03, Material::DarkPaint);
    // A step ladder and a gas bottle cage.
    b.beam(at(48.9, 13.4, 0.0), at(49.2, 13.4, 2.0), 0.5, 0.05, Material::Galvanised);
    b.beam(at(49.6, 13.4, 0.0), at(49.2, 13.4, 2.0), 0.5, 0.05, Material::Galvanised);
    for i in 0..4 {
        let x = 55.0 + 0.3 * f64::from(i);
        b.cylinder(at(x + 2.0, 39.5, 0.0), at(x + 2.0, 39.5, 1.5), 0.11, Material::DarkPaint);
    }
}

fn routes() -> Vec<SiteRoute> {
    let start = Start { position: Vec3::new(16.4, 23.5, 0.0), yaw: 0.0 };
    let round = vec![
        // Racks.
        [18.2, 23.5],
        [42.0, 23.5],
        [42.0, 29.0],
        [18.2, 29.0],
        [18.2, 33.4],
        [42.0, 33.4],
        [42.0, 37.4],
        [18.2, 37.4],
        [17.0, 35.0],
        [12.5, 35.0],
        // Rooms off the corridor.
        [12.5, 36.0],
        [8.0, 36.0],
        [12.5, 36.0],
        [12.5, 28.0],
        [8.0, 28.0],
        [12.5, 28.0],
        [12.5, 20.0],
        [6.5, 20.0],
        [12.5, 20.0],
        [12.5, 12.0],
        [8.0, 12.0],
        [12.5, 12.0],
        [12.5, 5.0],
        [16.4, 5.0],
        // Machines.
        [17.2, 2.6],
        [39.2, 2.6],
        [39.2, 9.9],
        [17.0, 9.9],
        [17.0, 17.2],
        [39.6, 17.2],
        [48.3, 17.2],
        [48.3, 6.0],
        // Pump room.
        [55.0, 6.0],
        [55.0, 14.6],
        [57.6, 16.5],
        [57.6, 23.5],
        // Tanks.
        [56.0, 26.0],
        [56.0, 37.8],
        [49.5, 37.8],
        [49.5, 26.0],
        [44.2, 23.5],
        // Back along the main aisle, with a detour under the bridge.
        [29.0, 23.5],
        [29.0, 17.2],
        [21.0, 17.2],
        [21.0, 23.0],
        [17.2, 23.0],
        // Once more through the corridor and along the racks, in the opposite direction.
        [15.4, 21.6],
        [15.4, 20.0],
        [12.5, 20.0],
        [12.5, 35.0],
        [16.4, 35.0],
        [18.2, 33.4],
        [42.0, 33.4],
        [42.0, 29.0],
        [44.2, 26.0],
        [44.2, 23.5],
        [17.2, 23.5],
    ];
    let short = vec![[18.2, 23.5], [29.0, 22.6], [29.0, 17.2], [21.0, 17.2], [21.0, 23.0], [18.0, 23.0]];
    vec![
        SiteRoute { name: "round", start, waypoints: round, speed: 1.0 },
        SiteRoute { name: "short", start, waypoints: short, speed: 0.9 },
    ]
}

fn pedestrian_paths() -> Vec<Vec<Vector3>> {
    let on_floor = |corners: &[[f64; 2]]| corners.iter().map(|c| at(c[0], c[1], 0.0)).collect();
    vec![
        on_floor(&[[22.0, 24.8], [41.0, 24.8], [43.5, 21.8], [24.0, 21.8]]),
        on_floor(&[[12.0, 5.0], [15.8, 5.2], [17.2, 10.6], [32.0, 10.4], [17.2, 10.6], [15.8, 5.2]]),
        on_floor(&[[48.8, 24.5], [55.4, 24.5], [55.4, 32.0], [55.4, 38.4], [49.8, 38.4], [49.2, 32.0]]),
        on_floor(&[[18.6, 33.8], [30.0, 32.9], [41.5, 33.6], [30.0, 33.2]]),
        on_floor(&[[47.8, 16.6], [48.6, 6.2], [54.0, 6.4], [48.6, 6.2]]),
    ]
}
