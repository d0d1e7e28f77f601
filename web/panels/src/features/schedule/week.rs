//! The week as a grid: days side by side, hours from top to bottom, in the time of the site.

use super::grid::{GUTTER_WIDTH, HOUR_HEIGHT, WeekGrid};
use super::plan_cache::{CachedPlan, MINUTE_NS};
use super::state::{Drag, Dragged, Question, SchedulePanel};
use super::week_paint::{BlockLook, paint_block, paint_ghost, paint_hours, paint_now};
use super::{drag, texts};
use crate::feature_panel::PanelContext;
use crate::features::runs::skip_reason;
use crate::theme::{self, Tokens, Weight, font};
use client_model::{
    ClientCommand, DaySegment, Occurrence, OccurrenceState, ScheduleSelection, ShownSpan, lay_out_week,
};
use egui::{
    Align2, CornerRadius, EventFilter, Id, Key, Rect, Response, Role, ScrollArea, Sense, Ui, WidgetInfo,
    pos2, vec2,
};
use missions::{MINUTES_A_DAY, day_number, minute_number};
use site_model::{LocalDateTime, Site};

/// Height of the row of days, points.
const HEAD_HEIGHT: f32 = 36.0;

/// Parameters of the week.
struct WeekConfig {
    /// The hour that is at the top when the screen is opened. Chosen: before the work of most sites begins.
    first_hour: f32,
    /// Distance from the edge at which a drag scrolls, points. Chosen: a little less than a button for fingers (44).
    scroll_edge_pt: f32,
    /// Greatest speed of that scrolling, points per second. Chosen: a screen of 1,000 points passes in less than two seconds.
    max_scroll_pt_s: f32,
}

const CONFIG: WeekConfig = WeekConfig { first_hour: 6.0, scroll_edge_pt: 36.0, max_scroll_pt_s: 600.0 };

/// A mission that is shorter is drawn as long as this, so that its name can be read, minutes.
const MIN_SHOWN_MIN: i64 = 30;

impl SchedulePanel {
    /// Shows the week that is chosen.
    pub(super) fn show_week(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        plan: &CachedPlan,
        site: &Site,
    ) {
        let gutter = if plan.your_zone.is_some() { 2.0 * GUTTER_WIDTH } else { GUTTER_WIDTH };
        show_days(ui, cx.tokens, plan, gutter);
        let mut area = ScrollArea::vertical().id_salt("week").auto_shrink([false, false]);
        if !std::mem::replace(&mut self.is_scrolled, true) {
            area = area.vertical_scroll_offset(CONFIG.first_hour * HOUR_HEIGHT - 10.0);
        }
        area.show(ui, |ui| {
            let size = vec2(ui.available_width(), 24.0 * HOUR_HEIGHT);
            let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
            let grid = WeekGrid { rect, gutter };
            paint_hours(ui, cx.tokens, plan, &grid);
            self.show_blocks(ui, cx, plan, site, &grid);
            paint_now(ui, cx.tokens, plan, &grid);
            self.follow_pointer(ui, cx, plan, &grid);
            self.show_ghost(ui, cx, plan, site, &grid);
        });
    }

    /// The occurrences.
    fn show_blocks(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        plan: &CachedPlan,
        site: &Site,
        grid: &WeekGrid,
    ) {
        let occurrences = &plan.of_week.occurrences;
        let spans: Vec<ShownSpan> = occurrences.iter().map(|it| span_of(plan, it)).collect();
        for segment in lay_out_week(&spans) {
            let occurrence = &occurrences[segment.span];
            let rect = grid.segment(&segment);
            if ui.is_rect_visible(rect) {
                self.show_block(ui, cx, plan, site, occurrence, &segment, rect);
            }
        }
    }

