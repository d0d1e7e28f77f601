//! The loops of the map being made: how many there are, the list of them, adding one by hand.

mod evidence;
#[cfg(test)]
mod tests;

use crate::button::{Button, Kind};
use crate::theme::{self, Tokens, Weight, font};
use crate::{PanelState, icon, widgets, words};
use api::{LoopDecision, LoopVerdict};
use client_model::{CameraMove, ClientCommand, LoopInitialGuess, LoopPair, LoopPick, Model, Selection};
use egui::{Color32, CornerRadius, Rect, Role, Sense, Ui, WidgetInfo, pos2, vec2};

/// Height of a row of the list, points: dense, but a finger hits it.
const ROW: f32 = 44.0;
/// Rows that stay in sight above the evidence of the selected one.
const ROWS_ABOVE_EVIDENCE: f32 = 2.0;
/// Where there is less room than this for list and evidence together, points, the evidence alone is shown.
const ROOM_FOR_BOTH: f32 = 560.0;

pub(crate) fn show(
    ui: &mut Ui,
    model: &Model,
    tokens: &Tokens,
    state: &mut PanelState,
    out: &mut Vec<ClientCommand>,
) {
    ui.spacing_mut().item_spacing.y = 8.0;
    if model.viewed_map().is_some() {
        saved(ui, model, tokens);
        return;
    }
    counts(ui, model, tokens);
    match model.loop_pick() {
        Some(pick) => return picking(ui, model, tokens, pick, out),
        None => actions(ui, model, tokens, out),
    }
    if let Some(proposed) = model.loops.proposal() {
        let text = format!("Comparing keyframes {}…", words::pair(proposed.pair));
        widgets::tinted_box(ui, tokens, tokens.accent, |ui| widgets::sentence(ui, tokens, &text));
    }
    let selected = match model.selection() {
        Some(Selection::Loop(pair)) => Some(pair),
        _ => None,
    };
    widgets::rule(ui, tokens);
    let Some(pair) = selected else { return list(ui, model, tokens, state, None, out) };
    if ui.available_height() >= ROOM_FOR_BOTH {
        let height = ROW * ROWS_ABOVE_EVIDENCE + 4.0;
        ui.allocate_ui(vec2(ui.available_width(), height), |ui| {
            ui.set_height(height);
            list(ui, model, tokens, state, selected, out);
        });
        widgets::rule(ui, tokens);
    }
    evidence::show(ui, model, tokens, pair, out);
}

/// Of a saved map only its edges are known.
fn saved(ui: &mut Ui, model: &Model, tokens: &Tokens) {
    let closed = words::count(model.displayed_map().graph.loops.len() as u64);
    widgets::fact(ui, tokens, "Closed loops", &closed);
    let text = "Loops can be looked into and decided on while a map is being made. This one is finished; its loops.json \
                holds what was decided.";
    widgets::remark(ui, tokens, text);
}

/// Three figures side by side.
fn counts(ui: &mut Ui, model: &Model, tokens: &Tokens) {
    let counts = model.loops.decisions().counts();
    let width = (ui.available_width() - 16.0) / 3.0;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        for (name, verdict, number) in [
            ("Accepted", LoopVerdict::Accepted, counts.accepted),
            ("Under test", LoopVerdict::Held, counts.held),
            ("Rejected", LoopVerdict::Rejected, counts.rejected),
        ] {
            figure(ui, tokens, width, name, verdict, number);
        }
    });
}

fn figure(ui: &mut Ui, tokens: &Tokens, width: f32, name: &str, verdict: LoopVerdict, number: usize) {
    let (rect, response) = ui.allocate_exact_size(vec2(width, 52.0), Sense::hover());
    let painter = ui.painter();
    painter.rect_filled(rect, CornerRadius::same(theme::BUTTON_RADIUS), tokens.raised);
    let (sign, colour) = sign_of(verdict, tokens);
    let left = rect.left() + 10.0;
    widgets::icon_at(ui, pos2(left + 8.0, rect.top() + 17.0), sign, theme::ICON, colour);
    let text = words::count(number as u64);
    let (large, small) = (font(theme::HEAD, Weight::SemiBold), font(theme::SMALL, Weight::Regular));
    painter.text(pos2(left + 24.0, rect.top() + 17.0), egui::Align2::LEFT_CENTER, &text, large, tokens.text);
    painter.text(pos2(left, rect.bottom() - 14.0), egui::Align2::LEFT_CENTER, name, small, tokens.dim);
    widgets::status_node(&response, &format!("{name} loops"), &text);
}

