//! `torus`: a round hall of 20 m radius with a fusion machine in the middle, after the JET torus hall. The machine and much of the hall repeat
//! every 45°, so octants are hard to distinguish. Two neutral-beam boxes, the entrance and clutter break the symmetry.

use super::parts::{Builder, at};
use super::plan::SitePlan;
use crate::route::{SiteRoute, Start};
use crate::shape::Material;
use geometry::Vector3;
use std::f64::consts::PI;
use vocab::Vec3;

/// Distance of the walls from the axis, metres.
const WALL_RADIUS: f64 = 20.0;
const HEIGHT: f64 = 12.0;
const FACETS: usize = 24;
/// Centre of the vessel's tube: distance from the axis and height, metres.
const VESSEL_RADIUS: f64 = 4.2;
const VESSEL_HEIGHT: f64 = 4.6;
/// Semi-axes of the tube, metres.
const TUBE_WIDTH: f64 = 1.9;
const TUBE_HEIGHT: f64 = 2.5;
/// Radii of the two rings for walking, metres: outside the cubicles, and between the cubicles and the machine.
const OUTER_RING: f64 = 16.1;
const INNER_RING: f64 = 12.2;
/// Angles of the octants with neutral-beam boxes, degrees. The boxes block the inner ring.
const BEAM_BOXES: [f64; 2] = [90.0, 225.0];

pub(super) fn plan() -> SitePlan {
    let mut b = Builder::new("torus");
    hall(&mut b);
    gallery(&mut b);
    vessel(&mut b);
    coils(&mut b);
    limbs(&mut b);
    beam_boxes(&mut b);
    octants(&mut b);
    along_the_wall(&mut b);
    entrance(&mut b);
    b.dock(at(29.6, 0.0, 0.0), PI);
    b.plan.outline =
        (0..FACETS).map(|i| ring_corner(WALL_RADIUS / (PI / FACETS as f64).cos(), i as f64 - 0.5)).collect();
    b.plan.routes = routes();
    b.plan.pedestrian_paths = pedestrian_paths();
    b.plan
}

/// A point in cylindrical coordinates: distance from the axis, angle from x in degrees, and height.
fn polar(radius: f64, degrees: f64, z: f64) -> Vector3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    at(radius * cos, radius * sin, z)
}

/// Corner `i` of the hall's polygon, scaled to `radius`.
fn ring_corner(radius: f64, i: f64) -> [f64; 2] {
    let corner = polar(radius, i * 360.0 / FACETS as f64, 0.0);
    [corner.x, corner.y]
}

/// A box standing at polar coordinates: radial, tangential and vertical size.
fn radial_box(b: &mut Builder, radius: f64, degrees: f64, z: f64, size: [f64; 3], material: Material) {
    b.oriented_box(polar(radius, degrees, z), Vector3::from(size), degrees.to_radians(), material);
}

fn hall(b: &mut Builder) {
    b.aligned_box(at(-23.0, -23.0, -0.3), at(35.0, 23.0, 0.0), Material::Floor);
    b.aligned_box(at(-21.0, -21.0, HEIGHT), at(21.0, 21.0, HEIGHT + 0.4), Material::Concrete);
    let corner_radius = (WALL_RADIUS + 0.25) / (PI / FACETS as f64).cos();
    for i in 0..FACETS {
        let ([x, y], to) =
            (ring_corner(corner_radius, i as f64 - 0.5), ring_corner(corner_radius, i as f64 + 0.5));
        let gate = super::parts::gate(2.66);
        let openings = if i == 0 { std::slice::from_ref(&gate) } else { &[] };
        b.wall(at(x, y, 0.0), to, HEIGHT, 0.5, openings, Material::Concrete);
        let degrees = 15.0 * (i as f64 + 0.5);
        radial_box(b, WALL_RADIUS - 0.05, degrees, 0.0, [0.5, 0.6, HEIGHT], Material::Concrete);
    }
    // The other entrance is closed by a shield door on rails.
    radial_box(b, WALL_RADIUS - 0.3, 180.0, 0.0, [0.5, 3.6, 4.2], Material::YellowPaint);
    for side in [-2.6, 2.6] {
        b.beam(
            at(-WALL_RADIUS + 0.7, side - 1.2, 4.4),
            at(-WALL_RADIUS + 0.7, side + 1.2, 4.4),
            0.2,
            0.2,
            Material::Steel,
        );
    }
    for y in [-6.0, -5.0, 5.0, 6.0] {
        b.beam(at(-18.6, y, 11.2), at(18.6, y, 11.2), 0.4, 0.8, Material::YellowPaint);
    }
    b.aligned_box(at(-3.0, -6.5, 10.6), at(0.5, -4.5, 11.6), Material::YellowPaint);
    for i in 0..9 {
        let x = -16.0 + 4.0 * f64::from(i);
        let reach = (19.6_f64 * 19.6 - x * x).sqrt();
        b.beam(at(x, -reach, HEIGHT - 0.2), at(x, reach, HEIGHT - 0.2), 0.25, 0.4, Material::Galvanised);
    }
}

