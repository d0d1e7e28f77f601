//! Texts of the frame, by key.

pub(super) const PRODUCT: &str = "Product";
pub(super) const PRODUCT_NAME: &str = "AutoInspect";
pub(super) const TOP_BAR: &str = "Top bar";
pub(super) const SCREENS: &str = "Screens";
pub(super) const OPEN_PANEL: &str = "Open panel";
pub(super) const CLOSE_PANEL: &str = "Close panel";
pub(super) const MESSAGES: &str = "Messages";
pub(super) const CLOSE: &str = "Close";
pub(super) const HELP_HEAD: &str = "Keyboard and pointer";
pub(super) const HELP_REMARK: &str =
    "The robot stops by itself half a second after the last command to move.";

/// Actions and their keys or gestures.
pub(super) const SHORTCUTS: [(&str, &str); 12] = [
    ("Stop motion", "Esc or Space"),
    ("Deselect, or cancel picking", "Esc"),
    ("Walk ahead, back", "W, S or ↑, ↓"),
    ("Step left, right", "A, D"),
    ("Turn left, right", "Q, E or ←, →"),
    ("Slowly", "Shift with any of these"),
    ("Orbit", "drag, or one finger"),
    ("Pan", "right drag, or two fingers"),
    ("Zoom", "wheel, or pinch"),
    ("Undo: the view, loops, the site", "Ctrl Z"),
    ("Redo", "Ctrl Shift Z"),
    ("These shortcuts", "?"),
];

/// The name of a screen with the number of things on it that nobody has looked at yet.
pub(super) fn with_count(name: &str, count: usize) -> String {
    format!("{name} {count}")
}
