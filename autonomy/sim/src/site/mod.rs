//! Sites: places made of solids, with docks, floor outline, routes for recordings and rounds for people.

mod b1;
mod changes;
mod parts;
mod plant;
mod structures;
mod torus;
mod twins;

use crate::bvh::Bvh;
use crate::packed::{NOTHING, Packet};
use crate::route::{Route, Start};
use crate::shape::Solid;
use geometry::{RngTree, Vector3};
use std::fmt;
use std::ops::Range;
use std::str::FromStr;
use vocab::Vec3;

/// Which site.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SiteName {
    /// A test hall of 60 m x 40 m with rooms, corridors, racks, pipes and machines.
    B1,
    /// A hall round a fusion machine.
    Torus,
    /// A process plant: two floors, stairs, a long featureless corridor, an outdoor yard.
    Plant,
    /// Two rooms furnished alike, joined by a bare corridor.
    Twins,
}

impl SiteName {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::B1, Self::Torus, Self::Plant, Self::Twins];

    const fn name(self) -> &'static str {
        match self {
            Self::B1 => "b1",
            Self::Torus => "torus",
            Self::Plant => "plant",
            Self::Twins => "twins",
        }
    }
}

impl fmt::Display for SiteName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// The text names no site.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownSite(String);

impl fmt::Display for UnknownSite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = SiteName::ALL.map(SiteName::name).join(", ");
        write!(f, "there is no site \"{}\"; the sites are {names}", self.0)
    }
}

impl std::error::Error for UnknownSite {}

impl FromStr for SiteName {
    type Err = UnknownSite;
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Self::ALL.into_iter().find(|site| site.name() == text).ok_or_else(|| UnknownSite(text.to_owned()))
    }
}

/// A charging dock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dock {
    /// Where the robot stands when docked, on the ground, site frame, metres.
    pub position: Vec3,
    /// Which way it then looks, radians.
    pub yaw: f64,
}

/// What a site's author puts down.
#[derive(Clone, Debug, Default)]
struct Plan {
    solids: Vec<Solid>,
    docks: Vec<Dock>,
    /// Corners of the ground plan, counter-clockwise, metres.
    outline: Vec<[f64; 2]>,
    routes: Vec<Route>,
    /// Closed walks of people, at the feet.
    rounds: Vec<Vec<Vector3>>,
    /// Which solids are one piece of furniture.
    furniture: Vec<Range<usize>>,
    /// Which solid is a door's leaf, and a point of its hinge.
    leaves: Vec<(usize, Vector3)>,
}

/// A place.
#[derive(Clone, Debug)]
pub struct Site {
    name: SiteName,
    bvh: Bvh,
    docks: Vec<Dock>,
    outline: Vec<[f64; 2]>,
    routes: Vec<Route>,
    rounds: Vec<Vec<Vector3>>,
}

/// What a robot needs about itself, metres, at these heights over its feet.
const ROOM: f64 = 0.45;
const ROOM_HEIGHTS: [f64; 3] = [0.25, 0.5, 0.75];

fn plan(name: SiteName) -> Plan {
    match name {
        SiteName::B1 => b1::plan(),
        SiteName::Torus => torus::plan(),
        SiteName::Plant => plant::plan(),
        SiteName::Twins => twins::plan(),
    }
}

impl Site {
    /// Builds a site. Always the same: the clutter's seed is fixed.
    pub fn new(name: SiteName) -> Self {
        Self::of(name, plan(name))
    }

    /// The same site on another day: such a share of the furniture is moved or gone, and doors stand otherwise, but nothing in the way
    /// of a route. The same for the same seed.
    pub fn on_another_day(name: SiteName, seed: u64, share: f64) -> Self {
        let mut plan = plan(name);
        changes::change(&mut plan, &mut RngTree::new(seed).child("another day").rng(), share);
        Self::of(name, plan)
    }

