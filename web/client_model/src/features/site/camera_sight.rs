//! What the robot's camera would see of an inspection point, and how far the robot stands off.

use super::{SiteEdit, SiteFeature};
use site_model::{InspectionPoint, Node, Object, Parameter};
use vocab::{Quat, Vec3};

/// Rows of a picture for each of its columns: 3 to 4.
const ROWS_PER_COLUMN: f64 = 0.75;

/// Line of sight from the camera to a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraSight {
    /// Where the camera is, m, map frame.
    pub camera_m: Vec3,
    /// What it looks at, m, map frame.
    pub target_m: Vec3,
    /// Distance between the two, m.
    pub distance_m: f64,
    /// Heading and angle upwards, rad.
    pub yaw_rad: f64,
    /// Angle upwards, rad.
    pub tilt_rad: f64,
    /// Tangent of half the vertical field of view, with the zoom.
    pub tan_half_height: f64,
    /// Whether the head can tilt that far.
    pub is_tilt_possible: bool,
}

impl SiteFeature {
    /// What the camera would see of an inspection point. The head turns towards it, whatever the heading of the node.
    pub fn camera_sight(&self, point: &InspectionPoint) -> Option<CameraSight> {
        let zoom = match point.request.parameters.get("zoom") {
            Some(Parameter::Number(zoom)) => *zoom,
            Some(Parameter::Integer(zoom)) => *zoom as f64,
            _ => 1.0,
        };
        Some(self.sight_from(self.site()?.node(point.node)?, point.target_m, zoom))
    }

    /// The line of sight from the camera at a node to a target, m, map frame.
    pub fn sight_from(&self, node: &Node, target: Vec3, zoom: f64) -> CameraSight {
        let head = self.camera_head();
        let yaw = yaw_of(&node.map_from_node.orientation);
        let base = node.map_from_node.position;
        let [ahead, left, up] = head.base_from_head_m;
        let camera = Vec3::new(
            base.x + ahead * yaw.cos() - left * yaw.sin(),
            base.y + ahead * yaw.sin() + left * yaw.cos(),
            base.z + up,
        );
        let (x, y, z) = (target.x - camera.x, target.y - camera.y, target.z - camera.z);
        let tilt_rad = z.atan2(x.hypot(y));
        let tan_half_height = (0.5 * head.field_of_view_rad).tan() * ROWS_PER_COLUMN;
        CameraSight {
            camera_m: camera,
            target_m: target,
            distance_m: x.hypot(y).hypot(z),
            yaw_rad: y.atan2(x),
            tilt_rad,
            tan_half_height: tan_half_height / zoom.clamp(1.0, head.zoom_max.max(1.0)),
            is_tilt_possible: (head.tilt_min_rad..=head.tilt_max_rad).contains(&tilt_rad),
        }
    }

    /// The node of an inspection point at this distance from the target, m, in the direction in which it is now, and facing the target. The robot keeps its height;
    /// so the distance is never less than the difference in height.
    pub fn standing_off(&self, point: &InspectionPoint, distance_m: f64) -> SiteEdit {
        self.facing(point, |node| {
            let (at, target) = (node.map_from_node.position, point.target_m);
            let (x, y, z) = (at.x - target.x, at.y - target.y, at.z - target.z);
            let across = x.hypot(y);
            let wanted = (distance_m * distance_m - z * z).max(0.0).sqrt();
            // From exactly below the target, any direction is as good.
            let [east, north] = if across > 1e-6 { [x / across, y / across] } else { [1.0, 0.0] };
            node.map_from_node.position =
                Vec3::new(target.x + east * wanted, target.y + north * wanted, at.z);
            node.anchor = None;
        })
    }

    /// The node of an inspection point facing the target.
    pub fn facing_target(&self, point: &InspectionPoint) -> SiteEdit {
        self.facing(point, |_| {})
    }

    fn facing(&self, point: &InspectionPoint, move_node: impl FnOnce(&mut Node)) -> SiteEdit {
        let edit = self.changing_node(point.node, |node| {
            move_node(node);
            let at = node.map_from_node.position;
            let (z, w) = (0.5 * (point.target_m.y - at.y).atan2(point.target_m.x - at.x)).sin_cos();
            node.map_from_node.orientation = Quat { x: 0.0, y: 0.0, z, w };
        });
        let is_new = |object: &Object| {
            self.site().is_none_or(|site| site.get(object.id()).is_none_or(|known| known.object != *object))
        };
        SiteEdit { put: edit.put.into_iter().filter(is_new).collect(), removed: Vec::new() }
    }
}

