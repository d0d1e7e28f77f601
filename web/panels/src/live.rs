//! The right card of Live: the robot now.

use crate::features::{goals, localisation};
use crate::theme::{self, Tokens};
use crate::top_bar::FRESH_S;
use crate::widgets::{self, fact, fact_with_note};
use crate::{PanelState, sensors, simulated_faults, words};
use client_model::{ClientCommand, Model};
use egui::Ui;

/// What is longer does not fit beside its name.
const LINE_CHARS: usize = 24;

pub(crate) fn show(
    ui: &mut Ui,
    model: &Model,
    tokens: &Tokens,
    _state: &PanelState,
    out: &mut Vec<ClientCommand>,
) {
    egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 6.0;
        widgets::head(ui, tokens, "Robot");
        robot(ui, model, tokens);
        if let Some(health) = &model.robot.health {
            sensors::findings(ui, &health.value, tokens);
        }
        goals::show(ui, model, tokens, out);
        ui.add_space(8.0);
        widgets::rule(ui, tokens);
        ui.add_space(4.0);
        widgets::head(ui, tokens, "Sensors");
        sensors::list(ui, model, tokens);
        if let Some(platform) = model.platform.report() {
            // Above what is rarely read, so that the buttons can be reached without scrolling.
            if platform.site.is_some() {
                ui.add_space(8.0);
                widgets::rule(ui, tokens);
                ui.add_space(4.0);
                simulated_faults::show(ui, model, tokens, out);
            }
            ui.add_space(8.0);
            widgets::rule(ui, tokens);
            ui.add_space(4.0);
            widgets::head(ui, tokens, "Robot computer");
            computer(ui, model, platform, tokens);
        }
    });
}

/// State of localisation: on the line of its name if it is short, else a sentence below.
fn localisation(ui: &mut Ui, model: &Model, tokens: &Tokens) {
    let known = localisation::state_text(&model.localisation());
    if known.chars().count() <= LINE_CHARS {
        fact(ui, tokens, "Localisation", &known);
        return;
    }
    widgets::tinted_box(ui, tokens, tokens.warn, |ui| {
        let text = egui::RichText::new(&known).size(theme::BODY).color(tokens.text);
        let response = ui.add(egui::Label::new(text).wrap());
        widgets::status_node(&response, "Localisation", &known);
    });
}

fn robot(ui: &mut Ui, model: &Model, tokens: &Tokens) {
    fact(ui, tokens, "Motion", words::motion(model.robot.motion.as_ref().map(|motion| &motion.value)));
    if let api::Motion::Blocked { reason, .. } = model.motion() {
        widgets::tinted_box(ui, tokens, tokens.warn, |ui| widgets::sentence(ui, tokens, reason));
    }
    if let Some(map) = model.localisation().map() {
        let known = model.maps().list().into_iter().flatten().find(|known| known.id == map);
        fact(ui, tokens, "Map", known.map_or("One that was deleted", |known| known.name.as_str()));
        localisation(ui, model, tokens);
    }
    let Some(estimate) = &model.robot.estimate else {
        widgets::remark(ui, tokens, "The robot has not said where it is yet.");
        return;
    };
    let age = model.data_age_s().unwrap_or(0.0);
    let old = words::age(age);
    let note = (age > FRESH_S).then_some((old.as_str(), tokens.warn));
    let v = estimate.value.velocity.linear;
    let p = estimate.value.map_from_base.position;
    fact_with_note(ui, tokens, "Speed", &format!("{:.1} m/s", v.x.hypot(v.y)), note);
    fact_with_note(ui, tokens, "Place", &words::place(&p), note);
    fact(ui, tokens, "Accuracy", &words::accuracy(words::position_sigma_m(&estimate.value)));
    fact(ui, tokens, "Walked", &words::distance(estimate.value.distance));
}

fn computer(ui: &mut Ui, model: &Model, platform: &api::Platform, tokens: &Tokens) {
    if !platform.core_connected {
        let sentence = "The robot's control program does not answer. What you see is the last it said; it is being \
                        restarted.";
        widgets::tinted_box(ui, tokens, tokens.bad, |ui| widgets::sentence(ui, tokens, sentence));
    }
    fact(ui, tokens, "Processing", &format!("{:.2} × real time", platform.real_time_factor));
    fact(ui, tokens, "Processor", &format!("{:.2} cores", platform.cpu_cores));
    fact(ui, tokens, "Memory", &words::bytes(platform.memory_bytes));
    fact(ui, tokens, "Free disk", &words::bytes(platform.disk_free_bytes));
    fact(ui, tokens, "Clients", &platform.clients.to_string());
    if !model.connection().program().is_empty() {
        fact(ui, tokens, "Version", model.connection().program());
    }
}
