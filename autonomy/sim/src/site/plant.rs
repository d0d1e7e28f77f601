//! `plant`: a process building of two floors (36 m x 24 m) joined by stairs, a featureless corridor of 60 m to a pump house,
//! and an outdoor yard between them with tanks, a pipe rack, containers and trees.

use super::parts::{Builder, at, door, gate, window};
use super::plan::SitePlan;
use crate::route::{SiteRoute, Start};
use crate::shape::Material;
use geometry::Vector3;
use vocab::Vec3;

/// Height of the upper floor, metres: 24 steps of 17 cm.
const UPPER: f64 = 4.08;
const ROOF: f64 = 8.2;
const EAST: f64 = 36.0;
const NORTH: f64 = 24.0;
/// x at which the long corridor ends, metres.
const PUMP_HOUSE: f64 = 96.0;

pub(super) fn plan() -> SitePlan {
    let mut b = Builder::new("plant");
    b.aligned_box(at(-22.0, -44.0, -0.3), at(122.0, 40.0, 0.0), Material::Asphalt);
    shell(&mut b);
    upper_slab(&mut b);
    stairwell(&mut b);
    ground_floor(&mut b);
    upper_floor(&mut b);
    corridor(&mut b);
    pump_house(&mut b);
    yard(&mut b);
    fence_and_trees(&mut b);
    b.dock(at(2.4, 20.8, 0.0), 0.0);
    b.plan.outline = vec![
        [-15.0, -36.0],
        [110.0, -36.0],
        [110.0, NORTH],
        [PUMP_HOUSE, NORTH],
        [PUMP_HOUSE, 17.4],
        [EAST, 17.4],
        [EAST, NORTH],
        [-15.0, NORTH],
    ];
    b.plan.routes = routes();
    b.plan.pedestrian_paths = pedestrian_paths();
    b.plan
}

fn shell(b: &mut Builder) {
    let sheet = Material::WhiteSheet;
    let panes = [window(19.5, 3.0), window(26.0, 3.0), window(32.0, 3.0)];
    b.wall(
        at(0.0, -0.15, 0.0),
        [EAST, -0.15],
        UPPER,
        0.3,
        &[gate(13.0), panes[0], panes[1], panes[2]],
        sheet,
    );
    b.wall(
        at(0.0, -0.15, UPPER),
        [EAST, -0.15],
        ROOF - UPPER,
        0.3,
        &[window(6.0, 4.0), window(19.0, 4.0), window(30.0, 4.0)],
        sheet,
    );
    for z in [0.0, UPPER] {
        b.wall(
            at(0.0, NORTH + 0.15, z),
            [EAST, NORTH + 0.15],
            ROOF - UPPER,
            0.3,
            &[window(9.0, 3.0), window(22.0, 3.0)],
            sheet,
        );
        b.wall(at(-0.15, 0.0, z), [-0.15, NORTH], ROOF - UPPER, 0.3, &[window(16.0, 3.0)], sheet);
    }
    b.wall(at(EAST + 0.15, 0.0, 0.0), [EAST + 0.15, NORTH], UPPER, 0.3, &[door(16.0)], sheet);
    b.wall(at(EAST + 0.15, 0.0, UPPER), [EAST + 0.15, NORTH], ROOF - UPPER, 0.3, &[window(6.0, 3.0)], sheet);
    b.aligned_box(at(-0.4, -0.4, ROOF), at(EAST + 0.4, NORTH + 0.4, ROOF + 0.25), Material::Galvanised);
    b.aligned_box(at(0.0, 0.0, 0.0), at(EAST, NORTH, 0.004), Material::Floor);
    for i in 0..5 {
        let x = 4.0 + 7.0 * f64::from(i);
        b.truss(at(x, 0.1, ROOF - 0.05), at(x, NORTH - 0.1, ROOF - 0.05), 0.7, 12, Material::BluePaint);
        for y in [0.25, 14.6, NORTH - 0.25] {
            b.column(at(x, y, 0.0), ROOF - 0.8, false, Material::BluePaint);
        }
    }
    b.leaf(at(EAST, 16.65, 0.0), 2.9, 1.3, 2.15, Material::Galvanised);
    // Roof plant.
    b.machine(at(10.0, 12.0, ROOF + 0.25), at(3.0, 2.0, 1.8), 0.0);
    b.railing(
        &[at(0.0, 0.0, ROOF + 0.25), at(EAST, 0.0, ROOF + 0.25), at(EAST, NORTH, ROOF + 0.25)],
        Material::Galvanised,
    );
}