/// A walkway along the wall at 5 m, on brackets and posts, with ladders up to it.
fn gallery(b: &mut Builder) {
    let level = 5.0;
    for i in 0..FACETS {
        let degrees = 15.0 * i as f64;
        if i == 0 {
            continue;
        }
        radial_box(b, 19.0, degrees, level - 0.1, [2.0, 5.2, 0.1], Material::Galvanised);
        radial_box(b, 19.0, degrees, level - 0.35, [2.0, 0.12, 0.25], Material::BluePaint);
        b.railing(
            &[polar(18.1, degrees - 7.4, level), polar(18.1, degrees + 7.4, level)],
            Material::YellowPaint,
        );
        if i % 2 == 1 {
            b.cylinder(
                polar(18.2, degrees, 0.0),
                polar(18.2, degrees, level - 0.1),
                0.1,
                Material::BluePaint,
            );
            radial_box(b, 18.2, degrees, 0.0, [0.35, 0.35, 0.03], Material::Steel);
        }
    }
    for degrees in [67.5, 157.5, 307.5] {
        let side = polar(1.0, degrees + 90.0, 0.0);
        b.ladder(polar(17.85, degrees, 0.0), 6.0, side);
    }
}

/// The vacuum vessel: an elongated tube bent into a ring, as a mesh.
fn vessel(b: &mut Builder) {
    const AROUND: usize = 48;
    const SECTION: usize = 20;
    let node = |i: usize, j: usize| {
        let (sin, cos) = (j as f64 * 2.0 * PI / SECTION as f64).sin_cos();
        polar(
            VESSEL_RADIUS + TUBE_WIDTH * cos,
            360.0 * i as f64 / AROUND as f64,
            VESSEL_HEIGHT + TUBE_HEIGHT * sin,
        )
    };
    for i in 0..AROUND {
        for j in 0..SECTION {
            b.quad([node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)], Material::Steel);
        }
    }
    b.cylinder(at(0.0, 0.0, 0.0), at(0.0, 0.0, 10.2), 1.3, Material::DarkPaint);
    b.cylinder(at(0.0, 0.0, 0.0), at(0.0, 0.0, 0.32), 7.4, Material::Concrete);
    b.cylinder(at(0.0, 0.0, 9.9), at(0.0, 0.0, 10.4), 2.6, Material::YellowPaint);
    for i in 0..16 {
        let degrees = 22.5 * f64::from(i) + 11.25;
        b.beam(polar(5.0, degrees, 0.3), polar(5.4, degrees, 2.6), 0.3, 0.3, Material::Steel);
    }
}

/// Toroidal-field coils about the tube and poloidal-field rings about the machine.
fn coils(b: &mut Builder) {
    const SIDES: usize = 14;
    for coil in 0..16 {
        let degrees = 22.5 * f64::from(coil);
        let node = |j: usize| {
            let (sin, cos) = (j as f64 * 2.0 * PI / SIDES as f64).sin_cos();
            polar(
                VESSEL_RADIUS + (TUBE_WIDTH + 0.45) * cos,
                degrees,
                VESSEL_HEIGHT + (TUBE_HEIGHT + 0.5) * sin,
            )
        };
        for j in 0..SIDES {
            b.beam(node(j), node(j + 1), 0.42, 0.5, Material::BluePaint);
        }
    }
    for (radius, z, thickness) in [(7.15, 2.1, 0.3), (7.15, 7.1, 0.3), (5.2, 8.0, 0.25), (5.6, 1.2, 0.2)] {
        ring(b, radius, z, thickness, 32, Material::Galvanised);
    }
}

/// A ring of rods about the axis.
fn ring(b: &mut Builder, radius: f64, z: f64, thickness: f64, sides: usize, material: Material) {
    for i in 0..sides {
        let node = |i: usize| polar(radius, 360.0 * i as f64 / sides as f64, z);
        b.cylinder(node(i), node(i + 1), thickness, material);
    }
}

