//! The queue of publications from the control loop to the publisher. Posting never blocks.
//!
//! An estimate or scan that the publisher has not taken yet is replaced by the next one. All other publications keep their order and are never
//! dropped. They are small; only keyframes have clouds, which they share with the `disk` thread.

use messages::{CorrectedScan, Estimate, Notice, Publication, Severity};
use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;
use vocab::Stamp;

/// The publications that wait.
#[derive(Default)]
pub struct Mail {
    /// Publications in the order of posting, without estimates and scans.
    pub ordered: VecDeque<Publication>,
    /// The newest scan.
    pub scan: Option<CorrectedScan>,
    /// The newest estimate.
    pub estimate: Option<Estimate>,
    /// Whether the control loop has ended.
    pub closed: bool,
}

impl Mail {
    fn is_empty(&self) -> bool {
        self.ordered.is_empty() && self.scan.is_none() && self.estimate.is_none()
    }
}

/// The queue, shared by both threads.
#[derive(Default)]
pub struct Mailbox {
    mail: Mutex<Mail>,
    arrived: Condvar,
}

impl Mailbox {
    /// Appends a publication.
    pub fn post(&self, publication: Publication) {
        let mut mail = self.lock();
        match publication {
            Publication::Estimate(estimate) => mail.estimate = Some(estimate),
            Publication::Scan(scan) => mail.scan = Some(scan),
            other => mail.ordered.push_back(other),
        }
        drop(mail);
        self.arrived.notify_one();
    }

    /// Appends a notice of the shell itself.
    pub fn notice(&self, at: Stamp, severity: Severity, text: String) {
        self.post(Publication::Notice(Notice { at, severity, text }));
    }

    /// Tells the publisher that nothing more comes.
    pub fn close(&self) {
        self.lock().closed = true;
        self.arrived.notify_one();
    }

    /// Waits until there is a publication, the mailbox is closed or `deadline` has passed. Takes all publications.
    pub fn wait(&self, deadline: Instant) -> Mail {
        let mut mail = self.lock();
        while mail.is_empty() && !mail.closed {
            let remaining = deadline.saturating_duration_since(Instant::now());
            if remaining.is_zero() {
                break;
            }
            mail = self.arrived.wait_timeout(mail, remaining).unwrap_or_else(PoisonError::into_inner).0;
        }
        let closed = mail.closed;
        Mail { closed, ..std::mem::take(&mut mail) }
    }

    /// Locks the data. A panic of the other thread leaves it usable, because every change of it is a single assignment.
    fn lock(&self) -> MutexGuard<'_, Mail> {
        self.mail.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
#[path = "mailbox_tests.rs"]
mod tests;
