//! Which displacements explain a difference at a place.

use crate::PictureChangesConfig;
use crate::align::PictureAlignment;
use crate::blocks::PictureBlock;

/// A square part of the earlier picture.
pub(crate) struct ToleranceCell {
    /// Displacements that the cell may have, whole pixels: zero, and those of the blocks round it.
    pub(crate) displacements: Vec<[isize; 2]>,
    /// A further displacement of up to this, pixels, explains a difference too.
    pub(crate) radius_px: usize,
    /// Whether the blocks round it say that it is a part of the aligned plane.
    pub(crate) is_plane: bool,
}

/// The parts of a picture.
pub(crate) struct ToleranceCells {
    columns: usize,
    side_px: usize,
    pub(crate) cells: Vec<ToleranceCell>,
}

impl ToleranceCells {
    /// The parts of a picture of that size. Equation 11 of docs/maths/picture-changes.md.
    pub(crate) fn of(
        alignment: &PictureAlignment,
        [width, height]: [usize; 2],
        config: &PictureChangesConfig,
    ) -> Self {
        let side_px = config.tolerance_cell_px;
        let (columns, rows) = (width.div_ceil(side_px), height.div_ceil(side_px));
        let cell = |at: usize| {
            let middle = [at % columns, at / columns].map(|cell| (cell as f64 + 0.5) * side_px as f64);
            let is_near = |block: &&PictureBlock| {
                (0..2).all(|axis| (block.centre_px[axis] - middle[axis]).abs() <= config.tolerance_reach_px)
            };
            let near: Vec<&PictureBlock> = alignment.blocks.iter().filter(is_near).collect();
            tolerance(&near, alignment.residual_px, config)
        };
        Self { columns, side_px, cells: (0..columns * rows).map(cell).collect() }
    }

    /// The part in which a pixel is.
    pub(crate) fn at(&self, [x, y]: [usize; 2]) -> &ToleranceCell {
        &self.cells[(y / self.side_px) * self.columns + x / self.side_px]
    }
}

/// What the blocks near a place say. Where most are where the plane says, the place is of the plane: a block that is displaced there or lost is what has changed.
fn tolerance(near: &[&PictureBlock], residual_px: f64, config: &PictureChangesConfig) -> ToleranceCell {
    let base_px = residual_px.max(config.displacement_tolerance_px);
    let size_px =
        |block: &&PictureBlock| block.displacement_px.map_or(config.lost_block_px, |[x, y]| x.hypot(y));
    let count = |is_counted: &dyn Fn(&&PictureBlock) -> bool| {
        near.iter().filter(|block| is_counted(block)).count() as f64
    };
    let is_on_plane = |block: &&PictureBlock| size_px(block) <= base_px;
    let on_plane = count(&is_on_plane);
    let displaced = count(&|block| block.displacement_px.is_some() && !is_on_plane(block));
    let all = near.len() as f64;
    let is_plane = on_plane >= config.plane_share * all && displaced <= config.displaced_share * all;
    let mut displacements = vec![[0, 0]];
    if is_plane {
        return ToleranceCell { displacements, radius_px: radius(base_px), is_plane };
    }
    for displacement_px in near.iter().filter_map(|block| block.displacement_px) {
        let whole = displacement_px.map(|px| px.round() as isize);
        if !displacements.contains(&whole) {
            displacements.push(whole);
        }
    }
    let greatest_px = near.iter().map(size_px).fold(base_px, f64::max);
    ToleranceCell { displacements, radius_px: radius(greatest_px), is_plane }
}

/// The least radius that is not shorter.
fn radius(wanted_px: f64) -> usize {
    RADII_PX
        .into_iter()
        .find(|radius| *radius as f64 >= wanted_px.round())
        .unwrap_or(RADII_PX[RADII_PX.len() - 1])
}

/// Radii that are used: few, because the light near each pixel is found once for each.
const RADII_PX: [usize; 5] = [1, 2, 4, 10, 24];
