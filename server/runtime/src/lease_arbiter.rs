//! Who gets the control lease from somebody who has it. The stack gives it to whoever asks; here the holder is asked first.
//!
//! The holder can refuse within [`LeaseConfig::refusal_time`]. An admin is not refused, and a holder without a connection is not asked. A lease whose holder has had no
//! connection for [`LeaseConfig::silence`] is given back. The stack is told the outcome only, as a command, so that the log needs nothing more for a replay.

use crate::state_publisher::StatePublisher;
use crate::texts;
use api::{Caller, ControlRequest, CoreMessage, Event, Notice, Role, Severity};
use messages::{Command, CommandKind, ControlState, Principal};
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use uuid::Uuid;
use vocab::{ClientId, CommandId, Stamp};

/// Parameters of the [`LeaseArbiter`].
#[derive(Clone, Copy, Debug)]
pub struct LeaseConfig {
    /// Time in which the holder can refuse to give the lease away: long enough to press a button, short enough for somebody who has to act.
    pub refusal_time: Duration,
    /// Time after a refusal in which the same client does not ask again. Chosen: twice [`Self::refusal_time`], so that nobody is asked all the time.
    pub pause: Duration,
    /// Time without a connection after which a lease is given back. A page that is loaded again, and a tablet that changes its access point, take less. Chosen: three
    /// times [`Self::refusal_time`].
    pub silence: Duration,
}

impl Default for LeaseConfig {
    fn default() -> Self {
        Self {
            refusal_time: Duration::from_secs(5),
            pause: Duration::from_secs(10),
            silence: Duration::from_secs(15),
        }
    }
}

/// Decides on take-overs.
pub struct LeaseArbiter {
    config: LeaseConfig,
    state_publisher: Arc<StatePublisher>,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    lease: ControlState,
    /// Clients that are connected; none: the gateway has not said yet.
    clients: Option<BTreeSet<ClientId>>,
    /// Since when the holder has no connection.
    holder_gone: Option<Instant>,
    request: Option<Request>,
    refused: Option<(ClientId, Instant)>,
}

/// Somebody asks for the lease.
#[derive(Debug)]
struct Request {
    by: Principal,
    caller: Caller,
    name: String,
    until: Instant,
}

/// What becomes of somebody who wants the lease.
#[derive(Debug, PartialEq)]
pub enum LeaseDecision {
    /// The stack gives it.
    Grant(Command),
    /// The holder is asked.
    Asked,
    /// One sentence: why not.
    Refused(String),
}

/// A command of the arbiter's own, for the stack.
#[derive(Debug, PartialEq)]
pub struct DueCommand {
    /// The command.
    pub command: Command,
    /// Who asked for it; none: the holder was silent.
    pub caller: Option<Caller>,
}

