//! Tests of the scene. Only `drawing` needs a GPU.

mod camera;
mod drawing;
mod frame_pacing;
mod level_of_detail;
mod picking;
mod point_columns;
mod shaders;

use crate::*;
use glam::DVec3;

/// Colours similar to those of the dark theme.
pub(crate) fn palette() -> Palette {
    Palette {
        ground_top: [13, 17, 23, 255],
        ground_bottom: [22, 29, 39, 255],
        plain: [139, 152, 166, 255],
        live: [255, 255, 255, 110],
        grid: [139, 152, 166, 90],
        node: [240, 244, 250, 255],
        uncertain: [210, 153, 34, 255],
        outline: [13, 17, 23, 255],
        edge: [140, 175, 220, 255],
        loop_closed: [188, 140, 255, 230],
        loop_open: [210, 153, 34, 230],
        loop_rejected: [139, 152, 166, 120],
        pair: [[57, 208, 216, 255], [255, 140, 66, 255]],
        changed: [[150, 176, 208, 255], [222, 60, 48, 255]],
        trajectory: [88, 166, 255, 255],
        accent: [88, 166, 255, 255],
        robot: [255, 211, 61, 255],
        bad: [248, 81, 73, 255],
    }
}

pub(crate) fn view(camera: CameraPose, viewport_px: [u32; 2]) -> View {
    View { camera, viewport_px, pixels_per_point: 1.0, options: Options::default(), palette: palette() }
}

/// A block of points around an origin, on a lattice of 5 mm.
pub(crate) struct TestTile {
    pub(crate) origin: [f32; 3],
    pub(crate) points: Vec<[u16; 4]>,
    pub(crate) spacing: f32,
}

impl TestTile {
    pub(crate) const STEP: f32 = 0.005;

    pub(crate) fn new(positions: &[DVec3], spacing: f32) -> Self {
        let least = positions.iter().copied().reduce(DVec3::min).unwrap_or_default();
        let lattice = |p: &DVec3| {
            let at = ((*p - least) / f64::from(Self::STEP)).round();
            [at.x as u16, at.y as u16, at.z as u16, ((p.x * 3.0 + p.y * 5.0).sin() * 60.0 + 100.0) as u16]
        };
        Self { origin: least.as_vec3().to_array(), points: positions.iter().map(lattice).collect(), spacing }
    }

    pub(crate) fn block(&self) -> PointBlock<'_> {
        PointBlock {
            origin: self.origin,
            step: Self::STEP,
            spacing: self.spacing,
            stamp: 0.0,
            points: &self.points,
        }
    }
}
