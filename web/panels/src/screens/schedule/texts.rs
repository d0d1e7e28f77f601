//! Texts of the screen, by key.

pub(super) const NAME: &str = "Schedule";
pub(super) const SIDE_CARD: &str = "Schedule panel";
