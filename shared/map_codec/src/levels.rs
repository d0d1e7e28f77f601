//! Splits a growing map into levels of detail, keyframe by keyframe.
//!
//! A point belongs to the coarsest level whose cell around it is free, so each level adds to the coarser ones. A point whose
//! cell of the finest level is occupied is dropped. Cells are counted in the frame of the current submap, a run of
//! keyframes, because drift between keyframes close in time is far below a cell. When a submap is full, a new one starts at the next
//! keyframe. An area that is seen again much later, perhaps after a loop closure, is therefore drawn again at its new position.

use crate::cells::{COORDINATE_END, CellSet};
#[cfg(not(target_arch = "wasm32"))]
use crate::encode::{encode, quantise};
use vocab::Pose;

/// Parameters of a [`LevelSplitter`].
#[derive(Clone, Debug, PartialEq)]
pub struct SplitConfig {
    /// Edge of the cells of each level, metres, coarsest first. At most 255. A level whose entry is not positive
    /// gets no points. If that is the finest level, no level gets points. Chosen: each level has half the spacing of the one before, down to about that of the keyframes'
    /// clouds (0.04 m).
    pub spacings_m: Vec<f32>,
    /// Keyframes after which a new submap starts. Chosen: a loop then moves few tiles, and a tile has enough points.
    pub max_submap_keyframes: u32,
    /// Occupied cells, all levels together, at which a new submap starts. Chosen: it bounds the memory where the robot stands or turns for long.
    pub max_submap_cells: usize,
}

impl Default for SplitConfig {
    fn default() -> Self {
        Self {
            spacings_m: vec![0.80, 0.40, 0.20, 0.10, 0.05],
            max_submap_keyframes: 64,
            max_submap_cells: 2_000_000,
        }
    }
}

/// The points that a keyframe adds to one level, in the keyframe's frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LevelPoints {
    /// Index into [`SplitConfig::spacings_m`].
    pub level: u8,
    /// Distance between points, metres.
    pub spacing: f32,
    /// Points, metres, frame of the keyframe.
    pub xyz: Vec<[f32; 3]>,
    /// Intensity of each point, sensor units.
    pub intensity: Vec<f32>,
}

#[cfg(not(target_arch = "wasm32"))]
impl LevelPoints {
    /// Encodes the tile. The error of each coordinate is at most half of `resolution` (metres); see [`crate::encode_scan`].
    pub fn encode(&self, resolution: f32) -> Vec<u8> {
        let mut chunk = quantise(&self.xyz, &self.intensity, resolution);
        chunk.level = self.level;
        chunk.spacing = self.spacing;
        encode(&chunk)
    }
}

/// Splits keyframe clouds into additive levels.
///
/// It passes over each cloud once. Memory: at most 22 bytes for each of `max_submap_cells` cells plus those of one keyframe, independent of
/// the size of the map.
#[derive(Clone, Debug)]
pub struct LevelSplitter {
    config: SplitConfig,
    /// One set for each level.
    occupied: Vec<CellSet>,
    /// Pose of the first keyframe of the submap; `None` before the first keyframe.
    map_from_submap: Option<RigidTransform>,
    keyframes_in_submap: u32,
}

impl LevelSplitter {
    /// Starts an empty map.
    pub fn new(mut config: SplitConfig) -> Self {
        config.spacings_m.truncate(usize::from(u8::MAX));
        let occupied = vec![CellSet::default(); config.spacings_m.len()];
        Self { config, occupied, map_from_submap: None, keyframes_in_submap: 0 }
    }

