//! The side card while no schedule is open: missions to drag, all schedules, and the next 30 days.

use super::drag::{add_schedule, next_hour, select};
use super::plan_cache::CachedPlan;
use super::state::{Drag, Dragged, SchedulePanel};
use super::texts;
use crate::button::Button;
use crate::feature_panel::PanelContext;
use crate::paint::{focus_ring, icon_at, one_line};
use crate::theme::{self, Tokens, Weight, font};
use crate::{icon, widgets};
use client_model::{ClientCommand, Occurrence};
use egui::{CornerRadius, Id, Role, Sense, Ui, WidgetInfo, pos2, vec2};
use missions::ClockChange;
use site_model::{LocalDateTime, Mission, Schedule, ScheduleId, Site};

/// Height of the row of a mission or schedule, points.
const ROW_HEIGHT: f32 = 52.0;
/// How many findings are listed.
#[derive(Clone, Copy, Debug)]
struct FindingListConfig {
    /// Conflicts and changes of the clocks that are listed at once. Chosen: they fit without scrolling.
    max_findings: usize,
}

const FINDINGS: FindingListConfig = FindingListConfig { max_findings: 6 };

impl SchedulePanel {
    /// Shows the lists.
    pub(super) fn show_lists(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        plan: &CachedPlan,
        site: &Site,
    ) {
        let tokens = cx.tokens;
        widgets::head(ui, tokens, texts::MISSIONS_HEAD);
        if site.missions().next().is_none() {
            widgets::sentence(ui, tokens, texts::NO_MISSIONS);
        } else {
            widgets::remark(ui, tokens, texts::DRAG_HINT);
        }
        for mission in site.missions() {
            self.show_mission(ui, cx, plan, mission);
        }
        widgets::section_head(ui, tokens, texts::SCHEDULES_HEAD);
        if site.schedules().next().is_none() {
            widgets::remark(ui, tokens, texts::NO_SCHEDULES);
        }
        for schedule in site.schedules() {
            show_schedule(ui, cx, plan, schedule);
        }
        if let Some((schedule, from, to)) = show_outlook(ui, cx, plan, site) {
            self.move_slot(cx, plan, schedule, from, to);
        }
        show_files(ui, cx);
    }

    /// A mission, which can be dragged into the week.
    fn show_mission(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, plan: &CachedPlan, mission: &Mission) {
        let name = texts::schedule_mission(&mission.name);
        let duration_s = plan.durations.get(&mission.id).map(|duration| duration.secs_f64());
        let facts = texts::mission_facts(mission.tasks.len(), duration_s);
        let id = Id::unique(("schedule mission", mission.id.0));
        let dragged = Dragged::Mission(mission.id);
        let is_dragged = self.drag.is_some_and(|drag| drag.dragged == dragged);
        let row = Row { name: &name, title: &mission.name, facts: &facts, colour: cx.tokens.accent };
        let response = show_row(ui, cx.tokens, id, &row, is_dragged, Some(icon::DOTS_SIX_VERTICAL));
        if response.drag_started() {
            self.drag = Some(Drag { dragged, by_keys: false, grip_min: 0.0, target: None });
        } else if response.clicked() {
            add_schedule(cx, mission.id, next_hour(plan));
        }
        // Where no week is shown, such as in the agenda, it falls to the ground.
        if is_dragged && ui.input(|input| !input.pointer.any_down() && !input.pointer.any_released()) {
            self.drag = None;
        }
    }
}

/// A row of a list.
struct Row<'a> {
    name: &'a str,
    title: &'a str,
    facts: &'a str,
    /// Of its edge.
    colour: egui::Color32,
}

fn show_row(
    ui: &mut Ui,
    tokens: &Tokens,
    id: Id,
    row: &Row<'_>,
    is_on: bool,
    handle: Option<&str>,
) -> egui::Response {
    let size = vec2(ui.available_width(), ROW_HEIGHT);
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    let sense = if handle.is_some() { Sense::click_and_drag() } else { Sense::click() };
    let response = ui.interact(rect, id, sense);
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, row.name));
    let fill = if is_on { tokens.selected() } else { tokens.raised };
    let fill = if response.hovered() { tokens.hovered(fill) } else { fill };
    let radius = CornerRadius::same(theme::BUTTON_RADIUS);
    let painter = ui.painter().with_clip_rect(rect.expand(3.0).intersect(ui.clip_rect()));
    painter.rect_filled(rect, radius, fill);
    let edge = egui::Rect::from_min_size(rect.min, vec2(4.0, rect.height()));
    painter.rect_filled(edge, CornerRadius { ne: 0, se: 0, ..radius }, row.colour);
    let mut left = rect.left() + 14.0;
    if let Some(handle) = handle {
        icon_at(ui, pos2(left + 6.0, rect.center().y), handle, theme::ICON, tokens.dim);
        left += 24.0;
    }
    let room = rect.right() - 8.0 - left;
    let title = one_line(ui, row.title, font(theme::BODY, Weight::Medium), tokens.text, room);
    painter.galley(pos2(left, rect.top() + 8.0), title, tokens.text);
    let facts = one_line(ui, row.facts, font(theme::SMALL, Weight::Regular), tokens.dim, room);
    painter.galley(pos2(left, rect.top() + 29.0), facts, tokens.dim);
    if response.has_focus() {
        focus_ring(ui, rect, tokens);
    }
    response
}

