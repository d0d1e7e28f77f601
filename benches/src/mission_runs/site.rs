//! A mapped site with missions of pictures, as an operator would make them.

use crate::mapped_folder::{MapPlan, MappedFolder};
use anyhow::{Context, Result};
use geometry::{Isometry, Rng, RngTree, Rotation, Vector3, isometry_from_pose, pose_from_isometry};
use messages::{PriorMap, RobotProfile};
use nalgebra::Point3;
use sim::{CameraConfig, SimulatedSite};
use site_files::SiteSource;
use site_model::{
    ActionRequest, EditId, FailurePolicy, InspectionPoint, InspectionPointId, Mission, MissionEnd, MissionId,
    Node, NodeId, NodeKind, Object, Parameter, PoseTolerance, Site, Task, TaskId, TaskOrder, TaskPlace,
};
use std::path::Path;
use std::sync::Arc;
use store::TopomapSource;
use topomap::TopomapConfig;
use uuid::Uuid;

/// The mission of a seed.
pub const MISSION: MissionId = MissionId(Uuid::from_u128(1));

/// Targets are in this range of distances from the camera, metres.
const TARGET_DISTANCE_M: std::ops::Range<f64> = 0.8..10.0;
/// They are at most this far to either side of where the robot looks, radians. The head pans by 170 degrees.
const MAX_TARGET_PAN_RAD: f64 = 2.4;
/// Elevations above the camera, radians: things that people can reach.
const TARGET_ELEVATION_RAD: std::ops::Range<f64> = -0.3..0.35;
/// Directions that are tried for a node. A node without a target is not visited.
const TARGET_ATTEMPTS: usize = 30;
/// A picture shows this width at its target, metres: a gauge of 0.1 m and its tag fill a quarter of it.
const SHOWN_WIDTH_M: f64 = 0.8;

/// Distances and greatest angle from where it faces at which a thing on a wall is looked at, metres and radians: what operators choose.
const PLATE_DISTANCE_M: std::ops::Range<f64> = 0.9..3.5;
const MAX_PLATE_ANGLE_RAD: f64 = 0.7;
/// The distance that is best, metres.
const PLATE_AWAY_M: f64 = 1.6;

/// A thing on a wall: its place and the direction in which it faces, site frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plate {
    /// Its middle, metres.
    pub site_m: Vector3,
    /// Unit vector.
    pub outward: Vector3,
}

/// A site with its metric and its topological map.
pub struct MissionSite {
    /// The simulated site.
    pub site: Arc<SimulatedSite>,
    /// Its metric map.
    pub prior_map: Arc<PriorMap>,
    /// The best rigid alignment of the map with the site.
    pub site_from_map: Isometry,
    /// The topological map.
    pub graph: Site,
}

/// What a task of a mission is to show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InspectionTarget {
    /// The task.
    pub task: TaskId,
    /// Where the robot has to stand, site frame.
    pub site_from_node: Isometry,
    /// What has to be in the middle of the picture, site frame, metres.
    pub site_m: Vector3,
    /// The same in the map, as it is in the parameters of the action.
    pub map_m: Vector3,
}

/// A topological map with a mission.
pub struct PlannedMission {
    /// The objects.
    pub graph: Site,
    /// What its tasks are to show, in their order.
    pub targets: Vec<InspectionTarget>,
}

impl MissionSite {
    /// Maps a site with the whole stack, unless its map is in the folder `work`, and makes the topological map from that map.
    ///
    /// # Errors
    /// When the site cannot be mapped, or the map cannot be read.
    pub fn new(source: &SiteSource, work: &Path, plan: &MapPlan) -> Result<Self> {
        let site = source.load()?;
        let folder = MappedFolder::of(source, work, plan)?;
        let prior_map = runtime::known_map(&folder.path)?;
        let site_from_map = folder.site_from_map;
        // As the robot records them where it was charged.
        let docks = site.docks().iter().map(|dock| {
            let at = geometry::vec_from_plain(dock.position) + Vector3::z() * sim::STANDING_HEIGHT;
            let heading = Rotation::from_euler_angles(0.0, 0.0, dock.yaw);
            pose_from_isometry(&(site_from_map.inverse() * Isometry::from_parts(at.into(), heading)))
        });
        let docks: Vec<_> = docks.collect();
        let profile = RobotProfile::default();
        let source = TopomapSource::read(&folder.path, &docks, &profile, TopomapConfig::default())?;
        let mut graph = Site::default();
        let replacement = source.generate().replacement(&graph, prior_map.map, EditId(Uuid::from_u128(3)));
        let edit = replacement.edit;
        graph.apply(&edit, edit.id).map_err(|error| anyhow::anyhow!("{error:?}"))?;
        Ok(Self { site, prior_map: Arc::new(prior_map), site_from_map, graph })
    }

