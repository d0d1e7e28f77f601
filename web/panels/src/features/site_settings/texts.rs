//! Texts of the settings, by key.

use crate::format;
use site_model::LocalDateTime;

pub(super) const TAB: &str = "Settings";
pub(super) const LOADING: &str = "The site has not arrived from the robot yet.";
pub(super) const SITE_HEAD: &str = "Site";
pub(super) const UNNAMED_SITE: &str = "Site";
pub(super) const NAME: &str = "Site name";
pub(super) const RENAME: &str = "Rename site";
pub(super) const ZONE: &str = "Time zone";
pub(super) const SITE_TIME: &str = "Time there";
pub(super) const ZONE_REMARK: &str = "Schedules follow the clocks of this time zone, also where they change.";
pub(super) const CHOOSE_ZONE: &str = "Choose a time zone";
pub(super) const FIND_ZONE: &str = "Find a time zone";
pub(super) const FIND_ZONE_HINT: &str = "City, such as London";
pub(super) const NO_ZONE_FOUND: &str = "No time zone has this in its name. Try the largest city nearby.";
pub(super) const MORE_ZONES: &str = "There are more. Type a part of the name.";

pub(super) const ROBOT_HEAD: &str = "Robot";
pub(super) const ROBOT_SILENT: &str = "The robot has not told anything of itself yet.";
pub(super) const ROBOT_NAME: &str = "Name";
pub(super) const SIMULATED_SITE: &str = "Simulated site";
pub(super) const FORWARD: &str = "By hand, ahead";
pub(super) const SIDEWAYS: &str = "By hand, sideways";
pub(super) const TURN: &str = "By hand, turning";
pub(super) const PROFILE_REMARK: &str =
    "These values come from the robot's profile and cannot be changed here.";

pub(super) const DATA_HEAD: &str = "Data";
pub(super) const FREE_DISK: &str = "Room for recordings";
pub(super) const MAPS: &str = "Saved maps";
pub(super) const PLAN: &str = "Plan";
pub(super) const NODES: &str = "Nodes of the graph";
pub(super) const SAVE: &str = "Save plan to a file";
pub(super) const LOAD: &str = "Load plan from a file";

pub(super) fn clock(at: LocalDateTime) -> String {
    format!("{:02}:{:02}", at.time.hour, at.time.minute)
}

pub(super) fn zone(name: &str) -> String {
    format!("Time zone {name}")
}

/// `Europe/London · 13:25`.
pub(super) fn zone_row(name: &str, at: LocalDateTime) -> String {
    format!("{} · {}", name.replace('_', " "), clock(at))
}

pub(super) fn use_zone(name: &str) -> String {
    format!("Use yours: {}", name.replace('_', " "))
}

/// `error` is a sentence without its full stop.
pub(super) fn unknown_zone(error: &str) -> String {
    format!("Schedules wait: {error}.")
}

pub(super) fn turn_rate(rate_rad_s: f64) -> String {
    format!("{:.0} °/s", rate_rad_s.to_degrees())
}

pub(super) fn maps(number: usize, bytes: u64) -> String {
    format!("{number} · {}", format::bytes(bytes))
}

pub(super) fn plan(missions: usize, schedules: usize) -> String {
    format!("{missions} missions, {schedules} schedules")
}
