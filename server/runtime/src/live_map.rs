//! The map while it grows: keyframe clouds cut into tiles as they come, each in its keyframe's frame, so that a loop
//! closure sends poses and no points.

use api::{Anchor, Event, TileEntry, TileHash, TilesChanged};
use map_codec::{LevelPoints, LevelSplitter, SplitOptions};
use messages::{Keyframe, MappingState};
use store::{StoreError, TileFiles};
use vocab::{Aabb, KeyframeId, SessionId};

/// Greatest step of a tile's lattice, metres: four per voxel of a keyframe's cloud.
const RESOLUTION: f32 = 0.01;

/// Tiles of the running session.
pub struct LiveMap {
    files: TileFiles,
    session: Option<SessionId>,
    splitter: LevelSplitter,
    tiles: Vec<TileHash>,
}

/// A session that has ended, and its tiles.
pub type Ended = (SessionId, Vec<TileHash>);

impl LiveMap {
    /// No session yet; tiles go to `files`.
    pub fn new(files: TileFiles) -> Self {
        Self {
            files,
            session: None,
            splitter: LevelSplitter::new(SplitOptions::default()),
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
            MappingState::Starting { session }
            | MappingState::Mapping { session, .. }
            | MappingState::Saving { session, .. } => Some(*session),
        };
        if session == self.session {
            return None;
        }
        let ended = std::mem::replace(&mut self.session, session);
        self.splitter = LevelSplitter::new(SplitOptions::default());
        let tiles = std::mem::take(&mut self.tiles);
        ended.map(|session| (session, tiles))
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
            hash: self.files.put(&bytes)?,
            anchor: Anchor::Keyframe(keyframe),
            level: level.level,
            spacing: level.spacing,
            bounds,
            points: level.xyz.len() as u32,
            bytes: bytes.len() as u32,
        })
    }
}
