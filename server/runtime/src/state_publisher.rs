//! The latest state for clients, and the queue of messages to the gateway.
//!
//! The queue to the gateway is bounded by what it holds, not by how fast the gateway is: of every kind of event that
//! replaces the last of its kind only the newest waits, and so does only the newest scan. Answers, notices, loops and tiles
//! add up; when more than [`StatePublisherConfig::max_queued_messages`] wait, the gateway is stuck and the connection is dropped. It connects again and
//! gets a snapshot.
//!
//! Changes of the pose graph are published only if they apply to the published graph exactly. So the messages that wait for the gateway lead
//! from the graph that it has to the published one.

use api::{
    CommandOutcome, CoreMessage, Event, GraphChanged, LoopDecision, LoopsChanged, MAX_LOOP_DECISIONS,
    TilesChanged,
};
use std::collections::VecDeque;
use std::mem::{Discriminant, discriminant};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use vocab::{ClientId, CommandId};

/// Parameters of a [`StatePublisher`].
#[derive(Clone, Copy, Debug)]
struct StatePublisherConfig {
    /// Messages that may wait for the gateway. With more, its connection is dropped.
    max_queued_messages: usize,
}

const CONFIG: StatePublisherConfig = StatePublisherConfig { max_queued_messages: 2_000 };

/// Shared by the threads that publish state and the thread that writes to the gateway.
#[derive(Default)]
pub struct StatePublisher {
    state: Mutex<State>,
    changed: Condvar,
    streams: AtomicU32,
}

#[derive(Default)]
struct State {
    snapshot: Snapshot,
    /// Which connection the queue belongs to; none while no gateway is connected.
    connection: Option<u64>,
    connections: u64,
    queue: VecDeque<CoreMessage>,
}

