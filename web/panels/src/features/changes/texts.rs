//! Texts of changes between visits, by key.

use crate::format;
use crate::name_field::NameFieldTexts;
use site_model::{ReviewState, SceneChange, SceneChangeKind};

pub(super) const TAB: &str = "Changes";
pub(super) const HEAD: &str = "What has changed";
pub(super) const EMPTY: &str =
    "Nothing here. After each run the robot compares what it saw with an earlier run, or with the map.";
/// By which decision the list is filtered.
pub(super) const REVIEWS: [(&str, usize); 3] = [("New", 0), ("Watched", 1), ("Any state", 2)];
/// By which kind.
pub(super) const KINDS: [(&str, usize); 4] = [("Any kind", 0), ("Appeared", 1), ("Removed", 2), ("Moved", 3)];
/// By which size.
pub(super) const SIZES: [(&str, usize); 3] = [("Any size", 0), ("From 0.3 m", 1), ("From 1 m", 2)];
/// By the time since it was last seen.
pub(super) const AGES: [(&str, usize); 3] = [("Any age", 0), ("Last day", 1), ("Last week", 2)];
pub(super) const ZONE: &str = "Zone";
pub(super) const WHOLE_SITE: &str = "Whole site";
pub(super) const PLACE: &str = "Middle";
pub(super) const SIZE: &str = "Size";
pub(super) const CONFIDENCE: &str = "Confidence";
pub(super) const FIRST_SEEN: &str = "First seen";
pub(super) const TIMES_SEEN: &str = "Times seen";
pub(super) const STATE: &str = "State";
pub(super) const SHOW: &str = "Show the place";
pub(super) const ACKNOWLEDGE: &str = "Acknowledge";
pub(super) const WATCH: &str = "Watch";
pub(super) const REASON_FIELD: NameFieldTexts =
    NameFieldTexts { field: "Reason to dismiss", rename: "Dismiss the change", rename_short: "Dismiss" };
pub(super) const COMMENT_FIELD: NameFieldTexts =
    NameFieldTexts { field: "Comment", rename: "Keep the comment", rename_short: "Keep comment" };

/// A row of the list: `Appeared · 0.6 x 0.4 x 1.0 m · 2 h 05 old`.
pub(super) fn row(change: &SceneChange, age_s: f64) -> String {
    let kind = match change.kind {
        SceneChangeKind::Appeared => 1,
        SceneChangeKind::Removed => 2,
        SceneChangeKind::Moved { .. } => 3,
    };
    format!("{} · {} · {}", KINDS[kind].0, size(change), format::age(age_s))
}

/// A probability; one that is not certain never reads as 100 %.
pub(super) fn confidence(confidence: f64) -> String {
    if confidence > 0.99 { "over 99 %".to_owned() } else { format::percent(confidence as f32) }
}

pub(super) fn size(change: &SceneChange) -> String {
    let [length, width, height] = change.place.size_m.map(|side| format::decimal(side, 1));
    format!("{length} x {width} x {height} m")
}

pub(super) fn state(review: &ReviewState) -> String {
    match review {
        ReviewState::New => "new".to_owned(),
        ReviewState::Acknowledged => "acknowledged".to_owned(),
        ReviewState::Dismissed { reason } => format!("dismissed: {reason}"),
        ReviewState::Watched => "watched".to_owned(),
    }
}
