//! Texts of imports, alignments and comparisons that run within limits of memory and processor time.

use crate::limited_command::{Limit, LimitedCommand};
use api::ImportStage;
use std::fmt::Display;

/// A stage of an import or of the example, beside a bar of progress.
pub fn import_stage(stage: ImportStage) -> &'static str {
    match stage {
        ImportStage::Reading => "reading",
        ImportStage::ComputingViewpoints => "finding viewpoints",
        ImportStage::Writing => "writing",
        ImportStage::Walking => "walking",
        ImportStage::MakingTopomap => "making the topological map",
    }
}

/// The name of what runs within limits, and what to do when it reaches one.
fn limited_command(command: LimitedCommand) -> (&'static str, &'static str) {
    match command {
        LimitedCommand::Import => (
            "the import",
            "thin the survey to a point every 2 or 3 cm in the program that made it, or cut it into parts; ",
        ),
        LimitedCommand::Align => ("the alignment", ""),
        LimitedCommand::Changes => ("the comparison", ""),
        LimitedCommand::MakeNormal => ("the new version of the map", ""),
        LimitedCommand::Gauge => ("reading the gauge", "give a smaller picture; "),
        LimitedCommand::PictureChanges => ("comparing the pictures", "give smaller pictures; "),
    }
}

/// It needed more memory than its limit.
pub fn out_of_memory(command: LimitedCommand, limit_mb: u64) -> String {
    let (name, remedy) = limited_command(command);
    format!(
        "{name} needs more than {limit_mb} MB of memory, its limit; {remedy}on a computer with more memory, --max-memory raises the limit"
    )
}

/// It needed more processor time than its limit.
pub fn out_of_time(command: LimitedCommand, limit_minutes: f64) -> String {
    let (name, remedy) = limited_command(command);
    format!(
        "{name} needs more than {limit_minutes} minutes of processor time, its limit; {remedy}--max-minutes raises the limit"
    )
}

/// It ended in another way than by a limit.
pub fn limited_command_ended(command: LimitedCommand, status: &dyn Display) -> String {
    let (name, _) = limited_command(command);
    let remedy = match command {
        LimitedCommand::Import => {
            "the file is damaged in a way that this program does not expect; export it again"
        }
        LimitedCommand::Align | LimitedCommand::MakeNormal => {
            "a map is damaged in a way that this program does not expect; make it again"
        }
        LimitedCommand::Changes => {
            "a visit is damaged in a way that this program does not expect; compare others"
        }
        LimitedCommand::Gauge | LimitedCommand::PictureChanges => {
            "a picture is damaged in a way that this program does not expect; take it again"
        }
    };
    format!("{name} ended before it was done ({status}): {remedy}")
}

/// A process that the core has started has reached a limit.
pub fn limit_on_robot(command: LimitedCommand, limit: Limit) -> &'static str {
    match (command, limit) {
        (LimitedCommand::Import, Limit::Memory) => {
            "It needs more memory than an import may take. Thin the survey to a point every 2 or 3 cm, or cut it into parts."
        }
        (LimitedCommand::Import, Limit::Time) => {
            "It needs more time than an import may take. Thin the survey to a point every 2 or 3 cm, or cut it into parts."
        }
        (LimitedCommand::Align, Limit::Memory) => {
            "It needs more memory than an alignment may take on the robot. Align the map on another computer with autoinspect align --max-memory."
        }
        (LimitedCommand::Align, Limit::Time) => {
            "It needs more time than an alignment may take on the robot. Pick points in both maps, which takes less."
        }
        (LimitedCommand::Changes, Limit::Memory) => {
            "It needs more memory than a comparison may take on the robot. Compare the clouds of the runs on another computer with autoinspect changes."
        }
        (LimitedCommand::Changes, Limit::Time) => {
            "It needs more time than a comparison may take on the robot. Compare the clouds of the runs on another computer with autoinspect changes."
        }
        (LimitedCommand::Gauge, Limit::Memory) => {
            "The gauge was not read, because that needs more memory than it may take on the robot. Let the camera take smaller pictures."
        }
        (LimitedCommand::Gauge, Limit::Time) => {
            "The gauge was not read, because that needs more time than it may take on the robot. Let the camera take smaller pictures."
        }
        (LimitedCommand::PictureChanges, Limit::Memory) => {
            "The pictures were not compared, because that needs more memory than it may take on the robot. Let the camera take smaller pictures."
        }
        (LimitedCommand::PictureChanges, Limit::Time) => {
            "The pictures were not compared, because that needs more time than it may take on the robot. Let the camera take smaller pictures."
        }
        (LimitedCommand::MakeNormal, Limit::Memory) => {
            "It needs more memory than a new version of a map may take on the robot. Make it on another computer with autoinspect make-normal."
        }
        (LimitedCommand::MakeNormal, Limit::Time) => {
            "It needs more time than a new version of a map may take on the robot. Make it on another computer with autoinspect make-normal."
        }
    }
}

/// What was read of a gauge came in another form than expected.
pub fn gauge_not_understood(error: &dyn Display) -> String {
    format!("The gauge was not read, because the answer cannot be understood: {error}.")
}

/// What was found of two pictures came in another form than expected.
pub fn comparison_not_understood(error: &dyn Display) -> String {
    format!("The pictures were not compared, because the answer cannot be understood: {error}.")
}

/// The needle of a gauge gives no value.
pub fn gauge_unsure(explanation: &str) -> String {
    format!("The gauge was not read: {explanation}.")
}

/// The scale of a gauge is too small in its picture.
pub fn gauge_too_small(radius_px: f64, least_px: f64) -> String {
    format!(
        "The gauge was not read: its scale has a radius of {radius_px:.0} pixels, and {least_px:.0} are needed. Use more zoom."
    )
}

/// A picture of a gauge does not fit the one in which the gauge was described.
pub fn gauge_not_aligned(explanation: &str) -> String {
    format!(
        "The gauge was not read, because the picture does not fit the one in which it was described: {explanation}."
    )
}

/// A comparison whose outcome cannot be read.
pub fn comparison_not_read(error: &dyn Display) -> String {
    format!("Its result could not be read ({error}).")
}

/// Names of the file of an import, and of the map that it is aligned with, in its errors.
pub const UPLOADED_FILE: &str = "The file";
pub const FRAME_OF_IMPORT: &str = "that map";

/// A client cancelled it.
pub const IMPORT_CANCELLED: &str = "It was cancelled.";

/// It ended without an error message.
pub const IMPORT_ENDED_EARLY: &str =
    "It ended before it was done: there may be too little memory on this computer.";

/// The process did not start.
pub fn import_not_started(error: &dyn Display) -> String {
    format!("It cannot be started: {error}.")
}

/// The system does not say how the process ended.
pub fn import_outcome_unknown(error: &dyn Display) -> String {
    format!("What became of it is not known: {error}.")
}
