//! The list of loops, the newest first. Only the rows in sight are laid out, because a map can have thousands of loops.

use super::{LoopsPanel, sign_of, texts};
use crate::feature_panel::PanelContext;
use crate::theme::{self, Tokens, Weight, font};
use crate::{paint, widgets};
use api::LoopDecision;
use client_model::{CameraMove, ClientCommand, LoopPair, Model, Selection};
use egui::text::{LayoutJob, TextWrapping};
use egui::{Align2, CornerRadius, Rect, Response, Role, ScrollArea, Sense, Ui, WidgetInfo, pos2, vec2};

/// Height of a row, points. It is large enough for a finger.
const ROW_HEIGHT: f32 = 44.0;
/// Gap between two rows, points.
const ROW_GAP: f32 = 4.0;
/// Rows in sight above the evidence of the selected loop.
const ROWS_ABOVE_EVIDENCE: f32 = 2.0;
/// Height below which the evidence takes the place of the list, points.
const MIN_HEIGHT_FOR_BOTH: f32 = 560.0;

/// A few rows above the evidence of the selected loop, if there is room for both.
pub(super) fn show_above_evidence(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    panel: &mut LoopsPanel,
    selected: LoopPair,
) {
    if ui.available_height() < MIN_HEIGHT_FOR_BOTH {
        return;
    }
    let height = ROW_HEIGHT * ROWS_ABOVE_EVIDENCE + ROW_GAP;
    ui.allocate_ui(vec2(ui.available_width(), height), |ui| {
        ui.set_height(height);
        show(ui, cx, panel, Some(selected));
    });
    widgets::rule(ui, cx.tokens);
}

/// The list, as high as there is room.
pub(super) fn show(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    panel: &mut LoopsPanel,
    selected: Option<LoopPair>,
) {
    let model = cx.model;
    let decisions = model.loops.decisions();
    if decisions.is_empty() {
        widgets::remark(ui, cx.tokens, texts::NONE);
        return;
    }
    ui.spacing_mut().item_spacing.y = ROW_GAP;
    let mut area = ScrollArea::vertical().id_salt("loops").auto_shrink([false, false]);
    if let Some(offset) = offset_of_newly_selected(model, panel, selected) {
        area = area.vertical_scroll_offset(offset);
    }
    area.show_rows(ui, ROW_HEIGHT, decisions.len(), |ui, rows| {
        for decision in rows.filter_map(|row| decisions.nth_latest(row)) {
            show_row(ui, cx, decision, selected);
        }
    });
}

/// Scroll offset that brings a loop into sight in the frame in which it is selected, points.
fn offset_of_newly_selected(
    model: &Model,
    panel: &mut LoopsPanel,
    selected: Option<LoopPair>,
) -> Option<f32> {
    if selected == panel.scrolled_to {
        return None;
    }
    panel.scrolled_to = selected;
    let row = model.loops.latest().position(|decision| Some(LoopPair::of_decision(decision)) == selected)?;
    Some((row as f32 - 0.5).max(0.0) * (ROW_HEIGHT + ROW_GAP))
}

fn show_row(ui: &mut Ui, cx: &mut PanelContext<'_>, decision: &LoopDecision, selected: Option<LoopPair>) {
    let tokens = cx.tokens;
    let pair = LoopPair::of_decision(decision);
    let is_selected = selected == Some(pair);
    let (rect, response) = allocate_row(ui, pair);
    let name = texts::row(pair, decision.verdict, &decision.reason);
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_selected, &name));
    if response.clicked() {
        cx.commands.push(ClientCommand::Select((!is_selected).then_some(Selection::Loop(pair))));
        if !is_selected {
            cx.commands.push(ClientCommand::MoveCamera(CameraMove::Loop(pair)));
        }
    }
    let fill = if is_selected { tokens.selected() } else { tokens.raised };
    let fill = if response.hovered() { tokens.hovered(fill) } else { fill };
    ui.painter().rect_filled(rect, CornerRadius::same(theme::BUTTON_RADIUS), fill);
    paint_decision(ui, tokens, decision, rect);
    if response.has_focus() {
        paint::focus_ring(ui, rect.shrink(2.0), tokens);
    }
}

/// Room for a row. Its identity follows from the loop, so that it survives scrolling.
fn allocate_row(ui: &mut Ui, pair: LoopPair) -> (Rect, Response) {
    let size = vec2(ui.available_width(), ROW_HEIGHT);
    let allocate = |ui: &mut Ui| ui.allocate_exact_size(size, Sense::click());
    ui.push_id(pair.from.0, |ui| ui.push_id(pair.to.0, allocate).inner).inner
}

/// Icon, pair and verdict of a loop, and below them the reason, cut off where the row ends.
fn paint_decision(ui: &Ui, tokens: &Tokens, decision: &LoopDecision, rect: Rect) {
    let (sign, colour) = sign_of(decision.verdict, tokens);
    paint::icon_at(ui, pos2(rect.left() + 20.0, rect.center().y), sign, theme::ICON, colour);
    let (left, right) = (rect.left() + 40.0, rect.right() - 10.0);
    let (upper, lower) = (rect.top() + 14.0, rect.bottom() - 14.0);
    let (body, small) = (font(theme::BODY, Weight::Medium), font(theme::SMALL, Weight::Regular));
    let painter = ui.painter();
    let pair = texts::pair(LoopPair::of_decision(decision));
    painter.text(pos2(left, upper), Align2::LEFT_CENTER, pair, body, tokens.text);
    let verdict = texts::row_verdict(decision.verdict, decision.by_hand);
    painter.text(pos2(right, upper), Align2::RIGHT_CENTER, verdict, small.clone(), colour);
    let mut job = LayoutJob::simple_singleline(decision.reason.clone(), small, tokens.dim);
    job.wrap = TextWrapping::truncate_at_width(right - left);
    let reason = painter.layout_job(job);
    let at = pos2(left, lower - 0.5 * reason.size().y);
    painter.galley(at, reason, tokens.dim);
}
