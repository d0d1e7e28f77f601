//! Sensors: their rates and ages, and what the monitoring of their data found.

#[cfg(test)]
mod tests;
mod texts;

use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::features::{connection, tabs};
use crate::theme::Tokens;
use crate::widgets::{self, fact_with_note};
use crate::{format, icon};
use api::{Finding, Health, Mapping, Severity};
use egui::{Color32, Ui};

/// Parameters of the list of sensors.
struct SensorListConfig {
    /// Rate below which a sensor counts as silent, Hz. It would be shown as 0.0 Hz. Chosen: half of the last digit that is shown.
    silent_rate_hz: f32,
    /// Age of the report on all sensors from which it is added to the age of each, seconds. Twice the time between two reports.
    stale_report_s: f64,
}

const CONFIG: SensorListConfig = SensorListConfig { silent_rate_hz: 0.05, stale_report_s: 2.0 };

/// The panel. It keeps nothing between frames.
#[derive(Debug, Default)]
pub(crate) struct SensorsPanel;

impl FeaturePanel for SensorsPanel {
    fn tabs(&self) -> &'static [Tab] {
        &[tabs::ROBOT, tabs::SESSION]
    }

    fn show_section(&mut self, tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let (model, tokens) = (cx.model, cx.tokens);
        let is_session = tab == tabs::SESSION;
        if is_session && (*model.mapping() == Mapping::Idle || model.robot.health.is_none()) {
            return;
        }
        if let Some(health) = &model.robot.health {
            show_findings(ui, &health.value, tokens);
        }
        widgets::section_head(ui, tokens, texts::HEAD);
        show_list(ui, cx);
    }
}

/// Rates and ages of all sensors.
fn show_list(ui: &mut Ui, cx: &PanelContext<'_>) {
    let (model, tokens) = (cx.model, cx.tokens);
    let Some(health) = &model.robot.health else {
        widgets::remark(ui, tokens, texts::NO_REPORT);
        return;
    };
    let report_age_s = health.age(model.now());
    let added_age_s = if report_age_s > CONFIG.stale_report_s { report_age_s } else { 0.0 };
    for sensor in &health.value.sensors {
        let age_s = sensor.age.secs_f64() + added_age_s;
        let is_silent = sensor.rate_hz < CONFIG.silent_rate_hz;
        let rate = if is_silent { texts::SILENT.to_owned() } else { format::rate(sensor.rate_hz) };
        let age = format::age(age_s);
        let is_stale = is_silent || age_s > connection::LIVE_DATA.max_live_age_s;
        let note = is_stale.then_some((age.as_str(), tokens.warn));
        fact_with_note(ui, tokens, &sensor.name, &rate, note);
    }
}

/// What is wrong and what to do about it.
fn show_findings(ui: &mut Ui, health: &Health, tokens: &Tokens) {
    for finding in &health.findings {
        show_finding(ui, finding, tokens);
    }
}

fn show_finding(ui: &mut Ui, finding: &Finding, tokens: &Tokens) {
    let colour = severity_colour(finding.severity, tokens);
    let response = widgets::tinted_box(ui, tokens, colour, |ui| {
        let what = format!("{} {}", severity_icon(finding.severity), finding.what);
        let response = ui.add(egui::Label::new(egui::RichText::new(what).color(tokens.text)).wrap());
        widgets::remark(ui, tokens, &finding.remedy);
        response
    });
    ui.ctx().accesskit_node_builder(response.id, |node| {
        node.set_role(egui::Role::Alert);
        node.set_value(texts::finding(finding));
    });
}

/// The colour of a severity.
pub(crate) fn severity_colour(severity: Severity, tokens: &Tokens) -> Color32 {
    match severity {
        Severity::Info => tokens.accent,
        Severity::Warning => tokens.warn,
        Severity::Error => tokens.bad,
    }
}

/// The icon of a severity.
pub(crate) fn severity_icon(severity: Severity) -> &'static str {
    match severity {
        Severity::Info => icon::INFO,
        Severity::Warning => icon::WARNING,
        Severity::Error => icon::WARNING_OCTAGON,
    }
}
