//! Aligning one saved map to another: choosing the reference, picking corresponding points, starting the job.

#[cfg(test)]
mod tests;
mod texts;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::features::{imports, tabs};
use crate::map_name::map_name;
use crate::message::show_message;
use crate::{format, icon, widgets};
use api::{Import, MAX_PAIR_RMS_M, Mapping};
use client_model::{AlignmentDraft, ClientCommand, Model};
use egui::Ui;
use vocab::MapId;

/// The least residual that is shown, metres.
const LEAST_RESIDUAL_M: f64 = 1e-3;
/// Pairs of points that an alignment needs.
const MIN_PAIRS: usize = 2;

/// The panel. It keeps nothing between frames.
#[derive(Debug, Default)]
pub(crate) struct AlignmentPanel;

impl FeaturePanel for AlignmentPanel {
    fn show_messages(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let is_picking =
            |alignment: &&AlignmentDraft| alignment.reference.is_some() && alignment.job.is_none();
        let Some(alignment) = cx.model.alignment().filter(is_picking) else { return };
        let (tokens, sentence) = (cx.tokens, next_step(cx.model, alignment));
        show_message(ui, tokens, tokens.accent, icon::ARROWS_DOWN_UP, &sentence, |ui| {
            if Button::new(texts::CANCEL_SHORT).show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::CancelAlignment);
            }
        });
    }

    fn tabs(&self) -> &'static [Tab] {
        &[tabs::SESSION]
    }

    /// Shown in the place of the saved maps, and of the whole tab while nothing is mapped.
    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let Some(alignment) = cx.model.alignment() else { return };
        if *cx.model.mapping() != Mapping::Idle {
            ui.add_space(4.0);
            widgets::rule(ui, cx.tokens);
        }
        show(ui, cx, alignment);
    }
}

/// The button of the map that is viewed, if there is another map to align it to.
pub(crate) fn show_offer(ui: &mut Ui, cx: &mut PanelContext<'_>, map: MapId) {
    let (model, tokens) = (cx.model, cx.tokens);
    if model.maps().len() < 2 {
        return;
    }
    let name = texts::align(map_name(model, map));
    let button = Button::new(&name).text(texts::OFFER_SHORT).icon(icon::ARROWS_DOWN_UP);
    if button.enabled(model.is_connected()).wide(ui).show(ui, tokens).clicked() {
        cx.commands.push(ClientCommand::AlignMap { map, reference: None });
    }
    widgets::remark(ui, tokens, texts::OFFER_HINT);
}

/// The card while an alignment is prepared.
fn show(ui: &mut Ui, cx: &mut PanelContext<'_>, alignment: &AlignmentDraft) {
    let tokens = cx.tokens;
    widgets::head(ui, tokens, &texts::align(map_name(cx.model, alignment.map)));
    match alignment.reference {
        None => show_references(ui, cx, alignment.map),
        Some(reference) => {
            let contradictory = show_agreement(ui, cx, alignment, reference);
            if alignment.job.is_some() {
                show_job(ui, cx);
            } else {
                show_view_button(ui, cx, alignment, reference);
                show_remove_button(ui, cx, alignment);
                show_start(ui, cx, alignment, contradictory);
            }
        }
    }
    if alignment.job.is_none() {
        let cancel = Button::new(texts::CANCEL).text(texts::CANCEL_SHORT).icon(icon::X);
        if cancel.wide(ui).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::CancelAlignment);
        }
    }
}

/// A button for each map that can be the reference.
fn show_references(ui: &mut Ui, cx: &mut PanelContext<'_>, map: MapId) {
    let tokens = cx.tokens;
    widgets::remark(ui, tokens, texts::CHOOSE_REFERENCE);
    for other in cx.model.maps().list().into_iter().flatten().filter(|other| other.id != map) {
        let name = texts::reference(&other.name);
        let button = Button::new(&name).text(&other.name).icon(icon::MAP_TRIFOLD);
        if button.wide(ui).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::AlignMap { map, reference: Some(other.id) });
        }
    }
}

