//! Mapping sessions that were interrupted: go on, save or discard.

#[cfg(test)]
mod tests;
mod texts;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::features::tabs;
use crate::map_name::map_name;
use crate::{format, icon, widgets};
use api::{Command, InterruptedSession, Mapping};
use client_model::{ClientCommand, Model};
use egui::Ui;
use vocab::SessionId;

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct InterruptedSessionsPanel {
    /// The session that the operator is asked to confirm that it is discarded.
    confirm_discard: Option<SessionId>,
}

impl FeaturePanel for InterruptedSessionsPanel {
    fn tabs(&self) -> &'static [Tab] {
        &[tabs::SESSION]
    }

    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let model = cx.model;
        for session in model.interrupted_sessions.list() {
            ui.push_id(session.session.0, |ui| self.show(ui, session, cx));
        }
    }
}

impl InterruptedSessionsPanel {
    fn show(&mut self, ui: &mut Ui, session: &InterruptedSession, cx: &mut PanelContext<'_>) {
        let (model, tokens) = (cx.model, cx.tokens);
        widgets::head(ui, tokens, texts::HEAD);
        let when = format::date(session.at, cx.utc_offset_s);
        let sentence = match session.keyframes {
            0 => texts::DAMAGED.to_owned(),
            keyframes => texts::interrupted(&when, keyframes, &format::distance(session.distance_m)),
        };
        widgets::tinted_box(ui, tokens, tokens.accent, |ui| widgets::sentence(ui, tokens, &sentence));
        if self.confirm_discard == Some(session.session) {
            return self.show_confirmation(ui, session, cx);
        }
        let is_free = model.is_connected() && !is_pending(model, session.session);
        let can_save = is_free && session.keyframes > 0;
        let can_resume = can_save && model.can_command() && *model.mapping() == Mapping::Idle;
        let resume = Button::new(texts::RESUME).icon(icon::PLAY).kind(Kind::Primary).enabled(can_resume);
        let resumed = resume.wide(ui).show(ui, tokens).clicked();
        let save = Button::new(texts::SAVE).icon(icon::FLOPPY_DISK).enabled(can_save);
        if save.wide(ui).show(ui, tokens).clicked() || resumed {
            cx.commands.push(ClientCommand::SaveInterruptedSession {
                session: session.session,
                name: name_of(model, session),
                resume: resumed,
            });
        }
        let discard = Button::new(texts::DISCARD).text(texts::DISCARD_SHORT).icon(icon::TRASH);
        if discard.enabled(is_free).wide(ui).show(ui, tokens).clicked() {
            self.confirm_discard = Some(session.session);
        }
    }

    fn show_confirmation(&mut self, ui: &mut Ui, session: &InterruptedSession, cx: &mut PanelContext<'_>) {
        let tokens = cx.tokens;
        widgets::tinted_box(ui, tokens, tokens.bad, |ui| {
            widgets::sentence(ui, tokens, texts::DISCARD_WARNING)
        });
        let discard = Button::new(texts::CONFIRM_DISCARD).icon(icon::TRASH).kind(Kind::Danger);
        if discard.wide(ui).show(ui, tokens).clicked() {
            self.confirm_discard = None;
            cx.commands.push(ClientCommand::DiscardInterruptedSession(session.session));
        }
        if Button::new(texts::KEEP).wide(ui).show(ui, tokens).clicked() {
            self.confirm_discard = None;
        }
    }
}

/// Whether a decision on the session was sent and not answered.
fn is_pending(model: &Model, session: SessionId) -> bool {
    model.is_pending(|command| match command {
        Command::SaveInterruptedSession { session: saved, .. } => *saved == session,
        Command::DiscardInterruptedSession(discarded) => *discarded == session,
        _ => false,
    })
}

/// Name of the map: that of the map that it extends, or the next number.
fn name_of(model: &Model, session: &InterruptedSession) -> String {
    match session.extends {
        Some(map) => map_name(model, map).to_owned(),
        None => texts::default_map_name(model.maps().len() + 1),
    }
}
