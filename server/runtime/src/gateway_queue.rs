//! The messages that wait for one gateway.
//!
//! | what | policy |
//! | --- | --- |
//! | state of which only the newest counts, live scans | the newer replaces the older |
//! | the graph | one whole graph or one change of it; further changes are merged into it; what is too long goes out in parts |
//! | the site | its parts, then its changes; beyond [`QueueConfig::max_site_changes`] or [`QueueConfig::max_site_bytes`] the whole site takes their place |
//! | decisions on loops | merged; the oldest are dropped beyond [`MAX_LOOP_DECISIONS`] |
//! | tiles | not queued: read from the snapshot, [`MAX_TILES_PER_EVENT`] at a time, in turn with the rest |
//! | answers, notices | they add up; beyond a limit the gateway is stuck and its connection is dropped |

use crate::state_snapshot::{StateSnapshot, Tiles};
use api::{
    CoreMessage, Event, Graph, GraphChanged, LoopsChanged, MAX_LOOP_DECISIONS, MAX_TILES_PER_EVENT,
    SiteChanged, SiteParts, TilesChanged,
};
use std::collections::VecDeque;
use std::mem::{Discriminant, discriminant};

/// Bounds on what waits of the site.
#[derive(Clone, Copy, Debug)]
struct QueueConfig {
    /// Changes that may wait: some seconds of many clients. Chosen: with more, the gateway is sent the whole site.
    max_site_changes: usize,
    /// Bytes that they may take. Chosen: two of the longest edits.
    max_site_bytes: usize,
}

const CONFIG: QueueConfig = QueueConfig { max_site_changes: 1_000, max_site_bytes: 8 << 20 };

/// The queue of one connection.
pub struct GatewayQueue {
    /// Number of the connection.
    pub connection: u64,
    waiting: VecDeque<CoreMessage>,
    /// A whole graph of which the next part goes out before anything else.
    graph_parts: Option<(Box<Graph>, u32)>,
    /// The whole site, of which the next part goes out before anything else but the hello.
    site_parts: Option<SiteParts>,
    /// Number and bytes of the changes of the site that wait.
    site_changes: usize,
    site_bytes: usize,
    is_greeted: bool,
    /// Epoch of the tiles that were sent; `None` before the first.
    tiles_epoch: Option<u64>,
    tiles_sent: usize,
    /// Messages of the snapshot that go before the tiles: tiles refer to keyframes of the graph.
    before_tiles: usize,
    /// Whether tiles go before what waits.
    is_turn_of_tiles: bool,
}

impl GatewayQueue {
    /// The hello and the whole snapshot.
    pub fn new(connection: u64, snapshot: &StateSnapshot) -> Self {
        let hello = CoreMessage::Hello { version: api::VERSION };
        let events = snapshot.events().map(|event| CoreMessage::Event { to: None, event });
        // First, so that nobody is refused who may come in.
        let access = snapshot.access.clone().map(CoreMessage::Access);
        let waiting: VecDeque<_> = [hello].into_iter().chain(access).chain(events).collect();
        Self {
            connection,
            before_tiles: waiting.len(),
            waiting,
            graph_parts: None,
            site_parts: snapshot.site.clone().map(SiteParts::new),
            site_changes: 0,
            site_bytes: 0,
            is_greeted: false,
            tiles_epoch: None,
            tiles_sent: 0,
            is_turn_of_tiles: false,
        }
    }

    /// Messages that wait, without parts of a graph and tiles.
    pub fn len(&self) -> usize {
        self.waiting.len()
    }

    /// Adds a message.
    pub fn push(&mut self, message: CoreMessage, snapshot: &StateSnapshot) {
        match message {
            CoreMessage::Event { to: None, event } => self.push_event(event, snapshot),
            message => self.replace_or_append(message),
        }
    }

    fn push_event(&mut self, event: Event, snapshot: &StateSnapshot) {
        match event {
            // [`Self::next`] reads them from the snapshot.
            Event::Tiles(_) => {}
            Event::GraphChanged(changed) => self.push_graph_changes(changed, snapshot),
            Event::Graph(_) => {
                self.drop_graph();
                self.waiting.push_back(CoreMessage::Event { to: None, event });
            }
            Event::Loops(changed) => self.push_loops(changed),
            Event::SiteChanged(changed) => self.push_site_change(changed, snapshot),
            event => self.replace_or_append(CoreMessage::Event { to: None, event }),
        }
    }

    fn replace_or_append(&mut self, message: CoreMessage) {
        let kind = replaced_kind(&message);
        match self.waiting.iter_mut().find(|waiting| kind.is_some() && replaced_kind(waiting) == kind) {
            Some(waiting) => *waiting = message,
            None => self.waiting.push_back(message),
        }
    }

    fn push_loops(&mut self, changed: LoopsChanged) {
        let waiting = self.waiting.iter_mut().find_map(|waiting| match waiting {
            CoreMessage::Event { event: Event::Loops(loops), .. } => Some(loops),
            _ => None,
        });
        match waiting {
            Some(waiting) if !changed.reset => {
                waiting.added.extend(changed.added);
                keep_newest_loops(waiting);
            }
            Some(waiting) => *waiting = changed,
            None => {
                let mut changed = changed;
                keep_newest_loops(&mut changed);
                self.waiting.push_back(CoreMessage::Event { to: None, event: Event::Loops(changed) });
            }
        }
    }

