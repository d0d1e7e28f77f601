//! What hangs on the walls of a site for the cameras to read: labels, gauges, and machines that are warm.

use crate::route::SiteRoute;
use crate::shape::Material;
use crate::site::SimulatedSite;
use geometry::{Isometry, Rotation, Vector3};
use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion};
use std::f64::consts::TAU;

/// A plate on a wall.
#[derive(Clone, Debug, PartialEq)]
pub struct Fixture {
    /// Its tag, such as `PI-103`. Unique on its site.
    pub tag: String,
    /// Pose of the middle of the plate: x to the right of whoever looks at it, y up, z out of the wall.
    pub site_from_plate: Isometry,
    /// What is on the plate.
    pub face: Face,
}

/// What is on a plate.
#[derive(Clone, Debug, PartialEq)]
pub enum Face {
    /// Lines of text in letters 20 mm high.
    Label(Vec<String>),
    /// A round gauge, 100 mm wide, with its tag below.
    Gauge {
        /// Unit of the scale.
        unit: &'static str,
        /// Value at the beginning of the scale.
        min: f64,
        /// Value at its end.
        max: f64,
        /// What the needle shows.
        reading: SimulatedQuantity,
    },
    /// A casing that is warmer than the air, with its tag.
    Warm {
        /// Temperature of its middle, degrees Celsius.
        celsius: f64,
    },
}

/// A value that swings slowly, and may rise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimulatedQuantity {
    /// Its mean.
    pub mean: f64,
    /// How far it swings to either side.
    pub amplitude: f64,
    /// Time of a swing, seconds.
    pub period_s: f64,
    /// How much it rises besides, per second.
    pub rise_per_s: f64,
}

impl SimulatedQuantity {
    /// The value at a time.
    pub fn at(&self, seconds: f64) -> f64 {
        self.mean + self.rise_per_s * seconds + self.amplitude * (TAU * seconds / self.period_s).sin()
    }
}

impl Face {
    /// Half the width and half the height of the plate, metres.
    pub fn half_m(&self) -> [f64; 2] {
        match self {
            Self::Label(lines) => {
                let longest = lines.iter().map(|line| line.chars().count()).max().unwrap_or(1) as f64;
                [0.5 * longest * LETTER_ADVANCE_M + 0.02, 0.5 * lines.len() as f64 * LINE_STEP_M + 0.015]
            }
            Self::Gauge { .. } => [0.09, 0.11],
            Self::Warm { .. } => [0.14, 0.1],
        }
    }
}

/// Height of capital letters, metres.
pub(super) const CAPITAL_HEIGHT_M: f64 = 0.02;
/// Distance between letters, metres.
pub(super) const LETTER_ADVANCE_M: f64 = 0.0212;
/// Distance between lines, metres.
pub(super) const LINE_STEP_M: f64 = 0.034;

/// Distance between places along the route at which walls are looked for, metres.
const STEP_M: f64 = 0.5;
/// Least distance between two plates, metres.
const APART_M: f64 = 4.0;
/// Heights of plates above the floor, metres.
const HEIGHTS_M: [f64; 3] = [1.25, 0.95, 1.55];
/// A plate is at most this far from the route, metres: labels are read from 2 m.
const MAX_WALL_DISTANCE_M: f64 = 3.0;
/// It is at least this far away, so that the robot can look at it, metres.
const MIN_WALL_DISTANCE_M: f64 = 0.9;
/// Greatest angle between the line to the route and the normal of the wall, as a cosine.
const MIN_FACING: f64 = 0.9;
/// How far a wall may bend behind a plate, metres.
const FLAT_M: f64 = 0.004;
/// How far a plate stands out of its wall, metres.
const PLATE_OUT_M: f64 = 0.002;
/// Greatest number of plates on a site.
const MAX_COUNT: usize = 40;

/// The plates along the first route of a site. Always the same for a site.
pub(super) fn placed(site: &SimulatedSite) -> Vec<Fixture> {
    let Some(route) = site.routes().first() else { return Vec::new() };
    let mut fixtures: Vec<Fixture> = Vec::new();
    for (feet, ahead) in places(site, route) {
        for side in [1.0, -1.0] {
            if fixtures.len() >= MAX_COUNT {
                return fixtures;
            }
            let left = Vector3::z().cross(&ahead) * side;
            let face = face_of(fixtures.len());
            let near = |found: &Vector3| {
                fixtures.iter().any(|it| (it.site_from_plate.translation.vector - found).norm() < APART_M)
            };
            let found = HEIGHTS_M.into_iter().find_map(|height| {
                let eye = feet + Vector3::z() * height;
                wall(site, &eye, &left, face.half_m()).filter(|plate| !near(&plate.translation.vector))
            });
            if let Some(site_from_plate) = found {
                fixtures.push(Fixture { tag: tag_of(fixtures.len(), &face), site_from_plate, face });
            }
        }
    }
    fixtures
}

