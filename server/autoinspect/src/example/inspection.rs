//! What is inspected in the example: plates on the walls of the hall, each looked at from a node of the topological map.
//!
//! A person would click on what is to be inspected. Here the list of plates comes from the site, as from a list of measuring points of a plant.

use crate::summaries;
use geometry::{Isometry, Vector3};
use sim::{CameraConfig, CameraScene, Face, Fixture, GammaField, SimulatedSite};
use site_model::{
    ActionRequest, InspectionPoint, InspectionPointId, Node, NodeKind, Parameter, Parameters, ReadingLimits,
};
use uuid::Uuid;
use vocab::Vec3;

/// From where plates are looked at.
#[derive(Clone, Copy, Debug)]
struct ViewConfig {
    /// Shortest distance between node and plate, metres: the head tilts by 80 degrees at most, and the robot must not touch the wall.
    min_distance_m: f64,
    /// Longest distance, metres: at the greatest zoom in use the plate still has 100 pixels.
    max_distance_m: f64,
    /// Least cosine of the angle between the line to the node and the normal of the plate: 60 degrees. Chosen: at 60 degrees a dial looks half as wide as it is.
    min_facing: f64,
    /// A ray from the camera may end this far before the plate, metres. Chosen: the depth of a gauge before its plate.
    slack_m: f64,
    /// Width of the picture in the plane of the plate, metres. Chosen: a label and some of its surroundings.
    picture_width_m: f64,
    /// The same for a gauge: it is 160 of 640 pixels wide, so that its needle is read (docs/benchmarks/picture-changes.md).
    gauge_picture_width_m: f64,
    /// Greatest zoom in use. More would leave nothing of the surroundings when the aim is off by a degree.
    zoom_max: f64,
    /// Counting time of a spectrum, seconds. Chosen: the lines of the sources stand out from the background, and the tour does not take long.
    gamma_s: i64,
}

const CONFIG: ViewConfig = ViewConfig {
    min_distance_m: 0.8,
    max_distance_m: 5.0,
    min_facing: 0.5,
    slack_m: 0.05,
    picture_width_m: 0.8,
    gauge_picture_width_m: 0.4,
    zoom_max: 12.0,
    gamma_s: 20,
};

/// What is done at a plate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reading {
    /// A photo of a gauge.
    Gauge,
    /// A photo of a label.
    Label,
    /// A thermal photo of a warm machine.
    Thermal,
    /// Temperature and humidity of the air beside any plate.
    Air,
    /// A gamma spectrum beside a contaminated machine.
    Gamma,
}

/// The nine readings of the example, along the walk. Every action that looks at something is among them.
const READINGS: [Reading; 9] = [
    Reading::Gauge,
    Reading::Gamma,
    Reading::Gauge,
    Reading::Label,
    Reading::Air,
    Reading::Thermal,
    Reading::Label,
    Reading::Gauge,
    Reading::Thermal,
];

/// The site with what hangs on its walls.
pub struct InspectedSite<'a> {
    pub site: &'a SimulatedSite,
    pub scene: &'a CameraScene,
    pub gamma: &'a GammaField,
    /// The map in the site, as both are drawn: the map begins where the walk begins.
    pub site_from_map: Isometry,
}

