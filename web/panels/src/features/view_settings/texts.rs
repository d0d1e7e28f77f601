//! Texts of the view tools, by key.

use client_model::{ColourBy, Theme};

pub(super) const TOOLS: &str = "View tools";
pub(super) const COLOUR: &str = "Colour";
pub(super) const COLOUR_MENU: &str = "Colour of points";
pub(super) const COLOUR_HEAD: &str = "Colour by";
pub(super) const CEILING: &str = "Ceiling";
pub(super) const CEILING_MENU: &str = "Ceiling menu";
pub(super) const CUT_CEILING: &str = "Cut off the ceiling";
pub(super) const CUT_CEILING_HINT: &str = "Nothing is drawn above this height over the floor at the robot.";
pub(super) const CEILING_HEIGHT: &str = "Ceiling height";
pub(super) const POINT_SIZE: &str = "Point size";
pub(super) const POINT_SIZE_MENU: &str = "Point size menu";
pub(super) const POINT_SIZE_HINT: &str = "At 1.0 × points just close the surfaces they lie on.";
pub(super) const POINT_SIZE_SLIDER: &str = "Size of points";
pub(super) const POSE_GRAPH: &str = "Pose graph";
pub(super) const FOLLOW_ROBOT: &str = "Follow robot";
pub(super) const TOP_VIEW: &str = "Top view";
pub(super) const FIT_VIEW: &str = "Fit view";
pub(super) const BOOKMARKS: &str = "Remembered views";
pub(super) const BOOKMARKS_MENU: &str = "Remembered views menu";
pub(super) const BOOKMARK_NAME: &str = "Name of the view";
pub(super) const ADD_BOOKMARK: &str = "Remember this view";
pub(super) const THEME: &str = "Theme";
pub(super) const THEME_MENU: &str = "Theme menu";
pub(super) const KEYBOARD_SHORTCUTS: &str = "Keyboard shortcuts";

/// The state of a switch.
pub(super) fn switch(is_on: bool) -> &'static str {
    if is_on { "On" } else { "Off" }
}

pub(super) fn colour_by(colour: ColourBy) -> String {
    format!("Colour by {}", colour_by_short(colour).to_lowercase())
}

/// What gives points their colour.
pub(super) fn colour_by_short(colour: ColourBy) -> &'static str {
    match colour {
        ColourBy::Height => "Height",
        ColourBy::Intensity => "Intensity",
        ColourBy::Age => "Age",
        ColourBy::Plain => "Plain",
    }
}

pub(super) fn ceiling_height(height_m: f32) -> String {
    format!("{height_m:.1} m")
}

/// Size of points as a multiple of their spacing.
pub(super) fn point_size(factor: f32) -> String {
    format!("{factor:.1} ×")
}

pub(super) fn go_to_bookmark(name: &str) -> String {
    format!("Go to {name}")
}

pub(super) fn remove_bookmark(name: &str) -> String {
    format!("Forget {name}")
}

/// Name of a bookmark that is not named by anybody.
pub(super) fn default_bookmark_name(number: usize) -> String {
    format!("View {number}")
}

pub(super) fn theme(theme: Theme) -> String {
    format!("{} theme", theme_short(theme))
}

pub(super) fn theme_short(theme: Theme) -> &'static str {
    match theme {
        Theme::Dark => "Dark",
        Theme::Light => "Light",
        Theme::Sunlight => "Sunlight",
    }
}
