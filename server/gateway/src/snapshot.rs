//! The latest state of every kind, and what each client was sent of it.
//!
//! Nothing is queued per client. A [`Cursor`] holds the revision of each kind that its client was sent; newer state is sent next. A client that
//! reads slowly gets fewer and newer values, and needs the memory of one cursor only.

use crate::limits::FIXED;
use crate::snapshot_site::{SiteCursor, SiteFeed};
use api::{
    Event, Graph, GraphAssembly, GraphChanged, LoopDecision, LoopsChanged, MAX_GRAPH_ENTRIES,
    MAX_LOOP_DECISIONS, MAX_TILES_PER_EVENT, Notice, Platform, ProcessRestart, SiteState, StoredResult,
    TileEntry, TilesChanged,
};
use std::collections::VecDeque;
use std::sync::Arc;

const LATEST_KINDS: usize = ACTIONS + 1;
const TILES: usize = LATEST_KINDS;
const NOTICES: usize = LATEST_KINDS + 1;
const LOOPS: usize = LATEST_KINDS + 2;
const SITE: usize = LATEST_KINDS + 3;
const RESULTS: usize = LATEST_KINDS + 4;
const SOURCES: usize = LATEST_KINDS + 5;

/// The state that a client gets when it connects.
pub(crate) struct Snapshot {
    /// Counts changes; a kind's revision is that of its last change.
    revision: u64,
    latest: [Option<(u64, Arc<Event>)>; LATEST_KINDS],
    /// The last changes of the graph, each with its revision and its number of keyframes. They apply to the graph of `graph_changes_from` and later.
    graph_changes: VecDeque<(u64, usize, Arc<Event>)>,
    /// Sum of those numbers, [`MAX_GRAPH_ENTRIES`] at most: beyond that the whole graph is sent as fast.
    changed_nodes: usize,
    graph_changes_from: u64,
    /// Parts of a long graph that have come.
    graph_parts: GraphAssembly,
    /// Whether changes came that do not apply to the graph. It stays as it was until the whole graph comes.
    is_graph_stale: bool,
    tiles: Tiles,
    loops: Loops,
    site: SiteFeed,
    notices: VecDeque<(u64, Notice)>,
    /// The newest results of runs, in the order of their numbers.
    results: VecDeque<(u64, StoredResult)>,
    platform: Platform,
    /// Why this process was started again, if it was.
    restart: Option<ProcessRestart>,
}

#[derive(Default)]
struct Tiles {
    /// Counts resets; 0 while tiles were never mentioned.
    epoch: u64,
    revision: u64,
    entries: Vec<TileEntry>,
}

/// The last decisions on loops.
#[derive(Default)]
struct Loops {
    /// Counts resets; 0 while loops were never mentioned.
    epoch: u64,
    revision: u64,
    /// Decisions of this epoch that are not kept any more.
    gone: usize,
    kept: VecDeque<LoopDecision>,
}

/// What one client was sent.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cursor {
    /// Revision last sent, by source.
    seen: [u64; SOURCES],
    /// Turn in which a source was last served: the one that waited longest goes first.
    served: [u64; SOURCES],
    turn: u64,
    tiles_epoch: u64,
    tiles_sent: usize,
    loops_epoch: u64,
    /// Of the epoch, those included that are gone.
    loops_sent: usize,
    /// A long graph that is being sent in parts: its revision here, the graph, and the next part.
    graph_parts: Option<(u64, Arc<Event>, u32)>,
    /// What was sent of the site; `seen` of its source is not used.
    site: SiteCursor,
}

impl Cursor {
    /// The client has lost the graph: the whole graph is owed to it again.
    pub(crate) fn forget_graph(&mut self) {
        self.seen[GRAPH] = 0;
        self.graph_parts = None;
    }

    /// The client has lost the site: the whole site is owed to it again.
    pub(crate) fn forget_site(&mut self) {
        self.site.forget();
    }

    /// The next part of the graph that is being sent. The client knows its revision after the last.
    fn next_graph_part(&mut self) -> Option<Arc<Event>> {
        let (revision, event, index) = self.graph_parts.as_mut()?;
        let Event::Graph(graph) = &**event else { return None };
        let part = graph.part(*index);
        *index += 1;
        if part.is_last {
            self.seen[GRAPH] = *revision;
            self.graph_parts = None;
        }
        Some(Arc::new(Event::GraphPart(part)))
    }
}

