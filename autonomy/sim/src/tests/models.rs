//! Sites of triangles: rays, walking, and sites as triangles.

use super::{drive, ideal_blind, run};
use crate::{
    BuildingModel, BuildingModelConfig, Bvh, Material, Mobility, ModelPart, ModelTriangle, Shape,
    SimulatedSite, Simulator, SiteName, Solid, TessellationConfig,
};
use crate::{NO_HIT, RayPacket};
use geometry::{Rng, RngTree, Vector3};
use std::collections::BTreeMap;

fn random_point(rng: &mut Rng, reach: f64) -> Vector3 {
    Vector3::new(rng.range(-reach, reach), rng.range(-reach, reach), rng.range(-reach, reach))
}

fn direction(rng: &mut Rng) -> Vector3 {
    Vector3::new(rng.normal(), rng.normal(), rng.normal()).normalize()
}

/// Range of a ray to a triangle in 64 bits: the plane first, then the side of each edge. Also the distance of the hit from the nearest edge.
fn slow_range(origin: &Vector3, direction: &Vector3, corners: &[Vector3; 3]) -> Option<(f64, f64)> {
    let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).normalize();
    let range = (corners[0] - origin).dot(&normal) / direction.dot(&normal);
    let point = origin + direction * range;
    let inside = (0..3)
        .map(|i| {
            let edge = (corners[(i + 1) % 3] - corners[i]).normalize();
            normal.cross(&edge).dot(&(point - corners[i]))
        })
        .fold(f64::INFINITY, f64::min);
    (range.is_finite() && range > 0.0).then_some((range, inside))
}

#[test]
fn triangles_are_hit_from_both_sides_where_a_slow_twin_hits_them() {
    let mut rng = RngTree::new(11).child("triangles").rng();
    let mut hits = [0; 2];
    for _ in 0..60 {
        let triangles: Vec<[Vector3; 3]> = (0..40)
            .map(|_| {
                let at = random_point(&mut rng, 6.0);
                [0, 1, 2].map(|_| at + random_point(&mut rng, 2.0))
            })
            .collect();
        let solids: Vec<Solid> = (triangles.iter())
            .map(|corners| Solid { shape: Shape::Triangle(*corners), material: Material::Steel })
            .collect();
        let bvh = Bvh::new(&solids);
        for _ in 0..50 {
            let (origin, direction) = (random_point(&mut rng, 8.0), direction(&mut rng));
            let mut packet = RayPacket::single(&origin, &direction, 40.0);
            bvh.cast(&mut packet);
            let fast = (packet.solid[0] != NO_HIT).then(|| f64::from(packet.range[0]));
            let all = || triangles.iter().filter_map(|corners| slow_range(&origin, &direction, corners));
            // A ray within 0.1 mm of an edge may hit or miss.
            let surely = all().filter(|hit| hit.1 > 1e-4).map(|hit| hit.0).fold(f64::INFINITY, f64::min);
            let perhaps = all().filter(|hit| hit.1 > -1e-4).map(|hit| hit.0).fold(f64::INFINITY, f64::min);
            let fast_or_far = fast.unwrap_or(f64::INFINITY);
            assert!(
                fast_or_far <= surely + 1e-3 && fast_or_far >= perhaps - 1e-3,
                "{fast:?} between {perhaps} and {surely}"
            );
            if fast.is_some() {
                let normal = bvh.normal(packet.solid[0], packet.end(0)).map(f64::from);
                hits[usize::from(Vector3::from(normal).dot(&direction) > 0.0)] += 1;
            }
        }
    }
    assert!(hits.iter().all(|side| *side > 60), "rays from both sides: {hits:?}");
}

/// The number of triangles at every edge of a part, by its rounded ends.
fn uses_of_edges(part: &ModelPart) -> BTreeMap<[[i64; 3]; 2], i32> {
    let round = |corner: [f64; 3]| corner.map(|c| (c * 1e6).round() as i64);
    let mut uses = BTreeMap::new();
    for triangle in &part.triangles {
        for i in 0..3 {
            let (a, b) = (round(triangle.corners[i]), round(triangle.corners[(i + 1) % 3]));
            // Both directions of a closed surface cancel each other.
            let (key, sign) = if a < b { ([a, b], 1) } else { ([b, a], -1) };
            *uses.entry(key).or_insert(0) += sign;
        }
    }
    uses
}

