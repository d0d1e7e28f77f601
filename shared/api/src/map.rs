//! Saved maps and tiles.

use serde::{Deserialize, Serialize};
use vocab::{Aabb, KeyframeId, MapId, Span, Stamp, content_hash};

/// A saved map version, in a list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MapSummary {
    /// Which.
    pub id: MapId,
    /// For people.
    pub name: String,
    /// When it was finished.
    pub created: Stamp,
    /// Distance walked to make it, metres. `distance` in maps of format version 1.
    #[serde(alias = "distance")]
    pub distance_m: f64,
    /// Keyframes in it.
    pub keyframes: u32,
    /// Points in its tiles.
    pub points: u64,
    /// Bytes on disk.
    pub bytes: u64,
    /// Whether its keyframes and edges were measured by a robot that walked. Those of an imported cloud are virtual viewpoints, of
    /// interest to localisation only. Maps of versions that did not write this count as walked.
    #[serde(default = "walked")]
    pub has_pose_graph: bool,
}

/// A saved map that cannot be read. Nothing of it is removed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DamagedMap {
    /// Name of its folder in `maps/` of the data directory: the map's id.
    pub folder: String,
    /// Which file is damaged, and how: one sentence.
    pub problem: String,
    /// What to do: one or two sentences.
    pub remedy: String,
}

/// A deleted map. It can be restored until it is deleted for good.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BinnedMap {
    /// Which.
    pub id: MapId,
    /// For people; the id if the map is damaged.
    pub name: String,
    /// Bytes on disk; 0 if the map is damaged.
    pub bytes: u64,
    /// When it is deleted for good, by calendar time. None while nobody knows: the clock of the robot's computer has not been synchronised
    /// since it was deleted, or it is damaged and stays until a person decides.
    pub kept_until: Option<Stamp>,
    /// Time left until then, when this was published.
    pub time_left: Option<Span>,
    /// Which file is damaged or made by a newer program, and what to do: one or two sentences.
    pub problem: Option<String>,
}

fn walked() -> bool {
    true
}

content_hash! {
    /// BLAKE3 of a tile's bytes: its name. Hexadecimal in JSON and paths.
    TileHash,
    /// Text that names no tile.
    TileHashError,
    "a tile is named by 64 hexadecimal digits"
}

/// What a tile's coordinates are relative to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum TileAnchor {
    /// The map frame.
    Map,
    /// A keyframe, whose pose a loop closure may move.
    Keyframe(KeyframeId),
}

/// A tile that can be fetched. Tiles add up: showing a level means showing all coarser ones too.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TileEntry {
    /// Its name.
    pub hash: TileHash,
    /// What its coordinates are relative to.
    pub anchor: TileAnchor,
    /// 0 is coarsest.
    pub level: u8,
    /// Distance between neighbouring points of this level, metres. It is `spacing` in JSON, because clients get the tile lists of saved maps as
    /// they were written.
    #[serde(rename = "spacing")]
    pub spacing_m: f32,
    /// Box round its points, in the anchor's frame, metres.
    pub bounds: Aabb,
    /// Points in it.
    pub points: u32,
    /// Encoded size.
    pub bytes: u32,
}

/// Every tile of a saved map.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TileList {
    /// Box round all, map frame.
    pub bounds: Aabb,
    /// Coarse levels first.
    pub tiles: Vec<TileEntry>,
    /// Box round most points, map frame, to be shown first: stray points do not widen it. None in maps of versions that did not write
    /// this, and where there are no points.
    #[serde(default)]
    pub robust_bounds: Option<Aabb>,
}

/// An error over HTTP: `application/problem+json`, RFC 9457.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Problem {
    /// HTTP status.
    pub status: u16,
    /// The kind of problem, short.
    pub title: String,
    /// This case: what, where and what to do.
    pub detail: String,
}
