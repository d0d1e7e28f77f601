//! Messages for one client only: answers to its commands and pings. The queue is bounded; a client that lets it fill is disconnected.
//! Requests for the whole graph or the whole site take one bit, however many come.

use crate::limits::FIXED;
use api::Event;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;
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
    graph_requests: WholeRequests,
    site_requests: WholeRequests,
}

/// Requests for the whole graph, or for the whole site. Those that wait are answered together, `graph_answer_period` after the last answer.
#[derive(Default)]
struct WholeRequests {
    is_waiting: bool,
    /// When the last answer was given.
    answered: Option<Instant>,
}

impl WholeRequests {
    /// When an answer is due, if a request waits. `now` or earlier means at once.
    fn due(&self, now: Instant) -> Option<Instant> {
        self.is_waiting.then(|| self.answered.map_or(now, |answered| answered + FIXED.graph_answer_period))
    }

    /// Returns whether an answer is due, now counted as given.
    fn answer_if_due(&mut self, now: Instant) -> bool {
        let is_due = self.due(now).is_some_and(|due| due <= now);
        if is_due {
            *self = Self { is_waiting: false, answered: Some(now) };
        }
        is_due
    }
}

/// The next thing for a client.
#[derive(Debug, PartialEq)]
pub(crate) enum OutboxItem {
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
        if content.pongs.len() + content.answers.len() < FIXED.max_answers {
            push(&mut content);
            drop(content);
            self.filled.notify_one();
        } else {
            drop(content);
            self.overflowed.notify_one();
        }
    }

    /// Adds a request for the whole graph.
    pub(crate) fn request_graph(&self) {
        self.lock().graph_requests.is_waiting = true;
        self.filled.notify_one();
    }

    /// Returns whether the whole graph is to be sent now, and counts it as sent.
    pub(crate) fn take_graph_request(&self, now: Instant) -> bool {
        self.lock().graph_requests.answer_if_due(now)
    }

    /// Adds a request for the whole site.
    pub(crate) fn request_site(&self) {
        self.lock().site_requests.is_waiting = true;
        self.filled.notify_one();
    }

    /// Returns whether the whole site is to be sent now, and counts it as sent.
    pub(crate) fn take_site_request(&self, now: Instant) -> bool {
        self.lock().site_requests.answer_if_due(now)
    }

    /// When a request that waits has an answer to give.
    pub(crate) fn request_due(&self, now: Instant) -> Option<Instant> {
        let content = self.lock();
        [&content.graph_requests, &content.site_requests].into_iter().filter_map(|it| it.due(now)).min()
    }

    /// Takes the next answer.
    pub(crate) fn next(&self) -> Option<OutboxItem> {
        let mut content = self.lock();
        let pong = content.pongs.pop_front().map(OutboxItem::Pong);
        pong.or_else(|| content.answers.pop_front().map(OutboxItem::Event))
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
        assert_eq!(outbox.next(), Some(OutboxItem::Pong(1)));
        assert_eq!(outbox.next(), Some(OutboxItem::Event(notice)));
        assert_eq!(outbox.next(), None);
        (0..=FIXED.max_answers as u64).for_each(|token| outbox.pong(token));
        outbox.overflowed().await;
        assert_eq!(outbox.lock().pongs.len(), FIXED.max_answers);
    }

    #[test]
    fn many_requests_for_the_graph_get_one_answer_in_a_period() {
        let (outbox, start) = (Outbox::default(), Instant::now());
        assert!(!outbox.take_graph_request(start) && outbox.request_due(start).is_none());
        (0..1000).for_each(|_| outbox.request_graph());
        assert!(outbox.take_graph_request(start));
        assert!(!outbox.take_graph_request(start), "all were answered");
        (0..1000).for_each(|_| outbox.request_graph());
        assert!(!outbox.take_graph_request(start + FIXED.graph_answer_period / 2));
        let due = outbox.request_due(start);
        assert_eq!(due, Some(start + FIXED.graph_answer_period));
        assert!(outbox.take_graph_request(start + FIXED.graph_answer_period), "late, but not never");
    }
}
