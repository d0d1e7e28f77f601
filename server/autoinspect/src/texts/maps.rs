//! Errors of commands that make or read a map.

use std::fmt::Display;
use std::path::Path;

/// A folder without map.json.
pub fn no_map(folder: &Path, error: &dyn Display) -> String {
    format!(
        "{} holds no map ({error} for its map.json); give a folder that `autoinspect map --out` wrote",
        folder.display()
    )
}

/// A map with missing cloud files.
pub fn missing_clouds(map: &Path) -> String {
    format!("{} has no clouds for some of its keyframes; make the map again", map.display())
}

/// No scan of the recordings was localised.
pub fn robot_not_found(map: &Path) -> String {
    format!("the robot was not found in {}", map.display())
}

/// A recording that gave no map.
pub fn no_map_made(reason: &str) -> String {
    format!("no map was made: {reason}")
}

/// The default reason of [`no_map_made`].
pub const NO_USABLE_MESSAGE: &str = "no message could be used";
