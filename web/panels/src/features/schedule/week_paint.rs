//! How the grid of a week and its blocks look.

use super::grid::{GUTTER_WIDTH, WeekGrid};
use super::plan_cache::CachedPlan;
use super::texts;
use crate::paint::{focus_ring, lines};
use crate::theme::{self, Tokens, Weight, font, mix};
use client_model::OccurrenceState;
use egui::{Align2, Color32, CornerRadius, Pos2, Rect, Shape, Stroke, StrokeKind, Ui, pos2, vec2};
use missions::day_number;
use site_model::{LocalDateTime, LocalTime, RunState};

/// Length of a dash and of the gap after it, points.
const DASH: f32 = 5.0;
const DASH_GAP: f32 = 3.0;
/// A block that is narrower than this has room for a time only, points.
const TIME_WIDTH: f32 = 62.0;
/// Length of a time, such as `15:00`.
const TIME_CHARS: usize = 5;
/// Height of a row of text in a block, points.
const ROW_HEIGHT: f32 = 15.0;
/// Distance between the lines of a hatched block, points.
const HATCH: f32 = 8.0;

/// What a block looks like.
#[derive(Clone, Copy, Debug)]
pub(super) struct BlockLook<'a> {
    pub(super) text: &'a str,
    pub(super) state: OccurrenceState,
    /// The state of its run, if there is one.
    pub(super) outcome: Option<RunState>,
    pub(super) is_past: bool,
    pub(super) is_selected: bool,
    /// Whether it is dragged elsewhere: only its place is left.
    pub(super) is_dragged: bool,
    pub(super) is_hovered: bool,
    pub(super) is_focused: bool,
    /// Whether it goes on from the day before.
    pub(super) is_continued: bool,
    /// Whether it goes on in the day after.
    pub(super) continues: bool,
}

/// Lines and hours of the grid.
pub(super) fn paint_hours(ui: &Ui, tokens: &Tokens, plan: &CachedPlan, grid: &WeekGrid) {
    let painter = ui.painter();
    let faint = Stroke::new(1.0, tokens.faint());
    let today = plan.zone.to_local(plan.now).date;
    for day in 0..7 {
        let left = grid.day_left(day);
        if plan.day(day) == today {
            let column = Rect::from_min_max(
                pos2(left, grid.rect.top()),
                pos2(left + grid.day_width(), grid.rect.bottom()),
            );
            painter.rect_filled(
                column,
                CornerRadius::ZERO,
                mix(tokens.card.to_opaque(), tokens.accent, 0.05),
            );
        }
        painter.vline(left, grid.rect.y_range(), faint);
    }
    for hour in 0..24_u8 {
        let y = grid.y(60.0 * f32::from(hour));
        if hour > 0 {
            let from = grid.rect.left() + grid.gutter - 6.0;
            painter.hline(from..=grid.rect.right(), y, faint);
        }
        paint_hour(ui, tokens, plan, grid, hour, y);
    }
}

/// The hour at the site, and the time that the operator's clock then shows.
fn paint_hour(ui: &Ui, tokens: &Tokens, plan: &CachedPlan, grid: &WeekGrid, hour: u8, y: f32) {
    let at_column =
        |column: f32| pos2(grid.rect.left() + column * GUTTER_WIDTH - 8.0, y.max(grid.rect.top() + 7.0));
    let text_font = font(theme::SMALL, Weight::Regular);
    let site_time = LocalTime { hour, minute: 0 };
    let painter = ui.painter();
    painter.text(at_column(1.0), Align2::RIGHT_CENTER, texts::time(site_time), text_font.clone(), tokens.dim);
    if let Some(yours) = &plan.your_zone
        && let Some((utc, _)) = plan.zone.to_utc(LocalDateTime { date: plan.week, time: site_time })
    {
        let text = texts::time(yours.to_local(utc).time);
        let colour = mix(tokens.dim, tokens.card.to_opaque(), 0.25);
        painter.text(at_column(2.0), Align2::RIGHT_CENTER, text, text_font, colour);
    }
}

/// A line at the present time, across the present day.
pub(super) fn paint_now(ui: &Ui, tokens: &Tokens, plan: &CachedPlan, grid: &WeekGrid) {
    let now = plan.zone.to_local(plan.now);
    let day = day_number(now.date) - day_number(plan.week);
    if let Ok(day) = usize::try_from(day)
        && day < 7
    {
        let minute = f32::from(now.time.hour) * 60.0 + f32::from(now.time.minute);
        let (left, y) = (grid.day_left(day), grid.y(minute));
        ui.painter().circle_filled(pos2(left, y), 4.0, tokens.bad);
        ui.painter().hline(left..=left + grid.day_width(), y, Stroke::new(2.0, tokens.bad));
    }
}

fn corners(is_continued: bool, continues: bool) -> CornerRadius {
    let (top, bottom) = (if is_continued { 0 } else { 6 }, if continues { 0 } else { 6 });
    CornerRadius { nw: top, ne: top, sw: bottom, se: bottom }
}

