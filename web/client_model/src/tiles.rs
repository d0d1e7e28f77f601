//! Which tiles of a map to have: coarse before fine, near before far, within a budget of points.
//!
//! Tiles add up, so a level is worth fetching where the one before it would show gaps: where twice its spacing covers
//! more pixels than [`GAP_PX`]. What is wanted is ordered by that size on the screen; the first tiles that fit into
//! [`TILE_POINTS_MAX`] are fetched, at most [`TILE_REQUESTS_MAX`] at once. A fetch that is no longer wanted is
//! cancelled; a tile that is there stays until its room is needed.

use crate::robust_bounds::{RobustBoundsConfig, TileExtent, robust_bounds};
use crate::{ClientEffect, ClientTime};
use api::{Anchor, TileEntry, TileHash};
use glam::{DQuat, DVec3, Vec3 as Vec3f};
use std::collections::BTreeMap;
use vocab::{Aabb, Pose};

/// Points on the graphics card at most: a laptop without a graphics card of its own draws these at leisure.
pub const TILE_POINTS_MAX: u64 = 4_000_000;
/// Fetches under way at once.
pub const TILE_REQUESTS_MAX: usize = 6;
/// Gaps between points of the coarser level, pixels, below which the finer level adds nothing.
const GAP_PX: f32 = 1.5;
/// Tiles behind the camera count as much smaller, but still come when all else is there.
const BEHIND_FACTOR: f32 = 0.1;
const RETRY_S: f64 = 2.0;
const TRIES_MAX: u32 = 5;

/// From where and how a map is looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Viewpoint {
    /// Of the camera, map frame, metres.
    pub position: [f64; 3],
    /// Unit vector into the picture, map frame.
    pub forward: [f32; 3],
    /// Pixels that one metre covers at a distance of one metre.
    pub focal_px: f32,
    /// Cosine of the angle between the middle and a corner of the picture.
    pub corner_cos: f32,
}

/// What is known of a tile here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TileState {
    /// Not here.
    Absent,
    /// Being fetched.
    Loading,
    /// On the screen.
    Ready,
    /// Could not be had; tried again a few times.
    Failed,
}

#[derive(Clone, Debug)]
struct Tile {
    entry: TileEntry,
    state: TileState,
    failures: u32,
    retry_at: ClientTime,
}

/// The tiles of one map and what is here of them.
#[derive(Clone, Debug, Default)]
pub struct TileSet {
    tiles: BTreeMap<TileHash, Tile>,
    points: u64,
    ready_points: u64,
    loading: usize,
    ready: usize,
    dirty: bool,
    listed: bool,
    /// When the next fetch that failed may be tried again.
    retry_at: Option<ClientTime>,
}

impl TileSet {
    /// Points of all tiles, here or not.
    pub fn points(&self) -> u64 {
        self.points
    }

    /// Tiles known.
    pub fn len(&self) -> usize {
        self.tiles.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.tiles.is_empty()
    }

    /// Whether the server has said which there are, be it none.
    pub fn listed(&self) -> bool {
        self.listed
    }

    /// Tiles on the screen.
    pub fn ready(&self) -> usize {
        self.ready
    }

    /// Points on the screen.
    pub fn ready_points(&self) -> u64 {
        self.ready_points
    }

    /// Fetches under way.
    pub fn loading(&self) -> usize {
        self.loading
    }

    /// What is known of a tile.
    pub fn get(&self, hash: &TileHash) -> Option<(&TileEntry, TileState)> {
        self.tiles.get(hash).map(|tile| (&tile.entry, tile.state))
    }

    /// The box of the map without stray points, m, map frame; `None` without tiles. `pose_of`: pose of an anchor in the map.
    pub fn robust_bounds(&self, pose_of: impl Fn(Anchor) -> Option<Pose>) -> Option<Aabb> {
        let extents = self.tiles.values().filter_map(|tile| {
            let (map_from_anchor, (centre, half)) =
                (pose_of(tile.entry.anchor)?, box_of(&tile.entry.bounds)?);
            let centre = move_point(&map_from_anchor, centre);
            // The box that holds the rotated box of the tile.
            let rotation = glam::DMat3::from_quat(quat(&map_from_anchor));
            let half = rotation.x_axis.abs() * half.x
                + rotation.y_axis.abs() * half.y
                + rotation.z_axis.abs() * half.z;
            let [min, max] = [centre - half, centre + half].map(|corner| corner.as_vec3().to_array());
            Some(TileExtent { bounds: Aabb { min, max }, level: tile.entry.level, points: tile.entry.points })
        });
        robust_bounds(&RobustBoundsConfig::default(), &extents.collect::<Vec<_>>())
    }

    pub(crate) fn add(&mut self, entries: &[TileEntry]) {
        for entry in entries {
            // A tile listed twice: what is here of it stays true.
            self.tiles.entry(entry.hash).or_insert_with(|| {
                self.points += u64::from(entry.points);
                Tile { entry: *entry, state: TileState::Absent, failures: 0, retry_at: ClientTime::default() }
            });
        }
        (self.dirty, self.listed) = (true, true);
    }

    /// Takes everything off the screen; the list stays unless `forget`.
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

