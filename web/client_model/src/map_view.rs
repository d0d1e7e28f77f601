//! A map on the screen: the one being made, or a saved one.

use crate::{ClientEffect, TileSet};
use api::{Anchor, Graph};
use std::collections::BTreeMap;
use vocab::{KeyframeId, Pose};

/// How far a document has come.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Loading {
    /// Asked for.
    #[default]
    Waiting,
    /// Here.
    Done,
    /// Could not be had; a sentence for the person.
    Failed(String),
}

/// Tiles and pose graph of one map.
#[derive(Clone, Debug, Default)]
pub struct MapView {
    /// Its tiles.
    pub tiles: TileSet,
    /// Its pose graph.
    pub graph: Graph,
    /// Grows with every change of the graph.
    pub graph_revision: u64,
    /// How far tiles and graph have come; of a live map always [`Loading::Done`].
    pub loading: Loading,
    /// Robust bounds as the server computed them from the points, m, map frame.
    pub(crate) listed_bounds: Option<vocab::Aabb>,
    poses: BTreeMap<KeyframeId, Pose>,
}

impl MapView {
    /// The map being made: nothing has to be fetched before it is there.
    pub(crate) fn live() -> Self {
        Self { loading: Loading::Done, ..Self::default() }
    }

    /// Where an anchor is in the map; `None` while its keyframe is not known.
    pub fn map_from_anchor(&self, anchor: Anchor) -> Option<Pose> {
        match anchor {
            Anchor::Map => Some(Pose::IDENTITY),
            Anchor::Keyframe(id) => self.poses.get(&id).copied(),
        }
    }

    /// The box of the map without stray points, m, map frame: the server's, else one computed from the tiles.
    pub fn robust_bounds(&self) -> Option<vocab::Aabb> {
        self.listed_bounds.or_else(|| self.tiles.robust_bounds(|anchor| self.map_from_anchor(anchor)))
    }

    pub(crate) fn set_graph(&mut self, graph: Graph) {
        self.poses = graph.nodes.iter().map(|node| (node.id, node.map_from_keyframe)).collect();
        self.graph = graph;
        self.graph_revision += 1;
        self.tiles.mark_dirty();
    }

    pub(crate) fn plan(
        &mut self,
        eye: &crate::Viewpoint,
        now: crate::ClientTime,
        effects: &mut Vec<ClientEffect>,
    ) {
        let poses = &self.poses;
        let pose_of = |anchor| match anchor {
            Anchor::Map => Some(Pose::IDENTITY),
            Anchor::Keyframe(id) => poses.get(&id).copied(),
        };
        self.tiles.plan(eye, now, pose_of, effects);
    }
}
