//! Sites that are given as triangles: what the triangles say, and what they do not. The text and the file of such a model are read elsewhere.

use super::main_floor::FloorSearch;
use super::plan::{DoorLeaf, SimulatedDock, SitePlan};
use super::walkable::{WalkableConfig, WalkableFloor};
use super::{SimulatedSite, error::BuildingModelError};
use crate::ray_packet::{NO_HIT, RayPacket};
use crate::route::{SiteRoute, Start};
use crate::shape::{Material, Shape, Solid};
use geometry::{Vector3, vec_from_plain};
use std::sync::Arc;
use vocab::Vec3;

/// Limits of a model.
#[derive(Clone, Copy, Debug)]
pub struct BuildingModelConfig {
    /// Largest number of triangles. A triangle takes about 260 B. Chosen: 130 MB.
    pub max_triangles: usize,
    /// Greatest distance of a corner from the origin along each axis, metres. Rays are computed in 32 bits: at 1 km they resolve 0.06 mm. Chosen: larger than any site.
    pub max_coordinate_m: f64,
    /// Smallest area of a triangle, square metres. Smaller ones are left out: they are degenerate, and no ray hits them. Chosen: a thousandth of a square millimetre.
    pub min_area_m2: f64,
    /// Greatest vertical distance of a dock or a start from a floor, metres. Chosen: a person who sets a dock in a modelling program misses the floor by less.
    pub max_floor_distance_m: f64,
    /// Distance between the places at which free floor is looked for where the model has neither dock nor start, metres. Chosen: about the width of a robot.
    pub start_grid_m: f64,
    /// Least area of a floor that such a start is looked for on, relative to the largest one of the model. Chosen: a storey is larger, and a landing, a pit or
    /// a table smaller.
    pub least_start_floor: f64,
}

impl Default for BuildingModelConfig {
    fn default() -> Self {
        Self {
            max_triangles: 500_000,
            max_coordinate_m: 1000.0,
            min_area_m2: 1e-9,
            max_floor_distance_m: 0.3,
            start_grid_m: 0.5,
            least_start_floor: 0.2,
        }
    }
}

/// A site as triangles. Site frame: z up, metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BuildingModel {
    /// Name of the site.
    pub name: String,
    /// What stands in it.
    pub parts: Vec<ModelPart>,
    /// Charging docks. The robot starts at the first one.
    pub docks: Vec<SimulatedDock>,
    /// Start of the robot where there is no dock. Without both, the robot starts on the lowest large floor, near the middle.
    pub start: Option<Start>,
    /// Corners of the ground plan, counter-clockwise, metres. Without corners it is the bounding rectangle.
    pub outline: Vec<[f64; 2]>,
    /// Routes for recordings. Without any, one that passes all floor which the robot can reach is found, named "round".
    pub routes: Vec<SiteRoute>,
    /// Closed paths of people, at the feet, metres.
    pub pedestrian_paths: Vec<Vec<Vec3>>,
}

/// A part of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelPart {
    /// Name of the part, for messages.
    pub name: String,
    /// Whether it moves on another day, and how.
    pub mobility: Mobility,
    /// Its triangles. They are visible from both sides.
    pub triangles: Vec<ModelTriangle>,
}

/// A triangle of a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelTriangle {
    /// Corners, metres.
    pub corners: [[f64; 3]; 3],
    /// Material.
    pub material: Material,
}

/// Whether a part of a model moves on another day.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mobility {
    /// It never moves.
    Fixed,
    /// A piece of furniture. It may stand elsewhere, or be gone.
    Furniture,
    /// A door leaf, which may stand at another angle.
    Door {
        /// A point on its hinge, metres.
        hinge: Vec3,
    },
}

impl SimulatedSite {
    /// Builds the site of a model.
    ///
    /// # Errors
    /// When the model cannot be walked on: see [`BuildingModelError`].
    pub fn from_model(
        model: BuildingModel,
        config: &BuildingModelConfig,
    ) -> Result<Self, BuildingModelError> {
        let mut plan = solids(&model.parts, config)?;
        let (least, most) = bounds(&plan.solids);
        plan.outline = if model.outline.is_empty() {
            vec![[least.x, least.y], [most.x, least.y], [most.x, most.y], [least.x, most.y]]
        } else {
            model.outline
        };
        plan.docks = model.docks;
        plan.routes = model.routes;
        let path = |corners: &Vec<Vec3>| corners.iter().map(|corner| vec_from_plain(*corner)).collect();
        plan.pedestrian_paths = model.pedestrian_paths.iter().map(path).collect();
        let mut site = Self::from_plan(model.name, plan);
        site.check(model.start.as_ref(), config)?;
        site.plan.start = if site.plan.docks.is_empty() { model.start } else { None };
        let walkable = if site.plan.docks.is_empty() && site.plan.start.is_none() {
            let search = FloorSearch { grid_m: config.start_grid_m, least_share: config.least_start_floor };
            let found = site.main_floor((least, most), &search);
            let (start, floor) = found.ok_or(BuildingModelError::NoFreeFloor)?;
            site.plan.start = Some(start);
            floor
        } else {
            WalkableFloor::new(&site.bvh, &site.start(), &WalkableConfig::default())
        };
        if site.plan.routes.is_empty() {
            site.plan.routes.extend(walkable.round(&site.start(), &WalkableConfig::default()));
        }
        site.walkable = Some(Arc::new(walkable));
        Ok(site)
    }

