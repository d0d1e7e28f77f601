//! Texts of the control lease, by key.

pub(super) const CONTROL: &str = "Control";
pub(super) const NOBODY: &str = "nobody";
pub(super) const YOU: &str = "You";
pub(super) const TAKE: &str = "Take control";
pub(super) const TAKE_HINT: &str = "Only one person moves the robot at a time";
pub(super) const TAKE_OVER_HINT: &str = "Takes control from the person who has it";
pub(super) const NEEDS_OPERATOR: &str = "This needs the role operator. Ask an admin for it";
pub(super) const RELEASE: &str = "Release control";
pub(super) const RELEASE_SHORT: &str = "Release";
pub(super) const RELEASE_HINT: &str = "Let somebody else control the robot";

pub(super) fn controlled_by(holder: &str) -> String {
    format!("{holder} controls the robot.")
}
