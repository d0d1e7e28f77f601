//! The latest state for clients, and the queue of messages to the gateway.
//!
//! The queue to the gateway is bounded by what it holds, not by how fast the gateway is, see [`crate::gateway_queue`]. When more than
//! [`StatePublisherConfig::max_queued_messages`] wait, the gateway is stuck and the connection is dropped. It connects again and gets a snapshot.
//!
//! Changes of the pose graph are published only if they apply to the published graph exactly. So the messages that wait for the gateway lead
//! from the graph that it has to the published one.

use crate::access::CommandAudit;
use crate::gateway_queue::GatewayQueue;
use crate::state_snapshot::StateSnapshot;
use api::access::AccessState;
use api::{CommandOutcome, CoreMessage, Event, GraphChanged, SiteChanged, SiteState};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use vocab::{ClientId, CommandId};

/// Parameters of a [`StatePublisher`].
#[derive(Clone, Copy, Debug)]
struct StatePublisherConfig {
    /// Messages that may wait for the gateway. With more, its connection is dropped. Chosen: some seconds of everything that is published; it is sent a snapshot when it
    /// connects again.
    max_queued_messages: usize,
}

const CONFIG: StatePublisherConfig = StatePublisherConfig { max_queued_messages: 2_000 };

/// Shared by the threads that publish state and the thread that writes to the gateway.
#[derive(Default)]
pub struct StatePublisher {
    state: Mutex<State>,
    changed: Condvar,
    streams: AtomicU32,
    /// Notes what became of commands, once a core has begun.
    audit: OnceLock<CommandAudit>,
}

#[derive(Default)]
struct State {
    snapshot: StateSnapshot,
    /// None while no gateway is connected.
    queue: Option<GatewayQueue>,
    connections: u64,
}

impl StatePublisher {
    /// Publishes state to all clients. Changes of the graph go through [`Self::publish_graph_changes`].
    pub fn publish(&self, event: Event) {
        self.try_publish(event);
    }

    /// Publishes changes of the graph. Returns whether they apply to the published graph; they are dropped if not.
    pub fn publish_graph_changes(&self, changed: GraphChanged) -> bool {
        self.try_publish(Event::GraphChanged(changed))
    }

    fn try_publish(&self, event: Event) -> bool {
        let mut state = self.lock();
        if !state.snapshot.keep(&event) {
            return false;
        }
        self.enqueue(&mut state, |queue, snapshot| {
            queue.push(CoreMessage::Event { to: None, event }, snapshot);
        });
        true
    }

    /// Tells the gateway who may use the platform. It goes to no client.
    pub fn publish_access(&self, access: AccessState) {
        let mut state = self.lock();
        state.snapshot.access = Some(access.clone());
        self.enqueue(&mut state, |queue, snapshot| queue.push(CoreMessage::Access(access), snapshot));
    }

    /// Publishes the whole site, unless it is the published one.
    pub fn publish_site(&self, site: &SiteState) {
        let mut state = self.lock();
        if state.snapshot.site.as_deref() != Some(site) {
            state.snapshot.site = Some(Arc::new(site.clone()));
            self.enqueue(&mut state, GatewayQueue::push_whole_site);
        }
    }

    /// Publishes an edit of the site. Returns whether it applies to the published site; it is dropped if not.
    pub fn publish_site_change(&self, changed: SiteChanged) -> bool {
        self.try_publish(Event::SiteChanged(changed))
    }

    /// Sends the whole site to the gateway, which has lost changes.
    pub fn resend_site(&self) {
        self.enqueue(&mut self.lock(), GatewayQueue::push_whole_site);
    }

    /// Sends the whole graph to the gateway, which has lost changes. The queue holds one whole graph at most, however often this is asked.
    pub fn resend_graph(&self) {
        self.enqueue(&mut self.lock(), GatewayQueue::push_whole_graph);
    }

    /// Lets this note what becomes of commands.
    pub fn set_audit(&self, audit: CommandAudit) {
        // There is one core in a process.
        let _ = self.audit.set(audit);
    }

    /// What notes commands.
    pub fn audit(&self) -> Option<&CommandAudit> {
        self.audit.get()
    }

    /// Answers a command, to its maker only.
    pub fn answer(&self, id: CommandId, to: ClientId, refused: Option<String>) {
        let outcome = refused.map_or(CommandOutcome::Accepted, CommandOutcome::Refused);
        if let Some(audit) = self.audit.get() {
            audit.finish(id, &outcome);
        }
        self.push(CoreMessage::Event { to: Some(to), event: Event::CommandDone { id, outcome } });
    }

    /// Sends a message that belongs to no snapshot, if a gateway is connected.
    pub fn push(&self, message: CoreMessage) {
        self.enqueue(&mut self.lock(), |queue, snapshot| queue.push(message, snapshot));
    }

    /// Changes the queue, if a gateway is connected. A queue that is too long is dropped with its connection.
    fn enqueue(&self, state: &mut State, change: impl FnOnce(&mut GatewayQueue, &StateSnapshot)) {
        let State { snapshot, queue: Some(queue), .. } = state else { return };
        change(queue, snapshot);
        if queue.len() > CONFIG.max_queued_messages {
            tracing::warn!("the gateway does not read; its connection is dropped");
            state.queue = None;
        }
        self.changed.notify_all();
    }

    /// Whether anybody wants live scans.
    pub fn wants_scans(&self) -> bool {
        self.streams.load(Ordering::Relaxed) > 0
    }

    /// How many want live scans.
    pub fn set_streams(&self, streams: u32) {
        self.streams.store(streams, Ordering::Relaxed);
    }

    /// A gateway has connected: it takes the place of any other, and a full snapshot waits for it.
    pub fn connect(&self) -> u64 {
        let mut state = self.lock();
        state.connections += 1;
        let connection = state.connections;
        state.queue = Some(GatewayQueue::new(connection, &state.snapshot));
        self.set_streams(0);
        self.changed.notify_all();
        connection
    }

    /// That gateway has gone.
    pub fn disconnect(&self, connection: u64) {
        let mut state = self.lock();
        if state.queue.as_ref().is_some_and(|queue| queue.connection == connection) {
            state.queue = None;
            self.set_streams(0);
        }
        self.changed.notify_all();
    }

    /// Waits for the next message to this connection; none when it has been replaced or dropped.
    pub fn next(&self, connection: u64) -> Option<CoreMessage> {
        let mut state = self.lock();
        loop {
            let State { snapshot, queue, .. } = &mut *state;
            let queue = queue.as_mut().filter(|queue| queue.connection == connection)?;
            if let Some(message) = queue.next(snapshot) {
                return Some(message);
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Plain data behind the lock: a thread that panicked while holding it left nothing half-done that matters.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
#[path = "state_publisher_tests.rs"]
mod tests;
