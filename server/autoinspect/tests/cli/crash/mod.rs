//! The crash test: the program is killed at random moments and its files are damaged, and nothing that it was given may be lost.
//!
//! `cargo xtask test crash` runs it with many kills and all damages; the tests of every change are a sample. Random numbers come from a seed, so
//! that a case can be repeated. How far the program has come when it is killed depends on the computer too.

mod case;
mod chain;
mod client;
mod damages;
mod inventory;
mod mission_kills;
mod options;
mod report;
mod situations;
mod target;

use case::CrashSituation;
use chain::kill_repeatedly;

#[test]
fn mapping_survives_kills() {
    kill_repeatedly(CrashSituation::Mapping);
}

#[test]
fn saving_survives_kills() {
    kill_repeatedly(CrashSituation::Saving);
}

#[test]
fn localising_survives_kills() {
    kill_repeatedly(CrashSituation::Localising);
}

#[test]
fn importing_survives_kills() {
    kill_repeatedly(CrashSituation::Importing);
}

#[test]
fn idle_survives_kills() {
    kill_repeatedly(CrashSituation::Idle);
}

/// Of the kills of missions, those in `crate::missions` are a sample.
mod nightly {
    #[test]
    fn missions_survive_kills() {
        super::mission_kills::kill_missions();
    }
}

#[test]
fn damage_to_files_is_named_and_loses_nothing() {
    damages::damage_files();
}