/// The upper floor, with openings for the tall vessels and for the stairs.
fn upper_slab(b: &mut Builder) {
    let (low, high) = (UPPER - 0.22, UPPER);
    let mut slab = |x0: f64, y0: f64, x1: f64, y1: f64| {
        b.aligned_box(at(x0, y0, low), at(x1, y1, high), Material::Concrete)
    };
    slab(0.0, 0.0, 2.0, 14.0);
    slab(2.0, 0.0, 14.0, 2.0);
    slab(2.0, 12.0, 14.0, 14.0);
    slab(14.0, 0.0, EAST, 14.0);
    slab(0.0, 14.0, 26.6, NORTH);
    slab(26.6, 14.0, EAST, 18.1);
    slab(26.6, 21.1, EAST, NORTH);
    slab(31.7, 18.1, EAST, 21.1);
    for i in 0..6 {
        let x = 3.0 + 6.0 * f64::from(i);
        if x < 26.0 {
            b.beam(at(x, 14.05, low - 0.15), at(x, NORTH, low - 0.15), 0.18, 0.3, Material::BluePaint);
        }
    }
    let z = UPPER;
    b.railing(
        &[at(1.95, 1.95, z), at(14.05, 1.95, z), at(14.05, 12.05, z), at(1.95, 12.05, z), at(1.95, 1.95, z)],
        Material::YellowPaint,
    );
    b.railing(
        &[at(26.7, 18.05, z), at(31.75, 18.05, z), at(31.75, 21.15, z), at(26.7, 21.15, z)],
        Material::YellowPaint,
    );
}

/// Two flights and a landing.
fn stairwell(b: &mut Builder) {
    let landing = UPPER / 2.0;
    b.stairs(at(26.6, 18.9, 0.0), Vector3::x(), 1.35, 12, 0.17, 0.28);
    b.stairs(at(29.96, 20.35, landing), -Vector3::x(), 1.35, 12, 0.17, 0.28);
    b.aligned_box(at(29.96, 18.15, landing - 0.15), at(31.65, 21.1, landing), Material::Galvanised);
    b.railing(
        &[
            at(30.0, 18.18, landing),
            at(31.62, 18.18, landing),
            at(31.62, 21.07, landing),
            at(30.0, 21.07, landing),
        ],
        Material::YellowPaint,
    );
    for y in [18.2, 21.05] {
        b.cylinder(at(31.55, y, 0.0), at(31.55, y, landing), 0.06, Material::BluePaint);
    }
}