impl Snapshot {
    /// Knows nothing but that there is no core.
    pub(crate) fn new(restart: Option<ProcessRestart>) -> Self {
        let mut snapshot = Self {
            revision: 0,
            latest: Default::default(),
            graph_changes: VecDeque::new(),
            changed_nodes: 0,
            graph_changes_from: 0,
            graph_parts: GraphAssembly::default(),
            is_graph_stale: false,
            tiles: Tiles::default(),
            loops: Loops::default(),
            site: SiteFeed::default(),
            notices: VecDeque::new(),
            results: VecDeque::new(),
            platform: Platform { restarts: restart.iter().cloned().collect(), ..Platform::default() },
            restart,
        };
        snapshot.change_platform(|_| ());
        snapshot
    }

    /// Takes in an event for all. [`Event::CommandDone`] is no state and changes nothing.
    pub(crate) fn apply(&mut self, event: Event) {
        match event {
            Event::Graph(graph) => self.set_graph(graph),
            Event::GraphPart(part) => {
                if let Some(graph) = self.graph_parts.add(&part) {
                    self.set_graph(graph);
                }
            }
            Event::GraphChanged(changed) => self.change_graph(changed),
            Event::SitePart(part) => {
                let is_used = self.site.add_part(&part, self.revision + 1);
                self.revision += u64::from(is_used);
            }
            Event::SiteChanged(changed) => {
                let is_used = self.site.change(changed, self.revision + 1);
                self.revision += u64::from(is_used);
            }
            Event::Tiles(change) => self.change_tiles(change),
            Event::Loops(change) => self.change_loops(change),
            Event::Notice(notice) => self.add_notice(notice),
            Event::ResultStored(result) => self.add_result(result),
            Event::Platform(report) => {
                let restarts = report.restarts.iter().chain(&self.restart).cloned().collect();
                self.change_platform(|platform| {
                    // These the gateway knows better than the core.
                    let clients = platform.clients;
                    *platform = Platform { core_connected: true, clients, restarts, ..report };
                });
            }
            event => {
                if let Some(kind) = latest_kind(&event) {
                    self.revision += 1;
                    self.latest[kind] = Some((self.revision, Arc::new(event)));
                }
            }
        }
    }

    /// Changes the report on the server itself.
    pub(crate) fn change_platform(&mut self, change: impl FnOnce(&mut Platform)) {
        change(&mut self.platform);
        let event = Event::Platform(self.platform.clone());
        if let Some(kind) = latest_kind(&event) {
            self.revision += 1;
            self.latest[kind] = Some((self.revision, Arc::new(event)));
        }
    }

    /// Processes that failed and run again.
    pub(crate) fn restarts(&self) -> Vec<ProcessRestart> {
        self.platform.restarts.clone()
    }

    /// Forgets tiles, because a core that (re)connects sends all of its own.
    pub(crate) fn forget_tiles(&mut self) {
        if self.tiles.epoch > 0 {
            self.change_tiles(TilesChanged { reset: true, added: Vec::new() });
        }
    }

    /// Whether the core has to be asked for the whole graph.
    pub(crate) fn is_graph_stale(&self) -> bool {
        self.is_graph_stale
    }

    /// The site.
    pub(crate) fn site(&self) -> Option<&Arc<SiteState>> {
        self.site.state()
    }

    /// Whether the core has to be asked for the whole site.
    pub(crate) fn is_site_stale(&self) -> bool {
        self.site.is_stale
    }

    /// Last lists of saved maps, of those that cannot be read, of the bin and of uploads, and the last state of the making of a map, of missions and of the route.
    pub(crate) fn stored_data(&self) -> [Option<Arc<Event>>; 7] {
        [MAPS, DAMAGED_MAPS, BINNED_MAPS, UPLOADS, IMPORT, MISSIONS, ROUTE]
            .map(|kind| self.latest[kind].as_ref().map(|(_, event)| event.clone()))
    }

    /// The next event for a client, which then counts as sent; `None` when the client has everything.
    pub(crate) fn next(&self, cursor: &mut Cursor) -> Option<Arc<Event>> {
        let source = (0..SOURCES)
            .filter_map(|source| Some((cursor.served[source], self.owed(source, cursor)?, source)))
            .min()
            .map(|(.., source)| source)?;
        cursor.turn += 1;
        cursor.served[source] = cursor.turn;
        match source {
            TILES => Some(self.next_tiles(cursor)),
            LOOPS => Some(self.next_loops(cursor)),
            NOTICES => self.next_notice(cursor),
            RESULTS => self.next_result(cursor),
            SITE => cursor.site.next(&self.site),
            GRAPH => {
                if cursor.graph_parts.is_none() {
                    let (revision, event) = self.next_graph(cursor.seen[GRAPH])?;
                    if !matches!(&*event, Event::Graph(graph) if graph.part_count() > 1) {
                        cursor.seen[GRAPH] = revision;
                        return Some(event);
                    }
                    cursor.graph_parts = Some((revision, event, 0));
                }
                cursor.next_graph_part()
            }
            kind => {
                let (revision, event) = self.latest[kind].as_ref()?;
                cursor.seen[kind] = *revision;
                Some(event.clone())
            }
        }
    }

