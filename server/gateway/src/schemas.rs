//! Schemas of the documents served: mirrors of the types of crate `api`, which is built for the browser too and carries no
//! schemas. The tests of [`crate::openapi`] compare every field with what the types really become.
#![allow(dead_code, reason = "described, never made: the contract's own types are")]

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// State of the server.
#[derive(Serialize, ToSchema)]
#[schema(as = Health)]
pub(crate) struct HealthDocument {
    /// Whether gateway and core are connected.
    pub(crate) core_connected: bool,
    /// Clients connected.
    pub(crate) clients: u32,
    /// Processes that failed since the platform was started and run again, each with its last failure.
    #[schema(value_type = Vec<ProcessRestartDocument>)]
    pub(crate) restarts: Vec<api::ProcessRestart>,
}

/// A process that failed and was started again.
#[derive(ToSchema)]
#[schema(as = ProcessRestart)]
pub(crate) struct ProcessRestartDocument {
    /// Its role: `core`, `gateway` or `simulated_robot`.
    process: String,
    /// What it did, a clause after its name.
    cause: String,
    /// How often it was started again since the platform was started.
    count: u32,
}

/// An error, RFC 9457.
#[derive(ToSchema)]
#[schema(as = Problem)]
pub(crate) struct ProblemDocument {
    /// HTTP status.
    status: u16,
    /// The kind of problem, short.
    title: String,
    /// This case: what, where and what to do.
    detail: String,
}

/// A saved map version.
#[derive(ToSchema)]
#[schema(as = MapSummary)]
pub(crate) struct MapSummaryDocument {
    /// Which.
    #[schema(format = Uuid)]
    id: String,
    /// For people.
    name: String,
    /// When it was finished, nanoseconds since the Unix epoch.
    created: i64,
    /// Distance walked to make it, metres.
    distance_m: f64,
    /// Keyframes in it.
    keyframes: u32,
    /// Points in its tiles.
    points: u64,
    /// Bytes on disk.
    bytes: u64,
    /// Whether its keyframes and edges were measured by a robot that walked. Those of an imported cloud are virtual viewpoints.
    has_pose_graph: bool,
}

/// A saved map that cannot be read.
#[derive(ToSchema)]
#[schema(as = DamagedMap)]
pub(crate) struct DamagedMapDocument {
    /// Name of its folder in `maps/` of the data directory: the map's id.
    folder: String,
    /// Which file is damaged, and how.
    problem: String,
    /// What to do.
    remedy: String,
}

/// A deleted map.
#[derive(ToSchema)]
#[schema(as = BinnedMap)]
pub(crate) struct BinnedMapDocument {
    /// Which.
    #[schema(format = Uuid)]
    id: String,
    /// For people; the id if the map is damaged.
    #[schema(example = "Pump hall")]
    name: String,
    /// Bytes on disk; 0 if the map is damaged.
    bytes: u64,
    /// When it is deleted for good, nanoseconds since the Unix epoch. Null while nobody knows: the clock of the robot's computer has not been
    /// synchronised since it was deleted, or it is damaged and stays until a person decides.
    #[schema(example = 1796083200000000000_i64)]
    kept_until: Option<i64>,
    /// Time left until then when the list was made, nanoseconds.
    #[schema(example = 604800000000000_i64)]
    time_left: Option<i64>,
    /// Which file is damaged or made by a newer program, and what to do.
    problem: Option<String>,
}

/// The new name of a map.
#[derive(Deserialize, ToSchema)]
#[schema(as = Rename)]
#[serde(deny_unknown_fields)]
pub(crate) struct RenameDocument {
    /// Up to 120 characters; blanks round it and what is longer are cut.
    #[schema(example = "Pump hall, east wing")]
    pub(crate) name: String,
}

/// An uploaded file that no map was made of yet.
#[derive(ToSchema)]
#[schema(as = StoredUpload)]
pub(crate) struct StoredUploadDocument {
    /// Its id.
    #[schema(format = Uuid)]
    upload: String,
    /// Name of the map that it was to become, if that was tried.
    name: Option<String>,
    /// The saved map whose frame that map was to have, if any.
    #[schema(format = Uuid)]
    frame: Option<String>,
    /// Its size.
    bytes: u64,
    /// Why the last import of it failed; null if none was tried.
    problem: Option<String>,
    /// When it is deleted, nanoseconds since the Unix epoch: a day after it came or was tried. Null while the clock of the robot's computer is not
    /// synchronised: then it stays.
    kept_until: Option<i64>,
}

/// Every tile of a saved map.
#[derive(ToSchema)]
#[schema(as = TileList)]
pub(crate) struct TileListDocument {
    /// Box round all, map frame.
    bounds: BoundsDocument,
    /// Coarse levels first.
    tiles: Vec<TileEntryDocument>,
    /// Box round most points, map frame, to be shown first: stray points do not widen it.
    robust_bounds: Option<BoundsDocument>,
}

/// A tile that can be fetched.
#[derive(ToSchema)]
#[schema(as = TileEntry)]
pub(crate) struct TileEntryDocument {
    /// BLAKE3 of its bytes, 64 hexadecimal digits.
    hash: String,
    /// What its coordinates are relative to.
    anchor: AnchorDocument,
    /// 0 is coarsest.
    level: u8,
    /// Distance between neighbouring points, metres.
    spacing: f32,
    /// Box round its points, in the anchor's frame.
    bounds: BoundsDocument,
    /// Points in it.
    points: u32,
    /// Encoded size.
    bytes: u32,
}

/// What coordinates are relative to.
#[derive(ToSchema)]
#[schema(as = Anchor)]
pub(crate) enum AnchorDocument {
    /// The map frame.
    Map,
    /// A keyframe, whose pose a loop closure may move.
    Keyframe(u32),
}

/// An axis-aligned box, metres.
#[derive(ToSchema)]
#[schema(as = Bounds)]
pub(crate) struct BoundsDocument {
    /// Least corner.
    min: [f32; 3],
    /// Greatest corner.
    max: [f32; 3],
}

/// A pose graph.
#[derive(ToSchema)]
#[schema(as = Graph)]
pub(crate) struct GraphDocument {
    /// Mapping session; null for a saved map.
    #[schema(format = Uuid)]
    session: Option<String>,
    /// Grows with every change within a session.
    revision: u64,
    /// Keyframes in the map, in the order of their ids.
    nodes: Vec<GraphNodeDocument>,
    /// Edges of the odometry as pairs of keyframes.
    edges: Vec<[u32; 2]>,
    /// Closed loops as pairs of keyframes, the older first.
    loops: Vec<[u32; 2]>,
}

/// One keyframe.
#[derive(ToSchema)]
#[schema(as = GraphNode)]
pub(crate) struct GraphNodeDocument {
    /// Which.
    id: u32,
    /// When it was made, nanoseconds since the Unix epoch.
    stamp: i64,
    /// Where.
    map_from_keyframe: PoseDocument,
}

/// Where a child frame is, seen from its parent.
#[derive(ToSchema)]
#[schema(as = Pose)]
pub(crate) struct PoseDocument {
    /// Origin of the child in the parent, metres.
    position: Vec3Document,
    /// Rotation of the child in the parent, unit, Hamilton.
    orientation: QuatDocument,
}

/// Three numbers.
#[derive(ToSchema)]
#[schema(as = Vec3)]
pub(crate) struct Vec3Document {
    x: f64,
    y: f64,
    z: f64,
}

/// A unit quaternion.
#[derive(ToSchema)]
#[schema(as = Quat)]
pub(crate) struct QuatDocument {
    w: f64,
    x: f64,
    y: f64,
    z: f64,
}
