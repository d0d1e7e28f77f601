//! What can be made to go wrong with a simulated robot, to see what it makes of it.

use crate::button::Button;
use crate::theme::Tokens;
use crate::widgets;
use api::Mishap;
use client_model::{ClientCommand, Model};
use egui::Ui;
use vocab::Span;

/// Long enough to be carried some way by the other sensors.
const DARK: Span = Span::from_millis(20_000);
const SLIP: Span = Span::from_millis(5_000);

/// What the buttons say.
const ALL: [(&str, Mishap); 6] = [
    ("Cover the LiDAR for 20 s", Mishap::CoverLidar(DARK)),
    ("Cut off the LiDAR for 20 s", Mishap::SilenceLidar(DARK)),
    ("Cut off the IMU for 20 s", Mishap::SilenceImu(DARK)),
    ("Let the feet slip for 5 s", Mishap::SlipFeet(SLIP)),
    ("Carry the robot away", Mishap::CarryAway),
    ("End all troubles", Mishap::End),
];

pub(crate) fn show(ui: &mut Ui, model: &Model, tokens: &Tokens, out: &mut Vec<ClientCommand>) {
    widgets::head(ui, tokens, "Simulated troubles");
    widgets::remark(
        ui,
        tokens,
        "This robot is a simulated one. Let something go wrong and see what it makes of it.",
    );
    for (text, mishap) in ALL {
        let waiting = model.is_pending(|order| *order == api::Order::Cause(mishap));
        let button = Button::new(text).text(text).enabled(model.link.connected() && !waiting).wide(ui);
        if button.show(ui, tokens).clicked() {
            out.push(ClientCommand::InjectFault(mishap));
        }
    }
}
