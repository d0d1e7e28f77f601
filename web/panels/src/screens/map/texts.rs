//! Texts of the screen, by key.

pub(super) const NAME: &str = "Map";
pub(super) const SIDE_CARD: &str = "Map panel";
