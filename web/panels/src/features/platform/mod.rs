//! The robot's computer: its load, and whether the control program answers.

#[cfg(test)]
mod tests;
mod texts;

use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::features::tabs;
use crate::format;
use crate::theme::{self, Weight};
use crate::widgets::{self, fact};
use egui::Ui;

/// The panel. It keeps nothing between frames.
#[derive(Debug, Default)]
pub(crate) struct PlatformPanel;

impl FeaturePanel for PlatformPanel {
    fn tabs(&self) -> &'static [Tab] {
        &[tabs::ROBOT]
    }

    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let Some(platform) = cx.model.platform.report() else { return };
        let tokens = cx.tokens;
        widgets::section_head(ui, tokens, texts::HEAD);
        if !platform.core_connected {
            widgets::tinted_box(ui, tokens, tokens.bad, |ui| {
                widgets::sentence(ui, tokens, texts::CORE_DISCONNECTED);
            });
        }
        fact(ui, tokens, texts::PROCESSING, &texts::real_time_factor(platform.real_time_factor));
        fact(ui, tokens, texts::PROCESSOR, &texts::cores(platform.cpu_cores));
        fact(ui, tokens, texts::MEMORY, &format::bytes(platform.memory_bytes));
        fact(ui, tokens, texts::FREE_DISK, &format::bytes(platform.disk_free_bytes));
        fact(ui, tokens, texts::CLIENTS, &platform.clients.to_string());
        let version = cx.model.connection().program();
        if !version.is_empty() {
            fact(ui, tokens, texts::VERSION, version);
        }
    }
}

/// Shows the robot's name, and the site of a simulated one, in the top bar.
pub(crate) fn show_robot_status(ui: &mut Ui, cx: &PanelContext<'_>) {
    let Some(platform) = cx.model.platform.report() else { return };
    let name = match &platform.site {
        Some(site) => texts::robot_in_site(&platform.robot, site),
        None => platform.robot.clone(),
    };
    let text = (name.as_str(), theme::BODY, Weight::Regular, cx.tokens.text);
    widgets::status_line(ui, texts::ROBOT, &name, &[text]);
}
