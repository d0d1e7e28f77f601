//! Texts of changes between visits, by key.

use crate::format;
use crate::name_field::NameFieldTexts;
use site_model::{Movement, ReviewState, SceneChange, SceneChangeKind};

pub(super) const TAB: &str = "Changes";
pub(super) const HEAD: &str = "What has changed";
const EMPTY: &str =
    "Nothing here. After each run the robot compares what it saw with earlier runs, or with the map.";
/// The button that unfolds the filters.
pub(super) const FILTERS: &str = "Filters";
pub(super) const CLEAR_FILTERS: &str = "Clear the filters";
/// By which decision the list is filtered, in rows that are as wide as the card.
pub(super) const REVIEWS: [&[(&str, usize)]; 2] =
    [&[("New", 0), ("Watched", 2), ("Any state", 4)], &[("Acknowledged", 1), ("Comes and goes", 3)]];
/// By which kind. What was moved includes what was turned.
pub(super) const KINDS: [(&str, usize); 4] = [("Any kind", 0), ("Appeared", 1), ("Removed", 2), ("Moved", 3)];
/// A thing that was moved, if its middle stays.
pub(super) const TURNED: &str = "Turned";
/// By which size.
pub(super) const SIZES: [(&str, usize); 3] = [("Any size", 0), ("From 0.3 m", 1), ("From 1 m", 2)];
/// By the time since it was last seen.
pub(super) const AGES: [(&str, usize); 3] = [("Any age", 0), ("Last day", 1), ("Last week", 2)];
pub(super) const ZONE: &str = "Zone";
pub(super) const WHOLE_SITE: &str = "Whole site";
/// Whose objects are shown in the scene.
pub(super) const SHOWN: [(&str, usize); 4] = [("Both", 0), ("Before", 1), ("After", 2), ("Wipe", 3)];
/// The slider of a wipe.
pub(super) const WIPE: &str = "Wipe between before and after";
pub(super) const SHOWN_HINT: &str = "Blue: there before, and gone now. Red: new.";
pub(super) const PLACE: &str = "Middle";
pub(super) const SIZE: &str = "Size";
pub(super) const CONFIDENCE: &str = "Confidence";
pub(super) const FIRST_SEEN: &str = "First seen";
pub(super) const TIMES_SEEN: &str = "Times seen";
pub(super) const STATE: &str = "State";
pub(super) const SHOW: &str = "Show the place";
/// Probability that the places are of one thing.
pub(super) const SAME_THING: &str = "One thing";
pub(super) const HISTORY_HINT: &str = "Where it was:";
/// What is decided of a change with one press.
pub(super) const DECISIONS: [(&str, Option<usize>); 2] = [("Acknowledge", Some(0)), ("Watch", Some(1))];
pub(super) const MAKE_NORMAL: &str = "Make normal";
pub(super) const NORMAL_HINT: &str = "Makes a new version of the map that shows the scene as it is now. Nodes and inspection points stay where they are, and the old version is kept.";

/// What is listed, on the button of the filters: `Filter: New · From 0.3 m · Pump hall`.
pub(super) fn filters(names: &[&str]) -> String {
    format!("Filter: {}", names.join(" · "))
}

/// How many changes of a site are listed.
pub(super) fn shown(shown: usize, all: usize) -> String {
    match (shown, all) {
        (0, 0) => EMPTY.to_owned(),
        (0, all) => format!("None of {} changes is shown: see the filters.", format::count(all as u64)),
        (shown, all) if shown == all => match all {
            1 => "1 change".to_owned(),
            all => format!("{} changes", format::count(all as u64)),
        },
        (shown, all) => format!("{} of {} changes", format::count(shown as u64), format::count(all as u64)),
    }
}

/// The time of a thing at a place: `21 Nov 2026, 11:40 to 23 Nov 2026, 8:05`.
pub(super) fn stay(from: Option<String>, until: Option<String>) -> String {
    match (from, until) {
        (Some(from), Some(until)) => format!("{from} to {until}"),
        (Some(from), None) => format!("since {from}"),
        (None, Some(until)) => format!("until {until}"),
        (None, None) => String::new(),
    }
}

/// The button of a place of the history.
pub(super) fn show_stay(number: usize) -> String {
    format!("Show the place {number}")
}

/// The button for all acknowledged changes.
pub(super) fn make_all_normal(count: usize) -> String {
    match count {
        1 => "Make the acknowledged change normal".to_owned(),
        count => format!("Make {count} acknowledged changes normal"),
    }
}
pub(super) const REASON_FIELD: NameFieldTexts =
    NameFieldTexts { field: "Reason to dismiss", rename: "Dismiss the change", rename_short: "Dismiss" };
pub(super) const COMMENT_FIELD: NameFieldTexts =
    NameFieldTexts { field: "Comment", rename: "Keep the comment", rename_short: "Keep comment" };

/// A row of the list: `Appeared · 0.6 x 0.4 x 1.0 m · 2 h 05 old`.
pub(super) fn row(change: &SceneChange, age_s: f64) -> String {
    format!("{} · {} · {}", kind(change), size(change), format::age(age_s))
}

/// What became of a thing: `Moved 1.5 m`, `Turned 34°`.
fn kind(change: &SceneChange) -> String {
    match change.kind {
        SceneChangeKind::Appeared => KINDS[1].0.to_owned(),
        SceneChangeKind::Removed => KINDS[2].0.to_owned(),
        SceneChangeKind::Moved { from } => match Movement::between(&from, &change.place) {
            Movement::Shifted { distance_m } => {
                format!("{} {} m", KINDS[3].0, format::decimal(distance_m, 1))
            }
            Movement::Turned { turn_rad } => {
                format!("{TURNED} {}°", format::decimal(turn_rad.to_degrees(), 0))
            }
        },
    }
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
        ReviewState::Normal { .. } => "normal in a newer version of the map".to_owned(),
        ReviewState::Routine => "comes and goes".to_owned(),
    }
}
