//! What is wrong with a site: typed, with the object and a sentence for people.

use crate::{NodeId, ObjectId, TaskId};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Something that is wrong with an object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SiteProblem {
    /// Which object.
    pub object: ObjectId,
    /// What is wrong.
    pub kind: ProblemKind,
}

/// Whether a site can be used with a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ProblemSeverity {
    /// It can, but somebody should look at it.
    Warning,
    /// The object cannot be used.
    Error,
}

/// What is wrong.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ProblemKind {
    /// It has no name, or only spaces.
    NoName,
    /// Another object of its kind has the same name.
    SameName(ObjectId),
    /// It refers to an object that is not there.
    Missing(ObjectId),
    /// A task refers to an object that is not there.
    TaskMissing {
        /// The task.
        task: TaskId,
        /// What is not there.
        object: ObjectId,
    },
    /// Two tasks of a mission have the same id.
    SameTask(TaskId),
    /// An order constraint names a task that the mission does not have.
    OrderConstraintMissing(TaskId),
    /// No order of the tasks meets all order constraints.
    OrderConstraintsCircular,
    /// A number is out of its range.
    OutOfRange {
        /// The field.
        field: String,
        /// What is permitted, for people.
        permitted: String,
    },
    /// An edge begins and ends at the same node.
    EdgeToItself,
    /// Another edge joins the same nodes in the same direction.
    SameEdge(ObjectId),
    /// No edge leads to a node that is needed.
    #[serde(rename = "no_way_to")]
    NoEdgeTo(NodeId),
    /// No edge leads away from a node that is needed.
    #[serde(rename = "no_way_from")]
    NoEdgeFrom(NodeId),
    /// A node is not of the kind that it is used as.
    WrongNodeKind(NodeId),
    /// A mission has no tasks.
    NoTasks,
    /// A schedule never has a slot.
    NeverDue,
    /// An action has no name.
    NoAction,
    /// An area has fewer than three corners, or its sides cross.
    NotAnArea,
    /// The site has no settings.
    NoSettings,
}

impl ProblemKind {
    /// Whether the object can be used.
    pub fn severity(&self) -> ProblemSeverity {
        match self {
            Self::NoName
            | Self::SameName(_)
            | Self::SameEdge(_)
            | Self::NoEdgeTo(_)
            | Self::NoEdgeFrom(_)
            | Self::WrongNodeKind(_)
            | Self::NoTasks
            | Self::NeverDue => ProblemSeverity::Warning,
            _ => ProblemSeverity::Error,
        }
    }
}

impl fmt::Display for ProblemKind {
    /// A clause for people, such as `it has no name`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoName => f.write_str("it has no name"),
            Self::SameName(other) => write!(f, "{other} has the same name"),
            Self::Missing(other) => write!(f, "{other} does not exist"),
            Self::TaskMissing { task, object } => {
                write!(f, "task {task} needs {object}, which does not exist")
            }
            Self::SameTask(task) => write!(f, "two tasks have the id {task}"),
            Self::OrderConstraintMissing(task) => {
                write!(f, "an order constraint names task {task}, which it does not have")
            }
            Self::OrderConstraintsCircular => f.write_str("its order constraints contradict each other"),
            Self::OutOfRange { field, permitted } => write!(f, "{field} must be {permitted}"),
            Self::EdgeToItself => f.write_str("it begins and ends at the same node"),
            Self::SameEdge(other) => write!(f, "{other} leads in the same direction"),
            Self::NoEdgeTo(node) => write!(f, "no edge leads to node {node}"),
            Self::NoEdgeFrom(node) => write!(f, "no edge leads away from node {node}"),
            Self::WrongNodeKind(node) => write!(f, "node {node} is of another kind"),
            Self::NoTasks => f.write_str("it has no tasks"),
            Self::NeverDue => f.write_str("it never becomes due"),
            Self::NoAction => f.write_str("an action has no name"),
            Self::NotAnArea => f.write_str("its corners do not enclose an area"),
            Self::NoSettings => f.write_str("the site has no settings"),
        }
    }
}

impl fmt::Display for SiteProblem {
    /// A sentence without its full stop.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.object, self.kind)
    }
}
