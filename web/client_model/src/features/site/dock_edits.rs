//! Docks that people add: the node on the dock, one in front of it, and the way between them, in one step of undo.

use super::{SiteEdit, SiteFeature};
use crate::texts;
use site_model::{
    Dock, DockId, Edge, EdgeId, Node, NodeId, NodeKind, Object, ObjectId, PoseTolerance, TravelDirection,
    Traversal,
};

impl SiteFeature {
    /// A node becomes a dock: the robot stands on it with the heading of the node. The place before it is ahead of that heading, so the robot leaves the dock ahead and
    /// walks onto it backwards. The other ways of the node lead to the place before it. Nothing for a node that is on or before a dock already.
    pub fn making_dock(&self, node: NodeId) -> SiteEdit {
        let mut edit = SiteEdit::default();
        let Some(site) = self.site() else { return edit };
        let is_of_dock = |dock: &Dock| dock.node == node || dock.approach == node;
        let Some(of_site) = site.node(node).filter(|_| !site.docks().any(is_of_dock)) else { return edit };
        let mut on_dock = of_site.clone();
        on_dock.kind = NodeKind::Dock;
        on_dock.tolerance = PoseTolerance::default();
        let approach = NodeId(self.new_id(0));
        let dock = Dock {
            id: DockId(self.new_id(1)),
            name: texts::dock_name(site.docks().count() + 1),
            node,
            approach,
        };
        edit.put.push(Object::Node(place_before(&on_dock, approach, &dock.name)));
        edit.put.push(Object::Node(on_dock));
        for edge in site.edges().filter(|edge| edge.from == node || edge.to == node) {
            let to_approach = |end: NodeId| if end == node { approach } else { end };
            edit.put.push(Object::Edge(Edge {
                from: to_approach(edge.from),
                to: to_approach(edge.to),
                ..edge.clone()
            }));
        }
        edit.put.push(Object::Edge(Edge::walk(EdgeId(self.new_id(2)), node, approach)));
        edit.put.push(Object::Edge(Edge {
            traversal: Traversal::Dock,
            direction: TravelDirection::Backward,
            ..Edge::walk(EdgeId(self.new_id(3)), approach, node)
        }));
        edit.put.push(Object::Dock(dock));
        edit
    }

    /// A dock under another name.
    pub fn renaming_dock(&self, id: DockId, name: String) -> SiteEdit {
        let dock = self.site().and_then(|site| site.docks().find(|dock| dock.id == id));
        let put = dock.map(|dock| Object::Dock(Dock { name, ..dock.clone() }));
        SiteEdit { put: put.into_iter().collect(), removed: Vec::new() }
    }

    /// The nodes from which an edge leads onto a dock, so that the robot can align itself there; the present one first.
    pub fn dock_approaches(&self, dock: &Dock) -> Vec<NodeId> {
        let mut nodes = vec![dock.approach];
        for edge in self.site().into_iter().flat_map(|site| site.edges()) {
            if edge.to == dock.node && !nodes.contains(&edge.from) {
                nodes.push(edge.from);
            }
        }
        nodes
    }

    /// A dock onto which the robot walks from another of [`Self::dock_approaches`]. The edges onto it and the kinds of both nodes follow.
    pub fn moving_dock_approach(&self, dock: &Dock, approach: NodeId) -> SiteEdit {
        let mut edit = SiteEdit::default();
        let Some(site) = self.site().filter(|_| approach != dock.approach && approach != dock.node) else {
            return edit;
        };
        for (node, kind) in [(dock.approach, NodeKind::Waypoint), (approach, NodeKind::DockApproach)] {
            edit.put.extend(self.changing_node(node, |node| node.kind = kind).put);
        }
        for edge in site.edges().filter(|edge| edge.to == dock.node) {
            let (traversal, direction) = if edge.from == approach {
                (Traversal::Dock, TravelDirection::Backward)
            } else if edge.from == dock.approach {
                (Traversal::Walk, TravelDirection::Forward)
            } else {
                continue;
            };
            edit.put.push(Object::Edge(Edge { traversal, direction, ..edge.clone() }));
        }
        edit.put.push(Object::Dock(Dock { approach, ..dock.clone() }));
        edit
    }

    /// A node is no dock any more: it becomes a waypoint, and the node before it too.
    pub fn unmaking_dock(&self, node: NodeId) -> SiteEdit {
        let mut edit = SiteEdit::default();
        let Some(dock) = self.site().and_then(|site| site.docks().find(|dock| dock.node == node)) else {
            return edit;
        };
        for node in [dock.node, dock.approach] {
            edit.put.extend(self.changing_node(node, |node| node.kind = NodeKind::Waypoint).put);
        }
        edit.removed.push(ObjectId::Dock(dock.id));
        edit
    }
}

