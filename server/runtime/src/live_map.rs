//! The tiles that clients see: of the map under construction, or of the saved map in which the robot is localised.
//!
//! The cloud of a new keyframe is cut into tiles in the keyframe's frame. After a loop closure only poses are sent again, no points.

use crate::convert;
use api::{Event, Graph, LoopsChanged, TileAnchor, TileEntry, TileHash, TilesChanged};
use map_codec::{LevelPoints, LevelSplitter, SplitConfig};
use messages::{Cloud, GraphNode, Keyframe, LocalisationState, MappingState};
use std::sync::Arc;
use store::{Store, StoreError};
use vocab::{Aabb, KeyframeId, MapId, Pose, SessionId};

/// Parameters of the [`LiveMap`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiveMapConfig {
    /// Coarsest step to which coordinates are rounded in tiles, metres: a quarter of a voxel of a keyframe's cloud. It is that of saved maps
    /// ([`map_codec::POINT_RESOLUTION_M`]).
    pub tile_resolution_m: f32,
}

impl Default for LiveMapConfig {
    fn default() -> Self {
        Self { tile_resolution_m: map_codec::POINT_RESOLUTION_M }
    }
}

/// Tiles of the running session, and which saved map is shown.
pub struct LiveMap {
    config: LiveMapConfig,
    store: Arc<Store>,
    session: Option<SessionId>,
    /// Whether the saved map that the session extends has been sent.
    has_sent_extended: bool,
    /// The saved map that is shown because the robot is localised or relocalises in it.
    saved: Option<MapId>,
    splitter: LevelSplitter,
    tiles: Vec<TileHash>,
}

/// A session that has ended, and its tiles.
pub type EndedSession = (SessionId, Vec<TileHash>);

impl LiveMap {
    /// Without a session. Tiles are written to the store.
    pub fn new(config: LiveMapConfig, store: Arc<Store>) -> Self {
        Self {
            config,
            store,
            session: None,
            has_sent_extended: false,
            saved: None,
            splitter: LevelSplitter::new(SplitConfig::default()),
            tiles: Vec::new(),
        }
    }

    /// The session whose map is shown.
    pub fn session(&self) -> Option<SessionId> {
        self.session
    }

    /// Updates the state of mapping. Returns the session that has ended, if one has.
    pub fn set_mapping(&mut self, state: &MappingState) -> Option<EndedSession> {
        let session = state.session();
        if session == self.session {
            return None;
        }
        let ended = std::mem::replace(&mut self.session, session);
        self.splitter = LevelSplitter::new(SplitConfig::default());
        self.has_sent_extended = false;
        let tiles = std::mem::take(&mut self.tiles);
        ended.map(|session| (session, tiles))
    }

    /// The events that show the map which the session extends: its tiles in the map's frame, and its loop decisions. They are returned once, when
    /// the robot is localised in that map.
    ///
    /// # Errors
    /// When that map cannot be read.
    pub fn show_extended(&mut self, state: &MappingState) -> Result<Vec<Event>, StoreError> {
        let MappingState::Mapping { extends: Some(map), .. } = state else { return Ok(Vec::new()) };
        if std::mem::replace(&mut self.has_sent_extended, true) {
            return Ok(Vec::new());
        }
        let added = self.store.map_tiles(*map)?.tiles;
        let tiles = Event::Tiles(TilesChanged { reset: false, added });
        let decisions = self.store.map(*map)?.decisions.into_iter().map(convert::loop_decision);
        let loops = Event::Loops(LoopsChanged { reset: false, added: decisions.collect() });
        Ok(vec![tiles, loops])
    }

    /// The events that show the saved map in which the robot is localised or relocalises: its tiles and its graph. They are returned when the map
    /// changes; without a map they clear both.
    ///
    /// # Errors
    /// When that map cannot be read.
    pub fn show_saved(&mut self, state: &LocalisationState) -> Result<Vec<Event>, StoreError> {
        let wanted = match state {
            LocalisationState::Localised { map, .. } | LocalisationState::Relocalising { map, .. } => {
                Some(*map)
            }
            LocalisationState::Idle | LocalisationState::Loading { .. } => None,
        };
        let before = std::mem::replace(&mut self.saved, wanted);
        if before == wanted || self.session.is_some() {
            return Ok(Vec::new());
        }
        let (added, graph) = match wanted {
            Some(map) => {
                (self.store.map_tiles(map)?.tiles, convert::graph(&self.store.map(map)?.graph(), None))
            }
            None => (Vec::new(), Graph::default()),
        };
        // The graph comes first, because tiles refer to its keyframes.
        Ok(vec![Event::Graph(graph), Event::Tiles(TilesChanged { reset: true, added })])
    }

    /// Cuts a keyframe's cloud into tiles, and returns the event that shows them.
    ///
    /// # Errors
    /// When a tile could not be written; the tiles before it are kept.
    pub fn insert_keyframe(&mut self, keyframe: &Keyframe) -> Result<Event, StoreError> {
        self.insert_cloud(keyframe.id, &keyframe.map_from_keyframe, &keyframe.cloud)
    }

    fn insert_cloud(
        &mut self,
        keyframe: KeyframeId,
        map_from_keyframe: &Pose,
        cloud: &Cloud,
    ) -> Result<Event, StoreError> {
        let levels = self.splitter.push(map_from_keyframe, &cloud.xyz, &cloud.intensity);
        let mut added = Vec::with_capacity(levels.len());
        for level in &levels {
            let entry = self.write(keyframe, level)?;
            self.tiles.push(entry.hash);
            added.push(entry);
        }
        Ok(Event::Tiles(TilesChanged { reset: false, added }))
    }

    /// Cuts the cloud of a keyframe of the session into tiles that was written to the disk; none if the disk does not have it.
    ///
    /// # Errors
    /// When it cannot be read, or a tile could not be written.
    pub fn recover_keyframe(&mut self, node: &GraphNode) -> Result<Option<Event>, StoreError> {
        let Some(session) = self.session else { return Ok(None) };
        let cloud = self.store.session_cloud(session, node.id, node.stamp)?;
        cloud.map(|cloud| self.insert_cloud(node.id, &node.map_from_keyframe, &cloud)).transpose()
    }

    fn write(&self, keyframe: KeyframeId, level: &LevelPoints) -> Result<TileEntry, StoreError> {
        let bytes = level.encode(self.config.tile_resolution_m);
        let mut bounds = Aabb::EMPTY;
        for point in &level.xyz {
            bounds.include(*point);
        }
        Ok(TileEntry {
            hash: self.store.tiles().put(&bytes)?,
            anchor: TileAnchor::Keyframe(keyframe),
            level: level.level,
            spacing_m: level.spacing,
            bounds,
            points: level.xyz.len() as u32,
            bytes: bytes.len() as u32,
        })
    }
}

#[cfg(test)]
#[path = "live_map_tests.rs"]
mod tests;
