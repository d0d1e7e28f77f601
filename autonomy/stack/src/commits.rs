//! Commands whose answers wait until what they changed is durable.

use messages::{Command, LedgerEvent, StackEffect};
use std::collections::VecDeque;
use vocab::{ClientId, CommandId};

/// Answers that may wait. Only stops of motion and their ends wait; the oldest is dropped when a disk does not write for long. Its client sends the
/// command again.
const WAITING_MAX: usize = 256;

/// Commits that were asked for, and the answers that wait for them.
#[derive(Debug, Default)]
pub(crate) struct Commits {
    /// Number of the next commit.
    next: u64,
    /// With the number of their commit, ascending.
    waiting: VecDeque<(u64, CommandId, ClientId)>,
}

impl Commits {
    /// Asks for a commit of what a command changed. Its answer waits.
    pub fn begin(&mut self, command: &Command, event: LedgerEvent) -> StackEffect {
        let (seq, commit) = self.begin_events(vec![event]);
        if self.waiting.len() == WAITING_MAX {
            self.waiting.pop_front();
        }
        self.waiting.push_back((seq, command.id, command.by.client));
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
        self.waiting.iter().any(|(_, id, _)| *id == command)
    }

    /// This commit and those before it are durable. Returns the commands that can be answered now, with their clients.
    pub fn end(&mut self, seq: u64) -> Vec<(CommandId, ClientId)> {
        let count = self.waiting.partition_point(|(waiting, ..)| *waiting <= seq);
        self.waiting.drain(..count).map(|(_, id, client)| (id, client)).collect()
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