    /// The graph with a mission of pictures of random targets, each from another node.
    ///
    /// # Errors
    /// When the graph refuses an object.
    pub fn with_mission(&self, seed: u64, tasks: usize) -> Result<PlannedMission> {
        let mut graph = self.graph.clone();
        let mut rng = RngTree::new(seed).child("mission").rng();
        let mut nodes: Vec<NodeId> =
            graph.nodes().filter(|node| is_place(node.kind)).map(|node| node.id).collect();
        let mut targets = Vec::new();
        while targets.len() < tasks && !nodes.is_empty() {
            let index = (rng.uniform() * nodes.len() as f64) as usize;
            let node = nodes.swap_remove(index.min(nodes.len() - 1));
            let node = graph.node(node).context("a node of the graph")?.clone();
            let number = targets.len() as u128;
            if let Some(target) = self.put_target(&mut graph, node, number, &mut rng)? {
                targets.push(target);
            }
        }
        self.plan(graph, targets, MissionEnd::NearestDock)
    }

    /// The graph with a mission of pictures of things on walls, each from the node that sees it best. Those that no node sees are left out. Returns the numbers of the others,
    /// in the order of the targets. `shown_width_m`: width of what a picture shows.
    ///
    /// # Errors
    /// When the graph refuses an object.
    pub fn with_plates(&self, plates: &[Plate], shown_width_m: f64) -> Result<(PlannedMission, Vec<usize>)> {
        let mut graph = self.graph.clone();
        let (mut targets, mut seen) = (Vec::new(), Vec::new());
        for (index, plate) in plates.iter().enumerate() {
            let Some((node, distance_m)) = self.node_before(plate) else { continue };
            let number = targets.len() as u128;
            targets.push(self.put_point(
                &mut graph,
                node,
                number,
                (plate.site_m, distance_m),
                shown_width_m,
            )?);
            seen.push(index);
        }
        Ok((self.plan(graph, targets, MissionEnd::Stay)?, seen))
    }

    /// The node that sees a thing on a wall best, and the distance from the camera there, metres.
    fn node_before(&self, plate: &Plate) -> Option<(Node, f64)> {
        let cameras = CameraConfig::default();
        let nodes = self.graph.nodes().filter(|node| is_place(node.kind));
        let seen = nodes.filter_map(|node| {
            let site_from_node = self.site_from_map * isometry_from_pose(&node.map_from_node)?;
            let head = (site_from_node * Point3::from(cameras.base_from_head_m)).coords;
            let offset = head - plate.site_m;
            let distance_m = offset.norm();
            let angle_rad = (offset.dot(&plate.outward) / distance_m).clamp(-1.0, 1.0).acos();
            let to_plate = site_from_node.rotation.inverse() * -offset;
            let is_seen = PLATE_DISTANCE_M.contains(&distance_m)
                && angle_rad < MAX_PLATE_ANGLE_RAD
                && to_plate.y.atan2(to_plate.x).abs() < MAX_TARGET_PAN_RAD
                && self
                    .site
                    .cast_ray(
                        &(plate.site_m + plate.outward * 0.01),
                        &(offset / distance_m),
                        distance_m - 0.05,
                    )
                    .is_none();
            is_seen.then(|| (node.clone(), distance_m))
        });
        seen.min_by(|(_, a), (_, b)| (a - PLATE_AWAY_M).abs().total_cmp(&(b - PLATE_AWAY_M).abs()))
    }

    fn plan(
        &self,
        mut graph: Site,
        targets: Vec<InspectionTarget>,
        end: MissionEnd,
    ) -> Result<PlannedMission> {
        let task = |(number, target): (u128, &InspectionTarget)| Task {
            id: target.task,
            place: TaskPlace::InspectionPoint(point_id(number)),
            on_unreachable: FailurePolicy::default(),
            on_action_failure: FailurePolicy::default(),
        };
        let mission = Mission {
            id: MISSION,
            name: "Round".to_owned(),
            tasks: (0..).zip(&targets).map(task).collect(),
            order: TaskOrder::Shortest { keep_first: false, keep_last: false },
            order_constraints: Vec::new(),
            end,
        };
        put(&mut graph, Object::Mission(mission))?;
        Ok(PlannedMission { graph, targets })
    }

