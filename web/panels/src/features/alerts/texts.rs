//! Texts of alerts, by key.

use crate::features::runs::reading_name;
use crate::format;
use crate::name_field::NameFieldTexts;
use site_model::{Alert, AlertCause, AlertSeverity, AlertState, OutsideLimits, Site};

pub(super) const TAB: &str = "Alerts";
pub(super) const HEAD: &str = "What a person has to look at";
pub(super) const EMPTY: &str =
    "Nothing here. Readings outside their limits, gauges that were not read and failed tasks raise alerts.";
/// By which state the list is filtered.
pub(super) const STATES: [(&str, usize); 4] = [("Open", 0), ("Acknowledged", 1), ("Closed", 2), ("All", 3)];
pub(super) const SEVERITIES: [(&str, AlertSeverity); 3] = [
    ("Information", AlertSeverity::Information),
    ("Warning", AlertSeverity::Warning),
    ("Critical", AlertSeverity::Critical),
];
pub(super) const STATE: &str = "State";
pub(super) const RAISED: &str = "First raised";
pub(super) const TIMES: &str = "Times raised";
pub(super) const RECOVERED: &str = "Normal again since";
pub(super) const HISTORY: &str = "History of this point";
pub(super) const HISTORY_SHORT: &str = "History";
pub(super) const SHOW: &str = "Show the place";
pub(super) const SHOW_SHORT: &str = "Place";
pub(super) const ACKNOWLEDGE: &str = "Acknowledge";
pub(super) const REOPEN: &str = "Open again";
pub(super) const MINE: &str = "I look after it";
pub(super) const OWNER_FIELD: NameFieldTexts =
    NameFieldTexts { field: "Owner", rename: "Keep the owner", rename_short: "Keep owner" };
pub(super) const WORK_ORDER_FIELD: NameFieldTexts =
    NameFieldTexts { field: "Work order", rename: "Keep the work order", rename_short: "Keep work order" };
pub(super) const COMMENT_FIELD: NameFieldTexts =
    NameFieldTexts { field: "Comment", rename: "Keep the comment", rename_short: "Keep comment" };
pub(super) const REMARK_FIELD: NameFieldTexts =
    NameFieldTexts { field: "Closing remark", rename: "Close the alert", rename_short: "Close" };

/// The button that raises an alert by hand.
pub(super) fn raise(point: Option<&str>) -> String {
    point.map_or_else(|| "Raise an alert".to_owned(), |point| format!("Raise an alert at {point}"))
}

pub(super) fn severity(severity: AlertSeverity) -> &'static str {
    SEVERITIES[severity as usize].0
}

/// A row of the list: `Warning · Boiler · 2 h 05 old`.
pub(super) fn row(alert: &Alert, site: &Site, age_s: f64) -> String {
    let point = alert.cause.point().and_then(|point| site.inspection_point(point));
    let mission = || match &alert.cause {
        AlertCause::TaskFailed { mission, .. } => Some(site.mission((*mission)?)?.name.as_str()),
        _ => None,
    };
    let place = point.map(|point| point.name.as_str()).or_else(mission).unwrap_or("Site");
    format!("{} · {place} · {}", severity(alert.severity), format::age(age_s))
}

/// What it is about: `Gauge 5.30 bar, above 5.00 bar`.
pub(super) fn what(alert: &Alert) -> String {
    match &alert.cause {
        AlertCause::OutsideLimits { reading, .. } => {
            let (side, limit) = match reading.outside {
                OutsideLimits::Below(limit) => ("below", limit),
                OutsideLimits::Above(limit) => ("above", limit),
            };
            let (value, unit) = (reading.value, &reading.unit);
            format!("{} {value:.2} {unit}, {side} {limit:.2} {unit}", reading_name(&reading.name))
        }
        AlertCause::GaugeNotRead { reason, .. } | AlertCause::TaskFailed { reason, .. } => reason.clone(),
        AlertCause::SceneChange(_) => "A change of the scene".to_owned(),
        AlertCause::ByHand { .. } if alert.comment.is_empty() => "Raised by hand".to_owned(),
        AlertCause::ByHand { .. } => alert.comment.clone(),
    }
}

/// Who looks after it, and what is to be done: `Ada: replace the valve`.
pub(super) fn who(alert: &Alert) -> String {
    let owner = if alert.owner.is_empty() { "Nobody yet" } else { &alert.owner };
    let separator = if alert.work_order.is_empty() { "" } else { ": " };
    format!("{owner}{separator}{}", alert.work_order)
}

pub(super) fn state(state: &AlertState) -> String {
    match state {
        AlertState::Open => "open".to_owned(),
        AlertState::Acknowledged { by, .. } => format!("acknowledged by {by}"),
        AlertState::Closed { by, .. } => format!("closed by {by}"),
    }
}