#[test]
fn sites_become_closed_surfaces_with_corners_in_order() {
    for name in [SiteName::B1, SiteName::Torus, SiteName::Generated(3)] {
        let model = SimulatedSite::new(name).to_model(&TessellationConfig::default());
        for part in model.parts.iter().filter(|part| part.mobility != Mobility::Fixed) {
            assert!(uses_of_edges(part).values().all(|sum| *sum == 0), "{name}: {} is not closed", part.name);
        }
    }
}

#[test]
fn a_finer_tessellation_comes_nearer() {
    let site = SimulatedSite::new(SiteName::Torus);
    let mut last = 0;
    for max_deviation_m in [0.02, 0.005, 0.001] {
        let config = TessellationConfig { max_deviation_m, ..TessellationConfig::default() };
        let model = site.to_model(&config);
        let count: usize = model.parts.iter().map(|part| part.triangles.len()).sum();
        assert!(count > last && count < 400_000, "{count} triangles for {max_deviation_m} m");
        last = count;
    }
}

/// A quadrilateral as two triangles.
fn quad([a, b, c, d]: [[f64; 3]; 4]) -> [ModelTriangle; 2] {
    [[a, b, c], [a, c, d]].map(|corners| ModelTriangle { corners, material: Material::Concrete })
}

/// A level square, by its middle and half its side, metres.
fn square([x, y, z]: [f64; 3], half: f64) -> [ModelTriangle; 2] {
    let corner = |sx: f64, sy: f64| [x + sx * half, y + sy * half, z];
    quad([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)])
}

/// A hall of 12 m x 12 m with a wall at x = 4, as a model.
fn hall() -> BuildingModel {
    let floor = quad([[-6.0, -6.0, 0.0], [6.0, -6.0, 0.0], [6.0, 6.0, 0.0], [-6.0, 6.0, 0.0]]);
    // A ramp to a step of 0.15 m, which the robot takes.
    let step = quad([[-6.0, -6.0, 0.15], [-3.0, -6.0, 0.15], [-3.0, 6.0, 0.15], [-6.0, 6.0, 0.15]]);
    let wall = quad([[4.0, -6.0, 0.0], [4.0, 6.0, 0.0], [4.0, 6.0, 3.0], [4.0, -6.0, 3.0]]);
    let part = |name: &str, triangles: Vec<ModelTriangle>| ModelPart {
        name: name.to_owned(),
        mobility: Mobility::Fixed,
        triangles,
    };
    BuildingModel {
        name: "hall".to_owned(),
        parts: vec![part("floors", [floor, step].concat()), part("wall", wall.to_vec())],
        ..BuildingModel::default()
    }
}

#[test]
fn a_robot_walks_on_triangles_and_stops_at_them() {
    let site = SimulatedSite::from_model(hall(), &BuildingModelConfig::default()).unwrap();
    let mut simulator = Simulator::new(ideal_blind(std::sync::Arc::new(site)));
    let first = simulator.truth().site_from_base.position;
    assert!(first.x.abs() < 1.0 && first.y.abs() < 1.0, "it starts in the middle, at {first:?}");
    run(&mut simulator, drive(1.0, 0.0, 0.0), 80);
    let at_wall = simulator.truth().site_from_base.position;
    assert!((3.4..3.75).contains(&at_wall.x), "the wall stops it at {at_wall:?}");
    run(&mut simulator, drive(-0.6, 0.0, 0.0), 150);
    let on_step = simulator.truth().site_from_base.position;
    assert!(on_step.x < -3.8, "{on_step:?}");
    assert!((on_step.z - first.z - 0.15).abs() < 0.03, "it stands on the step: {on_step:?}");
}

#[test]
fn a_robot_starts_on_a_storey_and_not_on_a_landing_or_the_roof() {
    let landing = square([8.0, 8.0, -3.0], 1.0);
    let storey = square([0.0, 0.0, 0.0], 6.0);
    let roof = square([0.0, 0.0, 4.0], 7.0);
    let model = BuildingModel {
        name: "stairwell".to_owned(),
        parts: vec![ModelPart {
            name: "floors".to_owned(),
            mobility: Mobility::Fixed,
            triangles: [landing, storey, roof].concat(),
        }],
        ..BuildingModel::default()
    };
    let site = SimulatedSite::from_model(model, &BuildingModelConfig::default()).unwrap();
    let start = site.start().position;
    assert!(start.z.abs() < 1e-6, "on the storey: {start:?}");
    let round = &site.routes()[0].waypoints;
    for (axis, side) in [(0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0)] {
        assert!(
            round.iter().any(|at| at[axis] * side > 1.5),
            "the round passes all of the storey: {round:?}"
        );
    }
}
