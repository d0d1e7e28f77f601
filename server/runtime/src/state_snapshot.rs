//! The latest state of every kind, for a gateway that connects.

use api::access::AccessState;
use api::{
    Event, GraphChanged, LoopDecision, LoopsChanged, MAX_LOOP_DECISIONS, SiteState, StoredResult, TileEntry,
};
use std::collections::VecDeque;
use std::mem::discriminant;
use std::sync::Arc;

/// The latest of everything.
#[derive(Default)]
pub struct StateSnapshot {
    /// One of each kind that replaces the last of its kind.
    latest: Vec<Event>,
    notices: VecDeque<Event>,
    results: VecDeque<Event>,
    /// Tiles of the map that is shown. They are never queued: each connection reads them from here, see [`crate::gateway_queue`].
    pub tiles: Tiles,
    loops: VecDeque<LoopDecision>,
    /// The site; none while it could not be read. It is sent in parts, see [`crate::gateway_queue`].
    pub site: Option<Arc<SiteState>>,
    /// Who may use the platform; none until accounts were read.
    pub access: Option<AccessState>,
}

/// The tiles of a map, in the order in which they came.
#[derive(Default)]
pub struct Tiles {
    /// Counts resets.
    pub epoch: u64,
    pub entries: Vec<TileEntry>,
}

impl StateSnapshot {
    /// Takes an event in. Returns false for changes that do not apply to the graph or the site; the snapshot is unchanged then.
    pub fn keep(&mut self, event: &Event) -> bool {
        match event {
            Event::CommandDone { .. } | Event::EditDone(_) | Event::SitePart(_) => {}
            Event::SiteChanged(changed) => {
                return self.site.as_mut().is_some_and(|site| Arc::make_mut(site).apply(changed));
            }
            Event::Notice(_) => {
                if self.notices.len() == api::Notice::MAX_KEPT {
                    self.notices.pop_front();
                }
                self.notices.push_back(event.clone());
            }
            Event::ResultStored(result) => {
                // One that was compared since takes the place of what was sent.
                self.results.retain(
                    |known| !matches!(known, Event::ResultStored(known) if known.number == result.number),
                );
                if self.results.len() == StoredResult::MAX_KEPT {
                    self.results.pop_front();
                }
                self.results.push_back(event.clone());
            }
            Event::GraphChanged(changed) => return self.change_graph(changed),
            Event::Tiles(changed) => {
                if changed.reset {
                    self.tiles.epoch += 1;
                    self.tiles.entries.clear();
                }
                self.tiles.entries.extend(&changed.added);
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

    fn change_graph(&mut self, changed: &GraphChanged) -> bool {
        self.latest.iter_mut().any(|kept| match kept {
            Event::Graph(graph) => graph.apply(changed),
            _ => false,
        })
    }

    /// The whole graph.
    pub fn graph(&self) -> Option<&Event> {
        self.latest.iter().find(|event| matches!(event, Event::Graph(_)))
    }

    /// Everything but the tiles and the site.
    pub fn events(&self) -> impl Iterator<Item = Event> {
        let added = self.loops.iter().cloned().collect();
        let loops = Event::Loops(LoopsChanged { reset: true, added });
        let added = self.notices.iter().chain(&self.results).cloned();
        self.latest.iter().cloned().chain([loops]).chain(added)
    }
}
