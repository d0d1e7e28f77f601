//! Point clouds as they are kept: a copy for the processor to pick from, beside the one on the GPU.

use glam::{DAffine3, DVec3, Mat4};

/// A tile, named by the caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TileId(pub u64);

/// A frame that tiles hang from, named by the caller. It moves with the pose graph; its points never do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AnchorId(pub u64);

/// The map frame itself, for tiles that no pose moves.
pub const WHOLE_MAP: AnchorId = AnchorId(u64::MAX);

/// Points on a lattice, as decoded, ready for the GPU.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointBlock<'a> {
    /// Where lattice coordinate (0, 0, 0) lies in the anchor's frame, metres.
    pub origin: [f32; 3],
    /// Edge of a lattice cell, metres.
    pub step: f32,
    /// Distance between neighbouring points, metres; 0 when unknown.
    pub spacing: f32,
    /// When the points were made, seconds on any clock; for [`crate::ColourBy::Age`].
    pub stamp: f64,
    /// Lattice x, y, z, then intensity in the low byte.
    pub points: &'a [[u16; 4]],
}

/// Points of one box of a cloud, so that a ray can pass over them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    pub(crate) min: [u16; 3],
    pub(crate) max: [u16; 3],
}

/// Points for each [`Block`]; tiles come in Morton order, which keeps the boxes small.
pub(crate) const BLOCK_POINTS: usize = 256;

/// The processor's copy of a tile.
#[derive(Clone, Debug)]
pub(crate) struct Cloud {
    pub(crate) anchor: AnchorId,
    pub(crate) origin: DVec3,
    pub(crate) step: f64,
    pub(crate) spacing: f32,
    pub(crate) stamp: f64,
    pub(crate) points: Vec<[u16; 4]>,
    pub(crate) blocks: Vec<Block>,
    /// Middle of the points in the anchor's frame.
    pub(crate) centre: DVec3,
    /// Half the diagonal of their box, metres.
    pub(crate) radius: f64,
}

impl Cloud {
    /// None for a block without points or with a lattice that is not finite.
    pub(crate) fn new(anchor: AnchorId, block: &PointBlock) -> Option<Self> {
        let origin = DVec3::from_array(block.origin.map(f64::from));
        let step = f64::from(block.step);
        if block.points.is_empty() || !origin.is_finite() || !step.is_finite() || step <= 0.0 {
            return None;
        }
        let blocks: Vec<Block> = block.points.chunks(BLOCK_POINTS).map(Block::around).collect();
        let whole = Block {
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

    /// Position in the anchor's frame, metres.
    pub(crate) fn position(&self, point: &[u16; 4]) -> DVec3 {
        self.origin + lattice([point[0], point[1], point[2]]) * self.step
    }

    /// From lattice coordinates to metres relative to the eye, along the map's axes. In f64 until the end, so that
    /// a map kilometres from its origin does not tremble.
    pub(crate) fn relative_from_lattice(&self, map_from_anchor: &DAffine3, eye: DVec3) -> Mat4 {
        let map_from_lattice = *map_from_anchor
            * DAffine3::from_translation(self.origin)
            * DAffine3::from_scale(DVec3::splat(self.step));
        let relative = DAffine3 { translation: map_from_lattice.translation - eye, ..map_from_lattice };
        Mat4::from(relative.as_affine3a())
    }
}

impl Block {
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

/// Lattice coordinates as numbers.
pub(crate) fn lattice(coordinates: [u16; 3]) -> DVec3 {
    DVec3::from_array(coordinates.map(f64::from))
}
