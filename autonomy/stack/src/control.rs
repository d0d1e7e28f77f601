//! The control lease, and the answers to commands: a command that is sent again is answered again, but done once.

use messages::{Command, CommandKind, ControlState, Role};
use std::collections::VecDeque;
use vocab::{ClientId, CommandId};

/// Number of answers that are remembered. Ten clients that drive at 10 Hz fill it in 25 s.
const REMEMBERED: usize = 2_500;

/// The lease and the answered commands.
#[derive(Debug, Default)]
pub(crate) struct Control {
    state: ControlState,
    answered: VecDeque<(CommandId, Option<String>)>,
}

/// Whether a command is carried out.
pub(crate) enum Admission {
    /// Yes. `changed`: the lease has another owner now.
    Granted { changed: bool },
    /// It was answered before, with this refusal or none.
    Repeated(Option<String>),
    /// No. The sentence says why and what to do.
    Refused(String),
}

impl Control {
    /// The lease, for publication.
    pub fn state(&self) -> &ControlState {
        &self.state
    }

    /// Decides on a command. An unheld lease goes to whoever commands first.
    pub fn admit(&mut self, command: &Command) -> Admission {
        if let Some((_, answer)) = self.answered.iter().rev().find(|(id, _)| *id == command.id) {
            return Admission::Repeated(answer.clone());
        }
        if command.by.role == Role::Viewer && command.kind != CommandKind::StopMotion {
            return Admission::Refused(crate::texts::VIEWER_REFUSED.to_owned());
        }
        match &command.kind {
            CommandKind::StopMotion => Admission::Granted { changed: false },
            CommandKind::TakeControl { name } => {
                let changed = self.grant(command.by.client, name);
                Admission::Granted { changed }
            }
            CommandKind::ReleaseControl => {
                let held = self.state.owner == Some(command.by.client);
                if held {
                    self.state = ControlState::default();
                }
                Admission::Granted { changed: held }
            }
            _ => match self.state.owner {
                Some(owner) if owner == command.by.client => Admission::Granted { changed: false },
                Some(_) => Admission::Refused(format!(
                    "{} is in control. Take control first; the change of hands is recorded.",
                    self.state.name
                )),
                None => Admission::Granted { changed: self.grant(command.by.client, "Operator") },
            },
        }
    }

    /// Remembers an answer.
    pub fn answered(&mut self, id: CommandId, refused: Option<String>) {
        if self.answered.len() == REMEMBERED {
            self.answered.pop_front();
        }
        self.answered.push_back((id, refused));
    }

    fn grant(&mut self, by: ClientId, name: &str) -> bool {
        let name = if name.trim().is_empty() { "Operator" } else { name.trim() };
        let next = ControlState { owner: Some(by), name: name.chars().take(60).collect() };
        let changed = next != self.state;
        self.state = next;
        changed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::Principal;
    use uuid::Uuid;

    fn command(id: u128, client: u128, role: Role, kind: CommandKind) -> Command {
        let by = Principal { role, ..Principal::operator(ClientId(Uuid::from_u128(client))) };
        Command { id: CommandId(Uuid::from_u128(id)), by, kind }
    }

    #[test]
    fn the_lease_goes_to_the_first_who_commands_and_the_others_are_refused_all_but_a_stop() {
        let mut control = Control::default();
        let first = command(1, 1, Role::Operator, CommandKind::AllowMotion);
        assert!(matches!(control.admit(&first), Admission::Granted { changed: true }));
        let second = command(2, 2, Role::Operator, CommandKind::AllowMotion);
        assert!(matches!(control.admit(&second), Admission::Refused(_)));
        let stop = command(3, 2, Role::Operator, CommandKind::StopMotion);
        assert!(matches!(control.admit(&stop), Admission::Granted { changed: false }));
        let take = command(4, 2, Role::Operator, CommandKind::TakeControl { name: "Ada".to_owned() });
        assert!(matches!(control.admit(&take), Admission::Granted { changed: true }));
        assert_eq!(control.state().owner, Some(ClientId(Uuid::from_u128(2))));
    }

    #[test]
    fn who_may_only_watch_may_stop_motion() {
        let mut control = Control::default();
        let take = command(1, 1, Role::Viewer, CommandKind::TakeControl { name: "Ada".to_owned() });
        assert!(matches!(control.admit(&take), Admission::Refused(_)));
        assert_eq!(control.state().owner, None);
        let stop = command(2, 1, Role::Viewer, CommandKind::StopMotion);
        assert!(matches!(control.admit(&stop), Admission::Granted { changed: false }));
    }

    #[test]
    fn a_command_that_is_sent_again_is_answered_as_before() {
        let mut control = Control::default();
        let once = command(1, 1, Role::Operator, CommandKind::AllowMotion);
        assert!(matches!(control.admit(&once), Admission::Granted { .. }));
        control.answered(once.id, Some("no".to_owned()));
        assert!(matches!(control.admit(&once), Admission::Repeated(Some(answer)) if answer == "no"));
    }
}