fn ground_floor(b: &mut Builder) {
    let plaster = Material::Plaster;
    b.wall(at(24.0, 0.0, 0.0), [24.0, NORTH], UPPER - 0.22, 0.18, &[door(3.5), door(16.0)], plaster);
    b.wall(at(24.0, 7.0, 0.0), [EAST, 7.0], UPPER - 0.22, 0.14, &[door(6.0)], plaster);
    b.wall(at(24.0, 14.0, 0.0), [EAST, 14.0], UPPER - 0.22, 0.14, &[door(9.0)], plaster);
    b.leaf(at(24.0, 4.2, 0.0), 0.5, 1.3, 2.15, Material::Galvanised);
    b.leaf(at(33.7, 14.0, 0.0), 4.3, 1.3, 2.15, Material::Wood);
    // Tall vessels through both floors.
    for (i, (x, y)) in [(5.0, 4.6), (10.2, 4.6), (5.0, 9.4), (10.2, 9.4)].into_iter().enumerate() {
        b.tank(at(x, y, 0.0), 0.95, 5.6 + 0.3 * i as f64);
    }
    b.pipe(
        &[at(5.0, 4.6, 6.6), at(5.0, 4.6, 7.2), at(10.2, 9.4, 7.2), at(10.2, 9.4, 7.0)],
        0.11,
        Material::Galvanised,
    );
    b.pipe(&[at(5.0, 9.4, 7.0), at(5.0, 9.4, 7.3), at(5.0, 23.4, 7.3)], 0.1, Material::Steel);
    for y in [3.2, 6.2, 9.2] {
        b.pump(at(17.2, y, 0.0), false);
    }
    for (y, z, radius) in [(1.2, 3.2, 0.14), (11.6, 3.4, 0.1), (12.1, 3.2, 0.08)] {
        b.pipe(&[at(0.4, y, z), at(23.6, y, z)], radius, Material::Galvanised);
    }
    for (i, x) in [5.4, 11.2, 17.0].into_iter().enumerate() {
        b.machine(at(x, 17.2, 0.0), at(2.8 + 0.3 * i as f64, 1.5, 2.0), 0.05 * i as f64);
    }
    b.tray(at(0.3, 19.3, 3.3), at(23.8, 19.3, 3.3), 0.6);
    b.duct(at(0.6, 22.8, 3.2), at(23.4, 22.8, 3.2), 0.8, 0.5);
    b.cabinets(at(8.0, 23.3, 0.0), 6, false);
    b.cabinets(at(25.0, 0.1, 0.0), 7, false);
    b.cabinets(at(32.6, 0.1, 0.0), 3, false);
    b.cabinets(at(35.3, 1.6, 0.0), 5, true);
    // Workshop and lobby.
    b.rack(at(24.4, 12.6, 0.0), 5.4, 2, false);
    for (x, y) in [(26.2, 7.6), (34.4, 9.4)] {
        b.table(at(x, y, 0.0), [2.0, 0.8], if x > 30.0 { 1.57 } else { 0.0 });
    }
    b.drum(at(35.4, 13.2, 0.0), 0.3, 0.9);
    b.extinguisher(at(24.1, 14.6, 0.0), Vector3::x());
    b.table(at(34.6, 22.6, 0.0), [1.8, 0.8], 0.0);
    b.chair(at(34.4, 21.8, 0.0), 1.5);
    b.pallet(at(33.0, 19.4, 0.0), false, 1.2);
    for (x, y) in [(21.6, 23.2), (15.6, 23.2), (0.8, 16.0)] {
        b.pallet(at(x, y, 0.0), y < 20.0, 1.3);
    }
}

fn upper_floor(b: &mut Builder) {
    let (plaster, z) = (Material::Plaster, UPPER);
    b.wall(at(24.0, 0.0, z), [24.0, 14.0], 3.3, 0.14, &[door(10.0)], plaster);
    b.wall(at(24.0, 14.0, z), [EAST, 14.0], 3.3, 0.14, &[door(6.0)], plaster);
    b.leaf(at(24.0, 10.7, z), 0.6, 1.3, 2.15, Material::Wood);
    b.leaf(at(30.7, 14.0, z), 4.5, 1.3, 2.15, Material::Wood);
    // Control room.
    for i in 0..5 {
        let x = 26.0 + 1.9 * f64::from(i);
        b.table(at(x, 3.4, z), [1.7, 0.9], 0.0);
        b.oriented_box(at(x, 3.1, z + 0.76), at(1.3, 0.06, 0.5), 0.0, Material::DarkPaint);
        b.chair(at(x + 0.1, 4.4, z), -1.4);
    }
    b.aligned_box(at(25.0, 0.05, z + 0.9), at(35.0, 0.12, z + 2.4), Material::DarkPaint);
    b.cabinets(at(35.3, 5.6, z), 6, true);
    // Heat exchangers and ducts on the open floor.
    for y in [3.4, 6.4] {
        b.vessel(at(19.2, y, z + 1.05), Vector3::x(), 2.6, 0.5);
    }
    b.machine(at(8.0, 18.2, z), at(3.4, 1.6, 2.1), 0.0);
    b.machine(at(15.0, 18.2, z), at(2.6, 1.6, 1.9), 0.06);
    b.cabinets(at(5.0, 23.3, z), 8, false);
    b.duct(at(0.6, 16.4, z + 2.9), at(23.6, 16.4, z + 2.9), 0.7, 0.45);
    b.tray(at(22.6, 0.4, z + 2.8), at(22.6, 23.6, z + 2.8), 0.5);
    b.pipe(
        &[at(19.2, 3.4, z + 1.9), at(19.2, 3.4, z + 2.6), at(19.2, 12.6, z + 2.6), at(3.0, 12.6, z + 2.6)],
        0.1,
        Material::Galvanised,
    );
    b.pallet(at(20.6, 22.8, z), false, 1.1);
    b.drum(at(34.8, 22.9, z), 0.3, 0.9);
    b.rack(at(27.4, 22.7, z), 5.4, 1, false);
    b.extinguisher(at(23.9, 12.6, z), -Vector3::x());
}

