//! The time line: one mark for each result, as wide as a pixel, coloured and as high as its judgement is remarkable. A drag zooms in, a press chooses, arrow keys go on.

use super::texts;
use super::time_axis::{DAY_MIN, TimeAxis};
use crate::feature_panel::PanelContext;
use crate::paint::focus_ring;
use crate::theme::{self, Tokens, Weight, font};
use client_model::{ClientCommand, HistorySpan, PointHistory, PointHistoryCommand, ResultJudgement};
use egui::accesskit::Action;
use egui::{
    Align2, Color32, EventFilter, Id, Key, Rect, Response, Sense, Stroke, Ui, WidgetInfo, pos2, vec2,
};
use missions::SiteZone;
use site_model::Utc;

/// Height of the marks, points.
const MARKS_HEIGHT: f32 = 48.0;
/// Height of the labels below them, points.
const LABELS_HEIGHT: f32 = 18.0;
/// Room for a letter at both ends, points.
const LETTER_ROOM: f32 = 14.0;
/// Half the diagonal of the diamond of a changed photo, and how far it is above the mark of its result, points.
const CHANGE_RADIUS: f32 = 4.0;
const CHANGE_GAP: f32 = 5.0;
/// Shortest drag that zooms, points. Chosen: a press that slips is shorter.
const MIN_DRAG: f32 = 6.0;

/// The time line, with what it keeps between frames.
#[derive(Debug, Default)]
pub(super) struct Strip {
    /// Where the drag that zooms began.
    drag_from: Option<Utc>,
}

impl Strip {
    /// Shows the time line over the width that there is. `id`: where it is shown, because there may be two.
    pub(super) fn show(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, zone: &SiteZone, id: &'static str) {
        let model = cx.model;
        let history = &model.point_history;
        let Some(range) = history.range() else { return };
        let size = vec2(ui.available_width(), MARKS_HEIGHT + LABELS_HEIGHT);
        let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
        let (place, labels) = rect.split_top_bottom_at_y(rect.top() + MARKS_HEIGHT);
        let response = ui.interact(place, id_of(id), Sense::click_and_drag());
        let value = texts::strip_value(history, zone);
        describe(&response, history, &value);
        let axis = TimeAxis::new(range, place.shrink2(vec2(LETTER_ROOM, 0.0)));
        if ui.is_rect_visible(rect) {
            paint(ui, cx.tokens, history, &axis, place);
            paint_labels(ui, cx.tokens, &axis, labels, zone);
            if response.has_focus() {
                focus_ring(ui, place, cx.tokens);
            }
        }
        self.follow_pointer(ui, cx, &axis, &response, place);
        follow_keys(ui, cx, &response);
    }

    /// A drag shows the stretch that it covers, and a press chooses the nearest result.
    fn follow_pointer(
        &mut self,
        ui: &Ui,
        cx: &mut PanelContext<'_>,
        axis: &TimeAxis,
        response: &Response,
        place: Rect,
    ) {
        if response.drag_started() {
            let origin = ui.input(|input| input.pointer.press_origin());
            self.drag_from = origin.map(|origin| axis.at(origin.x));
        } else if !response.dragged() && !response.drag_stopped() {
            self.drag_from = None;
        }
        let Some(pointer) = response.interact_pointer_pos() else { return };
        if let Some(from) = self.drag_from {
            let covered =
                Rect::from_two_pos(pos2(axis.x(from), place.top()), pos2(pointer.x, place.bottom()));
            ui.painter_at(place).rect_filled(covered, 0.0, cx.tokens.accent.gamma_multiply(0.25));
            if response.drag_stopped() {
                self.drag_from = None;
                if covered.width() >= MIN_DRAG {
                    let [from, to] = [covered.left(), covered.right()].map(|x| axis.at(x));
                    ask(cx, PointHistoryCommand::ShowSpan(HistorySpan::Between([from, to])));
                }
            }
        }
        if response.clicked()
            && let Some(number) = nearest(&cx.model.point_history, axis, axis.at(pointer.x))
        {
            response.request_focus();
            ask(cx, PointHistoryCommand::Choose(number));
        }
    }
}

/// Id of the time line in the focus.
pub(super) fn id_of(place: &'static str) -> Id {
    Id::unique(("time line", place))
}

/// In the accessible tree: a slider over the results.
fn describe(response: &Response, history: &PointHistory, value: &str) {
    let count = history.results().len();
    let place = history.later().and_then(|later| history.place_of(later.number)).unwrap_or(0);
    response.widget_info(|| WidgetInfo::slider(true, place as f64, texts::STRIP));
    response.ctx.accesskit_node_builder(response.id, |node| {
        node.set_min_numeric_value(0.0);
        node.set_max_numeric_value(count.saturating_sub(1) as f64);
        node.set_value(value);
    });
}

/// The most remarkable judgement of each column of a pixel that has a result.
pub(super) fn columns(history: &PointHistory, axis: &TimeAxis) -> Vec<Option<ResultJudgement>> {
    let mut columns = vec![None; axis.columns()];
    for (result, judgement) in history.judged() {
        if let Some(column) = axis.column(result.at) {
            columns[column] = columns[column].max(Some(judgement));
        }
    }
    columns
}

