//! Faults that can be injected into a simulated robot, to see how it recovers.

#[cfg(test)]
mod tests;
mod texts;

use crate::button::Button;
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::features::tabs;
use crate::widgets;
use api::SimulatedFault;
use client_model::ClientCommand;
use egui::Ui;
use vocab::Span;

/// How long faults last that a person injects.
#[derive(Clone, Copy, Debug)]
struct SimulatedFaultsConfig {
    /// Time without a sensor. The other sensors carry the odometry over several metres meanwhile. Chosen: as in the benchmark of the odometry, 20 s
    /// (docs/benchmarks/odometry.md).
    sensor_outage: Span,
    /// Time for which the feet slip. Chosen: some steps, 1.3 m of slip at the fault's velocity.
    slip: Span,
}

const CONFIG: SimulatedFaultsConfig =
    SimulatedFaultsConfig { sensor_outage: Span::from_millis(20_000), slip: Span::from_millis(5_000) };

/// The faults in the order of their buttons.
const FAULTS: [SimulatedFault; 6] = [
    SimulatedFault::CoverLidar(CONFIG.sensor_outage),
    SimulatedFault::SilenceLidar(CONFIG.sensor_outage),
    SimulatedFault::SilenceImu(CONFIG.sensor_outage),
    SimulatedFault::SlipFeet(CONFIG.slip),
    SimulatedFault::CarryAway,
    SimulatedFault::End,
];

/// The panel. It keeps nothing between frames.
#[derive(Debug, Default)]
pub(crate) struct SimulatedFaultsPanel;

impl FeaturePanel for SimulatedFaultsPanel {
    fn tabs(&self) -> &'static [Tab] {
        &[tabs::ROBOT]
    }

    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let is_simulated = cx.model.platform.report().is_some_and(|platform| platform.site.is_some());
        if !is_simulated {
            return;
        }
        widgets::section_head(ui, cx.tokens, texts::HEAD);
        widgets::remark(ui, cx.tokens, texts::HINT);
        for fault in FAULTS {
            let is_pending = cx.model.is_pending(|command| *command == api::Command::InjectFault(fault));
            let name = texts::fault(fault);
            let button = Button::new(&name).enabled(cx.model.is_connected() && !is_pending).wide(ui);
            if button.show(ui, cx.tokens).clicked() {
                cx.commands.push(ClientCommand::InjectFault(fault));
            }
        }
    }
}