    /// Revision of what `source` owes to the client, if anything.
    fn owed(&self, source: usize, cursor: &Cursor) -> Option<u64> {
        match source {
            TILES => {
                let complete =
                    cursor.tiles_epoch == self.tiles.epoch && cursor.tiles_sent == self.tiles.entries.len();
                (!complete).then_some(self.tiles.revision)
            }
            LOOPS => {
                let complete = cursor.loops_epoch == self.loops.epoch
                    && cursor.loops_sent == self.loops.gone + self.loops.kept.len();
                (!complete).then_some(self.loops.revision)
            }
            SITE => self.site.owed(cursor.site.seen),
            NOTICES => self.notices.iter().map(|(revision, _)| *revision).find(|r| *r > cursor.seen[NOTICES]),
            RESULTS => self.results.iter().map(|(revision, _)| *revision).find(|r| *r > cursor.seen[RESULTS]),
            kind => {
                self.latest[kind].as_ref().map(|(revision, _)| *revision).filter(|r| *r > cursor.seen[kind])
            }
        }
    }

    /// The next change of the graph after a revision, or the whole graph if that revision is too old.
    fn next_graph(&self, seen: u64) -> Option<(u64, Arc<Event>)> {
        if seen >= self.graph_changes_from {
            let next = self.graph_changes.iter().find(|(revision, ..)| *revision > seen);
            return next.map(|(revision, _, event)| (*revision, event.clone()));
        }
        self.latest[GRAPH].clone()
    }

    fn set_graph(&mut self, graph: Graph) {
        self.revision += 1;
        self.graph_changes.clear();
        self.changed_nodes = 0;
        self.graph_changes_from = self.revision;
        self.is_graph_stale = false;
        self.latest[GRAPH] = Some((self.revision, Arc::new(Event::Graph(graph))));
    }

    /// Applies changes to the whole graph, and keeps them for clients that know the graph before them. Changes that do not apply are dropped.
    fn change_graph(&mut self, changed: GraphChanged) {
        let known = match &mut self.latest[GRAPH] {
            Some((revision, event)) => match Arc::make_mut(event) {
                Event::Graph(graph) => graph.apply(&changed).then_some(revision),
                _ => None,
            },
            None => None,
        };
        let Some(revision) = known else {
            self.is_graph_stale = true;
            return;
        };
        self.revision += 1;
        *revision = self.revision;
        let entries = changed.nodes.len();
        self.changed_nodes += entries;
        self.graph_changes.push_back((self.revision, entries, Arc::new(Event::GraphChanged(changed))));
        while (self.graph_changes.len() > FIXED.max_graph_changes || self.changed_nodes > MAX_GRAPH_ENTRIES)
            && let Some((dropped, entries, _)) = self.graph_changes.pop_front()
        {
            self.changed_nodes -= entries;
            self.graph_changes_from = dropped;
        }
    }

    fn next_tiles(&self, cursor: &mut Cursor) -> Arc<Event> {
        let reset = cursor.tiles_epoch != self.tiles.epoch;
        if reset {
            cursor.tiles_epoch = self.tiles.epoch;
            cursor.tiles_sent = 0;
        }
        let end = self.tiles.entries.len().min(cursor.tiles_sent + MAX_TILES_PER_EVENT);
        let added = self.tiles.entries[cursor.tiles_sent..end].to_vec();
        cursor.tiles_sent = end;
        Arc::new(Event::Tiles(TilesChanged { reset, added }))
    }

    fn next_loops(&self, cursor: &mut Cursor) -> Arc<Event> {
        let reset = cursor.loops_epoch != self.loops.epoch;
        if reset {
            cursor.loops_epoch = self.loops.epoch;
            cursor.loops_sent = 0;
        }
        let first = cursor.loops_sent.saturating_sub(self.loops.gone);
        let added: Vec<_> =
            self.loops.kept.iter().skip(first).take(FIXED.max_loops_per_event).cloned().collect();
        cursor.loops_sent = self.loops.gone + first + added.len();
        Arc::new(Event::Loops(LoopsChanged { reset, added }))
    }

