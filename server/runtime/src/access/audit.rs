//! The audit log of commands: who asked for what from where, and what became of it. Entries are written by the ledger's thread, many in one transaction; nothing waits for
//! them.
//!
//! A flood fills neither the log nor the disk. Refusals that are equal in account, address, request and reason are counted: the first is written at once, further ones as
//! one entry after [`CommandAuditConfig::refusal_period`]. An account has a budget of commands with an entry each ([`CommandAuditConfig::command_burst`]); beyond it they
//! are counted too.

use super::audit_texts;
use accounts::{RepeatConfig, Repeated, Repeats};
use api::{Caller, Command, CommandOutcome};
use messages::Principal;
use std::collections::{BTreeMap, VecDeque};
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use store::{AuditEntry, LedgerWriter, StoreError};
use vocab::{ClientId, CommandId, Stamp, legible};

/// Parameters of the [`CommandAudit`].
#[derive(Clone, Copy, Debug)]
struct CommandAuditConfig {
    /// Commands that wait for their outcome. Of further ones the oldest is written as not answered. Chosen: twice the commands that may be in the gateway's queue to the
    /// core.
    max_waiting: usize,
    /// Longest text of a command, characters. Chosen: some lines of a table, enough for every regular command.
    max_chars: usize,
    /// Driving by hand sends ten commands a second. One entry in this time says that somebody drives. Chosen: a minute; with less, driving hides the other entries; with
    /// more, its end is known less well.
    driving_period: Duration,
    /// Clients of which it is known since when they drive. Chosen: four times the clients that may be connected.
    max_driving: usize,
    /// Time for which equal refusals are counted. Chosen: shorter than the gateway's 10 minutes, so that what it has counted is not held back.
    refusal_period: Duration,
    /// Refusals that are told apart at a time, of those who have signed in and of others each. Chosen: as the gateway's. They make 37,000 entries a day at most.
    max_refusals: usize,
    /// Commands of an account that have an entry each without a pause. Chosen: an hour of quick work with the client.
    command_burst: f64,
    /// Time after which an account may give one more that has. Chosen: 17,280 entries a day, with which an account needs a month to push older ones out of the log.
    command_period: Duration,
    /// Accounts whose commands are counted. Chosen: as many accounts and tokens as there may be.
    max_accounts: usize,
    /// Entries that wait for the ledger's thread while the disk fails. Chosen: 4 MB at most.
    max_ready: usize,
}

const CONFIG: CommandAuditConfig = CommandAuditConfig {
    max_waiting: 512,
    max_chars: 300,
    driving_period: Duration::from_secs(60),
    max_driving: 256,
    refusal_period: Duration::from_secs(300),
    max_refusals: 64,
    command_burst: 600.0,
    command_period: Duration::from_secs(5),
    max_accounts: 1_000,
    max_ready: 4_096,
};

/// What writes entries in a transaction of the ledger.
pub type AuditWrite = Box<dyn FnMut(&LedgerWriter<'_>, Stamp) -> Result<(), StoreError> + Send>;

/// Collects entries.
pub struct CommandAudit {
    /// Hands something to the ledger's thread. Returns whether there was room for it.
    submit: Box<dyn Fn(AuditWrite) -> bool + Send + Sync>,
    state: Arc<Mutex<State>>,
}

/// What makes refusals equal.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Refusal {
    account: Option<String>,
    address: Option<IpAddr>,
    command: String,
    outcome: String,
}

/// How many more commands of an account get an entry of their own: a token bucket.
#[derive(Clone, Copy, Debug)]
struct Budget {
    left: f64,
    at: Instant,
}

impl Budget {
    /// Takes one, if there is one.
    fn take(&mut self, now: Instant) -> bool {
        let earned =
            now.saturating_duration_since(self.at).as_secs_f64() / CONFIG.command_period.as_secs_f64();
        *self = Self { left: (self.left + earned).min(CONFIG.command_burst), at: now };
        let has_one = self.left >= 1.0;
        self.left -= f64::from(u8::from(has_one));
        has_one
    }
}

