//! Texts of the control lease, by key.

pub(super) const CONTROL: &str = "Control";
pub(super) const NOBODY: &str = "nobody";
pub(super) const YOU: &str = "You";
pub(super) const TAKE: &str = "Take control";
pub(super) const TAKE_HINT: &str = "Only one person moves the robot at a time";
pub(super) const TAKE_OVER_HINT: &str = "Asks the person who has control for it; they can keep it for 5 s";
pub(super) const NEEDS_OPERATOR: &str = "This needs the role operator. Ask an admin for it";
pub(super) const RELEASE: &str = "Release control";
pub(super) const RELEASE_SHORT: &str = "Release";
pub(super) const RELEASE_HINT: &str = "Let somebody else control the robot";

pub(super) fn controlled_by(holder: &str) -> String {
    format!("{holder} controls the robot.")
}

pub(super) const KEEP: &str = "Keep control";

pub(super) fn asked_for_control(name: &str, left_s: f64) -> String {
    format!("{name} asks for control, and gets it in {:.0} s.", left_s.ceil())
}

pub(super) fn asks_for_control(holder: &str) -> String {
    format!("{holder} has been asked for control, and can keep it for 5 s.")
}
