//! Texts of zones, by key.

use super::effect_kind::EffectKind;
use crate::features::action_form::action_title;
use crate::name_field::NameFieldTexts;
use site_model::{Zone, ZoneEffect};

pub(super) const TAB: &str = "Zones";
pub(super) const HEAD: &str = "Zones";
pub(super) const LOADING: &str = "The site has not arrived from the robot yet.";
pub(super) const NO_MAP: &str =
    "Zones are drawn in the map of the site. Make the topological map first; it says which map that is.";
pub(super) const OTHER_MAP: &str =
    "Zones are drawn in the map of the site. View it on the tab of the topological map.";
pub(super) const EMPTY: &str = "There are no zones yet. The robot keeps out of a zone, slows down in it, or walks round it where it can.";
pub(super) const DRAW: &str = "Draw a zone";
pub(super) const DRAW_HINT: &str = "Drag over the floor from one corner to the opposite one. Escape ends it.";
pub(super) const NAME_FIELD: NameFieldTexts =
    NameFieldTexts { field: "Zone name", rename: "Rename zone", rename_short: "Rename" };
pub(super) const EFFECT_HEAD: &str = "What holds there";
pub(super) const EFFECTS: [(&str, EffectKind); 4] = [
    ("Keep out", EffectKind::KeepOut),
    ("Speed limit", EffectKind::SpeedLimit),
    ("Penalty", EffectKind::Penalty),
    ("Action", EffectKind::Action),
];
/// Which action, of a zone with one.
pub(super) const ACTION: &str = "Action on entering";
pub(super) const SPEED: &str = "At most (m/s)";
pub(super) const PENALTY: &str = "Factor";
pub(super) const HEIGHT_HEAD: &str = "Heights";
pub(super) const ALL_HEIGHTS: &str = "All heights";
pub(super) const SOME_HEIGHTS: &str = "From … to";
pub(super) const HEIGHTS: [&str; 2] = ["From (m)", "To (m)"];
pub(super) const TIME_HEAD: &str = "Times";
pub(super) const ALWAYS: &str = "Always";
pub(super) const DAILY: &str = "Every day";
pub(super) const HOURS: [&str; 2] = ["From", "Until"];
pub(super) const DAILY_REMARK: &str = "In the time zone of the site. It may go past midnight.";
pub(super) const SHOW: &str = "Show the zone";
pub(super) const DELETE_SHORT: &str = "Delete";

/// What a kind of zone means.
pub(super) fn effect_remark(kind: EffectKind) -> &'static str {
    match kind {
        EffectKind::KeepOut => "The robot does not enter it. Routes lead round it.",
        EffectKind::SpeedLimit => "The robot walks no faster in it.",
        EffectKind::Penalty => "Ways through it count this many times their length, so routes avoid it.",
        EffectKind::Action => {
            "When the robot comes into it on its way, the action is called, and the robot walks on."
        }
    }
}

/// A zone with what holds in it: `Ramp · at most 0.3 m/s`.
pub(crate) fn tag(zone: &Zone) -> String {
    let effect = match &zone.effect {
        ZoneEffect::KeepOut => "keep out".to_owned(),
        ZoneEffect::SpeedLimit(speed) => format!("at most {speed:.1} m/s"),
        ZoneEffect::Penalty(factor) => format!("{factor:.1} times the way"),
        ZoneEffect::Action(request) => action_title(&request.action).to_lowercase(),
    };
    format!("{} · {effect}", zone.name)
}

/// What people are told when the robot comes into a zone, unless they write something else.
pub(super) fn entered(zone: &str) -> String {
    format!("The robot has come into {zone}.")
}

pub(super) fn zone(name: &str) -> String {
    format!("Zone {name}")
}

pub(super) fn only_floor(floor: i32) -> String {
    format!("Only floor {floor}")
}

pub(super) fn corners(count: usize) -> String {
    format!("{count} corners")
}

pub(super) fn delete(name: &str) -> String {
    format!("Delete zone {name}")
}