/// The reference, the number of pairs, and how well they agree. Returns whether they contradict each other.
fn show_agreement(ui: &mut Ui, cx: &PanelContext<'_>, alignment: &AlignmentDraft, reference: MapId) -> bool {
    let tokens = cx.tokens;
    widgets::fact(ui, tokens, texts::REFERENCE, map_name(cx.model, reference));
    widgets::fact(ui, tokens, texts::PAIRS, &format::count(alignment.pairs.len() as u64));
    let Some(residual_m) = alignment.rms_residual_m() else { return false };
    widgets::fact(ui, tokens, texts::RESIDUAL, &format::accuracy(residual_m.max(LEAST_RESIDUAL_M)));
    let contradictory = residual_m > MAX_PAIR_RMS_M;
    if contradictory {
        widgets::tinted_box(ui, tokens, tokens.warn, |ui| {
            widgets::sentence(ui, tokens, texts::CONTRADICTION)
        });
    }
    contradictory
}

/// The job that makes the aligned map; it runs as an import.
fn show_job(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    match cx.model.imports.import() {
        Import::Running { .. } => imports::show(ui, cx),
        _ => widgets::remark(ui, cx.tokens, texts::JOB_REQUESTED),
    }
}

/// Views the other one of the two maps.
fn show_view_button(ui: &mut Ui, cx: &mut PanelContext<'_>, alignment: &AlignmentDraft, reference: MapId) {
    let model = cx.model;
    let other = if model.viewed_map() == Some(reference) { alignment.map } else { reference };
    let name = texts::view(map_name(model, other));
    if Button::new(&name).icon(icon::EYE).wide(ui).show(ui, cx.tokens).clicked() {
        cx.commands.push(ClientCommand::ViewMap(Some(other)));
    }
}

fn show_remove_button(ui: &mut Ui, cx: &mut PanelContext<'_>, alignment: &AlignmentDraft) {
    let button = Button::new(texts::REMOVE_POINT).text(texts::REMOVE_POINT_SHORT);
    let button = button.icon(icon::ARROW_COUNTER_CLOCKWISE).hint(texts::REMOVE_POINT_KEYS);
    if button.enabled(has_points(alignment)).wide(ui).show(ui, cx.tokens).clicked() {
        cx.commands.push(ClientCommand::RemoveAlignmentPoint);
    }
}

/// Starts the job: by the picked points, or by appearance if there are none.
fn show_start(ui: &mut Ui, cx: &mut PanelContext<'_>, alignment: &AlignmentDraft, contradictory: bool) {
    let tokens = cx.tokens;
    let connected = cx.model.is_connected();
    let clicked = if has_points(alignment) {
        let text = texts::start_by_points_short(alignment.pairs.len());
        let determined = alignment.pairs.len() >= MIN_PAIRS && alignment.rms_residual_m().is_some();
        let button = Button::new(texts::START_BY_POINTS).text(&text).icon(icon::CHECK_CIRCLE);
        let button = button.kind(Kind::Primary).enabled(connected && determined && !contradictory);
        button.wide(ui).show(ui, tokens).clicked()
    } else {
        let button = Button::new(texts::START_BY_APPEARANCE).icon(icon::CHECK_CIRCLE).enabled(connected);
        let clicked = button.wide(ui).show(ui, tokens).clicked();
        widgets::remark(ui, tokens, texts::START_BY_APPEARANCE_HINT);
        clicked
    };
    if clicked {
        cx.commands.push(ClientCommand::StartAlignment);
    }
}

fn has_points(alignment: &AlignmentDraft) -> bool {
    !alignment.pairs.is_empty() || alignment.unpaired.is_some()
}

/// What the operator does next.
fn next_step(model: &Model, alignment: &AlignmentDraft) -> String {
    let Some(next) = alignment.next_map() else { return texts::ENOUGH_POINTS.to_owned() };
    let map = map_name(model, next);
    if model.viewed_map() != Some(next) {
        texts::step_view(map)
    } else if alignment.unpaired.is_some() {
        texts::step_second_point(map)
    } else {
        texts::step_first_point(map, alignment.pairs.len() + 1)
    }
}
