//! Faults that can be injected into a simulated robot, to see how it recovers.

use crate::button::Button;
use crate::theme::Tokens;
use crate::widgets;
use api::SimulatedFault;
use client_model::{ClientCommand, Model};
use egui::Ui;
use vocab::Span;

/// Time without LiDAR: long enough for the other sensors to carry the odometry over several metres.
const WITHOUT_SENSOR: Span = Span::from_millis(20_000);
const SLIP: Span = Span::from_millis(5_000);

/// The buttons' texts and what they inject.
const ALL: [(&str, SimulatedFault); 6] = [
    ("Cover the LiDAR for 20 s", SimulatedFault::CoverLidar(WITHOUT_SENSOR)),
    ("Cut off the LiDAR for 20 s", SimulatedFault::SilenceLidar(WITHOUT_SENSOR)),
    ("Cut off the IMU for 20 s", SimulatedFault::SilenceImu(WITHOUT_SENSOR)),
    ("Let the feet slip for 5 s", SimulatedFault::SlipFeet(SLIP)),
    ("Carry the robot away", SimulatedFault::CarryAway),
    ("End all faults", SimulatedFault::End),
];

pub(crate) fn show(ui: &mut Ui, model: &Model, tokens: &Tokens, out: &mut Vec<ClientCommand>) {
    widgets::head(ui, tokens, "Simulated faults");
    widgets::remark(ui, tokens, "This robot is simulated. Inject a fault and watch how it recovers.");
    for (text, fault) in ALL {
        let waiting = model.is_pending(|command| *command == api::Command::InjectFault(fault));
        let button = Button::new(text).text(text).enabled(model.is_connected() && !waiting).wide(ui);
        if button.show(ui, tokens).clicked() {
            out.push(ClientCommand::InjectFault(fault));
        }
    }
}
