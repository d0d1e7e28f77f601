//! `twins`: two identical rooms with identical furniture on one side of a bare corridor, and a lobby at its end. Scans inside a room do not
//! distinguish the two. Only the path to the room does. The site tests perceptual aliasing.

use super::parts::{Builder, at, door, gate};
use super::plan::SitePlan;
use crate::route::{SiteRoute, Start};
use crate::shape::Material;
use geometry::{RngTree, Vector3};
use vocab::Vec3;

const HEIGHT: f64 = 3.2;
/// x of the west walls of the two rooms, metres.
const ROOMS: [f64; 2] = [6.0, 40.0];
const ROOM_LENGTH: f64 = 14.0;
const ROOM_DEPTH: f64 = 12.0;
/// x at which the corridor ends, metres. It begins at the lobby.
const CORRIDOR_END: f64 = 64.0;
/// Width of the corridor, metres. It lies south of the rooms.
const CORRIDOR_WIDTH: f64 = 3.0;
/// Distance of the middle of a room's door from its west wall, metres.
const DOOR: f64 = 3.0;
/// South-west corner of the lobby, metres.
const LOBBY_MIN: [f64; 2] = [-12.0, -9.0];
/// North-east corner of the lobby, metres.
const LOBBY_MAX: [f64; 2] = [0.0, 3.0];

pub(super) fn plan() -> SitePlan {
    let mut b = Builder::new("twins");
    b.aligned_box(at(-16.0, -13.0, -0.3), at(CORRIDOR_END + 4.0, ROOM_DEPTH + 4.0, 0.0), Material::Floor);
    b.aligned_box(
        at(-12.5, -9.5, HEIGHT),
        at(CORRIDOR_END + 0.5, ROOM_DEPTH + 0.5, HEIGHT + 0.3),
        Material::Concrete,
    );
    for west in ROOMS {
        // Both rooms get the same random numbers, so their furniture is the same.
        b.rng = RngTree::new(2024).child("twin").rng();
        room(&mut b, west);
    }
    corridor(&mut b);
    lobby(&mut b);
    b.dock(at(-8.0, -1.5, 0.0), 0.0);
    b.plan.outline = vec![
        LOBBY_MIN,
        [LOBBY_MAX[0], LOBBY_MIN[1]],
        [LOBBY_MAX[0], -CORRIDOR_WIDTH],
        [CORRIDOR_END, -CORRIDOR_WIDTH],
        [CORRIDOR_END, ROOM_DEPTH],
        [LOBBY_MIN[0], ROOM_DEPTH],
    ];
    b.plan.routes = routes();
    b.plan.pedestrian_paths = pedestrian_paths();
    b.plan
}

/// One of the two rooms. All coordinates are relative to the room's corner.
fn room(b: &mut Builder, west: f64) {
    let place = |x: f64, y: f64, z: f64| at(west + x, y, z);
    for x in [-0.1, ROOM_LENGTH + 0.1] {
        b.wall(place(x, 0.0, 0.0), [west + x, ROOM_DEPTH], HEIGHT, 0.2, &[], Material::Plaster);
    }
    let north = ROOM_DEPTH + 0.1;
    b.wall(place(-0.2, north, 0.0), [west + ROOM_LENGTH + 0.2, north], HEIGHT, 0.2, &[], Material::Plaster);
    b.leaf(place(DOOR - 0.7, 0.1, 0.0), 1.7, 1.3, 2.1, Material::Wood);
    b.rack(place(4.4, 5.2, 0.0), 5.4, 1, false);
    b.cabinets(place(2.2, 11.35, 0.0), 5, false);
    b.machine(place(9.4, 10.9, 0.0), at(2.4, 1.3, 1.9), 0.0);
    b.pump(place(13.0, 9.6, 0.0), true);
    b.drum(place(13.4, 6.6, 0.0), 0.3, 0.9);
    b.drum(place(13.3, 5.8, 0.0), 0.3, 0.9);
    b.table(place(0.6, 6.2, 0.0), [1.8, 0.8], std::f64::consts::FRAC_PI_2);
    b.chair(place(1.3, 6.4, 0.0), 2.6);
    b.table(place(10.2, 0.6, 0.0), [2.2, 0.8], 0.0);
    b.tank(place(12.9, 2.2, 0.0), 0.6, 1.9);
    b.pallet(place(0.8, 10.6, 0.0), true, 1.0);
    b.column(place(7.0, ROOM_DEPTH - 0.25, 0.0), HEIGHT, false, Material::BluePaint);
    b.extinguisher(place(0.0, 2.6, 0.0), Vector3::x());
    b.duct(place(0.3, 8.2, 2.75), place(ROOM_LENGTH - 0.3, 8.2, 2.75), 0.6, 0.4);
    b.pipe(
        &[place(13.6, 0.4, 2.6), place(13.6, 11.6, 2.6), place(0.4, 11.6, 2.6)],
        0.07,
        Material::Galvanised,
    );
}

