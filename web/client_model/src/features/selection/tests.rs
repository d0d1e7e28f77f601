//! What is selected, alone or together, and what the next click does.

use super::*;
use uuid::Uuid;

fn node(number: u128) -> NodeId {
    NodeId(Uuid::from_u128(number))
}

#[test]
fn one_node_is_selected_alone_and_several_together() {
    let mut selected = Selected::default();
    selected.select_nodes(&BTreeSet::from([node(1)]));
    assert_eq!(selected.selection, Some(Selection::Node(node(1))));
    assert_eq!(selected.nodes(), BTreeSet::from([node(1)]));
    let both = BTreeSet::from([node(1), node(2)]);
    selected.select_nodes(&both);
    assert_eq!((selected.selection, selected.nodes()), (None, both));
    selected.selection = Some(Selection::Robot);
    assert_eq!(selected.nodes(), BTreeSet::new(), "only while nothing else is selected");
    selected.selection = None;
    selected.part();
    assert_eq!(selected.nodes(), BTreeSet::new());
}

#[test]
fn a_mode_ends_only_if_it_is_the_one_that_is_left() {
    let mut selected = Selected::default();
    selected.enter(PointerMode::PickPose);
    selected.leave(PointerMode::PickGoal);
    assert_eq!(selected.mode(), PointerMode::PickPose);
    selected.leave(PointerMode::PickPose);
    assert_eq!(selected.mode(), PointerMode::Select);
}
