//! Which tiles of a map to fetch: coarse before fine, near before far, within a budget of points.
//!
//! Tiles are additive: a level adds points between those of the coarser levels. A level is worth fetching where the coarser one
//! would show gaps, that is where twice its point spacing covers more than [`TilePlanConfig::min_gap_px`] pixels. Wanted tiles are
//! ordered by the size of those gaps. The first ones that fit into the point budget are fetched, a few at a time. A fetch that is no
//! longer wanted is cancelled. A fetched tile stays until its room is needed.

use super::robust_bounds::{TileBoundsConfig, TileExtent, robust_bounds};
use super::viewpoint::Viewpoint;
use crate::{ClientEffect, ClientTime};
use api::{TileAnchor, TileEntry, TileHash};
use glam::{DQuat, DVec3, Vec3 as Vec3f};
use std::collections::{BTreeMap, BTreeSet};
use vocab::{Aabb, Pose};

/// Budgets and thresholds of the tile plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TilePlanConfig {
    /// Points on the graphics card at most. A laptop with integrated graphics draws these smoothly.
    pub max_points: u64,
    /// Fetches at the same time: enough to fill the link, few enough to be cancelled soon. Chosen: as many as browsers open to one server over HTTP/1.1.
    pub max_requests: usize,
    /// Gaps between points, pixels, below which a finer level adds nothing visible. Chosen: points are drawn with a radius of 1.45 px and more, which covers it.
    pub min_gap_px: f32,
    /// Factor on the priority of tiles outside the picture: they are fetched after all visible ones. Chosen: ten times less.
    pub outside_factor: f32,
    /// Wait after the first failed fetch of a tile, seconds; after the nth failure n times as long. Chosen: a gateway that restarts is back by then.
    pub retry_s: f64,
    /// Attempts to fetch one tile. Chosen: the last one comes after 20 s; a tile that is missing then stays so.
    pub max_tries: u32,
    /// Least time between two plans, seconds: planning visits all tiles, and four plans a second feel immediate.
    pub period_s: f64,
    /// Distance that tiles count as at least, metres: tiles round the camera would have infinite priority. Chosen: the width of a robot.
    pub min_distance_m: f32,
    /// Added to the priority of level 0, pixels: the coarsest level is small and shows everything, so it comes first. Chosen: more than any screen has.
    pub coarsest_level_px: f32,
}

impl Default for TilePlanConfig {
    fn default() -> Self {
        Self {
            max_points: 4_000_000,
            max_requests: 6,
            min_gap_px: 1.5,
            outside_factor: 0.1,
            retry_s: 2.0,
            max_tries: 5,
            period_s: 0.25,
            min_distance_m: 0.5,
            coarsest_level_px: 1e6,
        }
    }
}

/// State of a tile on this client.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TileState {
    /// Not here.
    Absent,
    /// Being fetched.
    Loading,
    /// On the screen.
    Ready,
    /// The last fetch failed.
    Failed,
}

#[derive(Clone, Debug)]
struct Tile {
    entry: TileEntry,
    state: TileState,
    failures: u32,
    retry_at: ClientTime,
}

/// The tiles of one map with their states.
#[derive(Clone, Debug, Default)]
pub struct TileSet {
    tiles: BTreeMap<TileHash, Tile>,
    points: u64,
    ready_points: u64,
    loading: usize,
    ready: usize,
    dirty: bool,
    listed: bool,
    /// When the earliest failed fetch may be tried again.
    retry_at: Option<ClientTime>,
    config: TilePlanConfig,
}

impl TileSet {
    /// Points of all tiles, fetched or not.
    pub fn points(&self) -> u64 {
        self.points
    }

    /// Number of tiles that the server listed.
    pub fn len(&self) -> usize {
        self.tiles.len()
    }

    /// Whether the server listed no tile.
    pub fn is_empty(&self) -> bool {
        self.tiles.is_empty()
    }

    /// Whether the server has listed the tiles; the list may be empty.
    pub fn listed(&self) -> bool {
        self.listed
    }

    /// Number of tiles on the screen.
    pub fn ready(&self) -> usize {
        self.ready
    }

    /// Points on the screen.
    pub fn ready_points(&self) -> u64 {
        self.ready_points
    }

    /// Number of fetches under way.
    pub fn loading(&self) -> usize {
        self.loading
    }

    /// A tile and its state.
    pub fn get(&self, hash: &TileHash) -> Option<(&TileEntry, TileState)> {
        self.tiles.get(hash).map(|tile| (&tile.entry, tile.state))
    }

    /// All tiles, in the order of their hashes.
    pub fn entries(&self) -> impl Iterator<Item = &TileEntry> {
        self.tiles.values().map(|tile| &tile.entry)
    }