/// The latest of everything.
#[derive(Default)]
struct Snapshot {
    /// One of each kind that replaces the last of its kind.
    latest: Vec<Event>,
    notices: VecDeque<Event>,
    tiles: Vec<api::TileEntry>,
    loops: VecDeque<LoopDecision>,
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
        if state.connection.is_some() {
            state.enqueue(CoreMessage::Event { to: None, event });
            self.changed.notify_all();
        }
        true
    }

    /// Sends the whole graph to the gateway, which has lost changes. The queue holds one whole graph at most, however often this is asked.
    pub fn resend_graph(&self) {
        let mut state = self.lock();
        if state.connection.is_some() {
            state.enqueue_whole_graph();
            self.changed.notify_all();
        }
    }

    /// Answers a command, to its maker only.
    pub fn answer(&self, id: CommandId, to: ClientId, refused: Option<String>) {
        let outcome = refused.map_or(CommandOutcome::Accepted, CommandOutcome::Refused);
        self.push(CoreMessage::Event { to: Some(to), event: Event::CommandDone { id, outcome } });
    }

    /// Sends a message that belongs to no snapshot, if a gateway is connected.
    pub fn push(&self, message: CoreMessage) {
        let mut state = self.lock();
        if state.connection.is_some() {
            state.enqueue(message);
            self.changed.notify_all();
        }
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
        state.connection = Some(connection);
        state.queue = state.snapshot.messages().collect();
        state.queue.push_front(CoreMessage::Hello { version: api::VERSION });
        self.set_streams(0);
        self.changed.notify_all();
        connection
    }

    /// That gateway has gone.
    pub fn disconnect(&self, connection: u64) {
        let mut state = self.lock();
        if state.connection == Some(connection) {
            state.connection = None;
            state.queue = VecDeque::new();
            self.set_streams(0);
        }
        self.changed.notify_all();
    }

    /// Waits for the next message to this connection; none when it has been replaced or dropped.
    pub fn next(&self, connection: u64) -> Option<CoreMessage> {
        let mut state = self.lock();
        loop {
            if state.connection != Some(connection) {
                return None;
            }
            if let Some(message) = state.queue.pop_front() {
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

impl State {
    fn enqueue(&mut self, message: CoreMessage) {
        match message {
            CoreMessage::Event { to: None, event: Event::GraphChanged(changed) } => {
                self.enqueue_graph_changes(changed);
            }
            CoreMessage::Event { to: None, event: Event::Graph(_) } => {
                self.queue.retain(|waiting| !is_of_graph(waiting));
                self.queue.push_back(message);
            }
            message => {
                let kind = replaced_kind(&message);
                let waiting =
                    self.queue.iter_mut().find(|waiting| kind.is_some() && replaced_kind(waiting) == kind);
                match waiting {
                    Some(waiting) => *waiting = message,
                    None => self.queue.push_back(message),
                }
            }
        }
        self.limit_queue();
    }

    /// Merges changes of the graph with what waits of it, so that one message at most does.
    fn enqueue_graph_changes(&mut self, changed: GraphChanged) {
        let merged = self.queue.iter_mut().find_map(|waiting| match waiting {
            CoreMessage::Event { event: Event::Graph(graph), .. } => Some(graph.apply(&changed)),
            CoreMessage::Event { event: Event::GraphChanged(before), .. } => Some(before.append(&changed)),
            _ => None,
        });
        match merged {
            Some(true) => {}
            Some(false) => self.enqueue_whole_graph(),
            None => {
                let event = Event::GraphChanged(changed);
                self.queue.push_back(CoreMessage::Event { to: None, event });
            }
        }
    }

    /// The whole graph takes the place of what waits of it.
    fn enqueue_whole_graph(&mut self) {
        if let Some(event) = self.snapshot.latest.iter().find(|event| matches!(event, Event::Graph(_))) {
            self.queue.retain(|waiting| !is_of_graph(waiting));
            self.queue.push_back(CoreMessage::Event { to: None, event: event.clone() });
        }
    }

    fn limit_queue(&mut self) {
        if self.queue.len() > CONFIG.max_queued_messages {
            tracing::warn!("the gateway does not read; its connection is dropped");
            self.connection = None;
            self.queue = VecDeque::new();
        }
    }
}

fn is_of_graph(message: &CoreMessage) -> bool {
    matches!(message, CoreMessage::Event { event: Event::Graph(_) | Event::GraphChanged(_), .. })
}

/// What a message replaces when it is still waiting; none if it adds to those before.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Scan,
    Event(Discriminant<Event>),
}

fn replaced_kind(message: &CoreMessage) -> Option<Kind> {
    match message {
        CoreMessage::Scan { .. } => Some(Kind::Scan),
        CoreMessage::Event { to: None, event } if replaces(event) => Some(Kind::Event(discriminant(event))),
        CoreMessage::Event { .. } | CoreMessage::Hello { .. } => None,
    }
}

fn replaces(event: &Event) -> bool {
    !matches!(
        event,
        Event::GraphChanged(_)
            | Event::Tiles(_)
            | Event::Loops(_)
            | Event::Notice(_)
            | Event::CommandDone { .. }
    )
}

impl Snapshot {
    /// Takes an event in. Returns false for changes that do not apply to the graph; the snapshot is unchanged then.
    fn keep(&mut self, event: &Event) -> bool {
        match event {
            Event::CommandDone { .. } => {}
            Event::Notice(_) => {
                if self.notices.len() == api::Notice::MAX_KEPT {
                    self.notices.pop_front();
                }
                self.notices.push_back(event.clone());
            }
            Event::GraphChanged(changed) => {
                return self.latest.iter_mut().any(|kept| match kept {
                    Event::Graph(graph) => graph.apply(changed),
                    _ => false,
                });
            }
            Event::Tiles(changed) => {
                if changed.reset {
                    self.tiles.clear();
                }
                self.tiles.extend(&changed.added);
            }
            Event::Loops(changed) => {
                if changed.reset {
                    self.loops.clear();
                }
                self.loops.extend(changed.added.iter().cloned());
                self.loops.drain(..self.loops.len().saturating_sub(MAX_LOOP_DECISIONS));
            }
            _ => match self.latest.iter_mut().find(|kept| discriminant(*kept) == discriminant(event)) {
                Some(kept) => *kept = event.clone(),
                None => self.latest.push(event.clone()),
            },
        }
        true
    }

    fn messages(&self) -> impl Iterator<Item = CoreMessage> {
        let tiles = Event::Tiles(TilesChanged { reset: true, added: self.tiles.clone() });
        let added = self.loops.iter().cloned().collect();
        let loops = Event::Loops(LoopsChanged { reset: true, added });
        let events = self.latest.iter().cloned().chain([loops, tiles]).chain(self.notices.iter().cloned());
        events.map(|event| CoreMessage::Event { to: None, event })
    }
}

#[cfg(test)]
#[path = "state_publisher_tests.rs"]
mod tests;
