//! Missions on simulated sites in lockstep, scored by the truth: a site with its map and its topological map ([`MissionSite`]), a robot on its dock
//! ([`MissionDay`]), and what became of a mission ([`MissionScore`]) against the bars ([`MissionTotals`]).

mod day;
mod score;
mod site;
mod totals;

pub use day::{MissionDay, Moment};
pub use score::{MissionScore, PictureScore, docked_error, run_mission};
pub use site::{InspectionTarget, MISSION, MissionSite, PlannedMission, Plate};
pub use totals::MissionTotals;

#[cfg(test)]
mod nightly {
    use super::*;
    use crate::mapped_folder::MapPlan;

    /// A mission of three pictures among four people on a site that is mapped for this time, with all bars.
    fn check_mission(name: &str, minutes: f64) {
        let work = tempfile::tempdir().expect("a folder");
        let plan = MapPlan { seed: 1, minutes, columns: 200, people: 4 };
        let source = name.parse().expect("a site");
        let mapped = MissionSite::new(&source, work.path(), &plan).expect("a map");
        let score = run_mission(&mapped, 1, 3, 200, 4).expect("a mission");
        assert_eq!(MissionTotals::of([&score]).missed(), [""; 0], "{name}: {score:?}");
    }

    #[test]
    fn a_mission_among_people_meets_the_bars_in_the_hall() {
        check_mission("b1", 2.5);
    }

    #[test]
    fn a_mission_among_people_meets_the_bars_in_the_ring() {
        check_mission("torus", 2.5);
    }

    #[test]
    fn a_mission_among_people_meets_the_bars_over_stairs() {
        check_mission("plant", 4.0);
    }

    #[test]
    fn a_mission_among_people_meets_the_bars_in_rooms_that_look_alike() {
        check_mission("twins", 2.5);
    }
}
