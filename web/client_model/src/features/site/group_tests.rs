//! Several nodes together, tools, and floors.

use super::tests::Robot;
use crate::testing::TestClient;
use crate::{ClientCommand, GraphTool, Selection};
use site_model::{NodeId, NodeKind};
use std::collections::BTreeSet;
use vocab::{MapId, Vec3};

/// A client with nodes at these places, none joined, and the robot that confirms them.
fn with_nodes(places: &[[f64; 3]]) -> (TestClient, Robot, Vec<NodeId>) {
    let mut robot = Robot::default();
    let mut client = TestClient::with_site(&robot);
    let map = MapId(uuid::Uuid::from_u128(3));
    let mut nodes = Vec::new();
    for [x, y, z] in places {
        let (node, edit) = client.model.site.adding_node(Vec3::new(*x, *y, *z), map, None);
        client.command(ClientCommand::EditSite(edit));
        client.settle(&mut robot);
        nodes.push(node);
    }
    (client, robot, nodes)
}

fn edges(client: &TestClient) -> Vec<[NodeId; 2]> {
    client
        .model
        .site
        .site()
        .into_iter()
        .flat_map(|site| site.edges())
        .map(|edge| [edge.from, edge.to])
        .collect()
}

#[test]
fn nodes_are_moved_changed_joined_and_deleted_together_each_by_one_step_of_undo() {
    let (mut client, mut robot, nodes) =
        with_nodes(&[[0.0, 0.0, 0.5], [1.0, 0.0, 0.5], [5.0, 0.0, 0.5], [2.5, 0.0, 0.5]]);
    let all: BTreeSet<NodeId> = nodes.iter().copied().collect();
    let to = |node: &NodeId| (*node, Vec3::new(9.0, 9.0, 0.5));
    let moved = client.model.site.moving_nodes(&nodes[..2].iter().map(to).collect());
    client.command(ClientCommand::EditSite(moved));
    assert_eq!(client.take_edits().iter().map(|edit| edit.changes.len()).collect::<Vec<_>>(), [2]);
    client.command(ClientCommand::Undo);
    let x = |client: &TestClient, node: NodeId| {
        client.model.site.site().and_then(|site| site.node(node)).map(|node| node.map_from_node.position.x)
    };
    assert_eq!((x(&client, nodes[0]), x(&client, nodes[1])), (Some(0.0), Some(1.0)));
    client.settle(&mut robot);

    let edit = client.model.site.changing_nodes(&all, |node| node.kind = NodeKind::Hold);
    client.command(ClientCommand::EditSite(edit));
    assert!(client.model.site.changing_nodes(&all, |node| node.kind = NodeKind::Hold).put.is_empty());

    // Neighbours along the line are joined, and not the ends.
    let edit = client.model.site.joining_nodes(&all);
    client.command(ClientCommand::EditSite(edit));
    let [a, b, far, between] = [nodes[0], nodes[1], nodes[2], nodes[3]];
    let pairs = [[a, b], [b, a], [b, between], [between, b], [between, far], [far, between]];
    assert_eq!(edges(&client).into_iter().collect::<BTreeSet<_>>(), BTreeSet::from(pairs));
    assert!(client.model.site.joining_nodes(&all).put.is_empty(), "they are joined");
    assert_eq!(client.model.site.edges_between(&BTreeSet::from([a, b])).count(), 2);

    let edit = client.model.site.removing_nodes(&BTreeSet::from([b, between]));
    client.command(ClientCommand::EditSite(edit));
    assert!(edges(&client).is_empty());
    client.command(ClientCommand::Undo);
    assert_eq!(edges(&client).len(), 6);
    client.command(ClientCommand::Undo);
    assert!(edges(&client).is_empty() && client.model.site.floors().len() == 1);
}

#[test]
fn several_nodes_are_selected_until_something_else_is_or_they_are_gone() {
    let (mut client, _, nodes) = with_nodes(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    let two = BTreeSet::from([nodes[0], nodes[1]]);
    client.command(ClientCommand::SelectNodes(two.clone()));
    assert_eq!((client.model.selection(), client.model.selected_nodes()), (None, two.clone()));
    let edit = client.model.site.removing_selected(None, &two).expect("two nodes");
    client.command(ClientCommand::EditSite(edit));
    assert!(client.model.selected_nodes().is_empty());
    client.command(ClientCommand::Undo);
    client.command(ClientCommand::Select(Some(Selection::Node(nodes[2]))));
    assert_eq!(client.model.selected_nodes(), BTreeSet::from([nodes[2]]));
    client.command(ClientCommand::Select(None));
    assert!(client.model.selected_nodes().is_empty());
    client.command(ClientCommand::SelectNodes(BTreeSet::from([nodes[2]])));
    assert_eq!(
        client.model.selection(),
        Some(Selection::Node(nodes[2])),
        "one alone is an ordinary selection"
    );
    assert!(client.model.site.removing_selected(Some(Selection::Robot), &BTreeSet::new()).is_none());
}

#[test]
fn a_click_with_a_tool_joins_nodes_or_adds_to_those_that_are_selected() {
    let (mut client, _, nodes) = with_nodes(&[[0.0; 3], [1.0, 0.0, 0.0]]);
    let mut click = |tool, node| {
        let selected = client.model.selected_nodes();
        for command in client.model.site.clicking_node(tool, node, &selected) {
            client.command(command);
        }
        (edges(&client).len(), client.model.selected_nodes())
    };
    assert_eq!(click(GraphTool::Connect, nodes[0]), (0, [nodes[0]].into()));
    assert_eq!(click(GraphTool::Connect, nodes[1]), (2, [nodes[1]].into()));
    assert_eq!(click(GraphTool::SelectSeveral, nodes[0]), (2, [nodes[0], nodes[1]].into()));
    assert_eq!(click(GraphTool::SelectSeveral, nodes[1]), (2, [nodes[0]].into()));
}

#[test]
fn one_floor_alone_is_shown_while_it_has_nodes() {
    let (mut client, _, nodes) = with_nodes(&[[0.0, 0.0, 0.5], [1.0, 0.0, 3.5], [2.0, 0.0, 3.6]]);
    let upper = BTreeSet::from([nodes[1], nodes[2]]);
    let edit = client.model.site.changing_nodes(&upper, |node| node.floor = 1);
    client.command(ClientCommand::EditSite(edit));
    assert_eq!(client.model.site.floors(), BTreeSet::from([0, 1]));
    assert_eq!((client.model.site.shown_nodes().count(), client.model.site.shown_heights_m()), (3, None));
    client.command(ClientCommand::ShowFloor(Some(1)));
    assert_eq!(client.model.site.shown_nodes().map(|node| node.id).collect::<BTreeSet<_>>(), upper);
    assert_eq!(client.model.site.shown_heights_m(), Some([3.5, 3.6]));
    let edit = client.model.site.removing_nodes(&upper);
    client.command(ClientCommand::EditSite(edit));
    assert_eq!((client.model.site.shown_floor(), client.model.site.shown_nodes().count()), (None, 1));
}
