//! Missions on simulated sites in lockstep, scored by the truth: a site with its map and its topological map ([`MissionSite`]), a robot on its dock
//! ([`MissionDay`]), and what became of a mission ([`MissionScore`]) against the bars ([`MissionTotals`]).

mod day;
mod score;
mod site;
mod totals;

pub use day::MissionDay;
pub use score::{MissionScore, PictureScore, docked_error, run_mission};
pub use site::{InspectionTarget, MISSION, MissionSite, PlannedMission};
pub use totals::MissionTotals;
