//! Which tiles a frame draws: those whose point spacing appears largest first, until the budget is spent.

use crate::eye::Eye;
use crate::tiles::{AnchorId, TileId};
use glam::DVec3;

/// A level whose coarser neighbour is already this fine on the screen (pixels) adds nothing to see.
const SPACING_MIN_PX: f64 = 0.8;
/// Each level is about half as coarse as the one before.
const LEVEL_RATIO: f64 = 2.0;
/// Stands in for a spacing that nobody told, metres: drawn early, as a coarse level is.
const SPACING_UNKNOWN: f64 = 0.5;

/// A tile that could be drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    pub(crate) tile: TileId,
    pub(crate) anchor: AnchorId,
    /// Middle, metres, map frame.
    pub(crate) centre: DVec3,
    /// Of a ball around all points, metres.
    pub(crate) radius: f64,
    /// Distance between points, metres; 0 when unknown.
    pub(crate) spacing: f32,
    pub(crate) points: u32,
}

/// A tile to draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Chosen {
    pub(crate) tile: TileId,
    /// Distance between points here once everything chosen is drawn, metres.
    pub(crate) spacing: f32,
}

/// The tiles to draw, most important first, with at most `budget` points in all.
pub(crate) fn choose(candidates: &[Candidate], eye: &Eye, budget: u32) -> Vec<Chosen> {
    let mut ranked: Vec<(f64, &Candidate)> = candidates
        .iter()
        .filter(|c| eye.sees_ball(c.centre, c.radius))
        .map(|c| (spacing_px(c, eye), c))
        .filter(|(px, _)| px * LEVEL_RATIO >= SPACING_MIN_PX)
        .collect();
    // The tile's name breaks ties, so that equal tiles do not take turns.
    ranked.sort_by(|(a, c), (b, d)| b.total_cmp(a).then(c.tile.cmp(&d.tile)));
    let mut left = budget;
    let drawn: Vec<&Candidate> = ranked
        .into_iter()
        .map_while(|(_, c)| {
            left = left.checked_sub(c.points)?;
            Some(c)
        })
        .collect();
    drawn.iter().map(|c| Chosen { tile: c.tile, spacing: spacing_among(c, &drawn) }).collect()
}

/// Pixels between neighbouring points where the tile is nearest.
fn spacing_px(candidate: &Candidate, eye: &Eye) -> f64 {
    let told = f64::from(candidate.spacing);
    let spacing = if told > 0.0 { told } else { SPACING_UNKNOWN };
    let distance = (candidate.centre.distance(eye.position()) - candidate.radius).max(4.0 * Eye::NEAR);
    spacing * eye.focal_px() / distance
}

/// The finest spacing among drawn tiles that fill the same place: finer levels close the gaps of coarser ones.
fn spacing_among(candidate: &Candidate, drawn: &[&Candidate]) -> f32 {
    let shares_place = |other: &&&Candidate| {
        let apart = candidate.centre.distance(other.centre);
        other.anchor == candidate.anchor && other.spacing > 0.0 && apart <= candidate.radius.max(other.radius)
    };
    drawn.iter().filter(shares_place).map(|c| c.spacing).fold(candidate.spacing, f32::min)
}
