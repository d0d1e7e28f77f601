//! The form of a monitor: signal, condition, hold time, and what happens.

use super::texts::{self, ConditionKind, ResponseKind};
use crate::feature_panel::PanelContext;
use crate::features::mission_task::missions_by_name;
use crate::number_field::{NumberField, TypedNumber};
use crate::select::select;
use crate::widgets;
use egui::Ui;
use site_model::{Monitor, MonitorCondition, MonitorResponse, ObjectId, Resumption, Site};
use vocab::Span;

/// What people may enter, and what new conditions have.
struct FormConfig {
    /// Shortest and longest hold time, seconds. Chosen: an hour is longer than any condition is worth waiting for.
    holds_s: [f64; 2],
    /// Shortest and longest silence, seconds. Chosen: signals come every second or so; a day is longer than any pause.
    silences_s: [f64; 2],
    /// Silence that a new condition waits for, seconds. Chosen: as long as a lost link that comes back by itself.
    new_silence_s: f64,
    /// Range of a signal that is no share, in its unit. Chosen: wider than any signal, so that a slip of the finger is still a finite number.
    values: [f64; 2],
    /// Limits of a new condition on a signal that was watched for silence, shares. Chosen: those of the built-in monitor of the battery.
    new_limits: [f64; 2],
}

const CONFIG: FormConfig = FormConfig {
    holds_s: [0.0, 3_600.0],
    silences_s: [1.0, 86_400.0],
    new_silence_s: 60.0,
    values: [-1e9, 1e9],
    new_limits: [0.2, 0.8],
};

/// Shows all fields of a monitor, and puts what was changed into `changed`.
pub(super) fn show(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    typed: &mut TypedNumber,
    site: &Site,
    monitor: &Monitor,
    changed: &mut Monitor,
) {
    show_signal(ui, cx, monitor, changed);
    show_condition(ui, cx, typed, monitor, changed);
    let hold = seconds(ui, cx, typed, monitor, (texts::HOLD, monitor.hold, CONFIG.holds_s));
    changed.hold = hold.unwrap_or(monitor.hold);
    show_response(ui, cx, site, monitor, changed);
}

fn show_signal(ui: &mut Ui, cx: &PanelContext<'_>, monitor: &Monitor, changed: &mut Monitor) {
    let names: Vec<String> = texts::SIGNALS.iter().map(|(_, name)| (*name).to_owned()).collect();
    let shown = texts::signal(&monitor.signal);
    if let Some(index) = select(ui, cx.tokens, texts::SIGNAL, texts::SIGNAL, shown, &names) {
        changed.signal = texts::SIGNALS[index].0.to_owned();
    }
}

fn show_condition(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    typed: &mut TypedNumber,
    monitor: &Monitor,
    changed: &mut Monitor,
) {
    let kind = ConditionKind::of(monitor.condition);
    let mut chosen = kind;
    widgets::choice(ui, cx.tokens, &texts::CONDITIONS, kind, |kind| chosen = kind);
    if chosen != kind {
        changed.condition = condition_of(chosen, monitor.condition);
        return;
    }
    changed.condition = match monitor.condition {
        MonitorCondition::Silent(time) => {
            let time =
                seconds(ui, cx, typed, monitor, (texts::SILENCE, time, CONFIG.silences_s)).unwrap_or(time);
            MonitorCondition::Silent(time)
        }
        MonitorCondition::Below { threshold, release } => {
            let [threshold, release] = show_values(ui, cx, typed, monitor, [threshold, release], true);
            MonitorCondition::Below { threshold, release: release.max(threshold) }
        }
        MonitorCondition::Above { threshold, release } => {
            let [threshold, release] = show_values(ui, cx, typed, monitor, [threshold, release], false);
            MonitorCondition::Above { threshold, release: release.min(threshold) }
        }
    };
}

/// Fields for the value at which a condition begins to hold, and for the one at which it ends. Returns both as they are now.
fn show_values(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    typed: &mut TypedNumber,
    monitor: &Monitor,
    values: [f64; 2],
    is_below: bool,
) -> [f64; 2] {
    let (scale, unit, range) = match texts::is_share(&monitor.signal) {
        true => (100.0, " (%)", [0.0, 100.0]),
        false => (1.0, "", CONFIG.values),
    };
    let mut given = values;
    let threshold = values[0] * scale;
    let release_range = if is_below { [threshold, range[1]] } else { [range[0], threshold] };
    for (index, range) in [range, release_range].into_iter().enumerate() {
        let name = format!("{}{unit}", texts::values(is_below)[index]);
        let object = ObjectId::Monitor(monitor.id);
        // What is a whole number for people is one.
        let value = Some((values[index] * scale * 1e6).round() / 1e6);
        let field = NumberField { name: &name, object, value, hint: "", step: 5.0, decimals: 0, range };
        if let Some(value) = field.show(ui, cx, typed).flatten() {
            given[index] = value / scale;
        }
    }
    given
}

