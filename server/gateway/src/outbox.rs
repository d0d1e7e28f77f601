//! Messages for one client only: answers to its commands and pings. The queue is bounded; a client that lets it fill is disconnected.

use crate::limits::MAX_ANSWERS;
use api::Event;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::Notify;

/// Answers that wait to be written.
#[derive(Default)]
pub(crate) struct Outbox {
    content: Mutex<Content>,
    filled: Notify,
    overflowed: Notify,
}

#[derive(Default)]
struct Content {
    pongs: VecDeque<u64>,
    answers: VecDeque<Arc<Event>>,
}

/// The next thing for a client.
#[derive(Debug, PartialEq)]
pub(crate) enum Answer {
    /// Answer to a ping with this token.
    Pong(u64),
    /// An event.
    Event(Arc<Event>),
}

impl Outbox {
    fn lock(&self) -> MutexGuard<'_, Content> {
        self.content.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds an answer to a ping.
    pub(crate) fn pong(&self, token: u64) {
        self.add(|content| content.pongs.push_back(token));
    }

    /// Adds an event.
    pub(crate) fn answer(&self, event: Arc<Event>) {
        self.add(|content| content.answers.push_back(event));
    }

    fn add(&self, push: impl FnOnce(&mut Content)) {
        let mut content = self.lock();
        if content.pongs.len() + content.answers.len() < MAX_ANSWERS {
            push(&mut content);
            drop(content);
            self.filled.notify_one();
        } else {
            drop(content);
            self.overflowed.notify_one();
        }
    }

    /// Takes the next answer.
    pub(crate) fn next(&self) -> Option<Answer> {
        let mut content = self.lock();
        let pong = content.pongs.pop_front().map(Answer::Pong);
        pong.or_else(|| content.answers.pop_front().map(Answer::Event))
    }

    /// Returns after something was added since the last call. For one waiter.
    pub(crate) async fn filled(&self) {
        self.filled.notified().await;
    }

    /// Returns once an answer found no room: the client sends but does not read.
    pub(crate) async fn overflowed(&self) {
        self.overflowed.notified().await;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn pongs_overtake_answers_and_an_overflow_is_reported() {
        let outbox = Outbox::default();
        let notice = Arc::new(Event::Maps(Vec::new()));
        outbox.answer(notice.clone());
        outbox.pong(1);
        assert_eq!(outbox.next(), Some(Answer::Pong(1)));
        assert_eq!(outbox.next(), Some(Answer::Event(notice)));
        assert_eq!(outbox.next(), None);
        (0..=MAX_ANSWERS as u64).for_each(|token| outbox.pong(token));
        outbox.overflowed().await;
        assert_eq!(outbox.lock().pongs.len(), MAX_ANSWERS);
    }
}
