//! Sites: places that consist of solids, with docks, ground plan, routes for recordings and paths for people.

mod b1;
mod changed_conditions;
mod changes;
pub(crate) mod conditions;
mod dock;
mod error;
pub(crate) mod generated;
mod loose_objects;
mod main_floor;
mod model;
mod parts;
mod plan;
mod plant;
mod structures;
mod tessellation;
mod torus;
mod twins;
mod walkable;

use crate::bvh::Bvh;
use crate::route::{SiteRoute, Start};
use crate::shape::Solid;
use geometry::{RngTree, Vector3};
use plan::SitePlan;
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;
use vocab::Vec3;
use walkable::WalkableFloor;

pub use conditions::{ConditionChange, Leak, Liquid};
pub use error::BuildingModelError;
pub use loose_objects::{LooseObject, ObjectChange};
pub use model::{BuildingModel, BuildingModelConfig, Mobility, ModelPart, ModelTriangle};
pub use plan::SimulatedDock;
pub use tessellation::TessellationConfig;

/// The name of a site.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SiteName {
    /// A test hall of 60 m x 40 m with rooms, corridors, racks, pipes and machines.
    B1,
    /// A hall around a fusion machine.
    Torus,
    /// A process plant: two floors, stairs, a long featureless corridor, an outdoor yard.
    Plant,
    /// Two rooms furnished alike, joined by a bare corridor.
    Twins,
    /// A building of two floors that is drawn from this seed.
    Generated(u64),
}

/// Start of the names of generated sites. The seed follows.
const GENERATED: &str = "generated:";

impl SiteName {
    /// The sites that were made by hand.
    pub const ALL: [Self; 4] = [Self::B1, Self::Torus, Self::Plant, Self::Twins];
}

impl fmt::Display for SiteName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::B1 => f.pad("b1"),
            Self::Torus => f.pad("torus"),
            Self::Plant => f.pad("plant"),
            Self::Twins => f.pad("twins"),
            Self::Generated(seed) => f.pad(&format!("{GENERATED}{seed}")),
        }
    }
}

/// Error: there is no site of this name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownSite(String);

impl fmt::Display for UnknownSite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = SiteName::ALL.map(|site| site.to_string()).join(", ");
        let text = &self.0;
        if text.starts_with(GENERATED) {
            write!(
                f,
                "there is no site \"{text}\"; the seed after \"{GENERATED}\" is a whole number from 0 to {}",
                u64::MAX
            )
        } else {
            write!(f, "there is no site \"{text}\"; the sites are {names}, and {GENERATED}SEED")
        }
    }
}

impl std::error::Error for UnknownSite {}

impl FromStr for SiteName {
    type Err = UnknownSite;
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let seed = text.strip_prefix(GENERATED).and_then(|seed| seed.parse().ok());
        let site = Self::ALL.into_iter().find(|site| site.to_string() == text);
        site.or(seed.map(Self::Generated)).ok_or_else(|| UnknownSite(text.to_owned()))
    }
}

/// A site: its solids in a tree for ray casting, its docks, routes and pedestrian paths.
#[derive(Clone, Debug)]
pub struct SimulatedSite {
    name: String,
    bvh: Bvh,
    plan: SitePlan,
    /// The floor that can be reached, for sites of models: their solids do not say what is inside and outside.
    walkable: Option<Arc<WalkableFloor>>,
    /// What is not in its usual condition.
    conditions: Option<Arc<ChangedConditions>>,
}

/// What is not as usual at a site, with the site as it usually is.
#[derive(Clone, Debug)]
struct ChangedConditions {
    usual: SimulatedSite,
    changes: Vec<ConditionChange>,
}

impl From<SiteName> for Arc<SimulatedSite> {
    fn from(name: SiteName) -> Self {
        Self::new(SimulatedSite::new(name))
    }
}

/// Free distance that a standing robot needs on all sides, metres.
const CLEARANCE_M: f64 = 0.45;
/// Heights above the feet at which that distance is checked, metres.
const CLEARANCE_HEIGHTS_M: [f64; 3] = [0.25, 0.5, 0.75];

fn plan_of(name: SiteName) -> SitePlan {
    match name {
        SiteName::B1 => b1::plan(),
        SiteName::Torus => torus::plan(),
        SiteName::Plant => plant::plan(),
        SiteName::Twins => twins::plan(),
        SiteName::Generated(seed) => generated::plan(seed),
    }
}

impl SimulatedSite {
    /// Builds a site. It is always the same, because the seed of its clutter is fixed.
    pub fn new(name: SiteName) -> Self {
        Self::from_plan(name.to_string(), plan_of(name))
    }

    /// The site on another day: `changed_share` of the furniture is moved or removed, and doors stand at other angles. Nothing obstructs a
    /// route. The same seed gives the same changes.
    pub fn on_another_day(&self, seed: u64, changed_share: f64) -> Self {
        let mut plan = self.usual().plan.clone();
        changes::change(&mut plan, &mut RngTree::new(seed).child("another day").rng(), changed_share);
        self.with_plan(plan)
    }