/// A corridor of 60 m without features: smooth walls, ceiling and floor.
fn corridor(b: &mut Builder) {
    let (from, plaster) = (EAST + 0.3, Material::Plaster);
    b.aligned_box(at(from, 14.5, 0.0), at(PUMP_HOUSE, 14.7, 2.9), plaster);
    b.aligned_box(at(from, 17.3, 0.0), at(PUMP_HOUSE, 17.5, 2.9), plaster);
    b.aligned_box(at(from, 14.5, 2.9), at(PUMP_HOUSE, 17.5, 3.1), plaster);
    b.aligned_box(at(from, 14.7, 0.0), at(PUMP_HOUSE, 17.3, 0.004), Material::Floor);
}

fn pump_house(b: &mut Builder) {
    let (x, east) = (PUMP_HOUSE, PUMP_HOUSE + 12.0);
    b.wall(at(x + 0.1, 9.0, 0.0), [x + 0.1, NORTH], 4.6, 0.2, &[door(7.0)], Material::Concrete);
    b.wall(at(east, 9.0, 0.0), [east, NORTH], 4.6, 0.2, &[], Material::Concrete);
    b.wall(at(x, 9.0, 0.0), [east, 9.0], 4.6, 0.2, &[gate(5.0)], Material::Concrete);
    b.wall(at(x, NORTH, 0.0), [east, NORTH], 4.6, 0.2, &[window(6.0, 3.0)], Material::Concrete);
    b.aligned_box(at(x - 0.2, 8.8, 4.6), at(east + 0.2, NORTH + 0.2, 4.85), Material::Concrete);
    for y in [12.6, 18.4, 21.4] {
        b.pump(at(x + 9.0, y, 0.0), false);
    }
    b.pump(at(x + 2.0, 21.0, 0.0), true);
    b.pipe(
        &[at(x + 0.6, 23.4, 3.0), at(x + 11.4, 23.4, 3.0), at(x + 11.4, 9.6, 3.0)],
        0.18,
        Material::Galvanised,
    );
    b.pipe(&[at(x + 0.6, 23.0, 2.6), at(x + 11.0, 23.0, 2.6), at(x + 11.0, 9.6, 2.6)], 0.1, Material::Steel);
    b.cabinets(at(x + 0.3, 10.0, 0.0), 3, true);
    b.beam(at(x + 6.0, 9.2, 4.3), at(x + 6.0, 23.8, 4.3), 0.2, 0.35, Material::YellowPaint);
}

fn yard(b: &mut Builder) {
    for (x, y, radius, height) in [(64.0, -12.0, 3.2, 6.5), (73.5, -12.0, 3.2, 6.5), (68.8, -19.4, 2.4, 8.0)]
    {
        b.tank(at(x, y, 0.0), radius, height);
    }
    // A bund wall round the tanks, with pipes over it.
    b.railing(
        &[
            at(58.5, -6.6, 0.0),
            at(79.0, -6.6, 0.0),
            at(79.0, -23.4, 0.0),
            at(58.5, -23.4, 0.0),
            at(58.5, -6.6, 0.0),
        ],
        Material::Galvanised,
    );
    for i in 0..9 {
        let x = 40.0 + 7.0 * f64::from(i);
        for y in [3.0, 6.2] {
            b.column(at(x, y, 0.0), 5.8, true, Material::Galvanised);
        }
        for z in [4.4, 5.7] {
            b.beam(at(x, 2.7, z), at(x, 6.5, z), 0.2, 0.25, Material::Galvanised);
        }
        if i < 8 {
            b.beam(at(x, 3.0, 4.4), at(x + 7.0, 3.0, 5.7), 0.08, 0.08, Material::Galvanised);
        }
    }
    for (y, z, radius) in [
        (3.3, 4.7, 0.18),
        (3.9, 4.65, 0.12),
        (4.5, 4.75, 0.22),
        (5.3, 4.65, 0.1),
        (3.6, 5.95, 0.12),
        (4.4, 6.0, 0.16),
    ] {
        b.pipe(&[at(36.4, y, z), at(97.0, y, z), at(97.0, 8.8, z)], radius, Material::Galvanised);
    }
    b.tray(at(37.0, 5.6, 6.0), at(96.0, 5.6, 6.0), 0.7);
    b.pipe(
        &[at(64.0, -8.6, 1.2), at(64.0, -1.0, 1.2), at(64.0, -1.0, 4.7), at(64.0, 3.3, 4.7)],
        0.14,
        Material::Galvanised,
    );
    b.pipe(
        &[at(73.5, -8.6, 1.0), at(73.5, 1.6, 1.0), at(73.5, 1.6, 4.7), at(73.5, 3.9, 4.7)],
        0.12,
        Material::Steel,
    );
    containers_and_truck(b);
}