    /// The box of the map without stray points, metres, map frame; `None` without tiles. `pose_of` gives poses of anchors in the map.
    pub fn robust_bounds(&self, pose_of: impl Fn(TileAnchor) -> Option<Pose>) -> Option<Aabb> {
        let extents = self.tiles.values().filter_map(|tile| {
            let (map_from_anchor, (centre, half)) =
                (pose_of(tile.entry.anchor)?, centre_and_half(&tile.entry.bounds)?);
            let centre = transform_point(&map_from_anchor, centre);
            // The half extents, along the map's axes, of a box that is rotated with its anchor.
            let rotation = glam::DMat3::from_quat(quat(&map_from_anchor));
            let half = rotation.x_axis.abs() * half.x
                + rotation.y_axis.abs() * half.y
                + rotation.z_axis.abs() * half.z;
            let [min, max] = [centre - half, centre + half].map(|corner| corner.as_vec3().to_array());
            Some(TileExtent { bounds: Aabb { min, max }, level: tile.entry.level, points: tile.entry.points })
        });
        robust_bounds(&TileBoundsConfig::default(), &extents.collect::<Vec<_>>())
    }

    pub(crate) fn add(&mut self, entries: &[TileEntry]) {
        for entry in entries {
            // A tile that is listed twice keeps its state.
            self.tiles.entry(entry.hash).or_insert_with(|| {
                self.points += u64::from(entry.points);
                Tile { entry: *entry, state: TileState::Absent, failures: 0, retry_at: ClientTime::default() }
            });
        }
        (self.dirty, self.listed) = (true, true);
    }

    /// Removes all tiles from the screen. The list stays unless `forget`.
    pub(crate) fn unload(&mut self, forget: bool, effects: &mut Vec<ClientEffect>) {
        for (hash, tile) in &mut self.tiles {
            match tile.state {
                TileState::Loading => effects.push(ClientEffect::CancelTile(*hash)),
                TileState::Ready => effects.push(ClientEffect::RemoveTile(*hash)),
                TileState::Absent | TileState::Failed => {}
            }
            tile.state = TileState::Absent;
        }
        (self.ready_points, self.loading, self.ready) = (0, 0, 0);
        self.dirty = true;
        if forget {
            *self = Self::default();
        }
    }

    /// A fetch succeeded. Returns whether this set waited for it.
    pub(crate) fn on_fetched(&mut self, hash: &TileHash) -> bool {
        let Some(tile) = self.tiles.get_mut(hash).filter(|tile| tile.state == TileState::Loading) else {
            return false;
        };
        tile.state = TileState::Ready;
        self.loading -= 1;
        self.ready += 1;
        self.ready_points += u64::from(tile.entry.points);
        self.dirty = true;
        true
    }

    /// A fetch failed. It is tried again later, [`TilePlanConfig::max_tries`] times in all.
    pub(crate) fn on_failed(&mut self, hash: &TileHash, now: ClientTime) {
        if let Some(tile) = self.tiles.get_mut(hash).filter(|tile| tile.state == TileState::Loading) {
            tile.failures += 1;
            tile.retry_at = now.after(self.config.retry_s * f64::from(tile.failures));
            tile.state = TileState::Failed;
            if tile.failures < self.config.max_tries {
                self.retry_at =
                    Some(self.retry_at.map_or(tile.retry_at, |other| earlier(other, tile.retry_at)));
            }
            self.loading -= 1;
            self.dirty = true;
        }
    }

    pub(crate) fn mark_dirty(&mut self) {
        self.dirty = true;
    }

    /// Whether a plan made now may differ from the last one.
    pub(crate) fn is_plan_due(&self, now: ClientTime) -> bool {
        self.dirty || self.retry_at.is_some_and(|at| now >= at)
    }

    /// Least time between two plans, seconds.
    pub(crate) fn plan_period_s(&self) -> f64 {
        self.config.period_s
    }

    /// Decides which tiles to fetch, cancel and remove for a viewpoint. `pose_of` gives poses of anchors in the map.
    pub(crate) fn plan(
        &mut self,
        viewpoint: &Viewpoint,
        now: ClientTime,
        pose_of: impl Fn(TileAnchor) -> Option<Pose>,
        effects: &mut Vec<ClientEffect>,
    ) {
        self.dirty = false;
        if self.retry_at.is_some_and(|at| now >= at) {
            self.retry_at = self.find_next_retry(now);
        }
        let mut wanted: Vec<(f32, TileHash)> = Vec::new();
        for (hash, tile) in &self.tiles {
            if let Some(map_from_anchor) = pose_of(tile.entry.anchor)
                && let Some(priority) =
                    compute_priority(&tile.entry, &map_from_anchor, viewpoint, &self.config)
            {
                wanted.push((priority, *hash));
            }
        }
        wanted.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut budget = self.config.max_points;
        let fitting = wanted.iter().take_while(|(_, hash)| {
            let points = self.tiles.get(hash).map_or(0, |tile| u64::from(tile.entry.points));
            let fits = points <= budget;
            budget = budget.saturating_sub(points);
            fits
        });
        let selected: Vec<TileHash> = fitting.map(|&(_, hash)| hash).collect();
        self.release(&selected, effects);
        for hash in selected {
            if self.loading >= self.config.max_requests {
                break;
            }
            self.fetch(hash, now, effects);
        }
    }