impl InspectedSite<'_> {
    /// Nine inspection points, each of another plate, spread along the walk. Fewer where the nodes do not see enough plates. `id` makes the id of the point of this number.
    pub fn points(&self, nodes: &[Node], id: impl Fn(u32) -> Uuid) -> Vec<InspectionPoint> {
        let mut seen: Vec<(&Fixture, View<'_>)> =
            self.scene.fixtures().iter().filter_map(|it| Some((it, self.best_view(it, nodes)?))).collect();
        // Fixtures come in the order of the walk.
        let order: Vec<String> = seen.iter().map(|(fixture, _)| fixture.tag.clone()).collect();
        let mut points = Vec::new();
        for (number, reading) in (0..).zip(READINGS) {
            let wanted = number as usize * order.len() / READINGS.len();
            let apart = |fixture: &Fixture| {
                order.iter().position(|tag| *tag == fixture.tag).map(|at| at.abs_diff(wanted))
            };
            let suitable = seen.iter().enumerate().filter(|(_, (fixture, _))| self.suits(reading, fixture));
            let nearest = suitable.min_by_key(|(_, (fixture, _))| apart(fixture)).map(|(index, _)| index);
            let Some(index) = nearest else { continue };
            let (fixture, view) = seen.remove(index);
            points.push(self.point(InspectionPointId(id(number)), reading, fixture, &view));
        }
        points
    }

    fn suits(&self, reading: Reading, fixture: &Fixture) -> bool {
        let plate = fixture.site_from_plate.translation.vector;
        let is_contaminated = || self.gamma.sources().iter().any(|it| (it.position_m - plate).norm() < 0.1);
        match (reading, &fixture.face) {
            (Reading::Gauge, Face::Gauge { .. }) | (Reading::Label, Face::Label(_)) => true,
            (Reading::Thermal, Face::Warm { .. }) | (Reading::Air, _) => true,
            (Reading::Gamma, Face::Warm { .. }) => is_contaminated(),
            _ => false,
        }
    }

    /// The node from which a plate is seen best: near to it and from the front.
    fn best_view<'a>(&self, fixture: &Fixture, nodes: &'a [Node]) -> Option<View<'a>> {
        let views = nodes.iter().filter_map(|node| self.view(fixture, node));
        views.min_by(|a, b| a.effort_m().total_cmp(&b.effort_m()))
    }

    /// How a plate is seen from a node; `None` where it is not.
    fn view<'a>(&self, fixture: &Fixture, node: &'a Node) -> Option<View<'a>> {
        if matches!(node.kind, NodeKind::Dock | NodeKind::DockApproach | NodeKind::Portal) {
            return None;
        }
        let map_from_node = geometry::isometry_from_pose(&node.map_from_node)?;
        let head_m = Vector3::z() * CameraConfig::default().base_from_head_m[2];
        let camera = (self.site_from_map * map_from_node).translation.vector + head_m;
        let to_camera = camera - fixture.site_from_plate.translation.vector;
        let distance_m = to_camera.norm();
        let outward = fixture.site_from_plate.rotation * Vector3::z();
        let facing = outward.dot(&to_camera) / distance_m;
        let is_near = (CONFIG.min_distance_m..=CONFIG.max_distance_m).contains(&distance_m);
        if !is_near || facing < CONFIG.min_facing {
            return None;
        }
        let free = self.site.cast_ray(&camera, &(-to_camera / distance_m), distance_m - CONFIG.slack_m);
        free.is_none().then_some(View { node, distance_m, facing })
    }

    fn point(
        &self,
        id: InspectionPointId,
        reading: Reading,
        fixture: &Fixture,
        view: &View<'_>,
    ) -> InspectionPoint {
        let target =
            self.site_from_map.inverse() * nalgebra::Point3::from(fixture.site_from_plate.translation.vector);
        let mut parameters = Parameters::new();
        let tag = &fixture.tag;
        let (name, action, limits) = match (reading, &fixture.face) {
            (Reading::Gauge, Face::Gauge { unit, max, .. }) => {
                let limits =
                    ReadingLimits { min: Some(0.1 * max), max: Some(0.9 * max), unit: (*unit).to_owned() };
                (summaries::gauge_name(*unit == "bar", tag), "photo", Some(limits))
            }
            (Reading::Label, _) => (summaries::valve_name(tag), "photo", None),
            (Reading::Thermal, _) => (summaries::machine_heat_name(tag), "thermal_photo", None),
            (Reading::Air, _) => (summaries::air_name(tag), "temperature_humidity", None),
            (Reading::Gamma, _) => (summaries::machine_radiation_name(tag), "gamma_spectrum", None),
            (Reading::Gauge, _) => (tag.clone(), "photo", None),
        };
        if action == "photo" {
            let width_m = match reading {
                Reading::Gauge => CONFIG.gauge_picture_width_m,
                _ => CONFIG.picture_width_m,
            };
            parameters.insert("zoom".to_owned(), Parameter::Number(view.zoom(width_m)));
        }
        if action == "gamma_spectrum" {
            parameters.insert("duration_s".to_owned(), Parameter::Integer(CONFIG.gamma_s));
        }
        InspectionPoint {
            id,
            name,
            asset: None,
            node: view.node.id,
            target_m: Vec3::new(target.x, target.y, target.z),
            request: ActionRequest { action: action.to_owned(), parameters },
            limits,
            gauge: None,
        }
    }
}

