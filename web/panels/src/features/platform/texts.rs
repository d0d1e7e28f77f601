//! Texts of the robot's computer, by key.

pub(super) const ROBOT: &str = "Robot";
pub(super) const HEAD: &str = "Robot computer";
pub(super) const CORE_DISCONNECTED: &str =
    "The robot's control program does not answer and is being restarted. What you see is its last report.";
pub(super) const PROCESSING: &str = "Processing";
pub(super) const PROCESSOR: &str = "Processor";
pub(super) const MEMORY: &str = "Memory";
pub(super) const FREE_DISK: &str = "Free disk";
pub(super) const CLIENTS: &str = "Clients";
pub(super) const VERSION: &str = "Version";

pub(super) fn robot_in_site(robot: &str, site: &str) -> String {
    format!("{robot} · {site}")
}

pub(super) fn real_time_factor(factor: f32) -> String {
    format!("{factor:.2} × real time")
}

pub(super) fn cores(cores: f32) -> String {
    format!("{cores:.2} cores")
}