fn show_schedule(ui: &mut Ui, cx: &mut PanelContext<'_>, plan: &CachedPlan, schedule: &Schedule) {
    let tokens = cx.tokens;
    let sentence = texts::recurrence(&schedule.recurrence);
    let (facts, colour) = if schedule.is_paused {
        (texts::paused(&sentence), tokens.dim)
    } else {
        (sentence, if plan.next_of(schedule.id).is_some() { tokens.accent } else { tokens.dim })
    };
    let name = texts::open_schedule(&schedule.name);
    let id = Id::unique(("open schedule", schedule.id.0));
    let row = Row { name: &name, title: &schedule.name, facts: &facts, colour };
    if show_row(ui, tokens, id, &row, false, None).clicked() {
        select(cx, schedule.id, None);
    }
}

/// What the next 30 days bring: how many runs, and where they meet each other or a change of the clocks. Returns a slot that shall move, from where and whereto.
fn show_outlook(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    plan: &CachedPlan,
    site: &Site,
) -> Option<(ScheduleId, LocalDateTime, LocalDateTime)> {
    let tokens = cx.tokens;
    let planned: Vec<&Occurrence> = plan.outlook.occurrences.iter().filter(|it| it.is_planned()).collect();
    let unusable = &plan.outlook.unusable;
    if planned.is_empty() && unusable.is_empty() {
        return None;
    }
    widgets::section_head(ui, tokens, texts::OUTLOOK_HEAD);
    let name_of = |id| site.schedule(id).map_or("", |schedule: &Schedule| schedule.name.as_str());
    let duration_s: f64 = planned.iter().map(|it| plan.duration(it.mission).secs_f64()).sum();
    widgets::sentence(ui, tokens, &texts::outlook(planned.len(), duration_s, plan.conflicts.len()));
    for (schedule, reason) in unusable {
        finding(ui, tokens, tokens.bad, &texts::unusable(name_of(*schedule), reason));
    }
    let mut moved = None;
    for (running, due) in plan.conflicts.iter().take(FINDINGS.max_findings) {
        let (running, due) = (&plan.outlook.occurrences[*running], &plan.outlook.occurrences[*due]);
        let policy = site.schedule(due.schedule).map(|schedule| schedule.overlap).unwrap_or_default();
        let (name, other) = (name_of(due.schedule), name_of(running.schedule));
        let sentence = if running.due == due.due {
            texts::due_together(plan.local(due), name, other, policy)
        } else {
            texts::conflict(plan.local(due), name, other, policy)
        };
        let free = plan.free_after(running);
        let to = free.filter(|to| *to != plan.local(due));
        widgets::tinted_box(ui, tokens, tokens.warn, |ui| {
            widgets::sentence(ui, tokens, &sentence);
            if let Some(to) = to {
                let text = texts::move_to(name, to);
                if Button::new(&text).left().wide(ui).show(ui, tokens).clicked() {
                    moved = Some((due.schedule, due.slot, to));
                }
            }
        });
    }
    let changes = planned.iter().filter(|it| it.change != ClockChange::None);
    for occurrence in changes.take(FINDINGS.max_findings) {
        let change = texts::clock_change(occurrence.slot, plan.local(occurrence), occurrence.change);
        finding(ui, tokens, tokens.dim, &change.unwrap_or_default());
    }
    for schedule in &plan.of_week.shortened {
        finding(ui, tokens, tokens.dim, &texts::shortened(name_of(*schedule)));
    }
    moved
}

fn finding(ui: &mut Ui, tokens: &Tokens, colour: egui::Color32, sentence: &str) {
    widgets::tinted_box(ui, tokens, colour, |ui| widgets::sentence(ui, tokens, sentence));
}

/// Missions and schedules as a file.
fn show_files(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let tokens = cx.tokens;
    widgets::section_head(ui, tokens, texts::FILES_HEAD);
    for (name, sign, command) in [
        (texts::SAVE, icon::DOWNLOAD_SIMPLE, ClientCommand::SavePlanFile),
        (texts::LOAD, icon::UPLOAD_SIMPLE, ClientCommand::LoadPlanFile),
    ] {
        if Button::new(name).icon(sign).wide(ui).show(ui, tokens).clicked() {
            cx.commands.push(command);
        }
    }
}
