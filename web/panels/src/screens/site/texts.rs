//! Texts of the screen, by key.

pub(super) const NAME: &str = "Site";
pub(super) const SIDE_CARD: &str = "Site panel";