/// Adding a loop, and taking the last decision back.
fn actions(ui: &mut Ui, model: &Model, tokens: &Tokens, out: &mut Vec<ClientCommand>) {
    let locked = evidence::locked(model);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        let width = (ui.available_width() - 8.0) * 0.5;
        let add = Button::new("Add a loop").icon(icon::PLUS).size(width, theme::TOUCH);
        let enough = model.live_map().graph.nodes.len() > 2;
        if add.enabled(locked.is_none() && enough).show(ui, tokens).clicked() {
            out.push(ClientCommand::PickLoopKeyframes(true));
        }
        let last = model.last_loop_edit();
        let hint = last.map_or_else(
            || "Nothing was decided here yet.".to_owned(),
            |step| {
                let was = if step.accepted { "accepting" } else { "rejecting" };
                format!("Takes back {was} {}. Ctrl Z", words::pair(step.pair))
            },
        );
        let undo =
            Button::new("Undo the decision").text("Undo").icon(icon::ARROW_COUNTER_CLOCKWISE).hint(&hint);
        let undo = undo.enabled(last.is_some() && locked.is_none());
        if undo.size(width, theme::TOUCH).show(ui, tokens).clicked() {
            out.push(ClientCommand::UndoLoop);
        }
    });
    if let Some(sentence) = locked {
        widgets::remark(ui, tokens, &sentence);
    }
}

/// The list, newest first; only the rows in sight are made.
fn list(
    ui: &mut Ui,
    model: &Model,
    tokens: &Tokens,
    state: &mut PanelState,
    selected: Option<LoopPair>,
    out: &mut Vec<ClientCommand>,
) {
    if model.loops.decisions().is_empty() {
        let text = "No loops yet. Where the robot comes back to a place it has seen, the two are compared here by \
                    themselves.";
        widgets::remark(ui, tokens, text);
        return;
    }
    ui.spacing_mut().item_spacing.y = 4.0;
    let mut area = egui::ScrollArea::vertical().id_salt("loops").auto_shrink([false, false]);
    // What gets selected comes into sight.
    if selected != state.listed_loop {
        state.listed_loop = selected;
        let row = model.loops.latest().position(|decision| Some(LoopPair::of_decision(decision)) == selected);
        if let Some(row) = row {
            area = area.vertical_scroll_offset((row as f32 - 0.5).max(0.0) * (ROW + 4.0));
        }
    }
    area.show_rows(ui, ROW, model.loops.decisions().len(), |ui, rows| {
        for decision in rows.filter_map(|n| model.loops.decisions().nth_latest(n)) {
            row(ui, tokens, decision, selected, out);
        }
    });
}

fn row(
    ui: &mut Ui,
    tokens: &Tokens,
    decision: &LoopDecision,
    selected: Option<LoopPair>,
    out: &mut Vec<ClientCommand>,
) {
    let pair = LoopPair::of_decision(decision);
    let on = selected == Some(pair);
    let (rect, response) = ui
        .push_id(pair.from.0, |ui| {
            ui.push_id(pair.to.0, |ui| {
                ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::click())
            })
        })
        .inner
        .inner;
    let verdict = words::verdict(decision.verdict);
    let name = format!("Loop {}: {}. {}", words::pair(pair), verdict.to_lowercase(), decision.reason);
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, on, &name));
    if response.clicked() {
        out.push(ClientCommand::Select((!on).then_some(Selection::Loop(pair))));
        if !on {
            out.push(ClientCommand::MoveCamera(CameraMove::Loop(pair)));
        }
    }
    paint_row(ui, tokens, decision, rect, (on, response.hovered()));
    if response.has_focus() {
        widgets::focus_ring(ui, rect.shrink(2.0), tokens);
    }
}

