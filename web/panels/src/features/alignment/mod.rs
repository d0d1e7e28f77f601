//! Laying one saved map into the frame of another: onto which, by which points, and how well those agree.

#[cfg(test)]
mod tests;

use crate::button::{Button, Kind};
use crate::features::imports;
use crate::theme::Tokens;
use crate::{icon, widgets, words};
use api::Import;
use client_model::{ClientCommand, MapAlignment, Model};
use egui::Ui;
use vocab::MapId;

/// Points apart by more than this, metres, are not the same: the robot's computer will not lay a map by them.
const APART_MAX: f64 = 0.5;

/// The button at the map that is looked at, where there is another one.
pub(crate) fn offer(ui: &mut Ui, model: &Model, tokens: &Tokens, map: MapId, out: &mut Vec<ClientCommand>) {
    if model.maps().list().is_none_or(|maps| maps.len() < 2) {
        return;
    }
    let name = format!("Align {}", words::map_name(model, map));
    let button = Button::new(&name).text("Align to another map").icon(icon::ARROWS_DOWN_UP);
    if button.enabled(model.is_connected()).wide(ui).show(ui, tokens).clicked() {
        out.push(ClientCommand::AlignMap { map, reference: None });
    }
    widgets::remark(
        ui,
        tokens,
        "Of the same site: both then have one frame. Both are kept; the result is a third map.",
    );
}

/// The card while a map is being laid.
pub(crate) fn show(
    ui: &mut Ui,
    model: &Model,
    tokens: &Tokens,
    align: &MapAlignment,
    out: &mut Vec<ClientCommand>,
) {
    widgets::head(ui, tokens, &format!("Align {}", words::map_name(model, align.map)));
    match align.reference {
        None => choose(ui, model, tokens, align.map, out),
        Some(onto) => pick(ui, model, tokens, align, onto, out),
    }
    if align.job.is_none()
        && Button::new("Cancel aligning").text("Cancel").icon(icon::X).wide(ui).show(ui, tokens).clicked()
    {
        out.push(ClientCommand::CancelAlignment);
    }
}

/// Onto which map.
fn choose(ui: &mut Ui, model: &Model, tokens: &Tokens, map: MapId, out: &mut Vec<ClientCommand>) {
    widgets::remark(ui, tokens, "Into the frame of which map?");
    for other in model.maps().list().into_iter().flatten().filter(|other| other.id != map) {
        let name = format!("Onto {}", other.name);
        if Button::new(&name).text(&other.name).icon(icon::MAP_TRIFOLD).wide(ui).show(ui, tokens).clicked() {
            out.push(ClientCommand::AlignMap { map, reference: Some(other.id) });
        }
    }
}

/// By which points.
fn pick(
    ui: &mut Ui,
    model: &Model,
    tokens: &Tokens,
    align: &MapAlignment,
    onto: MapId,
    out: &mut Vec<ClientCommand>,
) {
    widgets::fact(ui, tokens, "Into the frame of", words::map_name(model, onto));
    widgets::fact(ui, tokens, "Points picked in both", &words::count(align.pairs.len() as u64));
    let apart = align.rms_residual_m();
    if let Some(apart) = apart {
        widgets::fact(ui, tokens, "They agree to", &words::accuracy(apart.max(1e-3)));
    }
    let contradict = apart.is_some_and(|apart| apart > APART_MAX);
    if contradict {
        let text = "These points contradict each other: one of them is not the same in both maps. Take back, and pick it again.";
        widgets::tinted_box(ui, tokens, tokens.warn, |ui| widgets::sentence(ui, tokens, text));
    }
    if align.job.is_some() {
        match model.imports.import() {
            Import::Running { .. } => imports::show(ui, model, tokens, out),
            _ => widgets::remark(ui, tokens, "The robot's computer is asked to."),
        }
        return;
    }
    let (here, there) = match model.viewed_map() {
        Some(viewed) if viewed == onto => (onto, align.map),
        _ => (align.map, onto),
    };
    let look = format!("Look at {}", words::map_name(model, there));
    if Button::new(&look).icon(icon::EYE).wide(ui).show(ui, tokens).clicked() {
        out.push(ClientCommand::ViewMap(Some(there)));
    }
    let picked = !align.points_in(here).is_empty() || !align.points_in(there).is_empty();
    let back = Button::new("Take the last point back").text("Take back").icon(icon::ARROW_COUNTER_CLOCKWISE);
    if back.enabled(picked).hint("Ctrl Z").wide(ui).show(ui, tokens).clicked() {
        out.push(ClientCommand::RemoveAlignmentPoint);
    }
    let busy = !model.is_connected();
    if picked {
        let lay = format!("Align by {} pairs", align.pairs.len());
        let enabled = align.pairs.len() >= 2 && apart.is_some() && !contradict && !busy;
        let button =
            Button::new("Align by the points").text(&lay).icon(icon::CHECK_CIRCLE).kind(Kind::Primary);
        if button.enabled(enabled).wide(ui).show(ui, tokens).clicked() {
            out.push(ClientCommand::StartAlignment);
        }
    } else {
        let button = Button::new("Align by what both look like").icon(icon::CHECK_CIRCLE).enabled(!busy);
        if button.wide(ui).show(ui, tokens).clicked() {
            out.push(ClientCommand::StartAlignment);
        }
        widgets::remark(
            ui,
            tokens,
            "Without any points it is tried to find one in the other, which takes some seconds.",
        );
    }
}

/// What to do next.
pub(crate) fn step(model: &Model, align: &MapAlignment) -> String {
    let Some(next) = align.next_map() else { return "These are enough.".to_owned() };
    let name = words::map_name(model, next);
    let number = align.pairs.len() + 1;
    match (model.viewed_map() == Some(next), align.unpaired.is_some()) {
        (false, _) => format!("Look at {name} for the next point."),
        (true, true) => format!("Click the same point here, in {name}."),
        (true, false) => {
            format!("Point {number}: click a corner or a pipe's end that {name} and the other map both show.")
        }
    }
}
