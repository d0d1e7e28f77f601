//! Stack and simulator in one thread, faster than real time, and a check that replaying a log gives the same bits.

mod digest;
mod walk;

pub use digest::{Digest, Stepper, replay, replay_with};
pub use walk::{CalledAction, JobPace, Lockstep};

#[cfg(test)]
mod contact_tests;
#[cfg(test)]
mod day;
#[cfg(test)]
mod dock_tests;
#[cfg(test)]
mod docking_tests;
#[cfg(test)]
mod edge_tests;
#[cfg(test)]
mod extend_tests;
#[cfg(test)]
mod foreign_tests;
#[cfg(test)]
mod generated_tests;
#[cfg(test)]
mod job_tests;
#[cfg(test)]
mod localise_tests;
#[cfg(test)]
mod loops_tests;
#[cfg(test)]
mod mission_tests;
#[cfg(test)]
mod site_mission_tests;
#[cfg(test)]
mod tests;
