//! The files of a finished map, for the data directory and for `autoinspect map --out` alike.
//!
//! ```text
//! trajectory.tum     base in the map after every scan
//! graph.g2o          pose graph for other tools
//! graph.json         pose graph for the client, an api::Graph
//! loops.json         decisions on loop candidates with their evidence, a list of messages::LoopDecision
//! places.bin         descriptors of the keyframes, for localisation
//! clouds/            motion-corrected clouds of the keyframes, or clouds of virtual viewpoints; written before
//! tiles.json         tiles of the whole map, an api::TileList; the tiles are in another directory
//! map.ply            all points in the map frame, if asked for
//! checksums.b3       checksums of all files above; of every file before map.json was written
//! map.json           an api::MapSummary with a checksum of its own, written last
//! ```

use crate::checksums::write_checksums;
use crate::keyframe_descriptors::write_keyframe_descriptors;
use crate::map_cloud::{CloudSelection, KeyframePose};
use crate::map_document::MapDocument;
use crate::map_folder_files::files_with_checksum;
use crate::robust_bounds::{RobustBoundsConfig, robust_bounds};
use crate::tiles::Durability;
use crate::{MapClouds, MapPoints, StoreError, TileFiles, files};
use api::{Graph, GraphNode, MapSummary, TileAnchor, TileEntry, TileList};
use formats::g2o::{G2oEdge, G2oVertex};
use map_codec::BakeConfig;
use messages::{EdgeKind, FinishedMap, PoseGraph};
use std::io::{self, Write};
use std::path::Path;
use std::time::{Duration, Instant};
use vocab::Aabb;

/// What to write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapFileOptions {
    /// Whether `map.ply` is wanted.
    pub ply: bool,
    /// As [`MapSummary::has_pose_graph`].
    pub has_pose_graph: bool,
}

impl Default for MapFileOptions {
    /// Of a map that was walked, without `map.ply`.
    fn default() -> Self {
        Self { ply: false, has_pose_graph: true }
    }
}

/// The result and the wall time of each stage.
#[derive(Clone, Debug, PartialEq)]
pub struct MapFilesReport {
    /// As in `map.json`.
    pub summary: MapSummary,
    /// Reading clouds and transforming them into the map frame.
    pub merge_time: Duration,
    /// Cutting and encoding tiles.
    pub tile_time: Duration,
    /// Writing everything else.
    pub write_time: Duration,
}

/// Writes all files of a map into `dir`, which holds `clouds/` already, and its tiles into `tiles`. Everything is synced
/// before it returns.
///
/// # Errors
/// When the disk fails, or a cloud cannot be read.
pub fn write_map_files(
    dir: &Path,
    tiles: &TileFiles,
    finished: &FinishedMap,
    options: MapFileOptions,
) -> Result<MapFilesReport, StoreError> {
    let start = Instant::now();
    let keyframes = finished.graph.nodes.iter().map(|node| KeyframePose {
        id: node.id,
        stamp: node.stamp,
        map_from_keyframe: node.map_from_keyframe,
    });
    let selection =
        CloudSelection { spacing_m: BakeConfig::default().finest_spacing_m, include_dynamic: false };
    let clouds = MapClouds::open(&dir.join("clouds"), keyframes.collect(), selection)?;
    let points = MapPoints::read(clouds)?;
    let merge_time = start.elapsed();
    let report = write_map_files_of(dir, tiles, finished, options, points)?;
    Ok(MapFilesReport { merge_time, ..report })
}

