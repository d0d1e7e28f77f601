//! Texts of the screen, by key.

pub(super) const NAME: &str = "Missions";
pub(super) const SIDE_CARD: &str = "Missions panel";
