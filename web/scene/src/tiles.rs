//! Copies of the tiles' points in main memory, for picking.

use glam::{DAffine3, DVec3, Mat4};

/// Id of a tile, chosen by the caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TileId(pub u64);

/// Id of an anchor, chosen by the caller: a frame that the pose graph moves. Tiles keep their coordinates in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AnchorId(pub u64);

/// The map frame itself, for tiles that do not move.
pub const WHOLE_MAP: AnchorId = AnchorId(u64::MAX);

/// Decoded points on a lattice, in the GPU's form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointBlock<'a> {
    /// Position of lattice coordinate (0, 0, 0) in the anchor's frame, m.
    pub origin: [f32; 3],
    /// Edge of a lattice cell, m.
    pub step: f32,
    /// Distance between neighbouring points, m; 0 when unknown.
    pub spacing: f32,
    /// Time of measurement, s, on any clock; for [`crate::ColourBy::Age`].
    pub stamp: f64,
    /// Lattice x, y, z, and intensity in the low byte.
    pub points: &'a [[u16; 4]],
}

/// Bounding box of consecutive points, so that picking can skip them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PickBlock {
    pub(crate) min: [u16; 3],
    pub(crate) max: [u16; 3],
}

/// Points of each [`PickBlock`]. Tiles come in Morton order, which keeps the boxes small.
pub(crate) const PICK_BLOCK_POINTS: usize = 256;

/// Points of a tile.
#[derive(Clone, Debug)]
pub(crate) struct TilePoints {
    pub(crate) anchor: AnchorId,
    pub(crate) origin: DVec3,
    pub(crate) step: f64,
    pub(crate) spacing: f32,
    pub(crate) stamp: f64,
    pub(crate) points: Vec<[u16; 4]>,
    pub(crate) blocks: Vec<PickBlock>,
    /// Centre of the points, m, anchor's frame.
    pub(crate) centre: DVec3,
    /// Half the diagonal of their bounding box, m.
    pub(crate) radius: f64,
}

impl TilePoints {
    /// `None` for a block without points or with an invalid lattice.
    pub(crate) fn new(anchor: AnchorId, block: &PointBlock) -> Option<Self> {
        let origin = DVec3::from_array(block.origin.map(f64::from));
        let step = f64::from(block.step);
        if block.points.is_empty() || !origin.is_finite() || !step.is_finite() || step <= 0.0 {
            return None;
        }
        let blocks: Vec<PickBlock> = block.points.chunks(PICK_BLOCK_POINTS).map(PickBlock::around).collect();
        let whole = PickBlock {
            min: std::array::from_fn(|axis| blocks.iter().map(|b| b.min[axis]).min().unwrap_or(0)),
            max: std::array::from_fn(|axis| blocks.iter().map(|b| b.max[axis]).max().unwrap_or(0)),
        };
        let (min, max) = (lattice(whole.min), lattice(whole.max));
        Some(Self {
            anchor,
            origin,
            step,
            spacing: if block.spacing.is_finite() { block.spacing.max(0.0) } else { 0.0 },
            stamp: block.stamp,
            points: block.points.to_vec(),
            blocks,
            centre: origin + (min + max) * (0.5 * step),
            radius: (max - min).length() * 0.5 * step,
        })
    }

    /// Position of a point in the anchor's frame, m.
    pub(crate) fn position(&self, point: &[u16; 4]) -> DVec3 {
        self.origin + lattice([point[0], point[1], point[2]]) * self.step
    }

    /// Visits the points, m, map frame, of all blocks of which centre and half diagonal, m, map frame, are in question.
    pub(crate) fn visit_blocks(
        &self,
        map_from_anchor: &DAffine3,
        is_in_question: &impl Fn(DVec3, f64) -> bool,
        visit: &mut dyn FnMut(DVec3),
    ) {
        for (block, points) in self.blocks.iter().zip(self.points.chunks(PICK_BLOCK_POINTS)) {
            let (min, max) = (lattice(block.min), lattice(block.max));
            let middle = map_from_anchor.transform_point3(self.origin + (min + max) * (0.5 * self.step));
            if is_in_question(middle, (max - min).length() * 0.5 * self.step) {
                points.iter().for_each(|point| visit(map_from_anchor.transform_point3(self.position(point))));
            }
        }
    }

    /// Transform from lattice coordinates to metres relative to the camera, along the map's axes. It is computed in f64, so that points
    /// kilometres from the map's origin do not jitter.
    pub(crate) fn relative_from_lattice(&self, map_from_anchor: &DAffine3, camera_position: DVec3) -> Mat4 {
        let map_from_lattice = *map_from_anchor
            * DAffine3::from_translation(self.origin)
            * DAffine3::from_scale(DVec3::splat(self.step));
        let relative =
            DAffine3 { translation: map_from_lattice.translation - camera_position, ..map_from_lattice };
        Mat4::from(relative.as_affine3a())
    }
}

impl PickBlock {
    fn around(points: &[[u16; 4]]) -> Self {
        let mut block = Self { min: [u16::MAX; 3], max: [0; 3] };
        for point in points {
            for axis in 0..3 {
                block.min[axis] = block.min[axis].min(point[axis]);
                block.max[axis] = block.max[axis].max(point[axis]);
            }
        }
        block
    }
}

/// Lattice coordinates as floats.
pub(crate) fn lattice(coordinates: [u16; 3]) -> DVec3 {
    DVec3::from_array(coordinates.map(f64::from))
}