    /// Merges changes of the graph with what waits of it, so that one message at most does.
    fn push_graph_changes(&mut self, changed: GraphChanged, snapshot: &StateSnapshot) {
        if changed.is_too_long() {
            return self.push_whole_graph(snapshot);
        }
        let merged = self.waiting.iter_mut().find_map(|waiting| match waiting {
            CoreMessage::Event { event: Event::Graph(graph), .. } => Some(graph.apply(&changed)),
            CoreMessage::Event { event: Event::GraphChanged(before), .. } => {
                Some(before.append(&changed) && !before.is_too_long())
            }
            _ => None,
        });
        match merged {
            Some(true) => {}
            Some(false) => self.push_whole_graph(snapshot),
            None => {
                let event = Event::GraphChanged(changed);
                self.waiting.push_back(CoreMessage::Event { to: None, event });
            }
        }
    }

    /// The whole graph takes the place of what waits of it.
    pub fn push_whole_graph(&mut self, snapshot: &StateSnapshot) {
        if let Some(event) = snapshot.graph() {
            self.drop_graph();
            self.waiting.push_back(CoreMessage::Event { to: None, event: event.clone() });
        }
    }

    fn push_site_change(&mut self, changed: SiteChanged, snapshot: &StateSnapshot) {
        self.site_changes += 1;
        self.site_bytes += api::encoded_bytes(&changed);
        if self.site_changes > CONFIG.max_site_changes || self.site_bytes > CONFIG.max_site_bytes {
            return self.push_whole_site(snapshot);
        }
        self.waiting.push_back(CoreMessage::Event { to: None, event: Event::SiteChanged(changed) });
    }

    /// The whole site takes the place of what waits of it.
    pub fn push_whole_site(&mut self, snapshot: &StateSnapshot) {
        let Some(site) = snapshot.site.clone() else { return };
        self.waiting.retain(|waiting| {
            !matches!(waiting, CoreMessage::Event { to: None, event: Event::SiteChanged(_) })
        });
        (self.site_changes, self.site_bytes) = (0, 0);
        self.site_parts = Some(SiteParts::new(site));
    }

    fn next_site_part(&mut self) -> Option<CoreMessage> {
        let part = self.site_parts.as_mut().filter(|_| self.is_greeted)?.next_part();
        if part.is_last {
            self.site_parts = None;
        }
        Some(CoreMessage::Event { to: None, event: Event::SitePart(part) })
    }

    fn drop_graph(&mut self) {
        self.graph_parts = None;
        self.waiting.retain(|waiting| {
            !matches!(waiting, CoreMessage::Event { event: Event::Graph(_) | Event::GraphChanged(_), .. })
        });
    }

    /// The next message to send.
    pub fn next(&mut self, snapshot: &StateSnapshot) -> Option<CoreMessage> {
        if let Some(part) = self.next_graph_part().or_else(|| self.next_site_part()) {
            return Some(part);
        }
        if (self.is_turn_of_tiles || self.waiting.is_empty())
            && let Some(tiles) = self.next_tiles(&snapshot.tiles)
        {
            self.is_turn_of_tiles = false;
            return Some(tiles);
        }
        self.before_tiles = self.before_tiles.saturating_sub(1);
        self.is_turn_of_tiles = self.before_tiles == 0;
        self.is_greeted = true;
        match self.waiting.pop_front()? {
            CoreMessage::Event { to: None, event: Event::SiteChanged(changed) } => {
                self.site_changes -= 1;
                self.site_bytes -= api::encoded_bytes(&changed);
                Some(CoreMessage::Event { to: None, event: Event::SiteChanged(changed) })
            }
            CoreMessage::Event { to: None, event: Event::Graph(graph) } if graph.part_count() > 1 => {
                self.graph_parts = Some((Box::new(graph), 0));
                self.next_graph_part()
            }
            message => Some(message),
        }
    }

    fn next_graph_part(&mut self) -> Option<CoreMessage> {
        let (graph, index) = self.graph_parts.as_mut()?;
        let part = graph.part(*index);
        *index += 1;
        if part.is_last {
            self.graph_parts = None;
        }
        Some(CoreMessage::Event { to: None, event: Event::GraphPart(part) })
    }

    fn next_tiles(&mut self, tiles: &Tiles) -> Option<CoreMessage> {
        let reset = self.tiles_epoch != Some(tiles.epoch);
        if reset {
            self.tiles_epoch = Some(tiles.epoch);
            self.tiles_sent = 0;
        } else if self.tiles_sent == tiles.entries.len() {
            return None;
        }
        let added: Vec<_> =
            tiles.entries.iter().skip(self.tiles_sent).take(MAX_TILES_PER_EVENT).copied().collect();
        self.tiles_sent += added.len();
        Some(CoreMessage::Event { to: None, event: Event::Tiles(TilesChanged { reset, added }) })
    }
}

fn keep_newest_loops(changed: &mut LoopsChanged) {
    changed.added.drain(..changed.added.len().saturating_sub(MAX_LOOP_DECISIONS));
}

/// What a message replaces when it is still waiting; none if it adds to those before.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Scan,
    Access,
    Event(Discriminant<Event>),
}

fn replaced_kind(message: &CoreMessage) -> Option<Kind> {
    match message {
        CoreMessage::Scan { .. } => Some(Kind::Scan),
        CoreMessage::Access(_) => Some(Kind::Access),
        CoreMessage::Event { to: None, event: Event::Notice(_) | Event::ResultStored(_) } => None,
        CoreMessage::Event { to: None, event } => Some(Kind::Event(discriminant(event))),
        CoreMessage::Event { .. }
        | CoreMessage::Hello { .. }
        | CoreMessage::Reply { .. }
        | CoreMessage::AccountReply { .. } => None,
    }
}