impl LeaseArbiter {
    /// Nobody has the lease.
    pub fn new(config: LeaseConfig, state_publisher: Arc<StatePublisher>) -> Self {
        Self { config, state_publisher, state: Mutex::default() }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The stack says who has the lease.
    pub fn set_lease(&self, lease: ControlState, now: Instant) {
        let mut state = self.lock();
        if lease.owner != state.lease.owner {
            // Somebody who asks a holder who is gone gets a free lease. A new holder is not asked for another one's sake.
            if lease.owner.is_some() {
                state.request = None;
            }
            state.refused = None;
        }
        state.lease = lease;
        state.find_holder(now);
        self.publish(&state, now);
    }

    /// The gateway says which clients are connected.
    pub fn set_clients(&self, clients: impl IntoIterator<Item = ClientId>, now: Instant) {
        let mut state = self.lock();
        state.clients = Some(clients.into_iter().collect());
        state.find_holder(now);
    }

    /// Somebody wants the lease, under this name.
    pub fn request(&self, command: Command, name: String, caller: Caller, now: Instant) -> LeaseDecision {
        let mut state = self.lock();
        let client = command.by.client;
        let is_own = state.lease.owner.is_none_or(|owner| owner == client);
        if is_own || command.by.role == Role::Admin || state.holder_gone.is_some() {
            return LeaseDecision::Grant(command);
        }
        if let Some((_, until)) = state.refused.filter(|(refused, until)| *refused == client && now < *until)
        {
            let wait = until.saturating_duration_since(now);
            return LeaseDecision::Refused(texts::take_over_refused_lately(&state.lease.name, wait));
        }
        match &state.request {
            Some(request) if request.by.client == client => LeaseDecision::Asked,
            Some(request) => LeaseDecision::Refused(texts::another_takes_over(&request.name)),
            None => {
                let until = now + self.config.refusal_time;
                state.request = Some(Request { by: command.by, caller, name, until });
                self.publish(&state, now);
                LeaseDecision::Asked
            }
        }
    }

    /// The holder keeps the lease. Whoever asked for it is told.
    ///
    /// # Errors
    /// When nobody asks, or somebody else is the holder; one sentence.
    pub fn refuse(&self, by: &Principal, at: Stamp, now: Instant) -> Result<(), String> {
        let mut state = self.lock();
        if state.lease.owner != Some(by.client) {
            return Err(texts::ONLY_THE_HOLDER_REFUSES.to_owned());
        }
        let Some(request) = state.request.take() else { return Err(texts::NOBODY_TAKES_OVER.to_owned()) };
        state.refused = Some((request.by.client, now + self.config.pause));
        self.publish(&state, now);
        let text = texts::take_over_refused(&state.lease.name);
        drop(state);
        let event = Event::Notice(Notice { at, severity: Severity::Warning, text });
        self.state_publisher.push(CoreMessage::Event { to: Some(request.by.client), event });
        Ok(())
    }

    /// Commands for the stack that are due: a take-over that was not refused, and a lease whose holder is silent.
    pub fn due(&self, at: Stamp, now: Instant) -> Option<DueCommand> {
        let mut state = self.lock();
        let is_due = |request: &mut Request| now >= request.until;
        let is_free = state.lease.owner.is_none() || state.holder_gone.is_some();
        let taken = if is_free { state.request.take() } else { state.request.take_if(is_due) };
        if let Some(Request { by, caller, name, .. }) = taken {
            self.publish(&state, now);
            let command = Command { id: new_id(), by, kind: CommandKind::TakeControl { name } };
            return Some(DueCommand { command, caller: Some(caller) });
        }
        let owner = state.lease.owner?;
        if now.saturating_duration_since(state.holder_gone?) < self.config.silence {
            return None;
        }
        // The stack answers before this is due again, unless it refuses; then it is tried again.
        state.holder_gone = Some(now);
        let text = texts::lease_expired(&state.lease.name);
        drop(state);
        let event = Event::Notice(Notice { at, severity: Severity::Info, text });
        self.state_publisher.push(CoreMessage::Event { to: None, event });
        let by = Principal::operator(owner);
        Some(DueCommand {
            command: Command { id: new_id(), by, kind: CommandKind::ReleaseControl },
            caller: None,
        })
    }

    fn publish(&self, state: &State, now: Instant) {
        let request = state.request.as_ref().map(|request| ControlRequest {
            by: request.by.client,
            name: request.name.clone(),
            seconds_left: request.until.saturating_duration_since(now).as_secs_f32(),
        });
        let ControlState { owner, name } = state.lease.clone();
        self.state_publisher.publish(Event::Control(api::Control { owner, name, request }));
    }
}

impl State {
    /// Notes since when the holder is gone.
    fn find_holder(&mut self, now: Instant) {
        let is_gone = match (self.lease.owner, &self.clients) {
            (Some(owner), Some(clients)) => !clients.contains(&owner),
            _ => false,
        };
        self.holder_gone = is_gone.then(|| self.holder_gone.unwrap_or(now));
    }
}

/// Ids are made here, outside of the stack, like those of clients.
fn new_id() -> CommandId {
    CommandId(Uuid::new_v4())
}

#[cfg(test)]
#[path = "lease_arbiter_tests.rs"]
mod tests;
