//! Texts of the screen, by key.

pub(super) const NAME: &str = "Settings";
pub(super) const SIDE_CARD: &str = "Settings panel";
