//! Commands whose answers wait until what they changed is durable.

use crate::waiting_answers::WaitingAnswers;
use messages::{Command, LedgerEvent, StackEffect};
use vocab::{ClientId, CommandId};

/// Commits that were asked for, and the answers that wait for them: those of stops of motion and their ends.
#[derive(Debug, Default)]
pub(crate) struct Commits {
    /// Number of the next commit.
    next: u64,
    /// By the number of their commit, ascending.
    waiting: WaitingAnswers<u64>,
}

impl Commits {
    /// Asks for a commit of what a command changed. Its answer waits.
    pub fn begin(&mut self, command: &Command, event: LedgerEvent) -> StackEffect {
        let (seq, commit) = self.begin_events(vec![event]);
        self.waiting.push(seq, command.id, command.by.client);
        commit
    }

    /// Asks for a commit for which no answer waits. Returns its number.
    pub fn begin_events(&mut self, events: Vec<LedgerEvent>) -> (u64, StackEffect) {
        let seq = self.next;
        self.next += 1;
        (seq, StackEffect::Commit { seq, events })
    }

    /// Whether the answer to this command waits.
    pub fn is_waiting(&self, command: CommandId) -> bool {
        self.waiting.contains(command)
    }

    /// This commit and those before it are durable. Returns the commands that can be answered now, with their clients.
    pub fn end(&mut self, seq: u64) -> Vec<(CommandId, ClientId)> {
        self.waiting.take_oldest(|waiting| *waiting <= seq)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{CommandKind, Principal};
    use uuid::Uuid;

    #[test]
    fn a_commit_answers_the_commands_before_it_and_none_after_it() {
        let mut commits = Commits::default();
        let client = ClientId(Uuid::from_u128(9));
        let id = |number| CommandId(Uuid::from_u128(number));
        for number in 0..4 {
            let by = Principal::operator(client);
            let command = Command { id: id(number), by, kind: CommandKind::AllowMotion };
            let effect = commits.begin(&command, LedgerEvent::StopLatch(None));
            assert!(matches!(effect, StackEffect::Commit { seq, .. } if u128::from(seq) == number));
        }
        assert_eq!(commits.end(1), [(id(0), client), (id(1), client)]);
        assert_eq!(commits.end(1), []);
        assert!(!commits.is_waiting(id(1)) && commits.is_waiting(id(2)));
        assert_eq!(commits.end(u64::MAX).len(), 2);
    }
}
