//! When a schedule has its slots: once, weekly, in equal intervals, or by a rule of RFC 5545.

use super::fields::{StepperField, TypedFields, stepped_date, stepped_interval, stepped_time};
use super::form::{FIRST_TIME, change};
use super::plan_cache::{CachedPlan, MINUTE_NS};
use super::state::SchedulePanel;
use super::texts;
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::theme;
use crate::{TextInput, icon, widgets};
use client_model::{ClientCommand, first_slot};
use egui::Ui;
use missions::{date_of, day_number, weekday_of};
use site_model::{LocalDate, LocalDateTime, LocalTime, Recurrence, Schedule, Weekdays};
use std::collections::BTreeSet;
use vocab::Span;

/// Longest recurrence rule, characters.
const MAX_RULE_CHARS: u32 = 200;

/// Values of a new recurrence.
struct NewRecurrenceConfig {
    /// Interval of a schedule that was weekly or once before, minutes. Chosen: two days, which no weekly schedule can say.
    interval_min: i64,
}

const CONFIG: NewRecurrenceConfig = NewRecurrenceConfig { interval_min: 2 * 24 * 60 };

/// Kinds of recurrences that are offered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RecurrenceKind {
    Weekly,
    Once,
    Every,
    Rule,
}

impl RecurrenceKind {
    fn of(recurrence: &Recurrence) -> Self {
        match recurrence {
            Recurrence::Once(_) => Self::Once,
            Recurrence::Weekly { .. } => Self::Weekly,
            Recurrence::Every { .. } => Self::Every,
            Recurrence::Rule { .. } => Self::Rule,
        }
    }
}

impl SchedulePanel {
    /// Shows the recurrence.
    pub(super) fn show_when(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        plan: &CachedPlan,
        schedule: &Schedule,
    ) {
        let tokens = cx.tokens;
        widgets::section_head(ui, tokens, texts::WHEN_HEAD);
        let kind = RecurrenceKind::of(&schedule.recurrence);
        let mut chosen = kind;
        let mut kinds = vec![
            (texts::WEEKLY, RecurrenceKind::Weekly),
            (texts::ONCE, RecurrenceKind::Once),
            (texts::EVERY, RecurrenceKind::Every),
        ];
        if kind == RecurrenceKind::Rule {
            kinds.push((texts::RULE_SHORT, RecurrenceKind::Rule));
        }
        widgets::choice(ui, tokens, &kinds, kind, |kind| chosen = kind);
        let typed = &mut self.typed;
        let changed = if chosen != kind {
            Some(converted(schedule, chosen, plan))
        } else {
            match &schedule.recurrence {
                Recurrence::Once(at) => show_date_time(ui, cx, typed, *at).map(Recurrence::Once),
                Recurrence::Weekly { days, times, first_day, last_day } => {
                    show_weekly(ui, cx, typed, days, times, *first_day, *last_day)
                }
                Recurrence::Every { first, interval } => show_every(ui, cx, typed, *first, *interval),
                Recurrence::Rule { first, rule } => show_rule(ui, cx, typed, *first, rule),
            }
        };
        if let Some(recurrence) = changed.filter(|recurrence| *recurrence != schedule.recurrence) {
            change(cx, schedule, |it| it.recurrence = recurrence);
        }
        show_end(ui, cx, &mut self.typed, plan, schedule);
    }
}

/// The recurrence of another kind that is nearest to that of a schedule.
fn converted(schedule: &Schedule, kind: RecurrenceKind, plan: &CachedPlan) -> Recurrence {
    let next = plan.next_of(schedule.id).map(|next| next.slot).or_else(|| first_slot(&schedule.recurrence));
    let first = next.unwrap_or(LocalDateTime { date: plan.zone.to_local(plan.now).date, time: FIRST_TIME });
    match kind {
        RecurrenceKind::Once => Recurrence::Once(first),
        RecurrenceKind::Weekly => Recurrence::Weekly {
            days: BTreeSet::from([texts::DAYS[usize::from(weekday_of(day_number(first.date)))].1]),
            times: vec![first.time],
            first_day: first.date,
            last_day: None,
        },
        RecurrenceKind::Every => {
            Recurrence::Every { first, interval: Span::from_nanos(CONFIG.interval_min * MINUTE_NS) }
        }
        RecurrenceKind::Rule => schedule.recurrence.clone(),
    }
}

fn show_date(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    typed: &mut TypedFields,
    name: &str,
    date: LocalDate,
) -> Option<LocalDate> {
    let shown = texts::iso_date(date);
    let stepper = StepperField { key: name, name, caption: name, shown: &shown };
    let step = ui.horizontal(|ui| stepper.show(ui, cx, typed, 0.0)).inner?;
    stepped_date(date, &step)
}

fn show_date_time(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    typed: &mut TypedFields,
    at: LocalDateTime,
) -> Option<LocalDateTime> {
    let date = show_date(ui, cx, typed, texts::DATE, at.date);
    let shown = texts::time(at.time);
    let stepper = StepperField { key: texts::TIME, name: texts::TIME, caption: texts::TIME, shown: &shown };
    let step = ui.horizontal(|ui| stepper.show(ui, cx, typed, 0.0)).inner;
    let time = step.and_then(|step| stepped_time(at.time, &step));
    (date.is_some() || time.is_some())
        .then(|| LocalDateTime { date: date.unwrap_or(at.date), time: time.unwrap_or(at.time) })
}