    /// The same site with other contents, in the same condition.
    fn with_plan(&self, plan: SitePlan) -> Self {
        let site = Self { walkable: self.walkable.clone(), ..Self::from_plan(self.name.clone(), plan) };
        let changes = self.condition_changes();
        if changes.is_empty() { site } else { site.with_conditions(changes.to_vec()) }
    }

    fn from_plan(name: String, plan: SitePlan) -> Self {
        // Those of docks follow from the docks, so that a dock can be moved.
        let docks = plan.docks.iter().flat_map(dock::solids);
        let loose = plan.loose_objects.iter().map(LooseObject::solid);
        let solids: Vec<Solid> = plan.solids.iter().copied().chain(docks).chain(loose).collect();
        Self { name, bvh: Bvh::new(&solids), plan, walkable: None, conditions: None }
    }

    /// The objects that stand loose on it.
    pub fn loose_objects(&self) -> &[LooseObject] {
        &self.plan.loose_objects
    }

    /// The solids of each piece of furniture.
    pub fn furniture(&self) -> impl Iterator<Item = &[Solid]> {
        self.plan.furniture.iter().map(|piece| &self.plan.solids[piece.clone()])
    }

    /// The site after these changes. A change of an object that is not there adds what it ends with.
    pub fn with_changes(&self, changes: &[ObjectChange]) -> Self {
        let mut plan = self.usual().plan.clone();
        for change in changes {
            let (gone, new) = match *change {
                ObjectChange::Put(object) => (None, Some(object)),
                ObjectChange::Taken(object) => (Some(object), None),
                ObjectChange::Moved { from, to } | ObjectChange::Turned { from, to } => {
                    (Some(from), Some(to))
                }
            };
            plan.loose_objects.retain(|object| Some(*object) != gone);
            plan.loose_objects.extend(new);
        }
        self.with_plan(plan)
    }

    /// Name of the site.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// All solids, in the order of the tree.
    pub fn solids(&self) -> &[Solid] {
        self.bvh.solids()
    }

    /// The tree over [`SimulatedSite::solids`].
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// Charging docks. Robots start at the first one.
    pub fn docks(&self) -> &[SimulatedDock] {
        &self.plan.docks
    }

    /// Corners of the ground plan, counter-clockwise, metres.
    pub fn outline(&self) -> &[[f64; 2]] {
        &self.plan.outline
    }

    /// Routes for recordings.
    pub fn routes(&self) -> &[SiteRoute] {
        &self.plan.routes
    }

    /// The route of that name.
    pub fn route(&self, name: &str) -> Option<&SiteRoute> {
        self.plan.routes.iter().find(|route| route.name == name)
    }

    /// Closed paths of people, at the feet, site frame, metres.
    pub(crate) fn pedestrian_paths(&self) -> &[Vec<Vector3>] {
        &self.plan.pedestrian_paths
    }

    /// The start at the first dock; without docks at the start of the site, or at the origin.
    pub fn start(&self) -> Start {
        let dock = self.plan.docks.first().map(|dock| Start { position: dock.position, yaw: dock.yaw });
        dock.or(self.plan.start).unwrap_or(Start { position: Vec3::default(), yaw: 0.0 })
    }

    /// The first surface along a unit direction within `max_range` metres: its range (metres) and its solid.
    pub fn cast_ray(&self, origin: &Vector3, direction: &Vector3, max_range: f64) -> Option<(f64, &Solid)> {
        self.bvh.first_hit(origin, direction, max_range)
    }

    /// Whether a robot can stand with its feet there: on a floor, inside the ground plan, and with enough clearance.
    pub fn has_room(&self, feet: &Vector3) -> bool {
        let on_floor = self
            .cast_ray(&(feet + Vector3::z() * CLEARANCE_HEIGHTS_M[0]), &-Vector3::z(), 1.0)
            .is_some_and(|(down, _)| (down - CLEARANCE_HEIGHTS_M[0]).abs() < 0.05);
        on_floor
            && self.is_inside(feet)
            && self.walkable.as_ref().is_none_or(|floor| floor.contains(feet))
            && CLEARANCE_HEIGHTS_M.iter().all(|height| {
                let middle = feet + Vector3::z() * *height;
                self.distance(&middle, CLEARANCE_M)
                    .is_none_or(|distance| distance >= CLEARANCE_M.min(*height - 0.02))
            })
    }

    /// Whether a point is inside the ground plan.
    pub(crate) fn is_inside(&self, point: &Vector3) -> bool {
        vocab::is_in_polygon(&self.plan.outline, [point.x, point.y])
    }

    /// Signed distance from a point to the nearest surface within `radius` metres, negative inside a solid; `None` if there is none.
    pub fn distance(&self, point: &Vector3, radius: f64) -> Option<f64> {
        let mut least: Option<f64> = None;
        self.bvh.near(point, radius, |solid| {
            let distance = solid.shape.clearance(point).distance;
            if distance.abs() <= radius && least.is_none_or(|best| distance.abs() < best.abs()) {
                least = Some(distance);
            }
        });
        least
    }
}
