//! Texts of monitors, by key, and the kinds that the texts are of.

use crate::format;
use crate::name_field::NameFieldTexts;
use missions::CHARGE_SIGNAL;
use site_model::{Monitor, MonitorCondition, MonitorResponse, Resumption, Site};

pub(super) const TAB: &str = "Monitors";
pub(super) const HEAD: &str = "Monitors";
pub(super) const LOADING: &str = "The site has not arrived from the robot yet.";
pub(super) const REMARK: &str = "A monitor watches a signal of the robot. While its condition holds, it keeps missions from beginning, or interrupts them.";
pub(super) const ADD: &str = "New monitor";
pub(super) const NAME_FIELD: NameFieldTexts =
    NameFieldTexts { field: "Monitor name", rename: "Rename monitor", rename_short: "Rename" };
pub(super) const WATCHED: &str = "It is watched";
pub(super) const SIGNAL: &str = "Signal";
pub(super) const SILENCE: &str = "Silent for (s)";
pub(super) const HOLD: &str = "For at least (s)";
pub(super) const RESPONSE: &str = "What happens";
pub(super) const MISSION: &str = "Which mission";
pub(super) const NO_MISSION: &str = "A mission that was deleted";
pub(super) const AFTERWARDS: &str = "The interrupted run, afterwards:";
pub(super) const RESUMPTIONS: [(&str, Resumption); 2] =
    [("Goes on", Resumption::Resume), ("Ends", Resumption::Drop)];
pub(super) const RESET_SHORT: &str = "Use the built-in values";
pub(super) const DELETE_SHORT: &str = "Delete";

/// The signals that robots send, with what people call them.
pub(super) const SIGNALS: [(&str, &str); 2] =
    [(CHARGE_SIGNAL, "Battery charge"), (RESERVE_SIGNAL, "Charge beyond the way to a dock")];
/// Signal of the charge that is left at the nearest dock, over what always stays (`missions::battery_monitors`).
pub(super) const RESERVE_SIGNAL: &str = "battery.reserve";

/// What a signal is called; its own name if the platform does not know it.
pub(super) fn signal(signal: &str) -> &str {
    SIGNALS.iter().find(|(known, _)| *known == signal).map_or(signal, |(_, name)| name)
}

/// Whether a signal is a share, from 0 to 1, that people read in per cent.
pub(super) fn is_share(signal: &str) -> bool {
    SIGNALS.iter().any(|(known, _)| *known == signal)
}

/// When a condition holds, without its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ConditionKind {
    Below,
    Above,
    Silent,
}

impl ConditionKind {
    pub(super) fn of(condition: MonitorCondition) -> Self {
        match condition {
            MonitorCondition::Below { .. } => Self::Below,
            MonitorCondition::Above { .. } => Self::Above,
            MonitorCondition::Silent(_) => Self::Silent,
        }
    }
}

pub(super) const CONDITIONS: [(&str, ConditionKind); 3] =
    [("Below", ConditionKind::Below), ("Above", ConditionKind::Above), ("Silent", ConditionKind::Silent)];

/// Names of the value at which a condition begins to hold, and of that at which it ends.
pub(super) fn values(is_below: bool) -> [&'static str; 2] {
    if is_below { ["Below", "Until above"] } else { ["Above", "Until below"] }
}

/// What happens, without the mission and what comes afterwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ResponseKind {
    Block,
    GoToDock,
    Interrupt,
    Pause,
    Notify,
}

impl ResponseKind {
    pub(super) fn of(response: MonitorResponse) -> Self {
        match response {
            MonitorResponse::BlockMissions => Self::Block,
            MonitorResponse::GoToDock { .. } => Self::GoToDock,
            MonitorResponse::Interrupt { .. } => Self::Interrupt,
            MonitorResponse::Pause => Self::Pause,
            MonitorResponse::Notify => Self::Notify,
        }
    }
}

pub(super) const RESPONSES: [(ResponseKind, &str); 5] = [
    (ResponseKind::Block, "No mission begins"),
    (ResponseKind::GoToDock, "The robot goes to a dock"),
    (ResponseKind::Interrupt, "A mission interrupts"),
    (ResponseKind::Pause, "The run is paused"),
    (ResponseKind::Notify, "People are told"),
];

pub(super) fn response(kind: ResponseKind) -> &'static str {
    RESPONSES.iter().find(|(known, _)| *known == kind).map_or("", |(_, name)| name)
}

pub(super) fn monitor(name: &str) -> String {
    format!("Monitor {name}")
}

fn value(monitor: &Monitor, value: f64) -> String {
    if is_share(&monitor.signal) { format!("{:.0} %", value * 100.0) } else { format::decimal(value, 2) }
}

/// `Battery low · below 20 %`.
pub(super) fn row(monitor: &Monitor) -> String {
    let condition = match monitor.condition {
        _ if !monitor.is_enabled => "not watched".to_owned(),
        MonitorCondition::Below { threshold, .. } => format!("below {}", value(monitor, threshold)),
        MonitorCondition::Above { threshold, .. } => format!("above {}", value(monitor, threshold)),
        MonitorCondition::Silent(time) => format!("silent for {}", format::duration(time.secs_f64())),
    };
    format!("{} · {condition}", monitor.name)
}

/// What a monitor does, in one or two sentences.
pub(super) fn summary(site: &Site, monitor: &Monitor) -> String {
    let signal = signal(&monitor.signal);
    let (when, until) = match monitor.condition {
        MonitorCondition::Below { threshold, release } => (
            format!("{signal} below {}", value(monitor, threshold)),
            format!("until it is above {}", value(monitor, release)),
        ),
        MonitorCondition::Above { threshold, release } => (
            format!("{signal} above {}", value(monitor, threshold)),
            format!("until it is below {}", value(monitor, release)),
        ),
        MonitorCondition::Silent(time) => (
            format!("{signal} silent for {}", format::duration(time.secs_f64())),
            "until it comes again".to_owned(),
        ),
    };
    let afterwards = |afterwards| match afterwards {
        Resumption::Resume => "The interrupted run goes on then.",
        Resumption::Drop => "The interrupted run has ended.",
    };
    match monitor.response {
        MonitorResponse::BlockMissions => format!("{when}: no mission begins, {until}."),
        MonitorResponse::GoToDock { afterwards: then } => {
            format!(
                "{when}: the run is interrupted, the robot goes to the nearest dock, and no mission begins, {until}. {}",
                afterwards(then)
            )
        }
        MonitorResponse::Interrupt { mission, afterwards: then } => {
            let name = site.mission(mission).map_or(NO_MISSION, |mission| &mission.name);
            format!(
                "{when}: {name} interrupts the run, and no other mission begins, {until}. {}",
                afterwards(then)
            )
        }
        MonitorResponse::Pause => format!("{when}: the run is paused. A person resumes it."),
        MonitorResponse::Notify => format!("{when}: people are told."),
    }
}

pub(super) fn reset(name: &str) -> String {
    format!("Use the built-in values of {name}")
}

pub(super) fn delete(name: &str) -> String {
    format!("Delete monitor {name}")
}