/// The transformer's iron limbs stand between the octants.
fn limbs(b: &mut Builder) {
    for i in 0..8 {
        let degrees = 45.0 * f64::from(i) + 22.5;
        radial_box(b, 8.5, degrees, 0.0, [1.3, 1.7, 9.4], Material::YellowPaint);
        radial_box(b, 5.2, degrees, 9.0, [7.9, 1.5, 1.2], Material::YellowPaint);
        radial_box(b, 8.5, degrees, 0.0, [1.7, 2.1, 0.4], Material::Concrete);
        for z in [2.0, 4.0, 6.0, 8.0] {
            radial_box(b, 8.5, degrees, z, [1.4, 1.8, 0.12], Material::DarkPaint);
        }
    }
}

/// The big boxes of neutral-beam injection, on legs, with their ducts and pumps.
fn beam_boxes(b: &mut Builder) {
    for degrees in BEAM_BOXES {
        radial_box(b, 11.3, degrees, 1.5, [3.6, 2.7, 4.4], Material::WhiteSheet);
        for z in [2.2, 3.3, 4.4, 5.5] {
            radial_box(b, 11.3, degrees, z, [3.75, 2.85, 0.12], Material::Galvanised);
        }
        b.cylinder(
            polar(6.3, degrees, VESSEL_HEIGHT),
            polar(9.6, degrees, VESSEL_HEIGHT),
            0.55,
            Material::Steel,
        );
        b.cylinder(
            polar(9.1, degrees, VESSEL_HEIGHT),
            polar(9.3, degrees, VESSEL_HEIGHT),
            0.8,
            Material::Steel,
        );
        for radius in [10.0, 12.6] {
            for side in [-1.0, 1.0] {
                let foot = polar(radius, degrees + side * 55.0 / radius, 0.0);
                b.beam(foot, foot + Vector3::z() * 1.5, 0.3, 0.3, Material::BluePaint);
            }
        }
        b.cylinder(polar(13.1, degrees, 3.7), polar(13.7, degrees, 3.7), 1.0, Material::Galvanised);
        b.pipe(
            &[polar(12.0, degrees, 5.9), polar(12.0, degrees, 8.4), polar(19.6, degrees, 8.4)],
            0.3,
            Material::Galvanised,
        );
        b.railing(&[polar(12.8, degrees - 5.0, 5.9), polar(12.8, degrees + 5.0, 5.9)], Material::YellowPaint);
    }
}

/// Ports, diagnostics and pumps at the other octants, and cubicles between all of them.
fn octants(b: &mut Builder) {
    for i in 0..8 {
        let degrees = 45.0 * f64::from(i);
        let cubicle = degrees + 22.5;
        radial_box(b, 14.0, cubicle, 0.0, [1.0, 1.9, 2.2], Material::WhiteSheet);
        radial_box(b, 14.54, cubicle, 0.9, [0.05, 1.5, 0.8], Material::DarkPaint);
        b.pipe(
            &[polar(14.0, cubicle, 2.2), polar(14.0, cubicle, 3.4), polar(9.2, cubicle, 3.4)],
            0.06,
            Material::Rubber,
        );
        if BEAM_BOXES.contains(&degrees) {
            continue;
        }
        b.cylinder(
            polar(6.2, degrees, VESSEL_HEIGHT),
            polar(8.6, degrees, VESSEL_HEIGHT),
            0.42,
            Material::Steel,
        );
        b.cylinder(
            polar(8.5, degrees, VESSEL_HEIGHT),
            polar(8.65, degrees, VESSEL_HEIGHT),
            0.6,
            Material::Steel,
        );
        b.pipe(
            &[
                polar(8.6, degrees, VESSEL_HEIGHT),
                polar(10.4, degrees, VESSEL_HEIGHT),
                polar(10.4, degrees, 2.9),
                polar(17.9, degrees + 4.0, 2.9),
            ],
            0.12,
            Material::Galvanised,
        );
        radial_box(b, 9.3, degrees, VESSEL_HEIGHT + 0.45, [1.2, 0.9, 0.8], Material::DarkPaint);
        match i {
            0 => b.pump(polar(9.9, degrees, 0.0), false),
            1 => b.tank(polar(10.1, degrees, 0.0), 0.75, 2.2),
            4 => b.pump(polar(9.9, degrees, 0.0), false),
            6 => b.pump(polar(9.9, degrees, 0.0), true),
            _ => b.machine(polar(10.0, degrees, 0.0), at(1.8, 1.0, 1.9), (degrees + 90.0).to_radians()),
        }
    }
}

