//! From the control loop to the publisher: never blocks, and holds the latest of what goes out of date.
//!
//! Estimates and scans are replaced when the publisher has not fetched them yet. Everything else keeps its order and is
//! never dropped: it is small, apart from keyframes, which come a few times a second and share their clouds with the
//! job thread.

use messages::{CorrectedScan, Estimate, Notice, Publication, Severity};
use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;
use vocab::Stamp;

/// What lies in the mailbox.
#[derive(Default)]
pub struct Mail {
    pub ordered: VecDeque<Publication>,
    pub scan: Option<CorrectedScan>,
    pub estimate: Option<Estimate>,
    pub closed: bool,
}

impl Mail {
    fn is_empty(&self) -> bool {
        self.ordered.is_empty() && self.scan.is_none() && self.estimate.is_none()
    }
}

/// Shared by both sides.
#[derive(Default)]
pub struct Mailbox {
    mail: Mutex<Mail>,
    arrived: Condvar,
}

impl Mailbox {
    /// Hands over what the stack said.
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

    /// Hands over something that the shell itself has to say.
    pub fn notice(&self, at: Stamp, severity: Severity, text: String) {
        self.post(Publication::Notice(Notice { at, severity, text }));
    }

    /// Nothing more will come.
    pub fn close(&self) {
        self.lock().closed = true;
        self.arrived.notify_one();
    }

    /// Waits until something lies here, it is closed, or `deadline` has come, and takes all of it.
    pub fn wait(&self, deadline: Instant) -> Mail {
        let mut mail = self.lock();
        while mail.is_empty() && !mail.closed {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                break;
            }
            mail = self.arrived.wait_timeout(mail, left).unwrap_or_else(PoisonError::into_inner).0;
        }
        let closed = mail.closed;
        Mail { closed, ..std::mem::take(&mut mail) }
    }

    /// Plain data behind the lock: a thread that panicked while holding it left nothing half-done that matters.
    fn lock(&self) -> MutexGuard<'_, Mail> {
        self.mail.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
