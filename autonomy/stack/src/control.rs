//! Who may command, and each command once.

use messages::{Command, CommandKind, ControlState, Role};
use std::collections::VecDeque;
use vocab::{ClientId, CommandId};

/// Answers remembered for clients that send a command again. At 10 Hz of driving, the last 25 s of ten clients.
const REMEMBERED: usize = 2_500;

/// The lease and the answered commands.
#[derive(Debug, Default)]
pub(crate) struct Control {
    state: ControlState,
    answered: VecDeque<(CommandId, Option<String>)>,
}

/// Whether a command may be carried out.
pub(crate) enum Admission {
    /// Yes; `changed` when the lease was given by it.
    Granted { changed: bool },
    /// It was answered before, with this.
    Repeated(Option<String>),
    /// Somebody else is in control; the sentence says what to do.
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
            return Admission::Refused("This account may only watch, and stop motion.".to_owned());
        }
        match &command.kind {
            CommandKind::StopMotion => Admission::Granted { changed: false },
            CommandKind::TakeControl { name } => {
                let changed = self.take(command.by.client, name);
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
                None => Admission::Granted { changed: self.take(command.by.client, "Operator") },
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

    fn take(&mut self, by: ClientId, name: &str) -> bool {
        let name = if name.trim().is_empty() { "Operator" } else { name.trim() };
        let next = ControlState { owner: Some(by), name: name.chars().take(60).collect() };
        let changed = next != self.state;
        self.state = next;
        changed
    }
}
