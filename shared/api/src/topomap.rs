//! The making of the site's topological map from a saved map.

use serde::{Deserialize, Serialize};
use site_model::EditId;
use vocab::{MapId, Vec3};

/// Stretches of [`TopomapSummary::blocked`] at most.
pub const MAX_BLOCKED_SEGMENTS: usize = 32;

/// State of the making of a topological map.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum TopomapGeneration {
    /// None was made since the start.
    #[default]
    None,
    /// One is made.
    Running {
        /// From which map.
        map: MapId,
        /// Its present stage.
        stage: TopomapStage,
    },
    /// It was made, and the site has it.
    Done {
        /// From which map.
        map: MapId,
        /// Id of the edit that has put it into the site.
        edit: EditId,
        /// What was made.
        summary: TopomapSummary,
    },
    /// It could not be made. The site is as before.
    Failed {
        /// From which map.
        map: MapId,
        /// Why, and what to do, one sentence.
        reason: String,
    },
}

/// Stage of the making of a topological map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TopomapStage {
    /// The map is read.
    Reading,
    /// Nodes and edges are computed.
    Generating,
    /// They are put into the site.
    Storing,
}

/// What was made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TopomapSummary {
    /// Number of nodes.
    pub nodes: u32,
    /// Number of edges, both directions counted.
    pub edges: u32,
    /// Number of docks.
    pub docks: u32,
    /// Number of floors.
    pub floors: u32,
    /// Length of all edges, one direction of each, metres.
    pub length_m: f64,
    /// Number of connected pieces; 1 if every node can be reached from every other.
    pub pieces: u32,
    /// Stretches of the walked path where the map shows an obstacle, so that there is no edge: where each begins and ends, metres, map frame.
    /// [`MAX_BLOCKED_SEGMENTS`] at most.
    pub blocked: Vec<[Vec3; 2]>,
    /// Nodes of the site before that stay, although they were not generated, because inspection points or missions need them.
    pub kept_nodes: u32,
}
