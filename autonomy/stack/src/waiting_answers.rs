//! Commands whose answers wait until what they changed is durable.

use std::collections::VecDeque;
use vocab::{ClientId, CommandId};

/// Parameters of [`WaitingAnswers`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct WaitingAnswersConfig {
    /// Answers that wait at most. Only commands that change what is durable wait, a few in a second, so that this is for a disk that does not write for minutes. Beyond
    /// it the oldest is forgotten; its client sends the command again. Chosen: a minute and more of such commands.
    pub max_waiting: usize,
}

impl Default for WaitingAnswersConfig {
    fn default() -> Self {
        Self { max_waiting: 256 }
    }
}

/// Commands with their clients and what their answers wait for, the oldest first.
#[derive(Clone, Debug)]
pub(crate) struct WaitingAnswers<Cause> {
    config: WaitingAnswersConfig,
    waiting: VecDeque<(Cause, CommandId, ClientId)>,
}

impl<Cause> Default for WaitingAnswers<Cause> {
    fn default() -> Self {
        Self { config: WaitingAnswersConfig::default(), waiting: VecDeque::new() }
    }
}

impl<Cause> WaitingAnswers<Cause> {
    /// Keeps a command until it is answered.
    pub fn push(&mut self, cause: Cause, command: CommandId, client: ClientId) {
        if self.waiting.len() >= self.config.max_waiting {
            self.waiting.pop_front();
        }
        self.waiting.push_back((cause, command, client));
    }

    /// Whether the answer to this command waits.
    pub fn contains(&self, command: CommandId) -> bool {
        self.waiting.iter().any(|(_, known, _)| *known == command)
    }

    /// The client of a command that is answered now; none if it was forgotten.
    pub fn take(&mut self, command: CommandId) -> Option<ClientId> {
        let index = self.waiting.iter().position(|(_, known, _)| *known == command)?;
        self.waiting.remove(index).map(|(_, _, client)| client)
    }

    /// The oldest commands, up to the first of which `is_over` does not hold.
    pub fn take_oldest(&mut self, is_over: impl Fn(&Cause) -> bool) -> Vec<(CommandId, ClientId)> {
        let count = self.waiting.iter().take_while(|(cause, ..)| is_over(cause)).count();
        self.waiting.drain(..count).map(|(_, command, client)| (command, client)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use uuid::Uuid;

    /// Ids are random: here the first is the greatest.
    fn id(number: u128) -> CommandId {
        CommandId(Uuid::from_u128(1_000 - number))
    }

    fn client(number: u128) -> ClientId {
        ClientId(Uuid::from_u128(number))
    }

    #[test]
    fn the_oldest_of_too_many_commands_is_forgotten() {
        let mut answers = WaitingAnswers::default();
        let max = answers.config.max_waiting as u128;
        for number in 0..=max {
            answers.push((), id(number), client(number));
        }
        assert!(!answers.contains(id(0)) && answers.contains(id(1)) && answers.contains(id(max)));
        assert_eq!(answers.take(id(1)), Some(client(1)));
        assert_eq!((answers.take(id(1)), answers.take(id(0))), (None, None));
    }

    #[test]
    fn commands_are_answered_up_to_the_first_that_has_to_wait() {
        let mut answers = WaitingAnswers::default();
        for number in 0..4_u8 {
            answers.push(number, id(number.into()), client(9));
        }
        assert_eq!(answers.take_oldest(|number| *number <= 1), [(id(0), client(9)), (id(1), client(9))]);
        assert_eq!(answers.take_oldest(|number| *number <= 1), []);
        assert_eq!(answers.take_oldest(|_| true).len(), 2);
    }
}
