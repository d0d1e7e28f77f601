//! The control lease, and the answers to commands. A command that is sent twice is answered twice, but executed once.

use crate::texts;
use messages::{Command, CommandKind, ControlState, Role};
use site_model::MissionCommandKind;
use std::collections::VecDeque;
use vocab::{ClientId, CommandId};

/// Parameters of [`ControlArbiter`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ControlConfig {
    /// Number of answers that are kept for commands that are sent again. Ten clients that drive at 10 Hz fill it in 25 s.
    pub max_answers: usize,
    /// Longest name of the lease's holder, characters; longer names are cut. Chosen: it fits on a line.
    pub max_name_chars: usize,
}

impl Default for ControlConfig {
    fn default() -> Self {
        Self { max_answers: 2_500, max_name_chars: 60 }
    }
}

/// The lease and the answered commands.
#[derive(Debug, Default)]
pub(crate) struct ControlArbiter {
    config: ControlConfig,
    state: ControlState,
    answered: VecDeque<(CommandId, Option<String>)>,
}

/// Decision on a command.
pub(crate) enum Admission {
    /// It is executed. `changed`: the lease has a new owner or name.
    Granted { changed: bool },
    /// It was answered before, with this refusal or with `None`.
    Repeated(Option<String>),
    /// It is refused. One sentence for people: why and what to do.
    Refused(String),
}

impl ControlArbiter {
    /// The lease, for publication.
    pub fn state(&self) -> &ControlState {
        &self.state
    }

    /// Decides on a command. A lease without a holder goes to the first client that sends a command.
    pub fn admit(&mut self, command: &Command) -> Admission {
        if let Some((_, answer)) = self.answered.iter().rev().find(|(id, _)| *id == command.id) {
            return Admission::Repeated(answer.clone());
        }
        if command.by.role == Role::Viewer && command.kind != CommandKind::StopMotion {
            return Admission::Refused(texts::VIEWER_REFUSED.to_owned());
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
            // Whoever sees that a run must stop can stop it.
            CommandKind::Mission(
                MissionCommandKind::Pause(_) | MissionCommandKind::Cancel(_) | MissionCommandKind::Abort(_),
            ) => Admission::Granted { changed: false },
            // Runs belong to all: asking for one takes no lease. While somebody has it, the others do not move the robot.
            CommandKind::Mission(_) if self.state.owner.is_none() => Admission::Granted { changed: false },
            _ => match self.state.owner {
                Some(owner) if owner == command.by.client => Admission::Granted { changed: false },
                Some(_) => Admission::Refused(texts::control_held_by(&self.state.name)),
                None => Admission::Granted { changed: self.grant(command.by.client, "") },
            },
        }
    }

    /// Keeps an answer for the case that the command is sent again.
    pub fn keep_answer(&mut self, id: CommandId, refused: Option<String>) {
        if self.answered.len() == self.config.max_answers {
            self.answered.pop_front();
        }
        self.answered.push_back((id, refused));
    }

    fn grant(&mut self, by: ClientId, name: &str) -> bool {
        let name = if name.trim().is_empty() { texts::UNNAMED_OPERATOR } else { name.trim() };
        let next =
            ControlState { owner: Some(by), name: name.chars().take(self.config.max_name_chars).collect() };
        let changed = next != self.state;
        self.state = next;
        changed
    }
}

#[cfg(test)]
#[path = "control_tests.rs"]
mod tests;
