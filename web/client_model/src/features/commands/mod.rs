//! Commands that the robot has not answered yet.

use crate::{ClientTime, texts};
use api::Command;
use vocab::CommandId;

/// When an unanswered command is sent again.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ResendConfig {
    /// A command older than this is not sent again after a reconnection: the operator has gone on meanwhile. Seconds. Chosen: as long as a person waits before he tries
    /// again.
    pub(crate) max_age_s: f64,
}

impl Default for ResendConfig {
    fn default() -> Self {
        Self { max_age_s: 5.0 }
    }
}

/// One unanswered command.
#[derive(Clone, Debug, PartialEq)]
struct PendingCommand {
    /// Its id. The server carries out an id once, however often it comes.
    id: CommandId,
    command: Command,
    /// When it was asked first.
    asked: ClientTime,
}

/// All unanswered commands, oldest first.
#[derive(Clone, Debug, Default)]
pub(crate) struct PendingCommands {
    pending: Vec<PendingCommand>,
    config: ResendConfig,
}

impl PendingCommands {
    /// Whether a command of this kind is unanswered.
    pub(crate) fn is_pending(&self, matches: impl Fn(&Command) -> bool) -> bool {
        self.pending.iter().any(|pending| matches(&pending.command))
    }

    pub(crate) fn add(&mut self, id: CommandId, command: Command, now: ClientTime) {
        self.pending.push(PendingCommand { id, command, asked: now });
    }

    /// The command of this id, which is no longer waited for.
    pub(crate) fn take(&mut self, id: CommandId) -> Option<Command> {
        let at = self.pending.iter().position(|pending| pending.id == id)?;
        Some(self.pending.remove(at).command)
    }

    /// The commands to send again on a new connection. All others are forgotten; `expired` gets what they were.
    pub(crate) fn resend(
        &mut self,
        now: ClientTime,
        mut expired: impl FnMut(&Command),
    ) -> Vec<(CommandId, Command)> {
        self.pending.retain(|pending| {
            let stays = match pending.command {
                // A stop is sent however old it is; a velocity is worthless after half a second.
                Command::StopMotion => true,
                Command::Teleoperate(_) => false,
                _ => now.since(pending.asked) <= self.config.max_age_s,
            };
            if !stays && !matches!(pending.command, Command::Teleoperate(_)) {
                expired(&pending.command);
            }
            stays
        });
        self.pending.iter().map(|pending| (pending.id, pending.command.clone())).collect()
    }
}

/// Sentence for a command that expired while the link was lost.
pub(crate) fn expired_sentence(command: &Command) -> String {
    texts::command_expired(texts::command_name(command))
}

#[cfg(test)]
mod tests;
