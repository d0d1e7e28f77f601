//! The account that has signed in: who it is, signing out, and what its role may not do.

#[cfg(test)]
mod tests;
mod texts;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::features::tabs;
use crate::icon;
use crate::message::show_message;
use crate::status_line::{StatusDetail, StatusLine};
use crate::widgets::{self, fact};
use api::Role;
use client_model::{AccountAction, ClientCommand};
use egui::Ui;

/// The panel. It keeps nothing between frames.
#[derive(Debug, Default)]
pub(crate) struct AccountPanel;

impl FeaturePanel for AccountPanel {
    fn show_messages(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        if !cx.model.may(Role::Operator) {
            show_message(ui, cx.tokens, cx.tokens.accent, icon::USER, texts::VIEWER, |_| {});
        }
    }

    fn tabs(&self) -> &'static [Tab] {
        &[tabs::ROBOT]
    }

    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let Some(you) = cx.model.you() else { return };
        let tokens = cx.tokens;
        widgets::section_head(ui, tokens, texts::HEAD);
        if you.is_demo {
            widgets::remark(ui, tokens, texts::DEMO);
            return;
        }
        fact(ui, tokens, texts::ACCOUNT, you.account.as_deref().unwrap_or(texts::NOBODY));
        fact(ui, tokens, texts::ROLE, you.role.name());
        let mut actions = vec![
            (texts::CHANGE_PASSWORD, AccountAction::ChangePassword),
            (texts::SIGN_OUT, AccountAction::SignOut),
        ];
        if you.role == Role::Admin {
            actions.insert(0, (texts::MANAGE, AccountAction::ManagePeople));
        }
        for (text, action) in actions {
            if Button::new(text).kind(Kind::Quiet).wide(ui).show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::Account(action));
            }
        }
    }
}

/// For the top bar: that this is a demonstration, if it is one. Nobody should take it for a robot that is protected.
pub(crate) fn demo_status(cx: &PanelContext<'_>, detail: StatusDetail) -> Option<StatusLine> {
    cx.model.you().filter(|you| you.is_demo)?;
    let shown = if detail == StatusDetail::Least { "" } else { texts::DEMO_SHORT };
    let line = StatusLine::new(texts::HEAD, texts::DEMO_SHORT).icon(icon::USER, cx.tokens.warn);
    Some(line.text(shown, cx.tokens.text).hint(texts::DEMO.to_owned()))
}