/// As [`write_map_files`], with `points` (map frame) for the tiles: those of an imported map are more than its keyframes hold.
///
/// # Errors
/// When the disk fails.
pub fn write_map_files_of(
    dir: &Path,
    tiles: &TileFiles,
    finished: &FinishedMap,
    options: MapFileOptions,
    points: MapPoints,
) -> Result<MapFilesReport, StoreError> {
    let merged = Instant::now();
    let list = write_tiles(tiles, &points, &BakeConfig::default())?;
    let tiled = Instant::now();

    files::write_json(&dir.join("tiles.json"), &list)?;
    files::write_json(&dir.join("graph.json"), &api_graph(&finished.graph))?;
    write_keyframe_descriptors(dir)?;
    files::write_json(&dir.join("loops.json"), &finished.decisions)?;
    files::write_durably(&dir.join("trajectory.tum"), |out| formats::tum::write(out, &finished.trajectory))?;
    files::write_durably(&dir.join("graph.g2o"), |out| write_g2o(out, &finished.graph))?;
    if options.ply {
        let ply = dir.join("map.ply");
        files::write_durably(&ply, |out| formats::ply::write(out, &points.xyz, &points.intensity))?;
    }
    for cloud in files::entries(&dir.join("clouds"))? {
        files::sync_file(&cloud)?;
    }
    write_checksums(dir, &files_with_checksum(dir)?)?;
    let tile_bytes: u64 = list.tiles.iter().map(|tile| u64::from(tile.bytes)).sum();
    // Tiles lie below `dir` for `autoinspect map --out`, and elsewhere for a data directory.
    let other_bytes = files::bytes_below(dir)?.saturating_sub(files::bytes_below(&dir.join("tiles"))?);
    let summary = MapSummary {
        id: finished.map,
        name: finished.name.clone(),
        created: finished.at,
        distance_m: finished.distance_m,
        keyframes: finished.graph.nodes.len() as u32,
        points: list.tiles.iter().map(|tile| u64::from(tile.points)).sum(),
        bytes: other_bytes + tile_bytes,
        has_pose_graph: options.has_pose_graph,
    };
    MapDocument::new(summary.clone()).write(&dir.join("map.json"))?;
    files::sync_directory(&dir.join("clouds"))?;
    files::sync_directory(dir)?;
    Ok(MapFilesReport {
        summary,
        merge_time: Duration::ZERO,
        tile_time: tiled - merged,
        write_time: tiled.elapsed(),
    })
}

fn write_tiles(tiles: &TileFiles, points: &MapPoints, options: &BakeConfig) -> Result<TileList, StoreError> {
    let robust_bounds = robust_bounds(&points.xyz, &RobustBoundsConfig::default());
    let mut list = TileList { bounds: Aabb::EMPTY, tiles: Vec::new(), robust_bounds };
    for tile in map_codec::bake(&points.xyz, &points.intensity, options) {
        list.bounds.include(tile.bounds.min);
        list.bounds.include(tile.bounds.max);
        list.tiles.push(TileEntry {
            hash: tiles.put_with_durability(&tile.bytes, Durability::Map)?,
            anchor: TileAnchor::Map,
            level: tile.node.level,
            spacing_m: tile.spacing,
            bounds: tile.bounds,
            points: tile.points,
            bytes: tile.bytes.len() as u32,
        });
    }
    Ok(list)
}

fn write_g2o(out: &mut impl Write, graph: &PoseGraph) -> io::Result<()> {
    let vertex =
        |node: &messages::GraphNode| G2oVertex { id: node.id.0.into(), pose: node.map_from_keyframe };
    let edge = |edge: &messages::GraphEdge| G2oEdge {
        from: edge.from.0.into(),
        to: edge.to.0.into(),
        from_from_to: edge.from_from_to,
        information: edge.information,
    };
    let vertices: Vec<_> = graph.nodes.iter().map(vertex).collect();
    let edges: Vec<_> = graph.edges.iter().map(edge).collect();
    formats::g2o::write(out, &vertices, &edges)
}

/// The graph as clients get it.
fn api_graph(graph: &PoseGraph) -> Graph {
    let of_kind = |kind| {
        let edges = graph.edges.iter().filter(move |edge| edge.kind == kind);
        edges.map(|edge| (edge.from, edge.to)).collect()
    };
    Graph {
        session: None,
        revision: graph.revision,
        nodes: graph
            .nodes
            .iter()
            .map(|node| GraphNode {
                id: node.id,
                stamp: node.stamp,
                map_from_keyframe: node.map_from_keyframe,
            })
            .collect(),
        edges: of_kind(EdgeKind::Odometry),
        loops: of_kind(EdgeKind::Loop),
    }
}