fn paint_row(ui: &Ui, tokens: &Tokens, decision: &LoopDecision, rect: Rect, (on, hovered): (bool, bool)) {
    let fill = if on { tokens.selected() } else { tokens.raised };
    let fill = if hovered { tokens.hovered(fill) } else { fill };
    ui.painter().rect_filled(rect, CornerRadius::same(theme::BUTTON_RADIUS), fill);
    let (sign, colour) = sign_of(decision.verdict, tokens);
    widgets::icon_at(ui, pos2(rect.left() + 20.0, rect.center().y), sign, theme::ICON, colour);
    let (left, right) = (rect.left() + 40.0, rect.right() - 10.0);
    let painter = ui.painter();
    let (name, small) = (font(theme::BODY, Weight::Medium), font(theme::SMALL, Weight::Regular));
    let pair = words::pair(LoopPair::of_decision(decision));
    painter.text(pos2(left, rect.top() + 14.0), egui::Align2::LEFT_CENTER, pair, name, tokens.text);
    let by = if decision.by_hand { "by hand · " } else { "" };
    let verdict = format!("{by}{}", words::verdict(decision.verdict).to_lowercase());
    painter.text(pos2(right, rect.top() + 14.0), egui::Align2::RIGHT_CENTER, verdict, small.clone(), colour);
    let mut job = egui::text::LayoutJob::simple_singleline(decision.reason.clone(), small, tokens.dim);
    job.wrap = egui::text::TextWrapping::truncate_at_width(right - left);
    let reason = painter.layout_job(job);
    let at = pos2(left, rect.bottom() - 14.0 - 0.5 * reason.size().y);
    painter.galley(at, reason, tokens.dim);
}

/// Sign and colour of a verdict; the word stands beside them.
pub(crate) fn sign_of(verdict: LoopVerdict, tokens: &Tokens) -> (&'static str, Color32) {
    match verdict {
        LoopVerdict::Accepted => (icon::CHECK_CIRCLE, tokens.closed),
        LoopVerdict::Held => (icon::CLOCK_COUNTDOWN, tokens.warn),
        LoopVerdict::Rejected | LoopVerdict::Dropped => (icon::X_CIRCLE, tokens.dim),
    }
}

/// Choosing two keyframes and proposing them.
fn picking(ui: &mut Ui, model: &Model, tokens: &Tokens, pick: LoopPick, out: &mut Vec<ClientCommand>) {
    widgets::rule(ui, tokens);
    widgets::head(ui, tokens, "Add a loop");
    let hint = words::loop_step(pick);
    widgets::tinted_box(ui, tokens, tokens.accent, |ui| widgets::sentence(ui, tokens, &hint));
    if let LoopPick::Both(pair) = pick {
        propose(ui, model, tokens, pair, out);
    }
    if Button::new("Cancel adding").text("Cancel").icon(icon::X).wide(ui).show(ui, tokens).clicked() {
        out.push(ClientCommand::PickLoopKeyframes(false));
    }
}

fn propose(ui: &mut Ui, model: &Model, tokens: &Tokens, pair: LoopPair, out: &mut Vec<ClientCommand>) {
    let apart = model.loop_initial_guess(pair, LoopInitialGuess::Graph).map_or(0.0, |from_from_to| {
        let p = from_from_to.position;
        p.x.hypot(p.y).hypot(p.z)
    });
    widgets::fact(ui, tokens, "Apart in the graph", &words::distance(apart));
    widgets::remark(ui, tokens, "From where shall the comparison start? A metre or two off is near enough.");
    let choices =
        [("From the graph", LoopInitialGuess::Graph), ("Same place", LoopInitialGuess::SamePosition)];
    widgets::choice(ui, tokens, &choices, model.loops.initial_guess(), |guess| {
        out.push(ClientCommand::SetLoopInitialGuess(guess))
    });
    evidence::legend(ui, model, tokens, pair);
    let locked = if pair.is_adjacent() {
        Some("They follow each other on the walk and are joined already. Choose two others.".to_owned())
    } else {
        evidence::locked(model)
    };
    let button =
        Button::new("Propose").icon(icon::CHECK_CIRCLE).kind(Kind::Primary).enabled(locked.is_none());
    if button.wide(ui).show(ui, tokens).clicked() {
        out.push(ClientCommand::ProposeLoop);
    }
    let sentence = locked
        .unwrap_or_else(|| "The two scans are compared; you then see the evidence, and decide.".to_owned());
    widgets::remark(ui, tokens, &sentence);
}