/// Colour of a run in this state.
fn outcome_colour(tokens: &Tokens, outcome: RunState) -> Color32 {
    match outcome {
        RunState::Queued | RunState::Cancelled | RunState::Interrupted => tokens.dim,
        RunState::Running | RunState::Ending => tokens.accent,
        RunState::Paused | RunState::Suspended | RunState::Restarted | RunState::PartiallySucceeded => {
            tokens.warn
        }
        RunState::Succeeded => tokens.good,
        RunState::Failed => tokens.bad,
    }
}

/// A block.
pub(super) fn paint_block(ui: &Ui, tokens: &Tokens, rect: Rect, look: &BlockLook<'_>) {
    let ground = tokens.card.to_opaque();
    let (edge, tint, ink) = match look.outcome.map(|outcome| outcome_colour(tokens, outcome)) {
        Some(colour) => (colour, 0.16, tokens.text),
        None => match look.state {
            OccurrenceState::Planned if look.is_past => (tokens.dim, 0.16, tokens.dim),
            OccurrenceState::Planned => (tokens.accent, 0.14, tokens.text),
            OccurrenceState::Skipped => (tokens.warn, 0.12, tokens.text),
            OccurrenceState::Paused | OccurrenceState::SameInstant => (tokens.dim, 0.10, tokens.dim),
        },
    };
    let radius = corners(look.is_continued, look.continues);
    let (tint, ink) = if look.is_dragged { (0.4 * tint, tokens.dim) } else { (tint, ink) };
    let fill = mix(ground, edge, if look.is_selected { tint + 0.10 } else { tint });
    let fill = if look.is_hovered { tokens.hovered(fill) } else { fill };
    let painter = ui.painter().with_clip_rect(rect.expand(4.0).intersect(ui.clip_rect()));
    painter.rect_filled(rect, radius, fill);
    if !look.is_past && look.outcome.is_none() && look.state != OccurrenceState::Planned {
        paint_hatch(ui, rect, mix(fill, edge, 0.18));
    }
    let bar = Rect::from_min_size(rect.min, vec2(4.0, rect.height()));
    painter.rect_filled(bar, CornerRadius { ne: 0, se: 0, ..radius }, edge);
    if look.is_selected {
        painter.rect_stroke(rect, radius, Stroke::new(2.0, tokens.accent), StrokeKind::Inside);
    } else if !look.is_past && look.outcome.is_none() {
        dashed(ui, rect, mix(ground, edge, 0.6));
    }
    if look.is_focused {
        focus_ring(ui, rect, tokens);
    }
    if !look.is_continued {
        block_text(ui, rect, look.text, ink);
    }
}

/// What is dragged, where it would be dropped.
pub(super) fn paint_ghost(ui: &Ui, tokens: &Tokens, rect: Rect, time: &str, name: &str, is_past: bool) {
    let colour = if is_past { tokens.bad } else { tokens.accent };
    let radius = corners(false, false);
    ui.painter().add(theme::drag_shadow(tokens).as_shape(rect, radius));
    ui.painter().rect_filled(rect, radius, mix(tokens.card.to_opaque(), colour, 0.30));
    ui.painter().rect_stroke(rect, radius, Stroke::new(2.0, colour), StrokeKind::Inside);
    let line = if is_past { format!("{time} {}", texts::IN_THE_PAST) } else { format!("{time} {name}") };
    block_text(ui, rect, &line, tokens.text);
}

/// The text of a block, in as many lines as fit.
fn block_text(ui: &Ui, rect: Rect, text: &str, ink: Color32) {
    let inside = Rect::from_min_max(rect.min + vec2(10.0, 2.0), rect.max - vec2(3.0, 0.0));
    let text_font = font(theme::SMALL, Weight::Medium);
    let painter = ui.painter().with_clip_rect(inside.intersect(ui.clip_rect()));
    let rows = ((rect.height() - 4.0) / ROW_HEIGHT).floor().max(1.0) as usize;
    // Beside others there may be room for the time only.
    let text = if inside.width() < TIME_WIDTH { text.get(..TIME_CHARS).unwrap_or(text) } else { text };
    let galley = lines(ui, text, text_font, ink, inside.width().max(20.0), rows);
    let y = (inside.center().y - 0.5 * galley.size().y).min(inside.top() + 3.0);
    painter.galley(pos2(inside.left(), y), galley, ink);
}

fn dashed(ui: &Ui, rect: Rect, colour: Color32) {
    let inner = rect.shrink(0.75);
    let path: [Pos2; 5] =
        [inner.left_top(), inner.right_top(), inner.right_bottom(), inner.left_bottom(), inner.left_top()];
    ui.painter().extend(Shape::dashed_line(&path, Stroke::new(1.0, colour), DASH, DASH_GAP));
}

fn paint_hatch(ui: &Ui, rect: Rect, colour: Color32) {
    let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
    let height = rect.height();
    let mut x = rect.left() - height;
    while x < rect.right() {
        painter
            .line_segment([pos2(x, rect.bottom()), pos2(x + height, rect.top())], Stroke::new(2.0, colour));
        x += HATCH;
    }
}
