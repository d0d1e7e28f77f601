//! Missions: what the robot does, in which order, and what becomes of failures.

use crate::{ActionRequest, DockAction, InspectionPointId, MissionId, NodeId, ObjectId, TaskId};
use serde::{Deserialize, Serialize};
use vocab::Span;

/// An ordered list of tasks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mission {
    /// Its id.
    pub id: MissionId,
    /// Shown to people.
    pub name: String,
    /// In the order of the list.
    pub tasks: Vec<Task>,
    /// Whether that order is kept.
    #[serde(default)]
    pub order: TaskOrder,
    /// Pairs of tasks of which the first is done before the second, whatever the order.
    #[serde(default)]
    pub order_constraints: Vec<[TaskId; 2]>,
    /// Where the robot goes afterwards.
    #[serde(default)]
    pub end: MissionEnd,
}

/// An action at a place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Task {
    /// Its id.
    pub id: TaskId,
    /// Where.
    pub place: TaskPlace,
    /// What happens if the place cannot be reached.
    #[serde(default)]
    pub on_unreachable: FailurePolicy,
    /// What happens if the action fails.
    #[serde(default)]
    pub on_action_failure: FailurePolicy,
}

/// Where a task is, and with that what it does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TaskPlace {
    /// At an inspection point, which has the action.
    InspectionPoint(InspectionPointId),
    /// At a node.
    Node {
        /// The node.
        node: NodeId,
        /// What is done there; none: it is only visited.
        #[serde(default)]
        request: Option<ActionRequest>,
    },
    /// Where the action brings the robot: `dock` and `undock`.
    ByAction {
        /// The action.
        request: ActionRequest,
    },
}

impl TaskPlace {
    /// The object of the site that says where the task is; none where the action finds the place when it is done.
    pub fn object(&self) -> Option<ObjectId> {
        match self {
            Self::InspectionPoint(point) => Some(ObjectId::InspectionPoint(*point)),
            Self::Node { node, .. } => Some(ObjectId::Node(*node)),
            Self::ByAction { request } => DockAction::of(request)?.dock().map(ObjectId::Dock),
        }
    }
}

/// Whether tasks are done in the order of the list.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TaskOrder {
    /// They are.
    #[default]
    AsListed,
    /// In the order of the shortest path. A mission with a task that docks or undocks is done as listed: what comes before and after is part of it.
    Shortest {
        /// Whether the first task of the list stays the first.
        keep_first: bool,
        /// Whether the last one stays the last.
        keep_last: bool,
    },
}

/// Where the robot goes after the last task.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MissionEnd {
    /// To the nearest dock.
    #[default]
    NearestDock,
    /// To this node.
    Node(NodeId),
    /// Nowhere.
    Stay,
}

/// What happens after a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FailurePolicy {
    /// Number of further attempts.
    pub retries: u8,
    /// What happens after the last one.
    pub then: FailureStep,
}

impl Default for FailurePolicy {
    /// One further attempt, then the robot goes on with the next task.
    fn default() -> Self {
        Self { retries: 1, then: FailureStep::Skip }
    }
}

/// What happens after the last attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FailureStep {
    /// The task is skipped.
    Skip,
    /// The task is tried once more after the others.
    TryLater,
    /// The run ends, and the robot goes to a dock.
    EndAtDock,
    /// The run ends where the robot is.
    EndHere,
    /// A person is asked.
    Ask {
        /// How long.
        time_limit: Span,
        /// What happens without an answer.
        default: AskDefault,
    },
}

/// What happens without an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AskDefault {
    /// The task is skipped.
    Skip,
    /// The run ends, and the robot goes to a dock.
    EndAtDock,
    /// The run ends where the robot is.
    EndHere,
}
