//! The queue of the thread `accounts`. Whoever floods it with attempts to sign in takes places of strangers only.

use super::texts;
use super::{AccessDirectory, AccountsConfig};
use accounts::AccountName;
use api::Caller;
use api::access::{AccountRefusal, AccountRefusalKind, AccountRequest};
use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A request that waits.
#[derive(Debug)]
pub(super) struct WaitingAccountRequest {
    pub number: u64,
    pub by: Caller,
    pub request: AccountRequest,
}

#[derive(Debug, Default)]
struct Lanes {
    /// Sign-ins from known addresses and browsers.
    known: VecDeque<WaitingAccountRequest>,
    others: VecDeque<WaitingAccountRequest>,
    strangers: VecDeque<WaitingAccountRequest>,
    is_closed: bool,
}

/// The queue, shared with the threads that fill it.
#[derive(Debug)]
pub struct AccountInbox {
    config: AccountsConfig,
    directory: Arc<AccessDirectory>,
    lanes: Mutex<Lanes>,
    changed: Condvar,
}

impl AccountInbox {
    /// An empty queue.
    pub fn new(config: AccountsConfig, directory: Arc<AccessDirectory>) -> Self {
        Self { config, directory, lanes: Mutex::default(), changed: Condvar::new() }
    }

    fn lock(&self) -> MutexGuard<'_, Lanes> {
        self.lanes.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Hands in a request. Never blocks.
    ///
    /// # Errors
    /// When too many wait.
    pub fn ask(&self, number: u64, by: Caller, request: AccountRequest) -> Result<(), AccountRefusal> {
        let is_known = match &request {
            AccountRequest::SignIn { account, .. } => {
                let name = account.parse::<AccountName>().ok();
                Some(name.is_some_and(|name| self.directory.is_known(name.as_str(), &by)))
            }
            AccountRequest::MakeFirstAdmin(_) => Some(false),
            _ => None,
        };
        let mut lanes = self.lock();
        let (lane, capacity) = match is_known {
            Some(true) => (&mut lanes.known, self.config.max_known),
            Some(false) => (&mut lanes.strangers, self.config.max_strangers),
            None => (&mut lanes.others, self.config.max_requests),
        };
        let is_waiting = is_known == Some(false) && lane.iter().any(|other| other.by.address == by.address);
        if lane.len() >= capacity || is_waiting {
            let reason = texts::SIGN_IN_BUSY.to_owned();
            return Err(AccountRefusal { kind: AccountRefusalKind::Busy, reason });
        }
        lane.push_back(WaitingAccountRequest { number, by, request });
        drop(lanes);
        self.changed.notify_one();
        Ok(())
    }

    /// No more requests come.
    pub fn close(&self) {
        self.lock().is_closed = true;
        self.changed.notify_one();
    }

    /// Waits for a request, at most for this time. Fails when no more come.
    pub(super) fn next(&self, patience: Duration) -> Result<Option<WaitingAccountRequest>, Closed> {
        let mut lanes = self.lock();
        let is_empty =
            |lanes: &Lanes| lanes.known.is_empty() && lanes.others.is_empty() && lanes.strangers.is_empty();
        if is_empty(&lanes) && !lanes.is_closed {
            lanes = self.changed.wait_timeout(lanes, patience).unwrap_or_else(PoisonError::into_inner).0;
        }
        if lanes.is_closed {
            return Err(Closed);
        }
        let Lanes { known, others, strangers, .. } = &mut *lanes;
        Ok([known, others, strangers].into_iter().find_map(VecDeque::pop_front))
    }
}

/// The queue gets no more requests.
#[derive(Debug)]
pub(super) struct Closed;