    /// A fetch ended well. Returns whether this set waited for it.
    pub(crate) fn arrive(&mut self, hash: &TileHash) -> bool {
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

    /// A fetch failed; it is tried again later, a few times.
    pub(crate) fn fail(&mut self, hash: &TileHash, now: ClientTime) {
        if let Some(tile) = self.tiles.get_mut(hash).filter(|tile| tile.state == TileState::Loading) {
            tile.failures += 1;
            tile.retry_at = now.after(RETRY_S * f64::from(tile.failures));
            tile.state = TileState::Failed;
            if tile.failures < TRIES_MAX {
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
    pub(crate) fn plan_due(&self, now: ClientTime) -> bool {
        self.dirty || self.retry_at.is_some_and(|at| now >= at)
    }

    /// Decides what to fetch, cancel and drop for this `eye`. `pose_of` says where anchors are in the map.
    pub(crate) fn plan(
        &mut self,
        eye: &Viewpoint,
        now: ClientTime,
        pose_of: impl Fn(Anchor) -> Option<Pose>,
        effects: &mut Vec<ClientEffect>,
    ) {
        self.dirty = false;
        if self.retry_at.is_some_and(|at| now >= at) {
            self.retry_at = self.next_retry(now);
        }
        let mut wanted: Vec<(f32, TileHash)> = Vec::new();
        for (hash, tile) in &self.tiles {
            if let Some(map_from_anchor) = pose_of(tile.entry.anchor)
                && let Some(worth) = worth(&tile.entry, &map_from_anchor, eye)
            {
                wanted.push((worth, *hash));
            }
        }
        wanted.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut room = TILE_POINTS_MAX;
        let fitting = wanted.iter().take_while(|(_, hash)| {
            let points = self.tiles.get(hash).map_or(0, |tile| u64::from(tile.entry.points));
            let fits = points <= room;
            room = room.saturating_sub(points);
            fits
        });
        let chosen: Vec<TileHash> = fitting.map(|&(_, hash)| hash).collect();
        self.release(&chosen, effects);
        for hash in chosen {
            if self.loading >= TILE_REQUESTS_MAX {
                break;
            }
            self.fetch(hash, now, effects);
        }
    }

    /// When the earliest of the failed fetches that are not due yet will be.
    fn next_retry(&self, now: ClientTime) -> Option<ClientTime> {
        let waiting =
            self.tiles.values().filter(|tile| tile.state == TileState::Failed && tile.failures < TRIES_MAX);
        waiting.map(|tile| tile.retry_at).filter(|at| *at > now).reduce(earlier)
    }

    fn fetch(&mut self, hash: TileHash, now: ClientTime, effects: &mut Vec<ClientEffect>) {
        let Some(tile) = self.tiles.get_mut(&hash) else { return };
        let due = match tile.state {
            TileState::Absent => true,
            TileState::Failed => tile.failures < TRIES_MAX && now >= tile.retry_at,
            TileState::Loading | TileState::Ready => false,
        };
        if due {
            tile.state = TileState::Loading;
            self.loading += 1;
            effects.push(ClientEffect::FetchTile(hash));
        }
    }

    /// Cancels fetches outside `chosen`, and drops tiles outside it while the budget is exceeded.
    fn release(&mut self, chosen: &[TileHash], effects: &mut Vec<ClientEffect>) {
        let chosen: std::collections::BTreeSet<&TileHash> = chosen.iter().collect();
        let coming: u64 = chosen
            .iter()
            .filter_map(|hash| self.tiles.get(hash))
            .filter(|tile| tile.state != TileState::Ready)
            .map(|tile| u64::from(tile.entry.points))
            .sum();
        for (hash, tile) in &mut self.tiles {
            match tile.state {
                TileState::Loading if !chosen.contains(hash) => {
                    tile.state = TileState::Absent;
                    self.loading -= 1;
                    effects.push(ClientEffect::CancelTile(*hash));
                }
                TileState::Ready
                    if !chosen.contains(hash) && self.ready_points + coming > TILE_POINTS_MAX =>
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

/// How much a tile would add to the picture: the gaps it fills, pixels. `None` when they are too small to see.
fn worth(entry: &TileEntry, map_from_anchor: &Pose, eye: &Viewpoint) -> Option<f32> {
    let (centre, half) = box_of(&entry.bounds)?;
    let to_centre = (move_point(map_from_anchor, centre) - DVec3::from(eye.position)).as_vec3();
    let radius = half.length() as f32;
    let distance = (to_centre.length() - radius).max(0.5);
    let gap_px = 2.0 * entry.spacing * eye.focal_px / distance;
    if entry.level > 0 && gap_px < GAP_PX {
        return None;
    }
    // The coarsest level first of all: it is small and shows everything.
    let head_start = if entry.level == 0 { 1e6 } else { 0.0 };
    let seen = in_cone(to_centre, radius, Vec3f::from(eye.forward), eye.corner_cos);
    Some(head_start + gap_px * if seen { 1.0 } else { BEHIND_FACTOR })
}

/// Whether a sphere touches the cone round the picture.
fn in_cone(to_centre: Vec3f, radius: f32, forward: Vec3f, corner_cos: f32) -> bool {
    let along = to_centre.dot(forward);
    let across = (to_centre.length_squared() - along * along).max(0.0).sqrt();
    let corner_sin = (1.0 - corner_cos * corner_cos).max(0.0).sqrt();
    across * corner_cos - along * corner_sin <= radius && along > -radius
}

fn box_of(bounds: &Aabb) -> Option<(DVec3, DVec3)> {
    let (min, max) = (Vec3f::from(bounds.min).as_dvec3(), Vec3f::from(bounds.max).as_dvec3());
    let valid = min.is_finite() && max.is_finite() && min.cmple(max).all();
    valid.then(|| (0.5 * (min + max), 0.5 * (max - min)))
}

fn quat(pose: &Pose) -> DQuat {
    let q = pose.orientation;
    DQuat::from_xyzw(q.x, q.y, q.z, q.w)
}

fn move_point(parent_from_child: &Pose, point_in_child: DVec3) -> DVec3 {
    quat(parent_from_child) * point_in_child + DVec3::from(parent_from_child.position.to_array())
}
