//! What can be made to go wrong with a simulated robot, to see what it makes of it.

use crate::button::Button;
use crate::theme::Tokens;
use crate::widgets;
use api::SimulatedFault;
use client_model::{ClientCommand, Model};
use egui::Ui;
use vocab::Span;

/// Long enough to be carried some way by the other sensors.
const DARK: Span = Span::from_millis(20_000);
const SLIP: Span = Span::from_millis(5_000);

/// What the buttons say.
const ALL: [(&str, SimulatedFault); 6] = [
    ("Cover the LiDAR for 20 s", SimulatedFault::CoverLidar(DARK)),
    ("Cut off the LiDAR for 20 s", SimulatedFault::SilenceLidar(DARK)),
    ("Cut off the IMU for 20 s", SimulatedFault::SilenceImu(DARK)),
    ("Let the feet slip for 5 s", SimulatedFault::SlipFeet(SLIP)),
    ("Carry the robot away", SimulatedFault::CarryAway),
    ("End all faults", SimulatedFault::End),
];

pub(crate) fn show(ui: &mut Ui, model: &Model, tokens: &Tokens, out: &mut Vec<ClientCommand>) {
    widgets::head(ui, tokens, "Simulated faults");
    widgets::remark(ui, tokens, "This robot is simulated. Inject a fault and watch how it recovers.");
    for (text, mishap) in ALL {
        let waiting = model.is_pending(|order| *order == api::Command::InjectFault(mishap));
        let button = Button::new(text).text(text).enabled(model.is_connected() && !waiting).wide(ui);
        if button.show(ui, tokens).clicked() {
            out.push(ClientCommand::InjectFault(mishap));
        }
    }
}