/// Colour of a judgement, and the share of the height of its mark.
pub(super) fn look_of(tokens: &Tokens, judgement: ResultJudgement) -> (Color32, f32) {
    match judgement {
        ResultJudgement::NotJudged => (tokens.accent, 0.45),
        ResultJudgement::Usual => (tokens.good, 0.45),
        ResultJudgement::Unusual => (tokens.warn, 0.7),
        ResultJudgement::OutsideLimits => (tokens.bad, 1.0),
    }
}

fn paint(ui: &Ui, tokens: &Tokens, history: &PointHistory, axis: &TimeAxis, place: Rect) {
    let painter = ui.painter_at(place.expand(2.0));
    painter.rect_filled(place, f32::from(theme::BUTTON_RADIUS), tokens.raised);
    let room = place.shrink2(vec2(0.0, 6.0));
    for (column, judgement) in columns(history, axis).into_iter().enumerate() {
        let Some(judgement) = judgement else { continue };
        let (colour, share) = look_of(tokens, judgement);
        let x = axis.column_x(column);
        let top = room.bottom() - share * room.height();
        painter.line_segment([pos2(x, room.bottom()), pos2(x, top)], Stroke::new(2.0, colour));
    }
    for result in history.results().iter().filter(|result| result.changes() > 0) {
        let Some(column) = axis.column(result.at) else { continue };
        let (_, share) = look_of(tokens, history.judgement(result.number));
        let at = pos2(axis.column_x(column), room.bottom() - share * room.height() - CHANGE_GAP);
        let [right, down] = [vec2(CHANGE_RADIUS, 0.0), vec2(0.0, CHANGE_RADIUS)];
        let corners = vec![at - right, at - down, at + right, at + down];
        painter.add(egui::Shape::convex_polygon(corners, tokens.warn, Stroke::NONE));
    }
    for (result, letter, colour) in [
        (history.earlier(), texts::EARLIER_LETTER, tokens.older),
        (history.later(), texts::LATER_LETTER, tokens.newer),
    ] {
        let Some(x) =
            result.filter(|result| axis.column(result.at).is_some()).map(|result| axis.x(result.at))
        else {
            continue;
        };
        painter.line_segment([pos2(x, place.top()), pos2(x, place.bottom())], Stroke::new(1.5, colour));
        // A stands left of its line and B right of it, so that neighbours stay legible.
        let (align, side) =
            if letter == texts::EARLIER_LETTER { (Align2::RIGHT_TOP, -3.0) } else { (Align2::LEFT_TOP, 3.0) };
        let at = pos2(x + side, place.top() + 1.0);
        painter.text(at, align, letter, font(theme::SMALL, Weight::SemiBold), colour);
    }
}

/// Paints the labels of an axis of time below a plot.
pub(super) fn paint_labels(ui: &Ui, tokens: &Tokens, axis: &TimeAxis, place: Rect, zone: &SiteZone) {
    let (labels, step_min) = axis.labels(zone);
    let mut free_from = place.left();
    for at in labels {
        let local = zone.to_local(at);
        let text = if step_min < DAY_MIN { texts::clock_label(local) } else { texts::day_label(local) };
        let small = font(theme::SMALL, Weight::Regular);
        let galley = ui.painter().layout_no_wrap(text, small, tokens.dim);
        let left = (axis.x(at) - 0.5 * galley.size().x).clamp(place.left(), place.right() - galley.size().x);
        if left >= free_from {
            free_from = left + galley.size().x + 6.0;
            ui.painter().galley(pos2(left, place.top() + 2.0), galley, tokens.dim);
        }
    }
}

/// The result that is nearest to an instant, among those that are shown.
pub(super) fn nearest(history: &PointHistory, axis: &TimeAxis, at: Utc) -> Option<u64> {
    let shown = history.results().iter().filter(|result| axis.column(result.at).is_some());
    let nearest = shown.min_by_key(|result| result.at.0.abs_diff(at.0));
    nearest.map(|result| result.number)
}

fn follow_keys(ui: &Ui, cx: &mut PanelContext<'_>, response: &Response) {
    let step = asked_step(ui, response) + if holds_arrows(ui, response) { pressed_step(ui) } else { 0 };
    if step != 0 {
        ask(cx, PointHistoryCommand::Step(step));
    }
}

/// Keeps the arrow keys for a control that has the focus. Returns whether it has it.
pub(super) fn holds_arrows(ui: &Ui, response: &Response) -> bool {
    let filter = EventFilter { horizontal_arrows: true, ..EventFilter::default() };
    let has_focus = response.has_focus();
    if has_focus {
        ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
    }
    has_focus
}

/// Steps that were asked of a slider over the accessible tree.
pub(super) fn asked_step(ui: &Ui, response: &Response) -> i64 {
    let asked = |action| ui.input(|input| input.num_accesskit_action_requests(response.id, action) as i64);
    asked(Action::Increment) - asked(Action::Decrement)
}

/// Steps by which the arrow keys go on: to the right, less those to the left.
pub(super) fn pressed_step(ui: &Ui) -> i64 {
    ui.input(|input| {
        let pressed = |key| i64::from(input.key_pressed(key));
        pressed(Key::ArrowRight) - pressed(Key::ArrowLeft)
    })
}

/// Asks something of the history.
pub(super) fn ask(cx: &mut PanelContext<'_>, command: PointHistoryCommand) {
    cx.commands.push(ClientCommand::PointHistory(command));
}
