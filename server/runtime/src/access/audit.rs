//! The audit log of commands: who asked for what from where, and what became of it. Entries are written by the ledger's thread, many in one transaction; nothing waits for
//! them.

use super::audit_texts;
use api::{Caller, Command, CommandOutcome};
use messages::Principal;
use std::collections::{BTreeMap, VecDeque};
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
}

const CONFIG: CommandAuditConfig = CommandAuditConfig {
    max_waiting: 512,
    max_chars: 300,
    driving_period: Duration::from_secs(60),
    max_driving: 256,
};

/// What writes entries in a transaction of the ledger.
pub type AuditWrite = Box<dyn FnMut(&LedgerWriter<'_>, Stamp) -> Result<(), StoreError> + Send>;

/// Collects entries.
pub struct CommandAudit {
    /// Hands something to the ledger's thread. Returns whether there was room for it.
    submit: Box<dyn Fn(AuditWrite) -> bool + Send + Sync>,
    state: Arc<Mutex<State>>,
}

#[derive(Debug, Default)]
struct State {
    /// Without an outcome.
    waiting: VecDeque<(CommandId, AuditEntry)>,
    /// To be written.
    ready: Vec<AuditEntry>,
    /// Whether the ledger's thread was asked to write what is ready.
    is_asked: bool,
    driving: BTreeMap<ClientId, Instant>,
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
        if matches!(command, Command::Teleoperate(_)) {
            let now = Instant::now();
            let is_new = |noted: &Instant| now.saturating_duration_since(*noted) >= CONFIG.driving_period;
            if !state.driving.get(&by.client).is_none_or(is_new) {
                return;
            }
            if state.driving.len() >= CONFIG.max_driving {
                state.driving.clear();
            }
            state.driving.insert(by.client, now);
        }
        if state.waiting.len() >= CONFIG.max_waiting
            && let Some((_, mut oldest)) = state.waiting.pop_front()
        {
            oldest.outcome = audit_texts::NOT_ANSWERED.to_owned();
            state.ready.push(oldest);
        }
        let command = legible(&format!("{command:?}"), CONFIG.max_chars);
        let outcome = String::new();
        state
            .waiting
            .push_back((id, AuditEntry { by: Some(by.clone()), address: caller.address, command, outcome }));
    }

    /// A command of somebody who may not give it was refused.
    pub fn refuse(&self, by: Option<Principal>, caller: &Caller, command: &str, reason: &str) {
        let command = legible(command, CONFIG.max_chars);
        let outcome = legible(&audit_texts::refused_because(reason), CONFIG.max_chars);
        lock(&self.state).ready.push(AuditEntry { by, address: caller.address, command, outcome });
        self.ask();
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
            state.ready.push(entry);
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