    /// Takes the cloud of the next keyframe and returns the points that it adds, one entry for each level with new points, the coarsest first.
    ///
    /// - `map_from_keyframe`: the present pose; later changes of it need no call.
    /// - `xyz`: metres, keyframe's frame. Points that are not finite, or over 1,000,000 cells away, are dropped.
    /// - `intensity`: sensor units; missing values count as 0.
    pub fn push(
        &mut self,
        map_from_keyframe: &Pose,
        xyz: &[[f32; 3]],
        intensity: &[f32],
    ) -> Vec<LevelPoints> {
        let submap_from_keyframe = self.enter_keyframe(map_from_keyframe);
        let mut levels: Vec<LevelPoints> = (0_u8..)
            .zip(&self.config.spacings_m)
            .map(|(level, spacing)| LevelPoints { level, spacing: *spacing, ..LevelPoints::default() })
            .collect();
        let intensities = intensity.iter().copied().chain(std::iter::repeat(0.0));
        for (point, intensity) in xyz.iter().zip(intensities) {
            let in_submap = submap_from_keyframe.apply(*point);
            if let Some(level) = find_level(in_submap, &mut self.occupied, &self.config.spacings_m) {
                levels[level].xyz.push(*point);
                levels[level].intensity.push(intensity);
            }
        }
        levels.retain(|level| !level.xyz.is_empty());
        levels
    }

    /// Starts a new submap if the current one is full, and returns the keyframe's pose in the current one.
    fn enter_keyframe(&mut self, map_from_keyframe: &Pose) -> RigidTransform {
        let map_from_keyframe = RigidTransform::from_pose(map_from_keyframe);
        let cells: usize = self.occupied.iter().map(CellSet::len).sum();
        let full = self.keyframes_in_submap >= self.config.max_submap_keyframes
            || cells >= self.config.max_submap_cells;
        if full {
            self.occupied.iter_mut().for_each(CellSet::clear);
            self.map_from_submap = None;
            self.keyframes_in_submap = 0;
        }
        self.keyframes_in_submap += 1;
        let map_from_submap = self.map_from_submap.get_or_insert(map_from_keyframe);
        map_from_submap.inverse_times(&map_from_keyframe)
    }
}

/// The level of a new point: the coarsest whose cell is free. `None` if its cell on the finest level is occupied.
fn find_level(point: [f32; 3], occupied: &mut [CellSet], spacings_m: &[f32]) -> Option<usize> {
    let finest = spacings_m.len().checked_sub(1)?;
    if !occupied[finest].insert(cell_of(point, spacings_m[finest])?) {
        return None;
    }
    let coarser = (0..finest).find(|level| match cell_of(point, spacings_m[*level]) {
        Some(cell) => occupied[*level].insert(cell),
        None => false,
    });
    Some(coarser.unwrap_or(finest))
}

/// The cell around a point, with positive coordinates; `None` if it is out of range or not finite.
fn cell_of(point: [f32; 3], spacing: f32) -> Option<[u32; 3]> {
    const HALF: f32 = (COORDINATE_END / 2) as f32;
    let cell = point.map(|c| (c / spacing).floor());
    // NaN, from a point or from a zero spacing, fails the comparison.
    let in_range = cell.iter().all(|c| c.abs() < HALF) && spacing > 0.0;
    in_range.then(|| cell.map(|c| (c + HALF) as u32))
}

/// A pose as a rotation matrix (rows) and a translation, metres.
#[derive(Clone, Copy, Debug)]
struct RigidTransform {
    rotation: [[f64; 3]; 3],
    translation: [f64; 3],
}

impl RigidTransform {
    fn from_pose(pose: &Pose) -> Self {
        let q = pose.orientation;
        let (w, x, y, z) = (q.w, q.x, q.y, q.z);
        Self {
            rotation: [
                [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
                [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
                [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
            ],
            translation: pose.position.to_array(),
        }
    }

    /// `self⁻¹ * other`.
    fn inverse_times(&self, other: &Self) -> Self {
        let transposed_dot = |row: usize, v: [f64; 3]| (0..3).map(|k| self.rotation[k][row] * v[k]).sum();
        let offset = std::array::from_fn(|axis| other.translation[axis] - self.translation[axis]);
        Self {
            rotation: std::array::from_fn(|row| {
                std::array::from_fn(|column| {
                    transposed_dot(row, std::array::from_fn(|k| other.rotation[k][column]))
                })
            }),
            translation: std::array::from_fn(|row| transposed_dot(row, offset)),
        }
    }

    fn apply(&self, point: [f32; 3]) -> [f32; 3] {
        std::array::from_fn(|row| {
            let rotated: f64 = (0..3).map(|k| self.rotation[row][k] * f64::from(point[k])).sum();
            (rotated + self.translation[row]) as f32
        })
    }
}
