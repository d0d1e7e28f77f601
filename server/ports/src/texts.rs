//! Texts for people, by key, English.

/// Refusal of a fault by a robot that is not simulated.
pub const REAL_ROBOT_HAS_NO_FAULTS: &str =
    "This robot is a real one: nothing can be made to go wrong with it from here.";