    #[allow(clippy::too_many_arguments, reason = "one block and all that it depends on")]
    fn show_block(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        plan: &CachedPlan,
        site: &Site,
        occurrence: &Occurrence,
        segment: &DaySegment,
        rect: Rect,
    ) {
        let Some(schedule) = site.schedule(occurrence.schedule) else { return };
        let at = plan.local(occurrence);
        let is_past = plan.is_past(occurrence.due);
        let selection = ScheduleSelection { schedule: occurrence.schedule, slot: Some(occurrence.slot) };
        let is_selected = cx.model.schedule.selection() == Some(selection);
        let id =
            Id::unique(("occurrence", occurrence.schedule.0, minute_number(occurrence.slot), segment.day));
        let sense = if is_past { Sense::click() } else { Sense::click_and_drag() };
        let response = ui.interact(rect, id, sense);
        let outcome = cx.model.runs.slot(schedule.id, occurrence.slot);
        let skipped = cx.model.runs.skipped_slot(schedule.id, occurrence.slot).filter(|_| outcome.is_none());
        let state = match skipped {
            Some(_) => texts::SKIPPED,
            None => texts::state_with_outcome(occurrence.state, outcome, is_past),
        };
        let reason = skipped.map(|reason| skip_reason(site, reason));
        let name = texts::occurrence(&schedule.name, at, &texts::with_reason(state, reason.as_deref()));
        response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_selected, &name));
        let dragged =
            self.drag.is_some_and(|drag| drag.dragged == Dragged::Slot(schedule.id, occurrence.slot));
        let look = BlockLook {
            text: &texts::block(&schedule.name, at.time, state),
            state: if skipped.is_some() { OccurrenceState::Skipped } else { occurrence.state },
            outcome,
            is_past,
            is_selected,
            is_dragged: dragged,
            is_hovered: response.hovered(),
            is_focused: response.has_focus(),
            is_continued: segment.is_continued,
            continues: segment.continues,
        };
        paint_block(ui, cx.tokens, rect, &look);
        let response = response.on_hover_text(&name);
        if response.clicked() && !self.drag.is_some_and(|drag| drag.by_keys) {
            drag::select(cx, schedule.id, Some(occurrence.slot));
            // Where its form is in a drawer, that opens.
            cx.frame.drawer_open = true;
            response.request_focus();
        }
        if !is_past {
            self.begin_drag(ui, cx, plan, occurrence, &response, rect);
        }
    }

    /// A pointer that drags the block, or a key that moves it.
    fn begin_drag(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        plan: &CachedPlan,
        occurrence: &Occurrence,
        response: &Response,
        rect: Rect,
    ) {
        let dragged = Dragged::Slot(occurrence.schedule, occurrence.slot);
        if response.drag_started() {
            let pressed = ui.input(|input| input.pointer.press_origin()).unwrap_or(rect.left_top());
            let grip_min = (pressed.y - rect.top()) / HOUR_HEIGHT * 60.0;
            self.drag = Some(Drag { dragged, by_keys: false, grip_min, target: Some(occurrence.slot) });
        }
        if !response.has_focus() {
            return;
        }
        let filter = EventFilter {
            horizontal_arrows: true,
            vertical_arrows: true,
            escape: true,
            ..EventFilter::default()
        };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
        let is_moving = self.drag.is_some_and(|drag| drag.by_keys && drag.dragged == dragged);
        if let Some((days, steps)) = pressed_step(ui) {
            let start = Drag { dragged, by_keys: true, grip_min: 0.0, target: Some(occurrence.slot) };
            let mut moved = if is_moving { self.drag.unwrap_or(start) } else { start };
            moved.step(plan, days, steps);
            self.drag = Some(moved);
        } else if is_moving && ui.input(|input| input.key_pressed(Key::Enter)) {
            self.drop_dragged(cx, plan);
        } else if !is_moving && ui.input(|input| input.key_pressed(Key::Delete)) {
            self.question = Some(Question::Remove { schedule: occurrence.schedule, slot: occurrence.slot });
        }
        // The page's shortcuts rest while a control has the focus; that of undo is needed here.
        let command = ui.input(|input| {
            let is_pressed = input.modifiers.command && input.key_pressed(Key::Z);
            is_pressed.then_some(if input.modifiers.shift {
                ClientCommand::Redo
            } else {
                ClientCommand::Undo
            })
        });
        cx.commands.extend(command);
    }

    /// Moves what the pointer drags, scrolls at the edges, and drops it where the pointer lets go.
    fn follow_pointer(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, plan: &CachedPlan, grid: &WeekGrid) {
        let Some(drag) = self.drag.as_mut().filter(|drag| !drag.by_keys) else { return };
        let visible = ui.clip_rect();
        let (position, is_released) =
            ui.input(|input| (input.pointer.latest_pos(), input.pointer.any_released()));
        let inside = position.filter(|position| visible.contains(*position));
        match inside.and_then(|position| grid.at(position)) {
            Some((day, minute)) => drag.point_at(plan, day, minute),
            None => drag.target = None,
        }
        if let Some(position) = inside {
            let from_top = position.y - visible.top();
            let from_bottom = visible.bottom() - position.y;
            let dt = ui.input(|input| input.stable_dt).min(0.1);
            if from_top < CONFIG.scroll_edge_pt {
                ui.scroll_with_delta(vec2(0.0, CONFIG.max_scroll_pt_s * dt));
            } else if from_bottom < CONFIG.scroll_edge_pt {
                ui.scroll_with_delta(vec2(0.0, -CONFIG.max_scroll_pt_s * dt));
            }
        }
        ui.request_repaint();
        if is_released {
            self.drop_dragged(cx, plan);
        }
    }

    /// What is dragged, where it would be dropped.
    fn show_ghost(
        &self,
        ui: &mut Ui,
        cx: &PanelContext<'_>,
        plan: &CachedPlan,
        site: &Site,
        grid: &WeekGrid,
    ) {
        let question = self.question.and_then(|question| match question {
            Question::Move { schedule, from, to } => Some((Dragged::Slot(schedule, from), to)),
            Question::Remove { .. } => None,
        });
        let dragged = self.drag.and_then(|drag| Some((drag.dragged, drag.target?)));
        let Some((dragged, to)) = dragged.or(question) else { return };
        let (mission, name, from) = match dragged {
            Dragged::Mission(mission) => (mission, site.mission(mission).map(|it| it.name.as_str()), None),
            Dragged::Slot(schedule, from) => {
                let Some(schedule) = site.schedule(schedule) else { return };
                (schedule.mission, Some(schedule.name.as_str()), Some(from))
            }
        };
        let time = match from {
            Some(from) if from.time != to.time => texts::moved(from.time, to.time),
            _ => texts::time(to.time),
        };
        let length_min = (plan.duration(mission).nanos() / MINUTE_NS).max(MIN_SHOWN_MIN);
        let start_min = minute_number(to) - day_number(plan.week) * MINUTES_A_DAY;
        let is_past = plan.is_local_past(to);
        for segment in lay_out_week(&[ShownSpan { start_min, length_min }]) {
            let rect = grid.segment(&segment);
            paint_ghost(ui, cx.tokens, rect, &time, name.unwrap_or_default(), is_past);
            if self.drag.is_some_and(|drag| drag.by_keys) {
                ui.scroll_to_rect(rect.expand(HOUR_HEIGHT), None);
            }
        }
    }
}

