//! Texts of the screen, by key.

pub(super) const NAME: &str = "Live";
pub(super) const SIDE_CARD: &str = "Robot panel";
