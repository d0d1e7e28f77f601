//! The account that has signed in. Passwords never come here: the page asks for them in form fields of its own.

use super::Feature;
use crate::shared::Context;
use crate::{ClientCommand, ClientEffect};

/// What an operator can do about accounts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AccountAction {
    /// End the session.
    SignOut,
    /// Change the password of the own account.
    ChangePassword,
    /// Open the page of people and tokens.
    ManagePeople,
}

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