/// Where an occurrence is drawn.
fn span_of(plan: &CachedPlan, occurrence: &Occurrence) -> ShownSpan {
    let begin = minute_number(plan.local(occurrence)) - day_number(plan.week) * MINUTES_A_DAY;
    let length_min = plan.duration(occurrence.mission).nanos() / MINUTE_NS;
    ShownSpan { start_min: begin, length_min: length_min.max(MIN_SHOWN_MIN) }
}

/// Days and steps of 15 minutes by which the arrow keys move a block.
fn pressed_step(ui: &Ui) -> Option<(i64, i64)> {
    let steps = [
        (Key::ArrowUp, (0, -1)),
        (Key::ArrowDown, (0, 1)),
        (Key::ArrowLeft, (-1, 0)),
        (Key::ArrowRight, (1, 0)),
    ];
    ui.input(|input| steps.into_iter().find_map(|(key, step)| input.key_pressed(key).then_some(step)))
}

/// The row of days above the grid.
fn show_days(ui: &mut Ui, tokens: &Tokens, plan: &CachedPlan, gutter: f32) {
    // The grid below has a scroll bar at its right.
    let scroll_bar = ui.spacing().scroll.allocated_width();
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), HEAD_HEIGHT), Sense::hover());
    let width = (rect.width() - scroll_bar - gutter) / 7.0;
    let today: LocalDateTime = plan.zone.to_local(plan.now);
    for day in 0..7 {
        let date = plan.day(day);
        let is_today = date == today.date;
        let left = rect.left() + gutter + day as f32 * width;
        let centre = pos2(left + 0.5 * width, rect.center().y);
        let (weight, colour) =
            if is_today { (Weight::SemiBold, tokens.accent) } else { (Weight::Medium, tokens.text) };
        let text_font = font(theme::BODY, weight);
        ui.painter().text(centre, Align2::CENTER_CENTER, texts::day_head(date), text_font, colour);
    }
    if plan.your_zone.is_some() {
        for (column, text) in [texts::SITE_COLUMN, texts::YOUR_COLUMN].into_iter().enumerate() {
            let at = pos2(rect.left() + (column as f32 + 1.0) * GUTTER_WIDTH - 8.0, rect.center().y);
            let text_font = font(theme::SMALL, Weight::Regular);
            ui.painter().text(at, Align2::RIGHT_CENTER, text, text_font, tokens.dim);
        }
    }
    let line = Rect::from_min_max(pos2(rect.left(), rect.bottom() - tokens.line_width), rect.max);
    ui.painter().rect_filled(line, CornerRadius::ZERO, tokens.line);
}
