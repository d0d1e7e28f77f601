//! What the shaders read, laid out as WGSL does: every field is a multiple of 16 bytes.

use crate::eye::Eye;
use crate::ramp::STOPS;
use crate::view::{Colour, ColourBy, View};
use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec3, Vec4};

/// Largest radius to which a point grows, pixels. The fill passes read this many pixels to each side at most; packing
/// has room for just under 16.
pub(crate) const RADIUS_MAX_PX: f32 = 14.0;
/// Least radius, pixels: the eight neighbours are reached, or a spacing of just over a pixel would leave a lattice of
/// holes.
pub(crate) const RADIUS_MIN_PX: f32 = 1.45;
/// Radius of a point in halves of its spacing. A square's corner is 1.4 half edges away; a little more closes surfaces
/// seen obliquely.
const RADIUS_PER_HALF_SPACING: f32 = 1.6;

/// Coarser points than these (metres apart) grow no larger: while finer levels are missing, dots with gaps between them
/// read better than blobs.
const GROWN_SPACING_MAX: f32 = 0.12;

/// `Globals` of common.wgsl.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Globals {
    clip_from_relative: Mat4,
    /// Eye in the map (metres), pixels a metre spans at one metre.
    eye: Vec4,
    /// Width, height, physical pixels a point, largest radius of a point in this frame.
    viewport: Vec4,
    /// Floor, ceiling, ends of the height ramp, metres.
    heights: Vec4,
    /// Radius of a point relative to half its spacing, strength of eye-dome lighting, colour mode, height of the grid (metres).
    style: Vec4,
    /// Half the extent of the grid (metres), its spacing (metres), 0, 0.
    grid_shape: Vec4,
    ground_top: Vec4,
    ground_bottom: Vec4,
    plain: Vec4,
    grid: Vec4,
    ramp: [[f32; 4]; STOPS],
}

impl Globals {
    /// `radius_max`: of all points of this frame, pixels; see [`radius_px`].
    pub(crate) fn new(view: &View, eye: &Eye, radius_max: f32) -> Self {
        let options = &view.options;
        let position = eye.position().as_vec3();
        let [width, height] = view.viewport_px.map(|px| px as f32);
        let [low, high] = options.height_range;
        let mode = match options.colour_by {
            ColourBy::Height => 0.0,
            ColourBy::Intensity => 1.0,
            ColourBy::Age => 2.0,
            ColourBy::Plain => 3.0,
        };
        Self {
            clip_from_relative: eye.clip_from_relative(),
            eye: position.extend(eye.focal_px() as f32),
            viewport: Vec4::new(width, height, view.pixels_per_point, radius_max),
            heights: Vec4::new(options.floor, options.ceiling, low, (high - low).max(1e-3)),
            style: Vec4::new(
                options.point_size * RADIUS_PER_HALF_SPACING,
                options.edl,
                mode,
                options.grid_height,
            ),
            grid_shape: grid_shape(view.camera.distance),
            ground_top: unit_range(view.palette.ground_top),
            ground_bottom: unit_range(view.palette.ground_bottom),
            plain: unit_range(view.palette.plain),
            grid: unit_range(view.palette.grid),
            ramp: options.ramp.stops(),
        }
    }
}

/// `Piece` of common.wgsl: one tile, scan or model.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Piece {
    /// To metres relative to the eye, along the map's axes.
    pub(crate) relative_from_local: Mat4,
    /// Half the spacing (metres), age between 0 and 1, 0, 1 to heed the clip heights.
    pub(crate) kind: Vec4,
    /// Colour that points and models are tinted with; w is its share, of points.
    pub(crate) tint: Vec4,
}

/// Pieces lie this far apart in their buffer; the least that every device can address.
pub(crate) const PIECE_STRIDE: u64 = 256;

/// A colour as the shaders compute with it: gamma-encoded, 0 to 1.
pub(crate) fn unit_range(colour: Colour) -> Vec4 {
    let [r, g, b, a] = colour.map(|c| f32::from(c) / 255.0);
    Vec3::new(r, g, b).extend(a)
}

/// The grid reaches three camera distances; its lines are 1, 10 or 100 m apart, some twenty across the picture.
fn grid_shape(distance: f64) -> Vec4 {
    let spacing = (distance / 12.0).max(1.0).log10().floor();
    Vec4::new((distance * 3.0) as f32, 10_f64.powf(spacing) as f32, 0.0, 0.0)
}

/// Half the spacing to which points `spacing` apart (metres) grow.
pub(crate) fn grown_half_spacing(spacing: f32) -> f32 {
    0.5 * spacing.min(GROWN_SPACING_MAX)
}

/// Radius to which points `spacing` apart (metres) grow at a depth (metres).
pub(crate) fn radius_px(view: &View, eye: &Eye, spacing: f32, depth: f64) -> f32 {
    let scale = grown_half_spacing(spacing) * RADIUS_PER_HALF_SPACING * view.options.point_size;
    let radius = scale * (eye.focal_px() / depth.max(Eye::NEAR)) as f32;
    if radius.is_nan() { RADIUS_MIN_PX } else { radius.clamp(RADIUS_MIN_PX, RADIUS_MAX_PX) }
}
