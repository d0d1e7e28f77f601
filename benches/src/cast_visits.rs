//! Visits without the stack: sweeps are cast from places along the whole round of a site, 2 m apart, with errors of the poses as localisation leaves them. A visit takes seconds
//! instead of minutes, so that detection can be measured on many.

use anyhow::{Context, Result};
use changes::{SensorView, Visit};
use geometry::{Isometry, Rng, RngTree, Vector3, so3};
use nalgebra::Point3;
use sim::SimulatedSite;
use std::f64::consts::TAU;

/// Height of the LiDAR above the floor, metres.
const SENSOR_HEIGHT_M: f64 = 0.7;
/// Elevations of the channels, degrees, as those of the simulated robot.
const ELEVATIONS_DEG: std::ops::RangeInclusive<i32> = -16..=15;
/// Standard deviation of a range, metres, and share of lost returns, as those of the simulated robot.
const RANGE_NOISE_M: f64 = 0.01;
const DROPOUT_SHARE: f64 = 0.002;
/// Returns from farther away are left out, metres: comparisons do not use them.
const MAX_RANGE_M: f64 = 30.0;
/// Standard deviations of the tilt of a body that walks, radians, and of its distance from the route, metres.
const TILT_RAD: f64 = 0.02;
const BESIDE_ROUTE_M: f64 = 0.1;
/// Standard deviations of the errors of poses, metres and radians: three times those of localisation in docs/benchmarks/localisation.md.
const POSE_ERROR_M: f64 = 0.01;
const POSE_ERROR_RAD: f64 = 0.001;
/// Distance between views, metres, and greatest step of the floor between two points of the route.
const VIEW_DISTANCE_M: f64 = 2.0;
const ROUTE_STEP_M: f64 = 0.2;
const FLOOR_STEP_M: f64 = 0.4;
/// A person: an upright cylinder, metres.
const PERSON_RADIUS_M: f64 = 0.25;
const PERSON_HEIGHT_M: f64 = 1.75;
/// Distance of people from the route and least distance from the sensor, metres.
const PERSON_BESIDE_M: f64 = 0.9;
const PERSON_CLEAR_M: f64 = 0.6;
/// Distance of people from loose objects, metres, as on the simulated sites.
const PERSON_FROM_OBJECT_M: f64 = 0.25;

/// What a walk along the whole round sees.
///
/// # Errors
/// When the site has no round.
pub fn cast_visit(site: &SimulatedSite, columns: u32, people: u32, seed: u64) -> Result<Visit> {
    let route = route_points(site)?;
    let tree = RngTree::new(seed).child("cast visit");
    let mut rng = tree.rng();
    let walkers: Vec<Walker> = (0..people).map(|_| Walker::new(&mut rng, route.len())).collect();
    let per_view = (VIEW_DISTANCE_M / ROUTE_STEP_M) as usize;
    let first = (rng.uniform() * per_view as f64) as usize;
    let mut visit = Visit::default();
    for (number, place) in (first..route.len()).step_by(per_view).enumerate() {
        let mut rng = tree.child(&format!("view {number}")).rng();
        let beside = Vector3::new(rng.normal(), rng.normal(), 0.0) * BESIDE_ROUTE_M;
        let at = route[place] + beside + Vector3::z() * SENSOR_HEIGHT_M;
        let feet: Vec<Vector3> = walkers
            .iter()
            .map(|walker| walker.feet(&route, number))
            .filter(|feet| (feet - at).xy().norm() > PERSON_RADIUS_M + PERSON_CLEAR_M)
            .filter(|feet| !stands_in_object(site, feet))
            .collect();
        visit.views.push(cast_view(site, &at, &feet, columns, &mut rng));
    }
    Ok(visit)
}

