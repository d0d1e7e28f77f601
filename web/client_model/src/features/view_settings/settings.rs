//! How things look: kept from visit to visit, and undoable. The names are those of the browser's storage.

use serde::{Deserialize, Serialize};

/// A screen of the page, named by its folder in `web/panels/src/screens`. Which screens there are is a matter of the panels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Screen(pub &'static str);

/// What gives points their colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ColourBy {
    /// Height above the map's origin.
    #[default]
    Height,
    /// Strength of the LiDAR's echo.
    Intensity,
    /// Time since the place was seen.
    Age,
    /// One colour; shading shows the shape.
    Plain,
}

impl ColourBy {
    /// All, in the order they are offered.
    pub const ALL: [Self; 4] = [Self::Height, Self::Intensity, Self::Age, Self::Plain];
}

/// Colours of the whole client.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Theme {
    /// For rooms.
    #[default]
    Dark,
    /// For offices.
    Light,
    /// For a tablet outdoors: contrast 10:1, thick lines, no transparency.
    Sunlight,
}

impl Theme {
    /// All, in the order they are offered.
    pub const ALL: [Self; 3] = [Self::Dark, Self::Light, Self::Sunlight];
}

/// A camera that looks at a target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CameraPose {
    /// What it looks at, map frame, metres.
    pub target: [f64; 3],
    /// Distance from the target, metres.
    pub distance: f64,
    /// Heading of the line of sight, radians, counter-clockwise from the map's x axis.
    pub yaw: f64,
    /// Angle of the line of sight below the horizontal, radians.
    pub pitch: f64,
}

/// A saved camera.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bookmark {
    /// Its name.
    pub name: String,
    /// Its camera.
    pub camera: CameraPose,
}

/// Everything about how things look.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ViewSettings {
    /// What gives points their colour.
    pub colour: ColourBy,
    /// Whether points above [`Self::ceiling_m`] are cut off.
    pub cut_ceiling: bool,
    /// Height above the ground at the robot, metres, above which nothing is drawn.
    pub ceiling_m: f32,
    /// Size of points relative to their spacing; at 1 they just close a surface.
    pub point_size: f32,
    /// Whether the pose graph is drawn.
    pub graph: bool,
    /// Whether the camera follows the robot.
    pub follow: bool,
    /// Colours of the client.
    pub theme: Theme,
    /// Saved cameras.
    pub bookmarks: Vec<Bookmark>,
}

impl Default for ViewSettings {
    fn default() -> Self {
        Self {
            colour: ColourBy::Height,
            cut_ceiling: true,
            ceiling_m: 2.2,
            point_size: 1.0,
            graph: true,
            follow: true,
            theme: Theme::Dark,
            bookmarks: Vec::new(),
        }
    }
}
