//! One map on the screen: its tiles and its pose graph.

use super::{TileSet, Viewpoint};
use crate::{ClientEffect, ClientTime};
use api::{Graph, GraphChanged, TileAnchor, TileList};
use std::collections::BTreeMap;
use vocab::{Aabb, KeyframeId, Pose};

/// State of a download.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Loading {
    /// Asked for.
    #[default]
    Waiting,
    /// Here.
    Done,
    /// It failed; a sentence for the operator.
    Failed(String),
}

/// Tiles and pose graph of one map.
#[derive(Clone, Debug, Default)]
pub struct MapView {
    /// Its tiles.
    pub tiles: TileSet,
    /// Its pose graph.
    pub graph: Graph,
    /// Grows with every change of the graph that this client sees, also over sessions and connections.
    pub graph_revision: u64,
    /// State of the download of tile list and graph; of the live map always [`Loading::Done`].
    pub loading: Loading,
    /// Whether changes came that do not apply to the graph, and the server was asked for the whole graph.
    is_graph_stale: bool,
    /// Box round most points, map frame, metres, as the server computed it.
    listed_bounds: Option<Aabb>,
    poses: BTreeMap<KeyframeId, Pose>,
}

impl MapView {
    /// The live map: the server sends it as events, nothing has to be fetched first.
    pub(crate) fn live() -> Self {
        Self { loading: Loading::Done, ..Self::default() }
    }

    /// Pose of an anchor in the map; `None` while its keyframe is not known.
    pub fn map_from_anchor(&self, anchor: TileAnchor) -> Option<Pose> {
        map_from_anchor(&self.poses, anchor)
    }

    /// The box of the map without stray points, metres, map frame: the server's, else one computed from the tiles. *Fit view* shows it.
    pub fn robust_bounds(&self) -> Option<Aabb> {
        self.listed_bounds.or_else(|| self.tiles.robust_bounds(|anchor| self.map_from_anchor(anchor)))
    }

    pub(crate) fn set_tiles(&mut self, list: &TileList) {
        self.tiles.add(&list.tiles);
        self.listed_bounds = list.robust_bounds;
        self.loading = Loading::Done;
    }

    pub(crate) fn set_graph(&mut self, graph: Graph) {
        self.poses = graph.nodes.iter().map(|node| (node.id, node.map_from_keyframe)).collect();
        self.graph = graph;
        self.is_graph_stale = false;
        self.graph_revision += 1;
        self.tiles.mark_dirty();
    }

    /// Applies changes of the graph. If they do not apply, they are dropped, and the graph stays as it is until the whole graph comes. Returns
    /// whether that has to be asked for.
    pub(crate) fn change_graph(&mut self, changed: &GraphChanged) -> bool {
        if self.graph.apply(changed) {
            self.poses.extend(changed.nodes.iter().map(|node| (node.id, node.map_from_keyframe)));
            self.graph_revision += 1;
            self.tiles.mark_dirty();
            return false;
        }
        !std::mem::replace(&mut self.is_graph_stale, true)
    }

    pub(crate) fn plan(&mut self, viewpoint: &Viewpoint, now: ClientTime, effects: &mut Vec<ClientEffect>) {
        let poses = &self.poses;
        self.tiles.plan(viewpoint, now, |anchor| map_from_anchor(poses, anchor), effects);
    }
}

fn map_from_anchor(poses: &BTreeMap<KeyframeId, Pose>, anchor: TileAnchor) -> Option<Pose> {
    match anchor {
        TileAnchor::Map => Some(Pose::IDENTITY),
        TileAnchor::Keyframe(id) => poses.get(&id).copied(),
    }
}