fn show_weekly(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    typed: &mut TypedFields,
    days: &Weekdays,
    times: &[LocalTime],
    first_day: LocalDate,
    last_day: Option<LocalDate>,
) -> Option<Recurrence> {
    let tokens = cx.tokens;
    let mut new_days = days.clone();
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let width = ((ui.available_width() + 4.0) / 7.0 - 4.0).floor();
        for (name, day) in texts::DAYS {
            let is_on = days.contains(&day);
            if Button::new(name).on(is_on).size(width, theme::TOUCH).tight().show(ui, tokens).clicked() {
                if is_on {
                    new_days.remove(&day);
                } else {
                    new_days.insert(day);
                }
            }
        }
    });
    let mut new_times = times.to_vec();
    for (index, time) in times.iter().enumerate() {
        let (name, shown) = (texts::numbered_time(index + 1), texts::time(*time));
        let caption = if index == 0 { texts::TIMES } else { " " };
        ui.horizontal(|ui| {
            let stepper = StepperField { key: &name, name: &name, caption, shown: &shown };
            let step = stepper.show(ui, cx, typed, theme::TOUCH + 4.0);
            if let Some(time) = step.and_then(|step| stepped_time(*time, &step)) {
                new_times[index] = time;
            }
            let remove = texts::remove_time(*time);
            let button = Button::icon_only(&remove, icon::X).kind(Kind::Quiet).enabled(times.len() > 1);
            if button.show(ui, tokens).clicked() {
                new_times.retain(|other| other != time);
            }
        });
    }
    if Button::new(texts::ADD_TIME).icon(icon::PLUS).wide(ui).show(ui, tokens).clicked() {
        new_times.push(new_time(times));
    }
    let first_day = show_date(ui, cx, typed, texts::FIRST_DAY, first_day).unwrap_or(first_day);
    new_times.sort_unstable();
    new_times.dedup();
    Some(Recurrence::Weekly { days: new_days, times: new_times, first_day, last_day })
}

/// A time that the others leave free: four hours after the last one, or the first one that is chosen.
fn new_time(times: &[LocalTime]) -> LocalTime {
    let last = times.iter().max().copied();
    let later = last.map(|last| LocalTime { hour: (last.hour + 4) % 24, ..last });
    let free = later.filter(|time| !times.contains(time));
    free.or_else(|| (0..24).map(|hour| LocalTime { hour, minute: 0 }).find(|time| !times.contains(time)))
        .unwrap_or(FIRST_TIME)
}

fn show_every(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    typed: &mut TypedFields,
    first: LocalDateTime,
    interval: Span,
) -> Option<Recurrence> {
    let minutes = (interval.nanos() / MINUTE_NS).max(1);
    let shown = texts::interval(interval);
    let stepper =
        StepperField { key: "interval", name: texts::INTERVAL, caption: texts::INTERVAL, shown: &shown };
    let step = ui.horizontal(|ui| stepper.show(ui, cx, typed, 0.0)).inner;
    let minutes = step.and_then(|step| stepped_interval(minutes, &step)).unwrap_or(minutes);
    let first = show_date_time(ui, cx, typed, first).unwrap_or(first);
    Some(Recurrence::Every { first, interval: Span::from_nanos(minutes * MINUTE_NS) })
}

fn show_rule(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    typed: &mut TypedFields,
    first: LocalDateTime,
    rule: &str,
) -> Option<Recurrence> {
    let text = typed.text(texts::RULE, rule);
    let field = TextInput::new(texts::RULE, texts::RULE).max_length(MAX_RULE_CHARS);
    let response = field.show(ui, cx.tokens, cx.text_inputs, text);
    let given = text.trim().to_owned();
    let rule = if response.submitted || response.lost_focus { given } else { rule.to_owned() };
    let first = show_date_time(ui, cx, typed, first).unwrap_or(first);
    Some(Recurrence::Rule { first, rule })
}

/// The last day, or that there is none.
fn show_end(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    typed: &mut TypedFields,
    plan: &CachedPlan,
    schedule: &Schedule,
) {
    // Whether an end can be said at all.
    let today = plan.zone.to_local(plan.now).date;
    let Some(without) = cx.model.site.ending_schedule(schedule.id, None) else { return };
    let Recurrence::Weekly { last_day, .. } = &schedule.recurrence else { return };
    match last_day {
        Some(last_day) => {
            if let Some(day) = show_date(ui, cx, typed, texts::LAST_DAY, *last_day)
                && let Some(edit) = cx.model.site.ending_schedule(schedule.id, Some(day))
            {
                cx.commands.push(ClientCommand::EditSite(edit));
            }
            if Button::new(texts::NO_END).wide(ui).show(ui, cx.tokens).clicked() {
                cx.commands.push(ClientCommand::EditSite(without));
            }
        }
        None => {
            if Button::new(texts::ADD_END).icon(icon::CALENDAR_X).wide(ui).show(ui, cx.tokens).clicked() {
                let day = date_of(day_number(today) + 28);
                let edit = cx.model.site.ending_schedule(schedule.id, Some(day));
                cx.commands.extend(edit.map(ClientCommand::EditSite));
            }
        }
    }
}
