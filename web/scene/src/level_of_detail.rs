//! Level of detail: selects the tiles of a frame in descending order of their point spacing on the screen, until the point budget is spent.

use crate::projection::CameraProjection;
use crate::tiles::{AnchorId, TileId};
use glam::DVec3;

/// Parameters of [`select_tiles`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LevelOfDetailConfig {
    /// A level is not drawn if the spacing of the next coarser level is below this on the screen, px: it would add nothing visible. Chosen: less than a pixel.
    pub(crate) min_spacing_px: f64,
    /// Spacing of a level relative to the next finer one: an octree halves it. Source: the levels of `map_codec`.
    pub(crate) level_spacing_ratio: f64,
    /// Assumed spacing of a tile of unknown spacing, m. It is large, so that the tile is drawn as early as a coarse level.
    pub(crate) default_spacing_m: f64,
    /// Shorter distances count as this one, m, so that the size of a tile around the camera is finite. Chosen: twice the nearest distance of the camera, 0.1 m.
    pub(crate) min_distance_m: f64,
}

impl Default for LevelOfDetailConfig {
    fn default() -> Self {
        Self { min_spacing_px: 0.8, level_spacing_ratio: 2.0, default_spacing_m: 0.5, min_distance_m: 0.2 }
    }
}

/// A tile that could be drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TileCandidate {
    pub(crate) tile: TileId,
    pub(crate) anchor: AnchorId,
    /// Centre, m, map frame.
    pub(crate) centre: DVec3,
    /// Radius of a sphere around all points, m.
    pub(crate) radius: f64,
    /// Distance between points, m; 0 when unknown.
    pub(crate) spacing: f32,
    pub(crate) points: u32,
}

/// A tile to draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SelectedTile {
    pub(crate) tile: TileId,
    /// Distance between points in the tile's volume once all selected tiles are drawn, m.
    pub(crate) spacing: f32,
}

/// The tiles to draw, most important first, with at most `point_budget` points in all.
pub(crate) fn select_tiles(
    config: &LevelOfDetailConfig,
    candidates: &[TileCandidate],
    projection: &CameraProjection,
    point_budget: u32,
) -> Vec<SelectedTile> {
    let mut ranked: Vec<(f64, &TileCandidate)> = candidates
        .iter()
        .filter(|c| projection.sees_sphere(c.centre, c.radius))
        .map(|c| (spacing_px(config, c, projection), c))
        .filter(|(px, _)| px * config.level_spacing_ratio >= config.min_spacing_px)
        .collect();
    // The tile's id breaks ties, so that equal tiles do not alternate from frame to frame.
    ranked.sort_by(|(a, c), (b, d)| b.total_cmp(a).then(c.tile.cmp(&d.tile)));
    let mut remaining = point_budget;
    let selected: Vec<&TileCandidate> = ranked
        .into_iter()
        .map_while(|(_, c)| {
            remaining = remaining.checked_sub(c.points)?;
            Some(c)
        })
        .collect();
    selected.iter().map(|c| SelectedTile { tile: c.tile, spacing: combined_spacing(c, &selected) }).collect()
}

/// Pixels between neighbouring points where the tile is nearest to the camera.
fn spacing_px(config: &LevelOfDetailConfig, candidate: &TileCandidate, projection: &CameraProjection) -> f64 {
    let known = f64::from(candidate.spacing);
    let spacing = if known > 0.0 { known } else { config.default_spacing_m };
    let to_centre = candidate.centre.distance(projection.camera_position());
    spacing * projection.focal_px() / (to_centre - candidate.radius).max(config.min_distance_m)
}

/// The finest spacing of the selected tiles in the volume of `candidate`: finer levels close the gaps of coarser ones.
fn combined_spacing(candidate: &TileCandidate, selected: &[&TileCandidate]) -> f32 {
    let shares_place = |other: &&&TileCandidate| {
        let apart = candidate.centre.distance(other.centre);
        other.anchor == candidate.anchor && other.spacing > 0.0 && apart <= candidate.radius.max(other.radius)
    };
    selected.iter().filter(shares_place).map(|c| c.spacing).fold(candidate.spacing, f32::min)
}