    /// Puts an inspection point for something that the camera sees from a node. None if it sees nothing near.
    fn put_target(
        &self,
        graph: &mut Site,
        node: Node,
        number: u128,
        rng: &mut Rng,
    ) -> Result<Option<InspectionTarget>> {
        let map_from_node = isometry_from_pose(&node.map_from_node).context("a node has no pose")?;
        let site_from_node = self.site_from_map * map_from_node;
        let Some((site_m, distance_m)) = self.seen_point(&site_from_node, rng) else { return Ok(None) };
        self.put_point(graph, node, number, (site_m, distance_m), SHOWN_WIDTH_M).map(Some)
    }

    /// Puts an inspection point for something at this place and distance from the camera.
    fn put_point(
        &self,
        graph: &mut Site,
        node: Node,
        number: u128,
        (site_m, distance_m): (Vector3, f64),
        shown_width_m: f64,
    ) -> Result<InspectionTarget> {
        let map_from_node = isometry_from_pose(&node.map_from_node).context("a node has no pose")?;
        let site_from_node = self.site_from_map * map_from_node;
        let map_m = self.site_from_map.inverse_transform_point(&Point3::from(site_m)).coords;
        let view_m = 2.0 * distance_m * (0.5 * CameraConfig::default().field_of_view_rad).tan();
        let zoom = Parameter::Number((view_m / shown_width_m).clamp(1.0, CameraConfig::default().zoom_max));
        let point = InspectionPoint {
            id: point_id(number),
            name: format!("P{number}"),
            asset: None,
            node: node.id,
            target_m: geometry::vec_to_plain(&map_m),
            request: ActionRequest {
                action: "photo".to_owned(),
                parameters: [("zoom".to_owned(), zoom)].into(),
            },
            limits: None,
            gauge: None,
        };
        // As an operator makes a node where something is looked at: with the tolerance of pictures.
        let tolerance = PoseTolerance::default();
        put(graph, Object::Node(Node { kind: NodeKind::Inspection, tolerance, ..node }))?;
        put(graph, Object::InspectionPoint(point))?;
        let task = TaskId(Uuid::from_u128(100 + number));
        Ok(InspectionTarget { task, site_from_node, site_m, map_m })
    }

    /// A random point of a solid that the camera sees from there, and its distance.
    fn seen_point(&self, site_from_base: &Isometry, rng: &mut Rng) -> Option<(Vector3, f64)> {
        let cameras = CameraConfig::default();
        let head = site_from_base * Point3::from(cameras.base_from_head_m);
        let ahead = site_from_base.rotation * Vector3::x();
        let heading_rad = ahead.y.atan2(ahead.x);
        (0..TARGET_ATTEMPTS).find_map(|_| {
            let (sin, cos) = (heading_rad + rng.range(-MAX_TARGET_PAN_RAD, MAX_TARGET_PAN_RAD)).sin_cos();
            let elevation = rng.range(TARGET_ELEVATION_RAD.start, TARGET_ELEVATION_RAD.end);
            let direction = Vector3::new(cos * elevation.cos(), sin * elevation.cos(), elevation.sin());
            let (distance_m, _) = self.site.cast_ray(&head.coords, &direction, TARGET_DISTANCE_M.end)?;
            let is_far_enough = distance_m >= TARGET_DISTANCE_M.start;
            is_far_enough.then(|| (head.coords + direction * distance_m, distance_m))
        })
    }
}

/// Whether a robot may stand there to look at something.
fn is_place(kind: NodeKind) -> bool {
    !matches!(kind, NodeKind::Dock | NodeKind::DockApproach | NodeKind::Portal)
}

fn point_id(number: u128) -> InspectionPointId {
    InspectionPointId(Uuid::from_u128(200 + number))
}

fn put(graph: &mut Site, object: Object) -> Result<()> {
    let id = EditId(Uuid::from_u128(4));
    let edit = graph.put(id, object);
    graph.apply(&edit, id).map_err(|error| anyhow::anyhow!("{error:?}"))?;
    Ok(())
}