/// A field for a time. Returns another time once it is given.
fn seconds(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    typed: &mut TypedNumber,
    monitor: &Monitor,
    (name, time, range): (&str, Span, [f64; 2]),
) -> Option<Span> {
    let (object, value) = (ObjectId::Monitor(monitor.id), Some(time.secs_f64()));
    let field = NumberField { name, object, value, hint: "", step: 5.0, decimals: 0, range };
    let time_s = field.show(ui, cx, typed).flatten()?;
    Some(Span::from_millis((time_s * 1e3).round() as i64))
}

fn show_response(ui: &mut Ui, cx: &PanelContext<'_>, site: &Site, monitor: &Monitor, changed: &mut Monitor) {
    let missions = missions_by_name(site);
    let kinds: Vec<(ResponseKind, String)> = texts::RESPONSES
        .iter()
        .filter(|(kind, _)| *kind != ResponseKind::Interrupt || !missions.is_empty())
        .map(|(kind, name)| (*kind, (*name).to_owned()))
        .collect();
    let names: Vec<String> = kinds.iter().map(|(_, name)| name.clone()).collect();
    let kind = ResponseKind::of(monitor.response);
    let shown = texts::response(kind);
    let afterwards = match monitor.response {
        MonitorResponse::Interrupt { afterwards, .. } | MonitorResponse::GoToDock { afterwards } => {
            afterwards
        }
        MonitorResponse::BlockMissions | MonitorResponse::Pause | MonitorResponse::Notify => {
            Resumption::Resume
        }
    };
    if let Some(index) = select(ui, cx.tokens, texts::RESPONSE, texts::RESPONSE, shown, &names) {
        let first = missions.first().map(|mission| mission.id);
        changed.response = match (kinds[index].0, first) {
            (ResponseKind::GoToDock, _) => MonitorResponse::GoToDock { afterwards },
            (ResponseKind::Interrupt, Some(mission)) => MonitorResponse::Interrupt { mission, afterwards },
            (ResponseKind::Pause, _) => MonitorResponse::Pause,
            (ResponseKind::Notify, _) => MonitorResponse::Notify,
            (ResponseKind::Block | ResponseKind::Interrupt, _) => MonitorResponse::BlockMissions,
        };
        return;
    }
    if let MonitorResponse::Interrupt { mission, .. } = monitor.response {
        let names: Vec<String> = missions.iter().map(|mission| mission.name.clone()).collect();
        let shown = site.mission(mission).map_or(texts::NO_MISSION, |mission| &mission.name);
        if let Some(index) = select(ui, cx.tokens, texts::MISSION, texts::MISSION, shown, &names) {
            changed.response = MonitorResponse::Interrupt { mission: missions[index].id, afterwards };
        }
    }
    if matches!(kind, ResponseKind::Interrupt | ResponseKind::GoToDock) {
        widgets::remark(ui, cx.tokens, texts::AFTERWARDS);
        widgets::choice(ui, cx.tokens, &texts::RESUMPTIONS, afterwards, |chosen| {
            match &mut changed.response {
                MonitorResponse::Interrupt { afterwards, .. } | MonitorResponse::GoToDock { afterwards } => {
                    *afterwards = chosen;
                }
                MonitorResponse::BlockMissions | MonitorResponse::Pause | MonitorResponse::Notify => {}
            }
        });
    }
}

/// A condition of this kind with the numbers of the one before it.
fn condition_of(kind: ConditionKind, before: MonitorCondition) -> MonitorCondition {
    let (low, high) = match before {
        MonitorCondition::Below { threshold, release } => (threshold, release),
        MonitorCondition::Above { threshold, release } => (release, threshold),
        MonitorCondition::Silent(_) => (CONFIG.new_limits[0], CONFIG.new_limits[1]),
    };
    match kind {
        ConditionKind::Below => MonitorCondition::Below { threshold: low, release: high },
        ConditionKind::Above => MonitorCondition::Above { threshold: high, release: low },
        ConditionKind::Silent => {
            MonitorCondition::Silent(Span::from_millis((CONFIG.new_silence_s * 1e3) as i64))
        }
    }
}
