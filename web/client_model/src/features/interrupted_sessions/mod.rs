//! Mapping sessions that were interrupted, and what the operator decides about them.

use super::Feature;
use crate::ClientCommand;
use crate::shared::Context;
use api::InterruptedSession;

/// The sessions that wait for a decision.
#[derive(Clone, Debug, Default)]
pub struct InterruptedSessions {
    sessions: Vec<InterruptedSession>,
}

impl InterruptedSessions {
    /// The sessions, the newest first.
    pub fn list(&self) -> &[InterruptedSession] {
        &self.sessions
    }
}

impl Feature for InterruptedSessions {
    fn on_event(&mut self, event: &api::Event, _cx: &mut Context<'_>) {
        if let api::Event::InterruptedSessions(sessions) = event {
            sessions.clone_into(&mut self.sessions);
        }
    }

    fn on_command(&mut self, command: &ClientCommand, cx: &mut Context<'_>) {
        match command {
            ClientCommand::SaveInterruptedSession { session, name, resume } => {
                let map = cx.shared.ids.map();
                let (session, name) = (*session, name.clone());
                let resume_as = resume.then(|| cx.shared.ids.session());
                let command = api::Command::SaveInterruptedSession { session, map, name, resume_as };
                match resume {
                    true => cx.send_in_control(command),
                    false => cx.send(command),
                }
            }
            ClientCommand::DiscardInterruptedSession(session) => {
                cx.send(api::Command::DiscardInterruptedSession(*session));
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests;
