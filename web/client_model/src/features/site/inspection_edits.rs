//! Edits of inspection points as operators make them: each a step of undo.

use super::{SiteEdit, SiteFeature};
use crate::Selection;
use site_model::{
    ActionRequest, InspectionPoint, InspectionPointId, Node, NodeId, NodeKind, Object, Parameters,
};
use std::collections::BTreeSet;
use vocab::Vec3;

/// The action of a new inspection point.
const FIRST_ACTION: &str = "photo";

/// Parameters of a new inspection point.
struct NewPointConfig {
    /// Nodes nearer to a target than this are not chosen by themselves, metres: the robot's head would touch it. Chosen: as for the inspection points of the example.
    min_node_distance_m: f64,
}

const CONFIG: NewPointConfig = NewPointConfig { min_node_distance_m: 0.8 };

impl SiteFeature {
    /// The inspection point that is selected, with another target, m, map frame. `None` with anything else selected.
    pub fn retargeting(&self, selection: Option<Selection>, target_m: Vec3) -> Option<SiteEdit> {
        match selection? {
            Selection::InspectionPoint(id) => {
                Some(self.changing_inspection_point(id, |point| point.target_m = target_m))
            }
            _ => None,
        }
    }

    /// The nodes from which a target, m, map frame, can be looked at, the best first: those in a good distance, then farther ones. Docks are not among them, because
    /// robots that charge block them.
    pub fn viewpoints(&self, target_m: Vec3) -> Vec<NodeId> {
        let distance_m = |node: &Node| {
            let at = node.map_from_node.position;
            (at.x - target_m.x).hypot(at.y - target_m.y).hypot(at.z - target_m.z)
        };
        let is_tilt_possible = |node: &Node| self.sight_from(node, target_m, 1.0).is_tilt_possible;
        // The first key is whether it is too near or out of the camera's reach.
        let mut nodes: Vec<(bool, f64, NodeId)> = self
            .shown_nodes()
            .filter(|node| !matches!(node.kind, NodeKind::Dock | NodeKind::DockApproach | NodeKind::Portal))
            .map(|node| {
                let distance_m = distance_m(node);
                (distance_m < CONFIG.min_node_distance_m || !is_tilt_possible(node), distance_m, node.id)
            })
            .collect();
        nodes.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        nodes.into_iter().map(|(_, _, node)| node).collect()
    }

    /// A new inspection point that takes a photo of a target, metres, map frame.
    pub fn adding_inspection_point(&self, node: NodeId, target_m: Vec3) -> (InspectionPointId, SiteEdit) {
        let id = InspectionPointId(self.new_id(0));
        let point = InspectionPoint {
            id,
            name: self.free_point_name(),
            asset: None,
            node,
            target_m,
            request: ActionRequest { action: FIRST_ACTION.to_owned(), parameters: Parameters::new() },
            limits: None,
            gauge: None,
        };
        (id, SiteEdit { put: vec![Object::InspectionPoint(point)], removed: Vec::new() })
    }

    /// An inspection point after a change.
    pub fn changing_inspection_point(
        &self,
        id: InspectionPointId,
        change: impl FnOnce(&mut InspectionPoint),
    ) -> SiteEdit {
        let mut edit = SiteEdit::default();
        if let Some(mut point) = self.site().and_then(|site| site.inspection_point(id)).cloned() {
            change(&mut point);
            edit.put.push(Object::InspectionPoint(point));
        }
        edit
    }

    /// All inspection points, by name.
    pub fn inspection_points(&self) -> Vec<&InspectionPoint> {
        let objects = self.site().into_iter().flat_map(|site| site.objects());
        let mut points: Vec<_> = objects
            .filter_map(|versioned| match &versioned.object {
                Object::InspectionPoint(point) => Some(point),
                _ => None,
            })
            .collect();
        points.sort_by(|a, b| a.name.cmp(&b.name).then(a.id.cmp(&b.id)));
        points
    }

    /// The first of the names `P1`, `P2` and so on that no inspection point begins with: people write what it is behind the number.
    fn free_point_name(&self) -> String {
        let points = self.inspection_points();
        let numbers: BTreeSet<&str> =
            points.iter().filter_map(|point| point.name.split_whitespace().next()).collect();
        let free = (1..).map(|number| format!("P{number}")).find(|name| !numbers.contains(name.as_str()));
        free.unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::Robot;
    use crate::ClientCommand;
    use crate::testing::TestClient;
    use vocab::{MapId, Vec3};

    #[test]
    fn the_next_number_follows_also_when_words_stand_behind_the_earlier_ones() {
        let robot = Robot::default();
        let mut client = TestClient::with_site(&robot);
        let map = MapId(uuid::Uuid::from_u128(3));
        let (node, edit) = client.model.site.adding_node(Vec3::default(), map, None);
        client.command(ClientCommand::EditSite(edit));
        for _ in 0..2 {
            let (point, edit) = client.model.site.adding_inspection_point(node, Vec3::new(2.0, 0.0, 1.0));
            client.command(ClientCommand::EditSite(edit));
            let renamed =
                client.model.site.changing_inspection_point(point, |point| point.name.push_str(" Pump hall"));
            client.command(ClientCommand::EditSite(renamed));
        }
        let names: Vec<&str> =
            client.model.site.inspection_points().into_iter().map(|point| point.name.as_str()).collect();
        assert_eq!(names, ["P1 Pump hall", "P2 Pump hall"]);
    }
}
