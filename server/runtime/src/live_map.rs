//! The map while it grows: keyframe clouds cut into tiles as they come, each in its keyframe's frame, so that a loop
//! closure sends poses and no points.

use crate::convert;
use api::{Anchor, Event, Graph, LoopsChanged, TileEntry, TileHash, TilesChanged};
use map_codec::{LevelPoints, LevelSplitter, SplitConfig};
use messages::{Keyframe, LocalisationState, MappingState};
use std::sync::Arc;
use store::{Store, StoreError};
use vocab::{Aabb, KeyframeId, MapId, SessionId};

/// Greatest step of a tile's lattice, metres: four per voxel of a keyframe's cloud.
const RESOLUTION: f32 = 0.01;

/// Tiles of the running session.
pub struct LiveMap {
    store: Arc<Store>,
    session: Option<SessionId>,
    /// Whether the map that the session goes on from is shown.
    base_shown: bool,
    /// The saved map that is shown because the robot is localised in it.
    known: Option<MapId>,
    splitter: LevelSplitter,
    tiles: Vec<TileHash>,
}

/// A session that has ended, and its tiles.
pub type Ended = (SessionId, Vec<TileHash>);

impl LiveMap {
    /// No session yet; tiles go to the store.
    pub fn new(store: Arc<Store>) -> Self {
        Self {
            store,
            session: None,
            base_shown: false,
            known: None,
            splitter: LevelSplitter::new(SplitConfig::default()),
            tiles: Vec::new(),
        }
    }

    /// The session whose map is shown.
    pub fn session(&self) -> Option<SessionId> {
        self.session
    }

    /// Follows the state of mapping. Returns the session that has ended with it, if one has.
    pub fn follow(&mut self, state: &MappingState) -> Option<Ended> {
        let session = match state {
            MappingState::Idle => None,
            MappingState::Loading { session, .. }
            | MappingState::Starting { session }
            | MappingState::Finding { session, .. }
            | MappingState::Mapping { session, .. }
            | MappingState::Saving { session, .. } => Some(*session),
        };
        if session == self.session {
            return None;
        }
        let ended = std::mem::replace(&mut self.session, session);
        self.splitter = LevelSplitter::new(SplitConfig::default());
        self.base_shown = false;
        let tiles = std::mem::take(&mut self.tiles);
        ended.map(|session| (session, tiles))
    }

    /// What to tell clients of the map that the session goes on from, once the robot has found itself in it: its tiles, which
    /// stay where that map has them, and what was decided on its loops.
    ///
    /// # Errors
    /// When that map cannot be read.
    pub fn show_base(&mut self, state: &MappingState) -> Result<Vec<Event>, StoreError> {
        let MappingState::Mapping { extends: Some(map), .. } = state else { return Ok(Vec::new()) };
        if std::mem::replace(&mut self.base_shown, true) {
            return Ok(Vec::new());
        }
        let added = self.store.map_tiles(*map)?.tiles;
        let tiles = Event::Tiles(TilesChanged { reset: false, added });
        let decisions = self.store.map(*map)?.decisions.into_iter().map(convert::loop_decision);
        let loops = Event::Loops(LoopsChanged { reset: false, added: decisions.collect() });
        Ok(vec![tiles, loops])
    }

    /// What to tell clients of the saved map that the robot is localised in: its tiles and its graph, from when on it has been read until
    /// the robot is in another map or none.
    ///
    /// # Errors
    /// When that map cannot be read.
    pub fn show_known(&mut self, state: &LocalisationState) -> Result<Vec<Event>, StoreError> {
        let wanted = match state {
            LocalisationState::Localised { map, .. } | LocalisationState::Relocalising { map, .. } => {
                Some(*map)
            }
            LocalisationState::Idle | LocalisationState::Loading { .. } => None,
        };
        let before = std::mem::replace(&mut self.known, wanted);
        if before == wanted || self.session.is_some() {
            return Ok(Vec::new());
        }
        let (added, graph) = match wanted {
            Some(map) => {
                (self.store.map_tiles(map)?.tiles, convert::graph(&self.store.map(map)?.graph(), None))
            }
            None => (Vec::new(), Graph::default()),
        };
        // The graph first, since tiles hang on its keyframes.
        Ok(vec![Event::Graph(graph), Event::Tiles(TilesChanged { reset: true, added })])
    }

    /// Adds a keyframe's cloud, and returns what to tell clients.
    ///
    /// # Errors
    /// When a tile could not be written; those before it are kept.
    pub fn add(&mut self, keyframe: &Keyframe) -> Result<Event, StoreError> {
        let cloud = &keyframe.cloud;
        let levels = self.splitter.push(&keyframe.map_from_keyframe, &cloud.xyz, &cloud.intensity);
        let mut added = Vec::with_capacity(levels.len());
        for level in &levels {
            let entry = self.write(keyframe.id, level)?;
            self.tiles.push(entry.hash);
            added.push(entry);
        }
        Ok(Event::Tiles(TilesChanged { reset: false, added }))
    }

    fn write(&self, keyframe: KeyframeId, level: &LevelPoints) -> Result<TileEntry, StoreError> {
        let bytes = level.encode(RESOLUTION);
        let mut bounds = Aabb::EMPTY;
        for point in &level.xyz {
            bounds.include(*point);
        }
        Ok(TileEntry {
            hash: self.store.tiles().put(&bytes)?,
            anchor: Anchor::Keyframe(keyframe),
            level: level.level,
            spacing: level.spacing,
            bounds,
            points: level.xyz.len() as u32,
            bytes: bytes.len() as u32,
        })
    }
}
