//! Uniforms of the shaders in WGSL's layout: every field is a multiple of 16 bytes.

use crate::colour_map::STOPS;
use crate::projection::CameraProjection;
use crate::view::{Colour, ColourBy, View};
use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec2, Vec3, Vec4};

/// Parameters of the size of points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PointSizeConfig {
    /// Largest radius of a point, logical px. Chosen: larger discs hide the shape of near things.
    pub(crate) max_radius_px: f32,
    /// Largest radius of a point, physical px. The fill passes read this many pixels to each side. The packed radius holds values
    /// below 16, and reach.wgsl looks for points up to 16 px away.
    pub(crate) max_fill_px: f32,
    /// Smallest radius of a point, px. It covers the eight neighbours, because a spacing of just over one pixel would leave a lattice of holes. Chosen: the distance of
    /// the diagonal neighbours is 1.41 px.
    pub(crate) min_radius_px: f32,
    /// Radius of a point in halves of its spacing. The corner of a square is 1.4 half edges away; a larger value also closes surfaces
    /// that are seen obliquely. Chosen: an eighth more.
    pub(crate) radius_per_half_spacing: f32,
    /// Points of a coarser spacing than this grow no larger, m. While finer levels are missing, dots with gaps between them read better
    /// than large discs. Chosen: between the levels of 0.1 and 0.2 m.
    pub(crate) max_grown_spacing_m: f32,
    /// Smallest radius of a point that is too near to close a surface, logical px. The nearer it is, the more it shrinks from the largest
    /// radius to this one: dots with gaps read better than large discs with gaps. Chosen: about a third of [`Self::max_radius_px`].
    pub(crate) dot_radius_px: f32,
    /// Assumed spacing of a scan's points, m. The rings of a scan are farther apart, so its points are drawn slightly larger than a dot and
    /// do not close a surface. Chosen: a little less than that of the keyframes' scans (0.04 m).
    pub(crate) scan_spacing_m: f32,
}

impl Default for PointSizeConfig {
    fn default() -> Self {
        Self {
            max_radius_px: 14.0,
            max_fill_px: 15.9,
            min_radius_px: 1.45,
            radius_per_half_spacing: 1.6,
            max_grown_spacing_m: 0.12,
            dot_radius_px: 5.0,
            scan_spacing_m: 0.035,
        }
    }
}

impl PointSizeConfig {
    /// Half the spacing to which points `spacing` apart (m) grow.
    pub(crate) fn grown_half_spacing(&self, spacing: f32) -> f32 {
        0.5 * spacing.min(self.max_grown_spacing_m)
    }

    /// Upper limit of the radius (px) of points `spacing` apart (m) from a depth (m) on.
    pub(crate) fn radius_px(
        &self,
        view: &View,
        projection: &CameraProjection,
        spacing: f32,
        depth: f64,
    ) -> f32 {
        let scale = self.grown_half_spacing(spacing) * self.radius_per_half_spacing * view.options.point_size;
        let radius = scale * (projection.focal_px() / depth.max(CameraProjection::NEAR_M)) as f32;
        let max = (self.max_radius_px * view.pixels_per_point).clamp(self.min_radius_px, self.max_fill_px);
        if radius.is_nan() { self.min_radius_px } else { radius.clamp(self.min_radius_px, max) }
    }
}

/// Uniforms of a frame: `FrameUniforms` of common.wgsl.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct FrameUniforms {
    clip_from_relative: Mat4,
    /// Position of the camera in the map (m), pixels that a metre spans at a depth of 1 m.
    camera: Vec4,
    /// Width and height (px), physical pixels for each logical one, largest radius of a point in this frame (px).
    viewport: Vec4,
    /// Floor, ceiling, lowest height of the colour map and its range, m.
    heights: Vec4,
    /// Radius of a point relative to half its spacing, strength of eye-dome lighting, colour mode, height of the grid (m).
    style: Vec4,
    /// Half the extent of the grid (m), its spacing (m), smallest radius of a point (px), smallest radius of a near point (px).
    grid_shape: Vec4,
    ground_top: Vec4,
    ground_bottom: Vec4,
    plain: Vec4,
    grid: Vec4,
    colour_map: [[f32; 4]; STOPS],
}

impl FrameUniforms {
    /// `max_radius_px`: largest radius of all points of this frame; see [`PointSizeConfig::radius_px`].
    pub(crate) fn new(
        config: &PointSizeConfig,
        view: &View,
        projection: &CameraProjection,
        max_radius_px: f32,
    ) -> Self {
        let options = &view.options;
        let position = projection.camera_position().as_vec3();
        let [width, height] = view.viewport_px.map(|px| px as f32);
        let [low, high] = options.height_range;
        let mode = match options.colour_by {
            ColourBy::Height => 0.0,
            ColourBy::Intensity => 1.0,
            ColourBy::Age => 2.0,
            ColourBy::Plain => 3.0,
        };
        Self {
            clip_from_relative: projection.clip_from_relative(),
            camera: position.extend(projection.focal_px() as f32),
            viewport: Vec4::new(width, height, view.pixels_per_point, max_radius_px),
            heights: Vec4::new(options.floor, options.ceiling, low, (high - low).max(1e-3)),
            style: Vec4::new(
                options.point_size * config.radius_per_half_spacing,
                options.edl,
                mode,
                options.grid_height,
            ),
            grid_shape: grid_shape(view.camera.distance)
                .extend(config.min_radius_px)
                .extend(config.dot_radius_px * view.pixels_per_point),
            ground_top: unit_range(view.palette.ground_top),
            ground_bottom: unit_range(view.palette.ground_bottom),
            plain: unit_range(view.palette.plain),
            grid: unit_range(view.palette.grid),
            colour_map: options.colour_map.stops(),
        }
    }
}

/// Uniforms of one draw call (a tile, a scan or a mesh): the struct of draw.wgsl.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct DrawUniforms {
    /// Transform to metres relative to the camera, along the map's axes.
    pub(crate) relative_from_local: Mat4,
    /// Half the spacing (m); age between 0 and 1; side of a wipe: 0 for none, else 1 plus the share of the width that is left of it, negative for the left side; 1 to apply floor and
    /// ceiling.
    pub(crate) kind: Vec4,
    /// Tint of points and meshes; w is its share for points.
    pub(crate) tint: Vec4,
}

/// Distance of draw uniforms in their buffer, bytes: the smallest alignment that every device supports.
pub(crate) const DRAW_STRIDE: u64 = 256;

/// A colour in the shaders' form: gamma-encoded, 0 to 1.
pub(crate) fn unit_range(colour: Colour) -> Vec4 {
    let [r, g, b, a] = colour.map(|c| f32::from(c) / 255.0);
    Vec3::new(r, g, b).extend(a)
}

/// The grid reaches three camera distances. Its lines are 1, 10 or 100 m apart, about twenty across the image.
fn grid_shape(distance: f64) -> Vec2 {
    let spacing = (distance / 12.0).max(1.0).log10().floor();
    Vec2::new((distance * 3.0) as f32, 10_f64.powf(spacing) as f32)
}
