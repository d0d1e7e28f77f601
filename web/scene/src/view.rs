//! The view of a frame: camera, options of the user, colours of the theme.

use crate::camera_pose::CameraPose;
use crate::colour_map::ColourMap;

/// Red, green, blue and opacity, gamma-encoded, not premultiplied.
pub type Colour = [u8; 4];

/// Inputs of a frame other than the scene's content.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Pose of the camera.
    pub camera: CameraPose,
    /// Size of the image, physical px.
    pub viewport_px: [u32; 2],
    /// Physical pixels for each logical one. Widths of lines and markers are in logical pixels.
    pub pixels_per_point: f32,
    /// Options of the user.
    pub options: Options,
    /// Colours of the theme.
    pub palette: Palette,
}

impl View {
    /// The view at the size of its render targets: scaled by its resolution, within the largest side of a texture.
    pub(crate) fn as_drawn(&self, max_side_px: u32) -> Self {
        let resolution = self.options.resolution;
        let scale = if resolution.is_nan() { 1.0 } else { resolution.clamp(0.25, 1.0) };
        let side = |px: u32| ((px as f32 * scale).round() as u32).clamp(1, max_side_px.max(1));
        let pixels_per_point = self.pixels_per_point * scale;
        Self { viewport_px: self.viewport_px.map(side), pixels_per_point, ..*self }
    }
}

/// The quantity that colours show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColourBy {
    /// Height in the map.
    #[default]
    Height,
    /// Measured intensity.
    Intensity,
    /// Time of measurement.
    Age,
    /// No quantity: all points have [`Palette::plain`].
    Plain,
}

/// Display options of the user.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The quantity that the points' colours show.
    pub colour_by: ColourBy,
    /// Colour map of heights, intensities and ages.
    pub colour_map: ColourMap,
    /// Heights at the two ends of the colour map, m, map frame. If they are not in ascending order, the range is 1 mm from the first.
    pub height_range: [f32; 2],
    /// Times at the two ends of the colour map, s, on the clock of [`crate::PointBlock::stamp`].
    pub age_range: [f64; 2],
    /// Points lower than this (m, map frame) are neither drawn nor picked.
    pub floor: f32,
    /// Points higher than this (m, map frame) are neither drawn nor picked.
    pub ceiling: f32,
    /// Size of points relative to their spacing. At 1, a surface that is seen from the front has no gaps.
    pub point_size: f32,
    /// Strength of eye-dome lighting; 0 turns it off, 1 is the default.
    pub edl: f32,
    /// Whether the ground grid is drawn, at height [`Options::grid_height`].
    pub grid: bool,
    /// Height of the ground grid, m, map frame.
    pub grid_height: f32,
    /// Largest number of points in a frame.
    pub point_budget: u32,
    /// Whether tiles are drawn and picked.
    pub map: bool,
    /// Whether the current scan is drawn.
    pub live_scan: bool,
    /// Where the objects of the later visit begin ([`crate::Renderer::set_changed`]), share of the width from the left; none: both are drawn everywhere.
    pub wipe: Option<f32>,
    /// Whether robot, lines and markers are drawn.
    pub overlay: bool,
    /// Focal length, in those of the usual field of view ([`crate::CameraProjection::TAN_HALF_FOV`]).
    pub magnification: f64,
    /// Rendered pixels for each pixel of the screen, along each side, between 0.25 and 1; less is faster. See [`crate::FramePacer`].
    pub resolution: f32,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            colour_by: ColourBy::Height,
            colour_map: ColourMap::Muted,
            height_range: [0.0, 3.0],
            age_range: [0.0, 1.0],
            floor: f32::MIN,
            ceiling: f32::MAX,
            point_size: 1.0,
            edl: 1.0,
            grid: false,
            grid_height: 0.0,
            point_budget: 1_500_000,
            map: true,
            live_scan: true,
            wipe: None,
            overlay: true,
            magnification: 1.0,
            resolution: 1.0,
        }
    }
}

/// Colours of the theme. The caller fills it from its table of tokens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Palette {
    /// Background at the top of the image.
    pub ground_top: Colour,
    /// Background at the bottom.
    pub ground_bottom: Colour,
    /// Points when [`ColourBy::Plain`].
    pub plain: Colour,
    /// Tint of the current scan's points; its opacity is its share.
    pub live: Colour,
    /// Ground grid.
    pub grid: Colour,
    /// Certain nodes of the graph.
    pub node: Colour,
    /// Uncertain nodes of the graph.
    pub uncertain: Colour,
    /// Rim around nodes and markers.
    pub outline: Colour,
    /// Edges of the graph.
    pub edge: Colour,
    /// Loops that are edges of the graph.
    pub loop_closed: Colour,
    /// Loops under test.
    pub loop_open: Colour,
    /// Rejected loops.
    pub loop_rejected: Colour,
    /// Two highlighted nodes and the scans that are compared, the older first.
    pub pair: [Colour; 2],
    /// Objects of the earlier and of the later visit.
    pub changed: [Colour; 2],
    /// The path that the robot has walked.
    pub trajectory: Colour,
    /// The path ahead, goal and selection.
    pub accent: Colour,
    /// The robot.
    pub robot: Colour,
    /// The robot when it needs attention.
    pub bad: Colour,
}