/// A sweep from a place, in the frame of the pose that localisation gives it.
fn cast_view(
    site: &SimulatedSite,
    at: &Vector3,
    people: &[Vector3],
    columns: u32,
    rng: &mut Rng,
) -> SensorView {
    let mut random = |sigma: f64| Vector3::new(rng.normal(), rng.normal(), rng.normal()) * sigma;
    let tilt = random(TILT_RAD);
    let error = Isometry::from_parts(random(POSE_ERROR_M).into(), so3::exp(&random(POSE_ERROR_RAD)));
    let heading = rng.uniform() * TAU;
    let site_from_sensor = so3::exp(&Vector3::new(tilt.x, tilt.y, heading));
    let mut points = Vec::new();
    for column in 0..columns {
        let azimuth = f64::from(column) / f64::from(columns) * TAU;
        for elevation_deg in ELEVATIONS_DEG {
            let (up, flat) = f64::from(elevation_deg).to_radians().sin_cos();
            let along = site_from_sensor * Vector3::new(flat * azimuth.cos(), flat * azimuth.sin(), up);
            let of_site =
                site.cast_ray(at, &along, MAX_RANGE_M).map_or(f64::INFINITY, |(range_m, _)| range_m);
            let of_people = people.iter().map(|feet| person_range_m(at, &along, feet));
            let range_m = of_people.fold(of_site, f64::min);
            if range_m < MAX_RANGE_M && rng.uniform() >= DROPOUT_SHARE {
                let offset = along * (range_m + RANGE_NOISE_M * rng.normal());
                let point = at + (error * Point3::from(offset)).coords;
                points.push(point.map(|at| at as f32).into());
            }
        }
    }
    SensorView { sensor: at + error.translation.vector, points }
}

/// Distance at which a ray meets a person, metres; infinite if it does not.
fn person_range_m(at: &Vector3, along: &Vector3, feet: &Vector3) -> f64 {
    let offset = (at - feet).xy();
    let flat = along.xy();
    let (a, half_b) = (flat.norm_squared(), offset.dot(&flat));
    let discriminant = half_b * half_b - a * (offset.norm_squared() - PERSON_RADIUS_M * PERSON_RADIUS_M);
    if discriminant < 0.0 {
        return f64::INFINITY;
    }
    let range_m = (-half_b - discriminant.sqrt()) / a;
    let height_m = at.z + along.z * range_m - feet.z;
    if range_m > 0.0 && (0.0..=PERSON_HEIGHT_M).contains(&height_m) { range_m } else { f64::INFINITY }
}

/// Whether a person would stand in a loose object or touch it.
fn stands_in_object(site: &SimulatedSite, feet: &Vector3) -> bool {
    site.loose_objects().iter().any(|object| {
        let reach_m = object.size_m[0].hypot(object.size_m[1]) / 2.0 + PERSON_RADIUS_M + PERSON_FROM_OBJECT_M;
        (object.foot - feet).xy().norm() < reach_m
    })
}

/// A person who walks along the round.
struct Walker {
    first: usize,
    /// Points of the route between two views.
    step: i64,
    beside_m: f64,
}

impl Walker {
    fn new(rng: &mut Rng, points: usize) -> Self {
        let step = [-10, -6, 5, 8, 10, 12][(rng.uniform() * 6.0) as usize % 6];
        let beside_m = if rng.uniform() < 0.5 { PERSON_BESIDE_M } else { -PERSON_BESIDE_M };
        Self { first: (rng.uniform() * points as f64) as usize, step, beside_m }
    }

    fn feet(&self, route: &[Vector3], view: usize) -> Vector3 {
        let place = (self.first as i64 + self.step * view as i64).rem_euclid(route.len() as i64) as usize;
        let along = route[(place + 1) % route.len()] - route[place];
        let beside = Vector3::new(-along.y, along.x, 0.0).normalize();
        if beside.iter().all(|at| at.is_finite()) {
            route[place] + beside * self.beside_m
        } else {
            route[place]
        }
    }
}

/// Points on the floor along the round.
fn route_points(site: &SimulatedSite) -> Result<Vec<Vector3>> {
    let route = site.route("round").context("the site has no round")?;
    let start = route.start.position;
    let mut at = Vector3::new(start.x, start.y, start.z);
    let mut points = vec![at];
    for to in &route.waypoints {
        let along = Vector3::new(to[0] - at.x, to[1] - at.y, 0.0);
        let steps = (along.norm() / ROUTE_STEP_M).ceil().max(1.0) as usize;
        for _ in 0..steps {
            at += along / steps as f64;
            let from = at + Vector3::z() * FLOOR_STEP_M;
            let down = site.cast_ray(&from, &-Vector3::z(), 2.0 * FLOOR_STEP_M);
            at.z = down.map_or(at.z, |(down_m, _)| from.z - down_m);
            points.push(at);
        }
    }
    Ok(points)
}