fn containers_and_truck(b: &mut Builder) {
    for (x, y, yaw, z) in
        [(44.0, -16.0, 0.0, 0.0), (44.2, -19.2, 0.04, 0.0), (44.0, -16.1, 0.02, 2.6), (30.0, -22.0, 1.4, 0.0)]
    {
        b.oriented_box(at(x, y, z), at(6.06, 2.44, 2.6), yaw, Material::BluePaint);
        let turn = nalgebra::Rotation3::from_euler_angles(0.0, 0.0, yaw);
        for rib in 0..16 {
            for side in [-1.23, 1.23] {
                let foot = at(x, y, z + 0.15) + turn * at(-2.85 + 0.38 * f64::from(rib), side, 0.0);
                b.oriented_box(foot, at(0.14, 0.05, 2.3), yaw, Material::BluePaint);
            }
        }
    }
    // A lorry.
    b.aligned_box(at(20.0, -14.2, 1.1), at(27.0, -11.8, 3.6), Material::WhiteSheet);
    b.aligned_box(at(27.3, -14.1, 0.7), at(29.4, -11.9, 2.9), Material::YellowPaint);
    b.aligned_box(at(20.0, -13.6, 0.7), at(29.0, -12.4, 1.1), Material::DarkPaint);
    for x in [21.4, 22.6, 28.3] {
        for y in [-14.15, -12.15] {
            b.cylinder(at(x, y, 0.5), at(x, y + 0.3, 0.5), 0.5, Material::Rubber);
        }
    }
    for i in 0..5 {
        let foot = at(36.0 + 15.0 * f64::from(i), -3.6, 0.0);
        b.cylinder(foot, foot + Vector3::z() * 6.5, 0.08, Material::Galvanised);
        b.cylinder(foot + Vector3::z() * 6.5, foot + at(0.0, 1.3, 6.7), 0.05, Material::Galvanised);
        b.aligned_box(foot + at(-0.2, 0.9, 6.6), foot + at(0.2, 1.7, 6.75), Material::WhiteSheet);
    }
    for i in 0..7 {
        b.drum(at(51.0 + 0.65 * f64::from(i % 4), -20.0 - 0.65 * f64::from(i / 4), 0.0), 0.3, 0.9);
    }
    for (x, y) in [(88.0, -8.0), (89.6, -8.3), (88.4, -10.4), (8.0, -5.6), (3.0, -8.0)] {
        b.pallet(at(x, y, 0.0), false, 1.5);
    }
}

fn fence_and_trees(b: &mut Builder) {
    let corners = [
        at(-15.0, -36.0, 0.0),
        at(110.0, -36.0, 0.0),
        at(110.0, 34.0, 0.0),
        at(-15.0, 34.0, 0.0),
        at(-15.0, -36.0, 0.0),
    ];
    for side in corners.windows(2) {
        let span = side[1] - side[0];
        let posts = (span.norm() / 3.0) as usize;
        for i in 0..posts {
            let foot = side[0] + span * (i as f64 / posts as f64);
            b.cylinder(foot, foot + Vector3::z() * 2.1, 0.035, Material::Galvanised);
        }
        for wire in 0..9 {
            let up = Vector3::z() * (0.1 + 0.24 * f64::from(wire));
            b.cylinder(side[0] + up, side[1] + up, 0.012, Material::Galvanised);
        }
    }
    for (x, y) in [
        (-9.0, -30.0),
        (-8.0, -18.0),
        (6.0, -32.0),
        (16.0, -30.0),
        (52.0, -31.0),
        (84.0, -31.5),
        (103.0, -30.0),
        (104.0, -16.0),
        (-9.0, 8.0),
        (50.0, 26.0),
        (70.0, 27.0),
    ] {
        tree(b, at(x, y, 0.0));
    }
}

