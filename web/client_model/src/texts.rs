//! Sentences of the model that operators read, by key. English; a translation replaces this file.

use api::{Command, GoalKind};
use site_model::LocalDate;

/// Shown when the stop command could not be sent.
pub(crate) const STOP_NOT_SENT: &str = "Not connected: the stop has not reached the robot yet. It is being asked for another way, and sent again as soon as the link is back. Use the stop button on the robot.";

/// Shown when a message could not be decoded.
pub(crate) const MESSAGE_UNREADABLE: &str = "The server sent something this page cannot read. Reload the page; if that does not help, server and page are of different versions.";

/// Shown when another client deleted the saved map on the screen.
pub(crate) const VIEWED_MAP_DELETED: &str = "The map on the screen was moved to the bin.";

/// Name of a map that is not listed.
pub(crate) const UNNAMED_MAP: &str = "Map";

/// Name of a new dock.
pub(crate) fn dock_name(number: usize) -> String {
    format!("Dock {number}")
}

/// Name of the node in front of a new dock.
pub(crate) fn before_dock_name(dock: &str) -> String {
    format!("Before {}", dock.to_lowercase())
}

/// Name of a new zone.
pub(crate) fn zone_name(number: usize) -> String {
    format!("Zone {number}")
}

/// Name of a new monitor.
pub(crate) fn monitor_name(number: usize) -> String {
    format!("Monitor {number}")
}

/// Name of a new asset.
pub(crate) fn asset_name(number: usize) -> String {
    format!("Asset {number}")
}

/// Shown when a draft cannot be published yet.
pub(crate) const DRAFT_CONFLICTS: &str = "Somebody else has changed objects of the draft. Choose on the tab Draft which of the two counts, then publish again.";

/// Shown when the site is edited before it has come.
pub(crate) const SITE_NOT_LOADED: &str =
    "The robot has not sent its graph, missions and schedules yet. Wait a moment and try again.";

/// Shown when an edit is longer than the server accepts.
pub(crate) const EDIT_TOO_LONG: &str = "This changes too much at once. Change a part of it first.";

/// Shown when the robot refused an edit. `reason` is a sentence without its full stop.
pub(crate) fn edit_refused(reason: &str) -> String {
    format!("Your change was taken back: {reason}.")
}

/// Shown when the robot does not accept an edit. `reason` is a sentence.
pub(crate) fn edit_rejected(reason: &str) -> String {
    format!("Your change was taken back. {reason}")
}

/// Shown when a step could not be undone or redone. `reason` is a sentence without its full stop.
pub(crate) fn undo_refused(reason: &str) -> String {
    format!("This cannot be undone: {reason}.")
}

/// Shown when a file of missions and schedules cannot be loaded. `reason` is a sentence without its full stop.
pub(crate) fn plan_file_unusable(name: &str, reason: &str) -> String {
    format!("{name} was not loaded: {reason}.")
}

/// Shown when a file has nothing that the site lacks.
pub(crate) fn plan_file_known(name: &str) -> String {
    format!("The site has all missions and schedules of {name} already.")
}

/// Months, short.
const MONTHS: [&str; 12] =
    ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];

/// Name of a schedule that one occurrence of `schedule` was made into. `day`: that of the occurrence.
pub(crate) fn single_occurrence(schedule: &str, day: LocalDate) -> String {
    let month = MONTHS.get(usize::from(day.month.wrapping_sub(1))).copied().unwrap_or_default();
    format!("{schedule}, instead of {} {month}", day.day)
}

/// Name of this client for other operators. `number` is part of its id.
pub(crate) fn operator_name(number: u16) -> String {
    format!("Operator {number:04x}")
}

/// Reason for which this page refuses a server.
pub(crate) fn version_mismatch(server: u16, page: u16) -> String {
    format!("The server speaks version {server} and this page version {page}. Reload the page.")
}

/// A command that may be lost. `name` as in [`command_name`].
pub(crate) fn command_expired(name: &str) -> String {
    format!("{name} may not have reached the robot: the link was lost. Try again.")
}

/// Shown when loops cannot be decided on because `holder` controls the robot.
pub(crate) fn loops_need_control(holder: &str) -> String {
    format!("{holder} controls the robot. Take control to decide on loops.")
}

/// Shown when a proposed loop was not answered.
pub(crate) fn proposal_expired(from: u32, to: u32) -> String {
    format!("No result of the comparison of keyframes {from} and {to}. Propose them again.")
}

/// Name of a map that is `map` in the frame of `reference`.
pub(crate) fn aligned_map_name(map: &str, reference: &str) -> String {
    format!("{map} on {reference}")
}

/// Name of a version of `map` in which changes are normal.
pub(crate) fn normal_map_name(map: &str) -> String {
    const SUFFIX: &str = ", new normal";
    format!("{}{SUFFIX}", map.strip_suffix(SUFFIX).unwrap_or(map))
}

/// Shown when a file could not be uploaded. `reason` is a sentence.
pub(crate) fn upload_failed(file: &str, reason: &str) -> String {
    format!("{file} was not sent: {reason}")
}

/// What a command does, as the subject of a sentence.
pub(crate) fn command_name(command: &Command) -> &'static str {
    match command {
        Command::TakeControl { .. } => "Taking control",
        Command::ReleaseControl => "Giving control back",
        Command::RefuseTakeOver => "Keeping control",
        Command::StartMapping(_) => "Starting the mapping",
        Command::ExtendMap { .. } => "Extending the map",
        Command::FinishMapping { .. } => "Saving the map",
        Command::DiscardMapping => "Discarding the map",
        Command::Teleoperate(_) => "Driving",
        Command::StartGoal { kind: GoalKind::WalkTo(_), .. } => "Walking there",
        Command::StartGoal { kind: GoalKind::Relocalise, .. } => "Relocalising",
        Command::StartGoal { kind: GoalKind::GoToNode(_), .. } => "Going to the node",
        Command::StartGoal { kind: GoalKind::GoToDock(_), .. } => "Going to the dock",
        Command::StartGoal { kind: GoalKind::Undock, .. } => "Leaving the dock",
        Command::Mission(_) => "The mission",
        Command::CancelGoal(_) => "Cancelling the goal",
        Command::StopMotion => "Stop motion",
        Command::AllowMotion => "Allowing motion",
        Command::AcceptLoop { .. } => "Accepting the loop",
        Command::RejectLoop { .. } => "Rejecting the loop",
        Command::ProposeLoop { .. } => "Proposing the loop",
        Command::Localise { .. } => "Using the map",
        Command::ImportMap { .. } => "Importing the map",
        Command::AlignMap { .. } => "Aligning the map",
        Command::SaveInterruptedSession { .. } => "Saving the interrupted map",
        Command::DiscardInterruptedSession(_) => "Discarding the interrupted map",
        Command::RenameMap { .. } => "Renaming the map",
        Command::DeleteMap(_) => "Deleting the map",
        Command::RestoreMap(_) => "Restoring the map",
        Command::DeleteMapPermanently(_) => "Deleting the map for good",
        Command::DeleteUpload(_) => "Deleting the file",
        Command::CancelImport(_) => "Cancelling the import",
        Command::GenerateTopomap { .. } => "Making the topological map",
        Command::MakeExample { .. } => "Making the example",
        Command::MakeNormal { .. } => "Making changes normal",
        Command::InjectFault(_) => "The simulated fault",
        Command::LeaveMap => "Leaving the map",
    }
}
