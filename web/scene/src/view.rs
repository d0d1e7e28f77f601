//! What a frame should look like: the camera, the options of the user, the colours of the theme.

use crate::camera::CameraPose;
use crate::ramp::Ramp;

/// Red, green, blue and opacity, gamma-encoded, not premultiplied.
pub type Colour = [u8; 4];

/// Everything that decides how the scene is drawn, apart from what is in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// From where.
    pub camera: CameraPose,
    /// Size of the picture in physical pixels.
    pub viewport_px: [u32; 2],
    /// Physical pixels for each logical one; widths of lines and markers are logical.
    pub pixels_per_point: f32,
    /// Choices of the user.
    pub options: Options,
    /// Colours of the theme.
    pub palette: Palette,
}

impl View {
    /// The same view as it is drawn: at its resolution, within a texture's limits.
    pub(crate) fn as_drawn(&self, side_max_px: u32) -> Self {
        let wanted = self.options.resolution;
        let scale = if wanted.is_nan() { 1.0 } else { wanted.clamp(0.25, 1.0) };
        let side = |px: u32| ((px as f32 * scale).round() as u32).clamp(1, side_max_px.max(1));
        let pixels_per_point = self.pixels_per_point * scale;
        Self { viewport_px: self.viewport_px.map(side), pixels_per_point, ..*self }
    }
}

/// What decides the colour of a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColourBy {
    /// Height in the map.
    #[default]
    Height,
    /// What the sensor measured.
    Intensity,
    /// When the tile was made.
    Age,
    /// [`Palette::plain`].
    Plain,
}

/// Choices of the user.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// What decides the colour of a point.
    pub colour_by: ColourBy,
    /// Colours for heights, intensities and ages.
    pub ramp: Ramp,
    /// Heights at the two ends of the ramp, metres; equal or reversed ends mean the lowest.
    pub height_range: [f32; 2],
    /// Times at the two ends of the ramp, seconds on the clock of [`crate::PointBlock::stamp`].
    pub age_range: [f64; 2],
    /// Points lower than this are not drawn and cannot be picked, metres.
    pub floor: f32,
    /// Points higher than this are not drawn and cannot be picked, metres.
    pub ceiling: f32,
    /// Size of points relative to their spacing; 1 just closes a surface seen from the front.
    pub point_size: f32,
    /// Strength of eye-dome lighting; 0 turns it off, 1 is usual.
    pub edl: f32,
    /// Whether the ground grid is drawn, at height [`Options::grid_height`].
    pub grid: bool,
    /// Height of the ground grid, metres.
    pub grid_height: f32,
    /// Most points in a frame.
    pub point_budget: u32,
    /// Whether the tiles are drawn and can be picked.
    pub map: bool,
    /// Whether the current scan is drawn.
    pub live_scan: bool,
    /// Pixels drawn for each pixel shown, along each side, between 0.25 and 1; less is quicker. See [`crate::Pace`].
    pub resolution: f32,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            colour_by: ColourBy::Height,
            ramp: Ramp::Muted,
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
            resolution: 1.0,
        }
    }
}

/// Colours of the theme. The caller fills it from its own table of tokens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Palette {
    /// Background at the top of the picture.
    pub ground_top: Colour,
    /// Background at the bottom.
    pub ground_bottom: Colour,
    /// Points when [`ColourBy::Plain`].
    pub plain: Colour,
    /// What points of the current scan are mixed with; opacity is the share of this colour.
    pub live: Colour,
    /// Ground grid.
    pub grid: Colour,
    /// Nodes of the graph that are known well.
    pub node: Colour,
    /// Nodes of the graph that are known vaguely.
    pub doubtful: Colour,
    /// Rim around nodes and markers.
    pub outline: Colour,
    /// Edges of the graph.
    pub edge: Colour,
    /// Loops that are edges of the graph.
    pub loop_closed: Colour,
    /// Loops that wait for others.
    pub loop_open: Colour,
    /// Pairs of nodes that are no loops.
    pub loop_rejected: Colour,
    /// Two nodes that stand out together and the scans that are compared, the older first.
    pub pair: [Colour; 2],
    /// The way the robot came.
    pub trajectory: Colour,
    /// The way the robot will go, goal and selection.
    pub accent: Colour,
    /// The robot.
    pub robot: Colour,
    /// The robot when it needs attention.
    pub bad: Colour,
}