    fn of(name: SiteName, plan: Plan) -> Self {
        Self {
            name,
            bvh: Bvh::new(&plan.solids),
            docks: plan.docks,
            outline: plan.outline,
            routes: plan.routes,
            rounds: plan.rounds,
        }
    }

    /// Which one.
    pub fn name(&self) -> SiteName {
        self.name
    }

    /// Everything in it.
    pub fn solids(&self) -> &[Solid] {
        self.bvh.solids()
    }

    /// The tree over [`Site::solids`].
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// Charging docks; the first is where robots begin.
    pub fn docks(&self) -> &[Dock] {
        &self.docks
    }

    /// Corners of the ground plan, counter-clockwise, metres.
    pub fn outline(&self) -> &[[f64; 2]] {
        &self.outline
    }

    /// Walks for recordings.
    pub fn routes(&self) -> &[Route] {
        &self.routes
    }

    /// The walk of that name.
    pub fn route(&self, name: &str) -> Option<&Route> {
        self.routes.iter().find(|route| route.name == name)
    }

    /// On which closed walks people go, at the feet.
    pub(crate) fn rounds(&self) -> &[Vec<Vector3>] {
        &self.rounds
    }

    /// At the first dock, or at the origin where there is none.
    pub fn start(&self) -> Start {
        let origin = Start { position: Vec3::default(), yaw: 0.0 };
        self.docks.first().map_or(origin, |dock| Start { position: dock.position, yaw: dock.yaw })
    }

    /// Whether a base at that place stands on a dock.
    pub(crate) fn docked(&self, site_from_base: &Vector3) -> bool {
        self.docks.iter().any(|dock| {
            let offset = site_from_base - geometry::vec_from_plain(dock.position);
            offset.xy().norm() < 0.35 && (0.0..1.0).contains(&offset.z)
        })
    }

    /// Range in metres along a unit direction to the first surface within `reach`, and the solid it belongs to.
    pub fn cast(&self, origin: &Vector3, direction: &Vector3, reach: f64) -> Option<(f64, &Solid)> {
        let mut packet = Packet::single(origin, direction, reach as f32);
        self.bvh.cast(&mut packet);
        let solid = packet.solid[0];
        (solid != NOTHING).then(|| (f64::from(packet.range[0]), &self.bvh.solids()[solid as usize]))
    }

    /// Whether a robot can stand with its feet there: on a floor, inside the outline, and with nothing within its reach.
    pub fn has_room(&self, feet: &Vector3) -> bool {
        let on_floor = self
            .cast(&(feet + Vector3::z() * ROOM_HEIGHTS[0]), &-Vector3::z(), 1.0)
            .is_some_and(|(down, _)| (down - ROOM_HEIGHTS[0]).abs() < 0.05);
        on_floor
            && self.is_inside(feet)
            && ROOM_HEIGHTS.iter().all(|height| {
                let middle = feet + Vector3::z() * *height;
                self.distance(&middle, ROOM).is_none_or(|distance| distance >= ROOM.min(*height - 0.02))
            })
    }

    /// By the parity of the outline's edges to the right.
    fn is_inside(&self, point: &Vector3) -> bool {
        let next = self.outline.iter().cycle().skip(1);
        let crossed = self.outline.iter().zip(next).filter(|(a, b)| {
            let above = (a[1] > point.y) != (b[1] > point.y);
            above && point.x < a[0] + (point.y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        });
        crossed.count() % 2 == 1
    }

    /// Distance in metres from a point to the nearest surface (negative inside a solid), if one is within `reach`.
    pub fn distance(&self, point: &Vector3, reach: f64) -> Option<f64> {
        let mut least: Option<f64> = None;
        self.bvh.near(point, reach, |solid| {
            let distance = solid.shape.clearance(point).distance;
            if distance.abs() <= reach && least.is_none_or(|best| distance.abs() < best.abs()) {
                least = Some(distance);
            }
        });
        least
    }
}