#[derive(Debug)]
struct State {
    /// Without an outcome.
    waiting: VecDeque<(CommandId, AuditEntry)>,
    /// To be written.
    ready: Vec<AuditEntry>,
    /// Whether the ledger's thread was asked to write what is ready.
    is_asked: bool,
    driving: BTreeMap<ClientId, Instant>,
    /// Of those who have not signed in, and of those who have.
    refusals: [Repeats<Refusal, Option<Principal>>; 2],
    budgets: BTreeMap<Option<String>, Budget>,
    /// Entries that had no room.
    lost: u64,
}

impl Default for State {
    fn default() -> Self {
        let config = RepeatConfig { period: CONFIG.refusal_period, max_kinds: CONFIG.max_refusals };
        Self {
            waiting: VecDeque::new(),
            ready: Vec::new(),
            is_asked: false,
            driving: BTreeMap::new(),
            refusals: [Repeats::new(config), Repeats::new(config)],
            budgets: BTreeMap::new(),
            lost: 0,
        }
    }
}

impl State {
    /// Puts an entry where the ledger's thread takes it. While the disk fails there is no room for all.
    fn push(&mut self, mut entry: AuditEntry) {
        if self.ready.len() >= CONFIG.max_ready {
            self.lost += 1;
            return;
        }
        match std::mem::take(&mut self.lost) {
            0 => {}
            lost => entry.outcome.push_str(&audit_texts::entries_lost(lost)),
        }
        self.ready.push(entry);
    }

    /// Counts a refusal, or something else that has no entry of its own.
    fn count(&mut self, by: Option<Principal>, kind: Refusal, count: u32) {
        let refusals = &mut self.refusals[usize::from(by.is_some())];
        if !refusals.note(kind, by, count) {
            let (command, outcome) =
                (audit_texts::OTHER_REQUESTS.to_owned(), audit_texts::REFUSED.to_owned());
            refusals.note_always(Refusal { account: None, address: None, command, outcome }, None, count);
        }
    }

    /// Makes entries of the refusals that are due.
    fn take_refusals(&mut self, now: Instant) {
        let due: Vec<_> = self.refusals.iter_mut().flat_map(|all| all.take_due(now, usize::MAX)).collect();
        for Repeated { kind: Refusal { address, command, mut outcome, .. }, last, count } in due {
            outcome.push_str(&audit_texts::times(count));
            self.push(AuditEntry { by: last, address, command, outcome });
        }
    }

    /// Whether a command of this account has an entry of its own.
    fn has_budget(&mut self, account: &Option<String>, now: Instant) -> bool {
        if self.budgets.len() >= CONFIG.max_accounts && !self.budgets.contains_key(account) {
            self.budgets.clear();
        }
        let full = Budget { left: CONFIG.command_burst, at: now };
        self.budgets.entry(account.clone()).or_insert(full).take(now)
    }
}

fn lock(state: &Mutex<State>) -> MutexGuard<'_, State> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}

impl CommandAudit {
    /// `submit` hands something to the ledger's thread, and returns whether there was room for it.
    pub fn new(submit: impl Fn(AuditWrite) -> bool + Send + Sync + 'static) -> Self {
        Self { submit: Box::new(submit), state: Arc::default() }
    }