/// Places along a route: the feet and the direction of walking. Heights follow the ground.
fn places(site: &SimulatedSite, route: &SiteRoute) -> Vec<(Vector3, Vector3)> {
    let mut places = Vec::new();
    let mut ground = route.start.position.z;
    let first = [route.start.position.x, route.start.position.y];
    let corners: Vec<[f64; 2]> = std::iter::once(first).chain(route.waypoints.iter().copied()).collect();
    for ends in corners.windows(2) {
        let [from, to] = [ends[0], ends[1]].map(|[x, y]| Vector3::new(x, y, 0.0));
        let length = (to - from).norm();
        if length < 1e-6 {
            continue;
        }
        let ahead = (to - from) / length;
        for step in 0..(length / STEP_M).floor() as usize {
            let at = from + ahead * (STEP_M * step as f64);
            let above = Vector3::new(at.x, at.y, ground + 0.6);
            if let Some((down, _)) = site.cast_ray(&above, &-Vector3::z(), 1.5) {
                ground = above.z - down;
            }
            places.push((Vector3::new(at.x, at.y, ground), ahead));
        }
    }
    places
}

/// The pose of a plate of that size on a flat, upright wall that is seen from `eye` in this direction.
fn wall(site: &SimulatedSite, eye: &Vector3, direction: &Vector3, half_m: [f64; 2]) -> Option<Isometry> {
    let (range, solid) = site.cast_ray(eye, direction, MAX_WALL_DISTANCE_M)?;
    if range < MIN_WALL_DISTANCE_M || matches!(solid.material, Material::Glass | Material::Foliage) {
        return None;
    }
    let hit = eye + direction * range;
    let outward = solid.shape.clearance(&(hit - direction * 1e-3)).outward;
    if outward.z.abs() > 1e-3 || -outward.dot(direction) < MIN_FACING {
        return None;
    }
    let right = Vector3::z().cross(&outward);
    // Around the plate the wall is as far away as a plane is.
    let is_flat = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)].into_iter().all(|(x, y)| {
        let corner = hit + right * (half_m[0] * x) + Vector3::z() * (half_m[1] * y) + outward * 0.3;
        site.cast_ray(&corner, &-outward, 1.0).is_some_and(|(range, _)| (range - 0.3).abs() < FLAT_M)
    });
    let plate = hit + outward * PLATE_OUT_M;
    // Nothing else is flush with the wall there.
    let is_alone = site.distance(&plate, 0.05).is_some_and(|distance| (distance - PLATE_OUT_M).abs() < 1e-6);
    (is_flat && is_alone).then(|| {
        let axes = Matrix3::from_columns(&[right, Vector3::z(), outward]);
        let rotation: Rotation =
            UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
        Isometry::from_parts(Translation3::from(plate), rotation)
    })
}

/// What the plate of this number shows.
fn face_of(number: usize) -> Face {
    let spread = (number / 4) as f64;
    match number % 4 {
        0 => Face::Gauge {
            unit: "bar",
            min: 0.0,
            max: 10.0,
            reading: SimulatedQuantity {
                mean: 3.0 + (1.3 * spread) % 5.0,
                amplitude: 0.4,
                period_s: 900.0,
                rise_per_s: 0.0,
            },
        },
        1 => Face::Label(vec![format!("VALVE V-{}", 201 + number), "KEEP CLOSED".to_owned()]),
        2 => Face::Warm { celsius: 48.0 + (9.0 * spread) % 40.0 },
        _ => Face::Gauge {
            unit: "C",
            min: 0.0,
            max: 120.0,
            reading: SimulatedQuantity {
                mean: 40.0 + (17.0 * spread) % 60.0,
                amplitude: 3.0,
                period_s: 1800.0,
                rise_per_s: 0.0,
            },
        },
    }
}

/// Tag of a plate: letters of the instrument, and its number.
fn tag_of(number: usize, face: &Face) -> String {
    let letters = match face {
        Face::Label(_) => "V",
        Face::Gauge { unit: "bar", .. } => "PI",
        Face::Gauge { .. } => "TI",
        Face::Warm { .. } => "M",
    };
    let first = if matches!(face, Face::Label(_)) { 201 } else { 101 };
    format!("{letters}-{}", first + number)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::site::SiteName;

    #[test]
    fn every_site_has_plates_on_its_walls_which_can_be_seen_from_the_route() {
        for name in [SiteName::B1, SiteName::Torus, SiteName::Plant, SiteName::Generated(1)] {
            let site = SimulatedSite::new(name);
            let fixtures = placed(&site);
            assert!(fixtures.len() >= 9, "{name}: {}", fixtures.len());
            for fixture in &fixtures {
                let plate = fixture.site_from_plate.translation.vector;
                let outward = fixture.site_from_plate.rotation * Vector3::z();
                let distance = site.distance(&plate, 0.05).unwrap_or(f64::INFINITY);
                assert!((distance - PLATE_OUT_M).abs() < 1e-3, "{name} {}: {distance} m", fixture.tag);
                let free = site.cast_ray(&plate, &outward, MIN_WALL_DISTANCE_M - 0.1);
                assert!(free.is_none(), "{name} {}: something stands in front of it", fixture.tag);
            }
            let tags: std::collections::BTreeSet<_> = fixtures.iter().map(|it| &it.tag).collect();
            assert_eq!(tags.len(), fixtures.len());
        }
    }
}