/// How a plate is seen from a node.
struct View<'a> {
    node: &'a Node,
    distance_m: f64,
    /// Cosine of the angle to the normal of the plate.
    facing: f64,
}

impl View<'_> {
    /// The distance, lengthened by a slanted view.
    fn effort_m(&self) -> f64 {
        self.distance_m / self.facing
    }

    /// The zoom at which the picture is this wide in the plane of the plate, metres, to half a step.
    fn zoom(&self, width_m: f64) -> f64 {
        let half_width = (0.5 * CameraConfig::default().field_of_view_rad).tan();
        let zoom = 2.0 * half_width * self.distance_m / width_m;
        (2.0 * zoom).round().clamp(2.0, 2.0 * CONFIG.zoom_max) / 2.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim::{InstrumentEnvironment, SiteName};
    use site_model::{NodeId, PoseTolerance, describe_action};
    use std::collections::BTreeSet;
    use std::sync::Arc;

    /// A node that looks at a plate from 1.5 m in front of it, in a map with the frame of the site.
    fn node_at(number: usize, fixture: &Fixture) -> Node {
        let at = fixture.site_from_plate * nalgebra::Point3::new(0.0, 0.0, 1.5);
        Node {
            id: NodeId(Uuid::from_u128(number as u128)),
            name: format!("N{number}"),
            kind: NodeKind::Waypoint,
            map_from_node: vocab::Pose { position: Vec3::new(at.x, at.y, 0.55), ..vocab::Pose::IDENTITY },
            anchor: None,
            tolerance: PoseTolerance::default(),
            influence_area_m: Vec::new(),
            floor: 0,
            tags: BTreeSet::new(),
            properties: [].into(),
        }
    }

    #[test]
    fn nine_plates_are_inspected_by_every_action_each_from_the_node_in_front_of_it() {
        let site = Arc::new(SimulatedSite::new(SiteName::B1));
        let scene = CameraScene::new(Arc::clone(&site));
        let surroundings = InstrumentEnvironment::new(&scene);
        let site_from_map = Isometry::identity();
        let inspected =
            InspectedSite { site: &site, scene: &scene, gamma: surroundings.gamma(), site_from_map };
        let nodes: Vec<Node> = (0..).zip(scene.fixtures()).map(|(number, it)| node_at(number, it)).collect();
        let points = inspected.points(&nodes, |number| Uuid::from_u128(u128::from(number)));
        let actions: BTreeSet<&str> = points.iter().map(|point| point.request.action.as_str()).collect();
        assert_eq!(
            actions.into_iter().collect::<Vec<_>>(),
            ["gamma_spectrum", "photo", "temperature_humidity", "thermal_photo"]
        );
        assert_eq!(points.len(), READINGS.len());
        let plates: BTreeSet<NodeId> = points.iter().map(|point| point.node).collect();
        assert_eq!(plates.len(), points.len(), "each is another plate");
        for point in &points {
            let node = nodes.iter().find(|node| node.id == point.node).expect("one of the nodes");
            let (from, to) = (node.map_from_node.position, point.target_m);
            let distance_m = (from.x - to.x).hypot(from.y - to.y);
            assert!((distance_m - 1.5).abs() < 0.01, "{}: {distance_m} m", point.name);
            assert!(describe_action(&point.request.action).is_some(), "{:?}", point.request);
        }
        assert!(inspected.points(&[], |_| Uuid::nil()).is_empty(), "nothing is seen from nowhere");
    }
}
