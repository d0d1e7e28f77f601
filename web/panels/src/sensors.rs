//! Sensor health and findings, for every screen that shows them.

use crate::theme::Tokens;
use crate::top_bar::FRESH_S;
use crate::widgets::{self, fact_with_note};
use crate::{icon, words};
use api::{Finding, Health, Severity};
use client_model::Model;
use egui::{Color32, Ui};

/// Rates and ages of all sensors.
pub(crate) fn list(ui: &mut Ui, model: &Model, tokens: &Tokens) {
    let Some(health) = &model.robot.health else {
        widgets::remark(ui, tokens, "No sensor has reported yet.");
        return;
    };
    let since = health.age(model.now());
    for sensor in &health.value.sensors {
        let age = sensor.age.secs_f64() + if since > FRESH_S * 2.0 { since } else { 0.0 };
        let silent = sensor.rate_hz < 0.05 || age > FRESH_S;
        let rate = if sensor.rate_hz < 0.05 { "silent".to_owned() } else { rate(sensor.rate_hz) };
        let old = words::age(age);
        let note = silent.then_some((old.as_str(), tokens.warn));
        fact_with_note(ui, tokens, &sensor.name, &rate, note);
    }
}

fn rate(hz: f32) -> String {
    if hz < 20.0 { format!("{hz:.1} Hz") } else { format!("{hz:.0} Hz") }
}

/// What is wrong and what to do about it.
pub(crate) fn findings(ui: &mut Ui, health: &Health, tokens: &Tokens) {
    for finding in &health.findings {
        finding_box(ui, finding, tokens);
    }
}

fn finding_box(ui: &mut Ui, finding: &Finding, tokens: &Tokens) {
    let colour = severity_colour(finding.severity, tokens);
    let response = widgets::tinted_box(ui, tokens, colour, |ui| {
        let what = format!("{} {}", severity_icon(finding.severity), finding.what);
        let response = ui.add(egui::Label::new(egui::RichText::new(what).color(tokens.text)).wrap());
        widgets::remark(ui, tokens, &finding.remedy);
        response
    });
    let sentence = format!("{}: {} {}", words::severity(finding.severity), finding.what, finding.remedy);
    ui.ctx().accesskit_node_builder(response.id, |node| {
        node.set_role(egui::Role::Alert);
        node.set_value(sentence);
    });
}

pub(crate) fn severity_colour(severity: Severity, tokens: &Tokens) -> Color32 {
    match severity {
        Severity::Info => tokens.accent,
        Severity::Warning => tokens.warn,
        Severity::Error => tokens.bad,
    }
}

pub(crate) fn severity_icon(severity: Severity) -> &'static str {
    match severity {
        Severity::Info => icon::INFO,
        Severity::Warning => icon::WARNING,
        Severity::Error => icon::WARNING_OCTAGON,
    }
}
