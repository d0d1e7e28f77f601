//! Actions that are performed on the way to a place: those of edges and of zones.

use crate::{ActionRequest, EdgeId, TaskId, ZoneId};
use serde::{Deserialize, Serialize};

/// What on the way an action belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RouteActionPlace {
    /// An edge.
    Edge {
        /// Which.
        edge: EdgeId,
        /// Where on it.
        stage: EdgeStage,
        /// Its number in the list of that stage, from 0.
        index: u32,
    },
    /// A zone that the robot enters.
    Zone(ZoneId),
}

/// Where on an edge an action is performed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EdgeStage {
    /// At its beginning, while the robot stands.
    Enter,
    /// While the robot walks.
    During,
    /// At its end, while the robot stands.
    Leave,
}

/// A step of an action on the way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RouteActionStep {
    /// It is to be called. Written before the call.
    Began {
        /// What it belongs to.
        place: RouteActionPlace,
        /// What is called.
        request: ActionRequest,
        /// Whether it can be repeated without harm.
        is_idempotent: bool,
        /// The task to which the robot is on its way; none: to where the run ends.
        task: Option<TaskId>,
    },
    /// It has ended.
    Ended(RouteActionEnd),
}

/// How an action on the way ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RouteActionEnd {
    /// It was done.
    Succeeded {
        /// Result of the action as JSON, if it has one.
        result: Option<String>,
    },
    /// It failed, with a sentence for people.
    Failed(String),
    /// It was cancelled, such as one during an edge when the robot has left that.
    Cancelled,
    /// The program ended, or the run, before its end was known.
    OutcomeUnknown,
}
