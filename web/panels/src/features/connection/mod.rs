//! The connection to the robot: data rate and age, and a message while it is lost.

#[cfg(test)]
mod tests;
mod texts;

use crate::button::Button;
use crate::feature_panel::{FeaturePanel, PanelContext};
use crate::message::show_message;
use crate::status_line::{StatusDetail, StatusLine};
use crate::{format, icon};
use client_model::{ClientCommand, Model, SocketState};
use egui::{Color32, Ui};

/// Parameters of what is shown of the connection.
pub(crate) struct LiveDataConfig {
    /// Age up to which data counts as live, seconds. The robot sends its pose several times a second. Chosen: several poses are missing then.
    pub(crate) max_live_age_s: f64,
}

pub(crate) const LIVE_DATA: LiveDataConfig = LiveDataConfig { max_live_age_s: 1.0 };

/// The panel. It keeps nothing between frames.
#[derive(Debug, Default)]
pub(crate) struct ConnectionPanel;

impl FeaturePanel for ConnectionPanel {
    fn show_messages(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let (model, tokens) = (cx.model, cx.tokens);
        let lost_s = model.connection().lost_since().map(|since| model.now().since(since));
        match (model.connection().state(), lost_s) {
            (SocketState::Connected { .. }, _) => {}
            (SocketState::Refused { reason }, _) => {
                show_message(ui, tokens, tokens.bad, icon::X_CIRCLE, reason, |_| {});
            }
            (SocketState::Connecting { .. }, None) => {
                show_message(ui, tokens, tokens.accent, icon::PLUGS, texts::CONNECTING_TO_ROBOT, |_| {});
            }
            (SocketState::Connecting { .. }, Some(lost_s)) => {
                let sentence = texts::reconnecting(lost_s);
                show_message(ui, tokens, tokens.bad, icon::WIFI_SLASH, &sentence, |_| {});
            }
            (SocketState::Lost { retry_at, .. }, lost_s) => {
                let sentence = texts::lost(lost_s.unwrap_or_default(), retry_at.since(model.now()));
                show_message(ui, tokens, tokens.bad, icon::WIFI_SLASH, &sentence, |ui| {
                    if Button::new(texts::RECONNECT).show(ui, tokens).clicked() {
                        cx.commands.push(ClientCommand::Reconnect);
                    }
                });
            }
        }
    }
}

/// The link for the top bar: the data rate, or the age of the data when it is not live.
pub(crate) fn status(cx: &PanelContext<'_>, detail: StatusDetail) -> StatusLine {
    let tokens = cx.tokens;
    let (icon, colour, state) = link_state(cx);
    let age_s =
        cx.model.data_age_s().filter(|age_s| *age_s <= LIVE_DATA.max_live_age_s && cx.model.is_connected());
    let age = age_s.filter(|_| detail == StatusDetail::Full).map(format::age).unwrap_or_default();
    // Where there is least room, the message below the bar says it in words.
    let shown = if detail == StatusDetail::Least { "" } else { state.as_str() };
    let line = StatusLine::new(texts::LINK, &format!("{state} {age}"));
    let line = line.icon(icon, colour).text(shown, tokens.text).text(&age, tokens.dim);
    line.hint(texts::link_hint(cx.model.connection().clock().round_trip_s()))
}

/// Icon, colour and words of the link.
fn link_state(cx: &PanelContext<'_>) -> (&'static str, Color32, String) {
    let (model, tokens) = (cx.model, cx.tokens);
    match model.connection().state() {
        SocketState::Connected { .. } => match stale_age_s(model) {
            Some(age_s) => (icon::CLOCK_COUNTDOWN, tokens.warn, format::age(age_s)),
            None => {
                let rate = model.connection().throughput().bits_per_s();
                (icon::ARROWS_DOWN_UP, tokens.good, format::bit_rate(rate))
            }
        },
        SocketState::Connecting { .. } if model.connection().lost_since().is_none() => {
            (icon::PLUGS, tokens.warn, texts::CONNECTING.to_owned())
        }
        SocketState::Connecting { .. } | SocketState::Lost { .. } => {
            (icon::WIFI_SLASH, tokens.bad, texts::LOST.to_owned())
        }
        SocketState::Refused { .. } => (icon::X_CIRCLE, tokens.bad, texts::REFUSED.to_owned()),
    }
}

/// Age of the robot's data, seconds, if it is not live.
pub(crate) fn stale_age_s(model: &Model) -> Option<f64> {
    model.data_age_s().filter(|age_s| *age_s > LIVE_DATA.max_live_age_s)
}