/// Heading of a rotation, radians.
pub(crate) fn yaw_of(q: &Quat) -> f64 {
    (2.0 * (q.w * q.z + q.x * q.y)).atan2(1.0 - 2.0 * (q.y * q.y + q.z * q.z))
}

#[cfg(test)]
mod tests {
    use super::super::tests::Robot;
    use crate::ClientCommand;
    use crate::testing::TestClient;
    use api::{Platform, RobotBody};
    use site_model::Parameter;
    use vocab::{CameraHead, MapId, Vec3};

    #[test]
    fn the_node_goes_to_a_distance_facing_the_target_and_the_camera_is_aimed_at_it() {
        let robot = Robot::default();
        let mut client = TestClient::with_site(&robot);
        let map = MapId(uuid::Uuid::from_u128(3));
        let (node, edit) = client.model.site.adding_node(Vec3::new(5.0, 1.0, 0.5), map, None);
        client.command(ClientCommand::EditSite(edit));
        let (point, edit) = client.model.site.adding_inspection_point(node, Vec3::new(1.0, 1.0, 0.7));
        client.command(ClientCommand::EditSite(edit));
        let edit = client.model.site.changing_inspection_point(point, |point| {
            point.request.parameters.insert("zoom".to_owned(), Parameter::Integer(2));
        });
        client.command(ClientCommand::EditSite(edit));
        let of = |client: &TestClient| client.model.site.inspection_points()[0].clone();
        let edit = client.model.site.standing_off(&of(&client), 2.0);
        client.command(ClientCommand::EditSite(edit));
        let sight = client.model.site.camera_sight(&of(&client)).expect("of a node");
        // The node stands at x = 2.99, the head 0.32 m nearer and at the height of the target.
        assert!((sight.camera_m.x - 2.67).abs() < 0.01 && (sight.camera_m.z - 0.7).abs() < 1e-9);
        assert!((sight.yaw_rad.abs() - std::f64::consts::PI).abs() < 1e-6 && sight.tilt_rad.abs() < 1e-9);
        assert!((sight.tan_half_height - 0.216_506).abs() < 1e-6 && sight.is_tilt_possible);
        assert!(client.model.site.facing_target(&of(&client)).put.is_empty(), "it faces it");
        client.command(ClientCommand::Undo);
        let site = client.model.site.site().expect("a site");
        assert_eq!(site.node(node).map(|node| node.map_from_node.position.x), Some(5.0));
    }

    #[test]
    fn a_target_straight_above_is_too_high_for_the_head() {
        let robot = Robot::default();
        let mut client = TestClient::with_site(&robot);
        let (node, edit) =
            client.model.site.adding_node(Vec3::default(), MapId(uuid::Uuid::from_u128(3)), None);
        client.command(ClientCommand::EditSite(edit));
        let (_, edit) = client.model.site.adding_inspection_point(node, Vec3::new(0.32, 0.0, 3.0));
        client.command(ClientCommand::EditSite(edit));
        let point = client.model.site.inspection_points()[0].clone();
        assert!(!client.model.site.camera_sight(&point).expect("of a node").is_tilt_possible);
        // Another robot looks straight up.
        let body = RobotBody {
            footprint_radius_m: 0.3,
            clearance_height_m: 0.8,
            standing_height_m: 0.42,
            step_height_m: 0.2,
            camera_head: CameraHead { tilt_max_rad: std::f64::consts::FRAC_PI_2, ..CameraHead::COMMON },
        };
        client.event(api::Event::Platform(Platform { body: Some(body), ..Platform::default() }));
        assert!(client.model.site.camera_sight(&point).expect("of a node").is_tilt_possible);
        // A report without a body, of a gateway that has no core, changes nothing.
        client.event(api::Event::Platform(Platform::default()));
        assert!(client.model.site.camera_sight(&point).expect("of a node").is_tilt_possible);
        // A distance below the difference in height leads to right below the target.
        let edit = client.model.site.standing_off(&point, 0.5);
        assert_eq!(edit.put.len(), 1);
    }
}
