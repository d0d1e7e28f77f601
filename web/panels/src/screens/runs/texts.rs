//! Texts of the screen, by key.

pub(super) const NAME: &str = "Runs";
pub(super) const SIDE_CARD: &str = "Runs panel";
