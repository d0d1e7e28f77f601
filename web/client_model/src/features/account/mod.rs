//! The account that has signed in. Passwords never come here: the page asks for them in form fields of its own.

mod action;

pub use action::AccountAction;

use super::Feature;
use crate::shared::Context;
use crate::{ClientCommand, ClientEffect};

/// The feature. The state is [`crate::Model::you`].
#[derive(Debug, Default)]
pub struct AccountFeature;

impl Feature for AccountFeature {
    fn on_command(&mut self, command: &ClientCommand, cx: &mut Context<'_>) {
        if let ClientCommand::Account(action) = command {
            cx.effects.push(ClientEffect::Account(*action));
        }
    }
}
