//! What is for one client only: answers to its commands and pings. Bounded; a client that lets it fill is dismissed.

use crate::limits::MAX_ANSWERS;
use api::Event;
use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};
use tokio::sync::Notify;

/// Answers that wait to be written.
#[derive(Default)]
pub(crate) struct Outbox {
    content: Mutex<Content>,
    filled: Notify,
}

#[derive(Default)]
struct Content {
    pongs: VecDeque<u64>,
    answers: VecDeque<Event>,
    overflowed: bool,
}

/// The next thing for this client only.
#[derive(Debug, PartialEq)]
pub(crate) enum Answer {
    /// Answer to a ping with this token.
    Pong(u64),
    /// An event for nobody else.
    Event(Event),
}

/// Too much waits: the client asks but does not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Overflow;

impl Outbox {
    fn lock(&self) -> MutexGuard<'_, Content> {
        self.content.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds an answer to a ping.
    pub(crate) fn pong(&self, token: u64) {
        self.add(|content| content.pongs.push_back(token));
    }

    /// Adds an event.
    pub(crate) fn answer(&self, event: Event) {
        self.add(|content| content.answers.push_back(event));
    }

    fn add(&self, push: impl FnOnce(&mut Content)) {
        let mut content = self.lock();
        if content.pongs.len() + content.answers.len() < MAX_ANSWERS {
            push(&mut content);
        } else {
            content.overflowed = true;
        }
        drop(content);
        self.filled.notify_one();
    }

    /// Takes the next answer.
    pub(crate) fn next(&self) -> Result<Option<Answer>, Overflow> {
        let mut content = self.lock();
        if content.overflowed {
            return Err(Overflow);
        }
        let pong = content.pongs.pop_front().map(Answer::Pong);
        Ok(pong.or_else(|| content.answers.pop_front().map(Answer::Event)))
    }

    /// Returns after something was added since the last call. For one waiter.
    pub(crate) async fn filled(&self) {
        self.filled.notified().await;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pongs_overtake_answers_and_overflow_is_final() {
        let outbox = Outbox::default();
        let notice = Event::Maps(Vec::new());
        outbox.answer(notice.clone());
        outbox.pong(1);
        assert_eq!(outbox.next(), Ok(Some(Answer::Pong(1))));
        assert_eq!(outbox.next(), Ok(Some(Answer::Event(notice))));
        assert_eq!(outbox.next(), Ok(None));
        (0..=MAX_ANSWERS as u64).for_each(|token| outbox.pong(token));
        assert_eq!(outbox.next(), Err(Overflow));
        assert_eq!(outbox.lock().pongs.len(), MAX_ANSWERS);
    }
}