    /// Whether everything stands on a floor, and is complete.
    fn check(&self, start: Option<&Start>, config: &BuildingModelConfig) -> Result<(), BuildingModelError> {
        let on_floor = |what: String, at: Vec3| {
            let place = vec_from_plain(at);
            let is_near = self.floor_distance(&place).is_some_and(|far| far <= config.max_floor_distance_m);
            if is_near { Ok(()) } else { Err(BuildingModelError::InTheAir { what, at: [at.x, at.y, at.z] }) }
        };
        if self.plan.outline.len() < 3 {
            return Err(BuildingModelError::FewCorners { what: "the outline".to_owned(), least: 3 });
        }
        for (index, dock) in self.plan.docks.iter().enumerate() {
            on_floor(format!("dock {}", index + 1), dock.position)?;
        }
        if let Some(start) = start {
            on_floor("the start".to_owned(), start.position)?;
        }
        for route in &self.plan.routes {
            if route.waypoints.is_empty() {
                let what = format!("route \"{}\"", route.name);
                return Err(BuildingModelError::FewCorners { what, least: 1 });
            }
            on_floor(format!("the start of route \"{}\"", route.name), route.start.position)?;
        }
        for (index, path) in self.plan.pedestrian_paths.iter().enumerate() {
            if path.len() < 2 {
                let what = format!("path {} of people", index + 1);
                return Err(BuildingModelError::FewCorners { what, least: 2 });
            }
        }
        Ok(())
    }

    /// Vertical distance from a point to the nearest surface below or above it, within a metre.
    fn floor_distance(&self, point: &Vector3) -> Option<f64> {
        let over = point + Vector3::z();
        let mut packet = RayPacket::single(&over, &-Vector3::z(), 2.0);
        self.bvh.cast(&mut packet);
        // The first surface from above may be the top of something that stands over the floor.
        let upper = (packet.solid[0] != NO_HIT).then(|| (f64::from(packet.range[0]) - 1.0).abs());
        let lower = self.cast_ray(&(point + Vector3::z() * 0.05), &-Vector3::z(), 1.0);
        let lower = lower.map(|(down, _)| (down - 0.05).abs());
        [upper, lower].into_iter().flatten().reduce(f64::min)
    }
}

/// The triangles of all parts as solids, with what may move.
fn solids(parts: &[ModelPart], config: &BuildingModelConfig) -> Result<SitePlan, BuildingModelError> {
    let count = parts.iter().map(|part| part.triangles.len()).sum();
    if count > config.max_triangles {
        return Err(BuildingModelError::TooManyTriangles { count, limit: config.max_triangles });
    }
    let mut plan = SitePlan::default();
    for part in parts {
        let first = plan.solids.len();
        for triangle in &part.triangles {
            let corners = triangle.corners.map(Vector3::from);
            if corners.iter().flatten().any(|c| !c.is_finite()) {
                return Err(BuildingModelError::NotFinite { part: part.name.clone() });
            }
            if corners.iter().flatten().any(|c| c.abs() > config.max_coordinate_m) {
                return Err(BuildingModelError::TooFar {
                    part: part.name.clone(),
                    limit_m: config.max_coordinate_m,
                });
            }
            let [a, b, c] = corners;
            if (b - a).cross(&(c - a)).norm() / 2.0 >= config.min_area_m2 {
                plan.solids.push(Solid { shape: Shape::Triangle(corners), material: triangle.material });
            }
        }
        let solids = first..plan.solids.len();
        match part.mobility {
            Mobility::Fixed => {}
            Mobility::Furniture => plan.furniture.push(solids),
            Mobility::Door { hinge } => {
                plan.door_leaves.push(DoorLeaf { solids, hinge: vec_from_plain(hinge) });
            }
        }
    }
    if plan.solids.is_empty() { Err(BuildingModelError::NoTriangles) } else { Ok(plan) }
}

/// Least and greatest corner of the box round solids.
fn bounds(solids: &[Solid]) -> (Vector3, Vector3) {
    let bounds = solids.iter().map(|solid| solid.shape.bounds());
    bounds.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1))).unwrap_or_default()
}
