//! A goal on the topological map that is active: where it leads, and what is done for it now.

use site_model::{DockId, EdgeId, EdgeStage, NodeId, ReachFailure};
use std::collections::BTreeSet;
use vocab::{ActionCallId, GoalId, LegId, Stamp};

/// Where a goal leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RouteTarget {
    Node(NodeId),
    Dock { dock: DockId, node: NodeId, approach: NodeId },
    OutOfDock,
}

impl RouteTarget {
    /// The node to which the route leads.
    pub fn route_end(self) -> Option<NodeId> {
        match self {
            Self::Node(node) | Self::Dock { approach: node, .. } => Some(node),
            Self::OutOfDock => None,
        }
    }
}

/// What is done now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Leg {
    /// From a place beside the graph, or in the middle of an edge, to a node.
    ToGraph(NodeId),
    /// Along an edge.
    Edge(EdgeId),
    /// Into the pose of a node at which the robot is nearly.
    IntoPose(NodeId),
    /// Out of a dock, to the node in front of it.
    OutOfDock(NodeId),
    /// From the node in front of a dock onto it.
    OntoDock,
    /// The robot stands on the dock, and waits for the charging current.
    Charge { until: Stamp },
    /// Away from a dock that does not charge, to the node in front of it.
    BackOff(NodeId),
    /// It waits before it tries an edge again.
    Wait { edge: EdgeId, until: Stamp },
    /// An action of an edge is performed, while the robot stands.
    Act { edge: EdgeId, stage: EdgeStage, index: usize, call: ActionCallId, until: Stamp },
    /// There is no route but over edges that are blocked for a short time.
    WaitForBlock { until: Stamp },
    /// Its place is not known yet. It is looked for again then.
    WaitForPlace { until: Stamp },
    /// The next edge is of a group that somebody else holds.
    WaitForHold { edge: EdgeId },
}

impl Leg {
    /// Whether the executive walks for it.
    pub fn is_walk(self) -> bool {
        !matches!(
            self,
            Self::Charge { .. }
                | Self::Wait { .. }
                | Self::WaitForBlock { .. }
                | Self::WaitForPlace { .. }
                | Self::WaitForHold { .. }
                | Self::Act { .. }
        )
    }
}

/// An action that is performed while the robot walks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct WalkingCall {
    pub call: ActionCallId,
    /// Name of the action.
    pub action: String,
    /// Whether it ends with the edge. Otherwise a zone has it.
    pub is_of_edge: bool,
}

/// The active goal.
#[derive(Clone, Debug)]
pub(super) struct ActiveRoute {
    pub goal: GoalId,
    pub target: RouteTarget,
    pub leg: Option<(LegId, Leg)>,
    /// When the robot began to stand for the present leg, if it stands.
    pub stands_since: Stamp,
    /// When the present edge was begun.
    pub edge_began: Stamp,
    /// Parts of the present edge that were walked.
    pub edge_parts: u32,
    /// The node that was reached last on the route.
    pub current: Option<NodeId>,
    /// Whether the robot has stood in the pose of the route's end.
    pub is_at_end: bool,
    /// Walks so far, from which their ids are made.
    pub walks: u64,
    /// Steps of the fail policy of the present edge that were taken.
    pub edge_failures: u32,
    /// The edge whose actions on entering were performed.
    pub entered: Option<EdgeId>,
    /// Actions that are performed while the robot walks.
    pub during: Vec<WalkingCall>,
    /// Calls of actions so far, from which their ids are made.
    pub calls: u64,
    /// Nodes to which there was no route from beside the graph.
    pub unreachable: BTreeSet<NodeId>,
    /// Times that the robot waited because its place was not known.
    pub place_waits: u32,
    /// Attempts to dock that failed.
    pub dock_failures: u32,
    /// Why.
    pub dock_failure: Option<ReachFailure>,
    /// Edges that are left, the present one first.
    pub route: Vec<EdgeId>,
}

impl ActiveRoute {
    pub fn new(at: Stamp, goal: GoalId, target: RouteTarget) -> Self {
        Self {
            goal,
            target,
            leg: None,
            stands_since: at,
            edge_began: at,
            edge_parts: 0,
            current: None,
            is_at_end: false,
            walks: 0,
            edge_failures: 0,
            entered: None,
            during: Vec::new(),
            calls: 0,
            unreachable: BTreeSet::new(),
            place_waits: 0,
            dock_failures: 0,
            dock_failure: None,
            route: Vec::new(),
        }
    }
}
