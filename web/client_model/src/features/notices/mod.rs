//! Sentences for the operator, until they are read.

use crate::{ClientTime, ServerClock};
use api::{Notice, Severity};

/// Names a notice for as long as the page is open.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NoticeId(pub u64);

/// A notice on show.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownNotice {
    /// Its name.
    pub id: NoticeId,
    /// How serious it is.
    pub severity: Severity,
    /// What happened and what comes next.
    pub text: String,
    /// When it was shown last.
    pub since: ClientTime,
    /// How often the same text came in a row.
    pub times: u32,
}

/// How many notices are shown, and for how long. Chosen for reading at leisure.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NoticeConfig {
    /// Notices on show at once. Chosen: more would cover the scene.
    pub(crate) max_shown: usize,
    /// Time on show of a notice of severity `Info`, seconds. Chosen: a person reads a line of 80 letters in about 5 s.
    pub(crate) info_s: f64,
    /// Time on show of a warning, seconds. Errors stay until they are dismissed. Chosen: twice that and more, because a warning interrupts other work.
    pub(crate) warning_s: f64,
    /// A notice of the server that is older than this is not shown: a snapshot repeats the last one, however old. Seconds. Chosen: twice [`Self::warning_s`].
    pub(crate) max_age_s: f64,
}

impl Default for NoticeConfig {
    fn default() -> Self {
        Self { max_shown: 4, info_s: 6.0, warning_s: 15.0, max_age_s: 30.0 }
    }
}

/// The notices on show, oldest first.
#[derive(Clone, Debug, Default)]
pub struct Notices {
    shown: Vec<ShownNotice>,
    last_id: u64,
    /// Notices that came before the server's clock was known: their age is not known either.
    received: Vec<Notice>,
    config: NoticeConfig,
}

impl Notices {
    /// What is on show, oldest first.
    pub fn visible(&self) -> &[ShownNotice] {
        &self.shown
    }

    /// A notice of the server, to be shown with [`Self::show_received`].
    pub(crate) fn receive(&mut self, notice: Notice) {
        self.received.push(notice);
    }

    /// Shows received notices that are recent by the server's clock, once that is known.
    pub(crate) fn show_received(&mut self, clock: &ServerClock, now: ClientTime) {
        if clock.stamp_at(now).is_none() {
            return;
        }
        for notice in std::mem::take(&mut self.received) {
            if clock.age_of(notice.at, now).is_some_and(|age| age < self.config.max_age_s) {
                self.add(now, notice.severity, notice.text);
            }
        }
    }

    /// Forgets notices that have not been shown: the server sends them again.
    pub(crate) fn forget_received(&mut self) {
        self.received.clear();
    }

    pub(crate) fn add(&mut self, now: ClientTime, severity: Severity, text: String) {
        if let Some(same) = self.shown.iter_mut().find(|notice| notice.text == text) {
            same.since = now;
            same.times += 1;
            return;
        }
        self.last_id += 1;
        self.shown.push(ShownNotice { id: NoticeId(self.last_id), severity, text, since: now, times: 1 });
        if self.shown.len() > self.config.max_shown {
            // The least serious one goes first; of equals the oldest.
            let least = (0..self.shown.len()).min_by_key(|&at| self.shown[at].severity);
            least.map(|at| self.shown.remove(at));
        }
    }

    pub(crate) fn dismiss(&mut self, id: NoticeId) {
        self.shown.retain(|notice| notice.id != id);
    }

    /// Removes notices that have been on show long enough.
    pub(crate) fn expire(&mut self, now: ClientTime) {
        self.shown.retain(|notice| match notice.severity {
            Severity::Info => now.since(notice.since) < self.config.info_s,
            Severity::Warning => now.since(notice.since) < self.config.warning_s,
            Severity::Error => true,
        });
    }
}

#[cfg(test)]
mod tests;
