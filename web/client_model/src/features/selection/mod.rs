//! What is selected in the scene, and what the next click there does.

use crate::LoopPair;
use site_model::{EdgeId, InspectionPointId, NodeId, ZoneId};
use std::collections::BTreeSet;
use vocab::KeyframeId;

/// Something selected in the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Selection {
    /// The robot.
    Robot,
    /// A keyframe of the map on the screen.
    Keyframe(KeyframeId),
    /// A loop of the map under construction.
    Loop(LoopPair),
    /// A node of the topological map.
    Node(NodeId),
    /// An edge of the topological map.
    Edge(EdgeId),
    /// An inspection point.
    InspectionPoint(InspectionPointId),
    /// A zone.
    Zone(ZoneId),
}

/// What a click in the scene does while the topological map is edited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GraphTool {
    /// Adds a node on the floor, joined to the one that is selected. A node that is clicked is joined too.
    AddNodes,
    /// Joins the node that is clicked to the one that is selected.
    Connect,
    /// Each point of the map that is clicked becomes the target of a new inspection point.
    AddInspectionPoints,
    /// The point of the map that is clicked becomes the target of the inspection point that is selected.
    PickTarget,
    /// A drag over the floor draws a zone from corner to corner.
    DrawZone,
    /// A drag selects the nodes in a box. A node that is clicked is added to those that are selected, or taken from them.
    SelectSeveral,
}

impl GraphTool {
    /// Whether it works on nodes.
    pub fn is_for_nodes(self) -> bool {
        matches!(self, Self::AddNodes | Self::Connect | Self::SelectSeveral)
    }
}

/// What the next click or drag on the ground does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PointerMode {
    /// It selects, or goes to whatever feature waits for a click.
    #[default]
    Select,
    /// A click sets the goal of a walk.
    PickGoal,
    /// A drag sets the pose of the robot: position, then heading.
    PickPose,
    /// A click edits the topological map.
    EditGraph(GraphTool),
}

/// Selection and pointer mode.
#[derive(Clone, Debug, Default)]
pub(crate) struct Selected {
    pub(crate) selection: Option<Selection>,
    /// Two or more nodes that are selected together. They count only while nothing else is selected.
    together: BTreeSet<NodeId>,
    mode: PointerMode,
}

impl Selected {
    /// Selects these nodes and nothing else.
    pub(crate) fn select_nodes(&mut self, nodes: &BTreeSet<NodeId>) {
        self.together.clear();
        self.selection = None;
        match nodes.len() {
            0 | 1 => self.selection = nodes.first().map(|node| Selection::Node(*node)),
            _ => nodes.clone_into(&mut self.together),
        }
    }

    /// Forgets which nodes are selected together.
    pub(crate) fn part(&mut self) {
        self.together.clear();
    }

    /// All nodes that are selected.
    pub(crate) fn nodes(&self) -> BTreeSet<NodeId> {
        match self.selection {
            Some(Selection::Node(node)) => BTreeSet::from([node]),
            Some(_) => BTreeSet::new(),
            None => self.together.clone(),
        }
    }

    pub(crate) fn mode(&self) -> PointerMode {
        self.mode
    }

    pub(crate) fn enter(&mut self, mode: PointerMode) {
        self.mode = mode;
    }

    /// Goes back to selecting if this mode is on.
    pub(crate) fn leave(&mut self, mode: PointerMode) {
        if self.mode == mode {
            self.mode = PointerMode::Select;
        }
    }
}

#[cfg(test)]
mod tests;