/// A bare corridor. No feature distinguishes places along it.
fn corridor(b: &mut Builder) {
    let doors = ROOMS.map(|west| door(west + DOOR));
    b.wall(at(0.0, -0.1, 0.0), [CORRIDOR_END, -0.1], HEIGHT, 0.2, &doors, Material::Plaster);
    let south = -CORRIDOR_WIDTH - 0.1;
    b.wall(at(0.0, south, 0.0), [CORRIDOR_END, south], HEIGHT, 0.2, &[], Material::Plaster);
    let end = CORRIDOR_END + 0.1;
    b.wall(at(end, -CORRIDOR_WIDTH - 0.2, 0.0), [end, 0.0], HEIGHT, 0.2, &[], Material::Plaster);
    b.cabinets(at(CORRIDOR_END - 0.7, -2.9, 0.0), 2, true);
}

fn lobby(b: &mut Builder) {
    let ([west, south], [east, north]) = (LOBBY_MIN, LOBBY_MAX);
    b.wall(at(west - 0.1, south, 0.0), [west - 0.1, north], HEIGHT, 0.2, &[], Material::WhiteSheet);
    b.wall(at(west, south - 0.1, 0.0), [east, south - 0.1], HEIGHT, 0.2, &[], Material::WhiteSheet);
    b.wall(at(west, north + 0.1, 0.0), [east, north + 0.1], HEIGHT, 0.2, &[], Material::WhiteSheet);
    let mouth = gate(-CORRIDOR_WIDTH / 2.0 - south);
    b.wall(at(east + 0.1, south, 0.0), [east + 0.1, north], HEIGHT, 0.2, &[mouth], Material::WhiteSheet);
    for y in [-8.8, -6.2] {
        b.rack(at(-11.0, y, 0.0), 8.1, 1, false);
    }
    b.rack(at(-11.9, -5.0, 0.0), 2.7, 1, true);
    b.machine(at(-4.0, 1.9, 0.0), at(2.6, 1.4, 2.0), 0.0);
    b.tank(at(-9.0, 2.0, 0.0), 0.7, 2.2);
    b.drum(at(-1.0, -7.0, 0.0), 0.3, 0.9);
    b.table(at(-0.6, -5.4, 0.0), [1.6, 0.7], std::f64::consts::FRAC_PI_2);
}

/// The walk round the rack of a room, from the corridor and back to it; in the opposite direction if `reversed`.
fn walk_round_rack(west: f64, reversed: bool) -> Vec<[f64; 2]> {
    let mut corners =
        vec![[3.0, 2.4], [11.3, 2.4], [11.3, 8.9], [3.0, 8.9], [3.0, 2.4]].into_iter().collect::<Vec<_>>();
    if reversed {
        corners.reverse();
    }
    let mouth = [DOOR, -CORRIDOR_WIDTH / 2.0];
    let mut walk = vec![mouth];
    walk.extend(corners);
    walk.push(mouth);
    walk.into_iter().map(|[x, y]| [west + x, y]).collect()
}

fn routes() -> Vec<SiteRoute> {
    let start = Start { position: Vec3::new(-8.0, -1.5, 0.0), yaw: 0.0 };
    let [first, second] = ROOMS;
    let home = vec![[-3.0, -1.5], [-3.0, -3.6], [-6.0, -3.6], [-6.0, -1.5]];
    let laps = [
        walk_round_rack(first, false),
        walk_round_rack(second, false),
        vec![[61.0, -1.5]],
        home.clone(),
        walk_round_rack(first, true),
        walk_round_rack(second, true),
        home.clone(),
        walk_round_rack(second, false),
        walk_round_rack(first, false),
        home,
    ];
    vec![
        SiteRoute { name: "round", start, waypoints: laps.concat(), speed: 1.05 },
        SiteRoute { name: "short", start, waypoints: walk_round_rack(first, false), speed: 1.1 },
    ]
}

fn pedestrian_paths() -> Vec<Vec<Vector3>> {
    let on_floor = |corners: &[[f64; 2]]| corners.iter().map(|c| at(c[0], c[1], 0.0)).collect();
    vec![
        on_floor(&[[24.0, -0.9], [36.0, -0.9], [36.0, -2.1], [24.0, -2.1]]),
        on_floor(&[[48.0, 2.2], [51.3, 3.4], [51.3, 7.6], [48.0, 2.2]]),
        on_floor(&[[-9.0, -4.2], [-3.0, -4.4], [-2.2, -7.6], [-2.2, -4.4]]),
        on_floor(&[[9.0, 9.6], [16.4, 8.6], [17.2, 4.0], [16.4, 8.6]]),
    ]
}