    /// A command was given. Its outcome follows.
    pub fn begin(&self, id: CommandId, by: &Principal, caller: &Caller, command: &Command) {
        let mut state = lock(&self.state);
        let now = Instant::now();
        if matches!(command, Command::Teleoperate(_)) {
            let is_new = |noted: &Instant| now.saturating_duration_since(*noted) >= CONFIG.driving_period;
            if !state.driving.get(&by.client).is_none_or(is_new) {
                return;
            }
            if state.driving.len() >= CONFIG.max_driving {
                state.driving.clear();
            }
            state.driving.insert(by.client, now);
        }
        if !state.has_budget(&by.account, now) {
            let kind = Refusal {
                account: by.account.clone(),
                address: caller.address,
                command: audit_texts::FURTHER_COMMANDS.to_owned(),
                outcome: audit_texts::NOT_LISTED.to_owned(),
            };
            state.count(Some(by.clone()), kind, 1);
            return;
        }
        if state.waiting.len() >= CONFIG.max_waiting
            && let Some((_, mut oldest)) = state.waiting.pop_front()
        {
            oldest.outcome = audit_texts::NOT_ANSWERED.to_owned();
            state.push(oldest);
        }
        let command = legible(&format!("{command:?}"), CONFIG.max_chars);
        let outcome = String::new();
        state
            .waiting
            .push_back((id, AuditEntry { by: Some(by.clone()), address: caller.address, command, outcome }));
    }

    /// Something was refused. Refusals that are equal are counted.
    pub fn refuse(&self, by: Option<Principal>, address: Option<IpAddr>, command: &str, reason: &str) {
        self.note(by, address, command, &audit_texts::refused_because(reason), 1);
    }

    /// Something has come of a request this many times. Those that are equal are counted together.
    pub fn note(
        &self,
        by: Option<Principal>,
        address: Option<IpAddr>,
        command: &str,
        outcome: &str,
        count: u32,
    ) {
        let account = by.as_ref().and_then(|by| by.account.clone());
        let command = legible(command, CONFIG.max_chars);
        let outcome = legible(outcome, CONFIG.max_chars);
        lock(&self.state).count(by, Refusal { account, address, command, outcome }, count);
        self.flush(Instant::now());
    }

    /// What somebody has begun with a command has ended, long after the command was answered.
    pub fn ended(&self, by: &Principal, address: Option<IpAddr>, command: &str, outcome: &str) {
        let command = legible(command, CONFIG.max_chars);
        let outcome = legible(outcome, CONFIG.max_chars);
        lock(&self.state).push(AuditEntry { by: Some(by.clone()), address, command, outcome });
        self.ask();
    }

    /// Has what was counted written once it is due. To be called from time to time.
    pub fn flush(&self, now: Instant) {
        let has_ready = {
            let mut state = lock(&self.state);
            state.take_refusals(now);
            !state.ready.is_empty()
        };
        if has_ready {
            self.ask();
        }
    }

    /// A command was answered.
    pub fn finish(&self, id: CommandId, outcome: &CommandOutcome) {
        {
            let mut state = lock(&self.state);
            let Some(index) = state.waiting.iter().position(|(waiting, _)| *waiting == id) else { return };
            let Some((_, mut entry)) = state.waiting.remove(index) else { return };
            entry.outcome = match outcome {
                CommandOutcome::Accepted => audit_texts::ACCEPTED.to_owned(),
                CommandOutcome::Refused(reason) => {
                    legible(&audit_texts::refused_because(reason), CONFIG.max_chars)
                }
            };
            state.push(entry);
        }
        self.ask();
    }

    /// Asks the ledger's thread to write, unless it was asked already. If its queue is full, the next entry asks again.
    fn ask(&self) {
        if std::mem::replace(&mut lock(&self.state).is_asked, true) {
            return;
        }
        let state = Arc::clone(&self.state);
        let write = move |writer: &LedgerWriter<'_>, at: Stamp| {
            let entries = {
                let mut state = lock(&state);
                state.is_asked = false;
                std::mem::take(&mut state.ready)
            };
            let written = entries.iter().try_for_each(|entry| writer.put_audit_entry(entry, at));
            if written.is_err() {
                // The transaction is undone. They are written with the next entry.
                lock(&state).ready.splice(..0, entries);
            }
            written
        };
        if !(self.submit)(Box::new(write)) {
            lock(&self.state).is_asked = false;
        }
    }
}

#[cfg(test)]
#[path = "audit_tests.rs"]
mod tests;