    /// When the earliest failed fetch that is not due yet may be tried again.
    fn find_next_retry(&self, now: ClientTime) -> Option<ClientTime> {
        let failed = self
            .tiles
            .values()
            .filter(|tile| tile.state == TileState::Failed && tile.failures < self.config.max_tries);
        failed.map(|tile| tile.retry_at).filter(|at| *at > now).reduce(earlier)
    }

    fn fetch(&mut self, hash: TileHash, now: ClientTime, effects: &mut Vec<ClientEffect>) {
        let Some(tile) = self.tiles.get_mut(&hash) else { return };
        let due = match tile.state {
            TileState::Absent => true,
            TileState::Failed => tile.failures < self.config.max_tries && now >= tile.retry_at,
            TileState::Loading | TileState::Ready => false,
        };
        if due {
            tile.state = TileState::Loading;
            self.loading += 1;
            effects.push(ClientEffect::FetchTile(hash));
        }
    }

    /// Cancels fetches that are not selected, and removes tiles that are not selected while the budget is exceeded.
    fn release(&mut self, selected: &[TileHash], effects: &mut Vec<ClientEffect>) {
        let selected: BTreeSet<&TileHash> = selected.iter().collect();
        let coming_points: u64 = selected
            .iter()
            .filter_map(|hash| self.tiles.get(hash))
            .filter(|tile| tile.state != TileState::Ready)
            .map(|tile| u64::from(tile.entry.points))
            .sum();
        for (hash, tile) in &mut self.tiles {
            match tile.state {
                TileState::Loading if !selected.contains(hash) => {
                    tile.state = TileState::Absent;
                    self.loading -= 1;
                    effects.push(ClientEffect::CancelTile(*hash));
                }
                TileState::Ready
                    if !selected.contains(hash)
                        && self.ready_points + coming_points > self.config.max_points =>
                {
                    tile.state = TileState::Absent;
                    self.ready -= 1;
                    self.ready_points -= u64::from(tile.entry.points);
                    effects.push(ClientEffect::RemoveTile(*hash));
                }
                _ => {}
            }
        }
    }
}

fn earlier(a: ClientTime, b: ClientTime) -> ClientTime {
    if a <= b { a } else { b }
}

/// Priority of a tile: the gaps that it fills on the screen, pixels. `None` if they are too small to see.
fn compute_priority(
    entry: &TileEntry,
    map_from_anchor: &Pose,
    viewpoint: &Viewpoint,
    config: &TilePlanConfig,
) -> Option<f32> {
    let (centre, half) = centre_and_half(&entry.bounds)?;
    let to_centre = (transform_point(map_from_anchor, centre) - DVec3::from(viewpoint.position)).as_vec3();
    let radius = half.length() as f32;
    let distance = (to_centre.length() - radius).max(config.min_distance_m);
    let gap_px = 2.0 * entry.spacing_m * viewpoint.focal_px / distance;
    if entry.level > 0 && gap_px < config.min_gap_px {
        return None;
    }
    let coarsest_px = if entry.level == 0 { config.coarsest_level_px } else { 0.0 };
    let visible = is_in_cone(to_centre, radius, Vec3f::from(viewpoint.forward), viewpoint.corner_cos);
    Some(coarsest_px + gap_px * if visible { 1.0 } else { config.outside_factor })
}

/// Whether a sphere touches the cone round the picture.
fn is_in_cone(to_centre: Vec3f, radius: f32, forward: Vec3f, corner_cos: f32) -> bool {
    let along = to_centre.dot(forward);
    let across = (to_centre.length_squared() - along * along).max(0.0).sqrt();
    let corner_sin = (1.0 - corner_cos * corner_cos).max(0.0).sqrt();
    across * corner_cos - along * corner_sin <= radius && along > -radius
}

fn centre_and_half(bounds: &Aabb) -> Option<(DVec3, DVec3)> {
    let (min, max) = (Vec3f::from(bounds.min).as_dvec3(), Vec3f::from(bounds.max).as_dvec3());
    let valid = min.is_finite() && max.is_finite() && min.cmple(max).all();
    valid.then(|| (0.5 * (min + max), 0.5 * (max - min)))
}

fn quat(pose: &Pose) -> DQuat {
    let q = pose.orientation;
    DQuat::from_xyzw(q.x, q.y, q.z, q.w)
}

fn transform_point(parent_from_child: &Pose, point_in_child: DVec3) -> DVec3 {
    quat(parent_from_child) * point_in_child + DVec3::from(parent_from_child.position.to_array())
}