fn along_the_wall(b: &mut Builder) {
    ring(b, 19.5, 2.9, 0.11, FACETS, Material::Galvanised);
    ring(b, 19.5, 3.25, 0.07, FACETS, Material::Steel);
    for i in 1..FACETS {
        let degrees = 15.0 * i as f64;
        b.tray(polar(19.0, degrees - 7.5, 3.9), polar(19.0, degrees + 7.5, 3.9), 0.5);
        radial_box(b, WALL_RADIUS - 0.03, degrees, 1.7, [0.04, 0.5, 0.35], Material::Reflector);
        match b.rng.bits() % 6 {
            0..=2 => {
                for k in 0..3 {
                    let along = degrees + 2.5 * (f64::from(k) - 1.0);
                    radial_box(b, 19.1, along, 0.0, [0.6, 0.78, 2.1], Material::WhiteSheet);
                    radial_box(b, 18.78, along + 0.8, 1.0, [0.05, 0.04, 0.25], Material::DarkPaint);
                }
            }
            3 => b.pallet(polar(18.9, degrees, 0.0), i % 2 == 0, 1.3),
            4 => b.table(polar(18.95, degrees, 0.0), [1.8, 0.7], (degrees + 90.0).to_radians()),
            _ => b.drum(polar(19.0, degrees, 0.0), 0.3, 0.9),
        }
    }
}

/// The entrance in the east, where the dock is.
fn entrance(b: &mut Builder) {
    for y in [-2.4, 2.4] {
        b.wall(at(20.5, y, 0.0), [32.0, y], 4.0, 0.3, &[], Material::Plaster);
    }
    b.wall(at(32.0, -2.4, 0.0), [32.0, 2.4], 4.0, 0.3, &[], Material::Plaster);
    b.aligned_box(at(20.4, -2.6, 4.0), at(32.2, 2.6, 4.3), Material::Concrete);
    b.aligned_box(at(31.75, -0.9, 0.0), at(31.85, 0.9, 2.3), Material::Galvanised);
    b.cabinets(at(24.6, 1.65, 0.0), 3, false);
    b.tray(at(20.6, -1.9, 3.5), at(31.8, -1.9, 3.5), 0.5);
    b.extinguisher(at(26.0, -2.25, 0.0), Vector3::y());
    b.table(at(28.0, -1.8, 0.0), [1.6, 0.7], 0.0);
}

/// Corners on a ring from one angle to another, every 10 degrees or so.
fn arc(radius: f64, from: f64, to: f64) -> Vec<[f64; 2]> {
    let steps = ((to - from).abs() / 10.0).ceil() as usize;
    (0..=steps)
        .map(|i| polar(radius, from + (to - from) * i as f64 / steps as f64, 0.0))
        .map(|corner| [corner.x, corner.y])
        .collect()
}

fn routes() -> Vec<SiteRoute> {
    let start = Start { position: Vec3::new(29.6, 0.0, 0.0), yaw: PI };
    let legs = [
        arc(OUTER_RING, 0.0, 360.0),
        // Along the machine up to the beam boxes.
        arc(INNER_RING, 360.0, 315.0),
        arc(INNER_RING, 315.0, 255.0),
        arc(OUTER_RING, 255.0, 195.0),
        arc(INNER_RING, 190.0, 120.0),
        arc(OUTER_RING, 120.0, 62.0),
        arc(INNER_RING, 58.0, 5.0),
        arc(OUTER_RING, 0.0, -125.0),
        arc(OUTER_RING, -130.0, 0.0),
        // Once more in the opposite direction, changing between the rings.
        arc(OUTER_RING, 0.0, -135.0),
        arc(OUTER_RING, 225.0, 182.0),
        arc(INNER_RING, 178.0, 122.0),
        arc(OUTER_RING, 118.0, 47.0),
        arc(INNER_RING, 43.0, -43.0),
        arc(OUTER_RING, -47.0, -120.0),
        arc(OUTER_RING, -118.0, 0.0),
    ];
    let mut round: Vec<[f64; 2]> = legs.concat();
    round.push([28.6, 0.0]);
    let mut short = arc(OUTER_RING, 0.0, 45.0);
    short.extend(arc(INNER_RING, 45.0, 0.0));
    short.push([24.0, 0.0]);
    vec![
        SiteRoute { name: "round", start, waypoints: round, speed: 0.95 },
        SiteRoute { name: "short", start, waypoints: short, speed: 1.1 },
    ]
}

fn pedestrian_paths() -> Vec<Vec<Vector3>> {
    let closed = |radius: f64, from: f64, to: f64| {
        let there = arc(radius, from, to);
        let back = there.iter().rev().skip(1).copied().collect::<Vec<_>>();
        let corners = [there, back[..back.len() - 1].to_vec()].concat();
        corners.into_iter().map(|c| at(c[0], c[1], 0.0)).collect::<Vec<_>>()
    };
    vec![
        closed(16.9, 15.0, 130.0),
        closed(15.4, 150.0, 260.0),
        closed(11.9, 275.0, 345.0),
        closed(16.9, 280.0, 345.0),
        closed(12.0, 125.0, 200.0),
    ]
}
