//! Sentences for the person, until they are read.

use crate::ClientTime;
use api::Severity;

/// Names a note for as long as the page is open.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NoticeId(pub u64);

/// Something to read.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownNotice {
    /// Which.
    pub id: NoticeId,
    /// How bad.
    pub severity: Severity,
    /// What happened and what comes next.
    pub text: String,
    /// When it came.
    pub since: ClientTime,
    /// How often the same was said in a row.
    pub times: u32,
}

/// The notes on show, oldest first.
#[derive(Clone, Debug, Default)]
pub struct Notices {
    shown: Vec<ShownNotice>,
    next: u64,
}

const SHOWN_MAX: usize = 4;
/// Reading time of a note that says all is well. Errors stay until they are put away.
const INFO_S: f64 = 6.0;
const WARNING_S: f64 = 15.0;

impl Notices {
    /// What is on show, oldest first.
    pub fn visible(&self) -> &[ShownNotice] {
        &self.shown
    }

    pub(crate) fn add(&mut self, now: ClientTime, severity: Severity, text: String) {
        if let Some(same) = self.shown.iter_mut().find(|note| note.text == text) {
            same.since = now;
            same.times += 1;
            return;
        }
        self.next += 1;
        self.shown.push(ShownNotice { id: NoticeId(self.next), severity, text, since: now, times: 1 });
        if self.shown.len() > SHOWN_MAX {
            // The least serious goes first, the oldest among equals.
            let least = (0..self.shown.len()).min_by_key(|&at| self.shown[at].severity);
            least.map(|at| self.shown.remove(at));
        }
    }

    pub(crate) fn dismiss(&mut self, id: NoticeId) {
        self.shown.retain(|note| note.id != id);
    }

    /// Puts away what has been there long enough.
    pub(crate) fn expire(&mut self, now: ClientTime) {
        self.shown.retain(|note| match note.severity {
            Severity::Info => now.since(note.since) < INFO_S,
            Severity::Warning => now.since(note.since) < WARNING_S,
            Severity::Error => true,
        });
    }
}
