//! Error messages and notes of the commands, by key: a file for each command, and here what several share. English; an error names what is
//! wrong, the file and the remedy. What a command prints when it succeeds is in `summaries.rs`, and what
//! `changes` says of depth images and `gauge` of dials in their own folders.

mod account;
mod align;
mod arguments;
mod changes;
mod example;
mod export;
mod limits;
mod maps;
mod optimise;
mod patch;
mod pictures;
mod robot_profile;
mod simulation;
mod topomap;
mod trajectory;
mod up;
mod verify;

pub use account::*;
pub use align::*;
pub use arguments::*;
pub use changes::*;
pub use example::*;
pub use export::*;
pub use limits::*;
pub use maps::*;
pub use optimise::*;
pub use patch::*;
pub use pictures::*;
pub use robot_profile::*;
pub use simulation::*;
pub use topomap::*;
pub use trajectory::*;
pub use up::*;
pub use verify::*;

use std::fmt::Display;
use std::path::Path;

/// A file or folder that cannot be written.
pub fn cannot_write(path: &Path, error: &dyn Display) -> String {
    format!("{} cannot be written: {error}", path.display())
}

/// A folder that cannot be created.
pub fn cannot_create(path: &Path, error: &dyn Display) -> String {
    format!("{} cannot be made: {error}", path.display())
}

/// An input of an unknown format.
pub fn unreadable_input(path: &Path, error: &dyn Display) -> String {
    format!("{}: {error}", path.display())
}

/// An input file that is missing or damaged.
pub fn could_not_be_read(path: &Path, reason: &str) -> String {
    format!("{} could not be read: {reason}", path.display())
}

/// A cloud without points.
pub fn no_points(path: &Path) -> String {
    format!("{} holds no points", path.display())
}

/// The folder for the results has other files.
pub fn folder_in_use(out: &Path) -> String {
    format!("{} holds other things; choose an empty folder or one of an earlier map", out.display())
}

/// The folder for the results is an input.
pub fn result_is_input(out: &Path) -> String {
    format!("{} is one of the maps; choose another folder for the result", out.display())
}
