//! Texts of the settings, by key.

use crate::format;
use site_model::LocalDateTime;

pub(super) const TAB: &str = "General";
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
/// Greatest speeds while a person drives: ahead, sideways, turning.
pub(super) const BY_HAND: [&str; 3] = ["By hand, ahead", "By hand, sideways", "By hand, turning"];
/// Greatest speeds while the robot walks by itself.
pub(super) const BY_ITSELF: [&str; 3] = ["By itself, ahead", "By itself, sideways", "By itself, turning"];
/// Lengths of the body: radius, height that must be free, height of the base, step.
pub(super) const BODY: [&str; 4] =
    ["Turns within, radius", "Free height needed", "Standing height", "Highest step"];
pub(super) const PAN: &str = "Camera, pan";
pub(super) const TILT: &str = "Camera, tilt";
pub(super) const VIEW: &str = "Camera, field of view";
pub(super) const ZOOM: &str = "Camera, greatest zoom";
pub(super) const PROFILE_REMARK: &str =
    "These values come from the robot's profile and cannot be changed here.";

pub(super) const DATA_HEAD: &str = "Data";
pub(super) const USED_DISK: &str = "Disk in use";
pub(super) const FREE_DISK: &str = "Free disk";
pub(super) const RECORDINGS: &str = "Recordings";
pub(super) const RECORDINGS_REMARK: &str =
    "Beyond their share of the disk the oldest recordings are deleted.";
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

pub(super) fn angle(angle_rad: f64) -> String {
    format!("{:.0}°", angle_rad.to_degrees())
}

pub(super) fn angles([from_rad, to_rad]: [f64; 2]) -> String {
    format!("{} to {}", angle(from_rad), angle(to_rad))
}

pub(super) fn zoom(factor: f64) -> String {
    format!("{factor:.0}×")
}

/// What is used of what there is.
pub(super) fn bytes_of(used: u64, all: u64) -> String {
    format!("{} of {}", format::bytes(used), format::bytes(all))
}

pub(super) fn maps(number: usize, bytes: u64) -> String {
    format!("{number} · {}", format::bytes(bytes))
}

pub(super) fn plan(missions: usize, schedules: usize) -> String {
    format!("{missions} missions, {schedules} schedules")
}