/// The node ahead of one on a dock, with its heading.
fn place_before(on_dock: &Node, id: NodeId, dock: &str) -> Node {
    let q = on_dock.map_from_node.orientation;
    let yaw = (2.0 * (q.w * q.z + q.x * q.y)).atan2(1.0 - 2.0 * (q.y * q.y + q.z * q.z));
    let mut before = on_dock.clone();
    before.id = id;
    before.name = texts::before_dock_name(dock);
    before.kind = NodeKind::DockApproach;
    before.anchor = None;
    before.map_from_node.position.x += Dock::APPROACH_M * yaw.cos();
    before.map_from_node.position.y += Dock::APPROACH_M * yaw.sin();
    before
}

#[cfg(test)]
mod tests {
    use super::super::tests::Robot;
    use super::*;
    use crate::ClientCommand;
    use crate::testing::TestClient;
    use site_model::ValidationConfig;
    use vocab::{MapId, Vec3};

    #[test]
    fn a_node_becomes_a_dock_with_a_place_before_it_and_a_waypoint_again() {
        let robot = Robot::default();
        let mut client = TestClient::with_site(&robot);
        let map = MapId(uuid::Uuid::from_u128(3));
        let (node, edit) = client.model.site.adding_node(Vec3::new(0.0, 0.0, 0.5), map, None);
        client.command(ClientCommand::EditSite(edit));
        let (other, edit) = client.model.site.adding_node(Vec3::new(4.0, 0.0, 0.5), map, Some(node));
        client.command(ClientCommand::EditSite(edit));
        client.command(ClientCommand::EditSite(client.model.site.making_dock(node)));

        let site = client.model.site.site().unwrap();
        let dock = site.docks().next().unwrap().clone();
        assert_eq!((dock.name.as_str(), dock.node), ("Dock 1", node));
        let before = site.node(dock.approach).unwrap();
        assert_eq!((before.map_from_node.position.x, before.kind), (1.0, NodeKind::DockApproach));
        let ends: std::collections::BTreeSet<_> = site.edges().map(|edge| [edge.from, edge.to]).collect();
        let wanted =
            [[node, dock.approach], [dock.approach, node], [dock.approach, other], [other, dock.approach]];
        assert_eq!(ends, wanted.into());
        let onto = site.edges().find(|edge| edge.to == node).unwrap();
        assert_eq!((&onto.traversal, onto.direction), (&Traversal::Dock, TravelDirection::Backward));
        let problems = site.problems(&ValidationConfig::default());
        assert!(problems.iter().all(|problem| problem.object != ObjectId::Dock(dock.id)), "{problems:?}");
        assert_eq!(client.model.site.making_dock(node), SiteEdit::default(), "it is one");

        let renamed = client.model.site.renaming_dock(dock.id, "Charger".to_owned());
        client.command(ClientCommand::EditSite(renamed));
        client.command(ClientCommand::EditSite(client.model.site.connecting(other, node)));
        let dock = client.model.site.site().unwrap().docks().next().unwrap().clone();
        assert_eq!(client.model.site.dock_approaches(&dock), [dock.approach, other]);
        client.command(ClientCommand::EditSite(client.model.site.moving_dock_approach(&dock, other)));
        let site = client.model.site.site().unwrap();
        let moved = site.docks().next().unwrap();
        assert_eq!((moved.name.as_str(), moved.approach), ("Charger", other));
        let onto: Vec<_> = site.edges().filter(|edge| edge.traversal == Traversal::Dock).collect();
        assert_eq!((onto.len(), onto[0].from, onto[0].to), (1, other, node));
        let problems = site.problems(&ValidationConfig::default());
        assert!(problems.iter().all(|problem| problem.object != ObjectId::Dock(dock.id)), "{problems:?}");
        for _ in 0..3 {
            client.command(ClientCommand::Undo);
        }

        client.command(ClientCommand::EditSite(client.model.site.unmaking_dock(node)));
        let site = client.model.site.site().unwrap();
        assert_eq!((site.docks().count(), site.node(node).unwrap().kind), (0, NodeKind::Waypoint));
        client.command(ClientCommand::Undo);
        client.command(ClientCommand::Undo);
        let site = client.model.site.site().unwrap();
        assert_eq!((site.docks().count(), site.nodes().count(), site.edges().count()), (0, 2, 2));
    }
}
