//! The robot's computer: its load, and whether the control program answers.

#[cfg(test)]
mod tests;
mod texts;

use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::features::tabs;
use crate::format;
use crate::status_line::{StatusDetail, StatusLine};
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

/// The robot's name, and the site of a simulated one, for the top bar; `None` where there is no room.
pub(crate) fn robot_status(cx: &PanelContext<'_>, detail: StatusDetail) -> Option<StatusLine> {
    let platform = cx.model.platform.report().filter(|_| detail >= StatusDetail::Normal)?;
    let name = match &platform.site {
        Some(site) => texts::robot_in_site(&platform.robot, site),
        None => platform.robot.clone(),
    };
    Some(StatusLine::new(texts::ROBOT, &name).text(&name, cx.tokens.text))
}