    fn next_notice(&self, cursor: &mut Cursor) -> Option<Arc<Event>> {
        let (revision, notice) =
            self.notices.iter().find(|(revision, _)| *revision > cursor.seen[NOTICES])?;
        cursor.seen[NOTICES] = *revision;
        Some(Arc::new(Event::Notice(notice.clone())))
    }

    fn next_result(&self, cursor: &mut Cursor) -> Option<Arc<Event>> {
        let (revision, result) =
            self.results.iter().find(|(revision, _)| *revision > cursor.seen[RESULTS])?;
        cursor.seen[RESULTS] = *revision;
        Some(Arc::new(Event::ResultStored(result.clone())))
    }

    fn change_tiles(&mut self, change: TilesChanged) {
        self.revision += 1;
        self.tiles.revision = self.revision;
        if change.reset || self.tiles.epoch == 0 {
            self.tiles.epoch += 1;
            self.tiles.entries.clear();
        }
        self.tiles.entries.extend(change.added);
    }

    fn change_loops(&mut self, change: LoopsChanged) {
        self.revision += 1;
        self.loops.revision = self.revision;
        if change.reset || self.loops.epoch == 0 {
            self.loops = Loops { epoch: self.loops.epoch + 1, revision: self.revision, ..Loops::default() };
        }
        self.loops.kept.extend(change.added);
        let over = self.loops.kept.len().saturating_sub(MAX_LOOP_DECISIONS);
        self.loops.kept.drain(..over);
        self.loops.gone += over;
    }

    fn add_notice(&mut self, notice: Notice) {
        // A core that reconnects repeats its notices; the instant in each distinguishes a repetition from a new one.
        if self.notices.iter().any(|(_, known)| *known == notice) {
            return;
        }
        self.revision += 1;
        self.notices.push_back((self.revision, notice));
        if self.notices.len() > Notice::MAX_KEPT {
            self.notices.pop_front();
        }
    }

    fn add_result(&mut self, result: StoredResult) {
        // A core that reconnects repeats its results.
        if self.results.iter().any(|(_, known)| *known == result) {
            return;
        }
        // One that was compared since takes the place of what was sent.
        self.results.retain(|(_, known)| known.number != result.number);
        self.revision += 1;
        self.results.push_back((self.revision, result));
        if self.results.len() > StoredResult::MAX_KEPT {
            self.results.pop_front();
        }
    }
}

const GRAPH: usize = 1;
const MAPS: usize = 7;
const IMPORT: usize = 11;
const GOALS: usize = 14;
const DAMAGED_MAPS: usize = 15;
const INTERRUPTED_SESSIONS: usize = 16;
const BINNED_MAPS: usize = 17;
const UPLOADS: usize = 18;
const MISSIONS: usize = 19;
const ROUTE: usize = 20;
const TOPOMAP_GENERATION: usize = 21;
/// The last of them.
const ACTIONS: usize = 22;

/// Place of events of which only the last counts.
fn latest_kind(event: &Event) -> Option<usize> {
    match event {
        Event::Estimate(_) => Some(0),
        Event::Graph(_) => Some(GRAPH),
        Event::Mapping(_) => Some(2),
        Event::Motion(_) => Some(3),
        Event::Control(_) => Some(4),
        Event::Health(_) => Some(5),
        Event::Battery(_) => Some(6),
        Event::Maps(_) => Some(MAPS),
        Event::Platform(_) => Some(8),
        Event::Quality(_) => Some(9),
        Event::Localisation(_) => Some(10),
        Event::Import(_) => Some(IMPORT),
        Event::Docks(_) => Some(12),
        Event::Executive(_) => Some(13),
        Event::Goals(_) => Some(GOALS),
        Event::DamagedMaps(_) => Some(DAMAGED_MAPS),
        Event::InterruptedSessions(_) => Some(INTERRUPTED_SESSIONS),
        Event::BinnedMaps(_) => Some(BINNED_MAPS),
        Event::Uploads(_) => Some(UPLOADS),
        Event::Missions(_) => Some(MISSIONS),
        Event::Route(_) => Some(ROUTE),
        Event::TopomapGeneration(_) => Some(TOPOMAP_GENERATION),
        Event::Actions(_) => Some(ACTIONS),
        Event::GraphChanged(_)
        | Event::GraphPart(_)
        | Event::Tiles(_)
        | Event::Loops(_)
        | Event::Notice(_)
        | Event::ResultStored(_)
        | Event::SitePart(_)
        | Event::SiteChanged(_)
        | Event::EditDone(_)
        | Event::CommandDone { .. } => None,
    }
}

#[cfg(test)]
#[path = "snapshot_tests.rs"]
mod tests;