fn tree(b: &mut Builder, foot: Vector3) {
    let height = b.rng.range(2.2, 3.2);
    let top = foot + at(b.rng.range(-0.2, 0.2), b.rng.range(-0.2, 0.2), height);
    b.cylinder(foot, top, 0.16, Material::Wood);
    for _ in 0..26 {
        let (angle, reach) = (b.rng.range(0.0, std::f64::consts::TAU), b.rng.range(0.2, 1.7));
        let leaf = top + at(reach * angle.cos(), reach * angle.sin(), b.rng.range(-0.3, 2.2));
        let radius = b.rng.range(0.18, 0.5);
        b.sphere(leaf, radius, Material::Foliage);
    }
    for i in 0..4 {
        let angle = 1.57 * f64::from(i) + 0.3;
        b.cylinder(
            top - Vector3::z() * 0.4,
            top + at(1.0 * angle.cos(), 1.0 * angle.sin(), 0.9),
            0.05,
            Material::Wood,
        );
    }
}

fn routes() -> Vec<SiteRoute> {
    let start = Start { position: Vec3::new(2.4, 20.8, 0.0), yaw: 0.0 };
    let up = [[25.2, 16.0], [25.2, 18.9], [30.8, 18.9], [30.8, 20.35], [25.2, 20.35]];
    let down = [[25.2, 20.35], [30.8, 20.35], [30.8, 18.9], [25.2, 18.9], [25.2, 16.0]];
    let ground = [
        [22.4, 20.8],
        [22.4, 13.4],
        [13.2, 13.4],
        [13.2, 2.2],
        [1.6, 2.2],
        [1.6, 13.2],
        [13.2, 13.4],
        [22.4, 13.4],
        [22.4, 16.0],
    ];
    let upper = [
        [22.0, 20.35],
        [22.0, 13.2],
        [15.2, 13.2],
        [15.2, 1.0],
        [1.0, 1.0],
        [1.0, 13.0],
        [15.2, 13.0],
        [22.0, 12.8],
        [22.0, 10.0],
        [30.0, 10.0],
        [30.0, 16.2],
        [25.2, 16.2],
    ];
    let outside = [
        [38.0, 16.0],
        [94.0, 16.0],
        [101.0, 16.0],
        [101.0, 6.0],
        [99.0, -2.4],
        [84.0, -2.4],
        [83.0, -26.0],
        [54.6, -26.0],
        [54.6, -2.4],
        [38.0, -2.0],
        [13.0, -5.0],
        [13.0, 13.4],
        [22.4, 13.4],
        [22.4, 20.8],
        [4.0, 20.8],
    ];
    let round = [&ground[..], &up, &upper, &down, &outside].concat();
    let short = [&ground[..1], &[[22.4, 16.0]], &up, &[[22.0, 20.35]]].concat();
    vec![
        SiteRoute { name: "round", start, waypoints: round, speed: 1.1 },
        SiteRoute { name: "short", start, waypoints: short, speed: 1.0 },
    ]
}

fn pedestrian_paths() -> Vec<Vec<Vector3>> {
    let closed = |z: f64, corners: &[[f64; 2]]| corners.iter().map(|c| at(c[0], c[1], z)).collect();
    vec![
        closed(0.0, &[[3.0, 21.4], [21.0, 21.4], [23.0, 19.8], [10.0, 20.0]]),
        closed(UPPER, &[[22.6, 19.8], [22.6, 13.8], [16.0, 13.6], [21.4, 13.8]]),
        closed(0.0, &[[14.0, -3.0], [34.0, -6.0], [52.0, -4.4], [34.0, -4.6]]),
        closed(0.0, &[[56.6, -4.0], [56.6, -25.0], [81.0, -25.4], [81.0, -4.2]]),
        closed(0.0, &[[40.0, 15.4], [92.0, 15.4], [92.0, 16.6], [40.0, 16.6]]),
    ]
}
