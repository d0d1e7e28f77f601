//! Makes the topological map of the site from a saved map: the disk lane reads the map, the compute lane finds nodes and edges, and the ledger applies one edit.
//!
//! One is made at a time. The edit is made of the site at the moment when it is applied, so that no edit of a person comes between.

use crate::ledger::{LedgerInbox, SiteWork, refusal_reason};
use crate::state_publisher::StatePublisher;
use crate::texts;
use api::{EditOutcome, Event, MAX_BLOCKED_SEGMENTS, TopomapGeneration, TopomapStage, TopomapSummary};
use messages::{Principal, RobotProfile};
use ports::error_with_causes;
use site_model::{Edit, EditId, Site};
use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use store::{Store, TopomapSource};
use topomap::{GeneratedMap, TopomapConfig};
use vocab::{MapId, Vec3};

/// What a person asks for.
#[derive(Clone, Debug)]
pub struct TopomapRequest {
    /// Who asks.
    pub by: Principal,
    /// The saved map.
    pub map: MapId,
    /// Id of the edit.
    pub edit: EditId,
}

/// A map that was read, on its way to the compute lane.
pub struct TopomapTask {
    request: TopomapRequest,
    source: TopomapSource,
}

/// Makes topological maps. Shared by the threads that take part.
#[derive(Clone)]
pub struct TopomapGenerator {
    shared: Arc<Shared>,
}

struct Shared {
    store: Arc<Store>,
    state_publisher: Arc<StatePublisher>,
    ledger: Arc<LedgerInbox>,
    profile: RobotProfile,
    is_running: AtomicBool,
}

impl TopomapGenerator {
    /// For a robot of this profile.
    pub fn new(
        store: Arc<Store>,
        state_publisher: Arc<StatePublisher>,
        ledger: Arc<LedgerInbox>,
        profile: RobotProfile,
    ) -> Self {
        let is_running = AtomicBool::new(false);
        Self { shared: Arc::new(Shared { store, state_publisher, ledger, profile, is_running }) }
    }

    /// Begins. `start` hands the request to the disk lane.
    ///
    /// # Errors
    /// The reason for the refusal, one sentence for people.
    pub fn begin(
        &self,
        request: TopomapRequest,
        start: impl FnOnce(TopomapRequest) -> Result<(), &'static str>,
    ) -> Result<(), &'static str> {
        if self.shared.is_running.swap(true, Ordering::AcqRel) {
            return Err(texts::TOPOMAP_IS_MADE);
        }
        let map = request.map;
        self.publish(TopomapGeneration::Running { map, stage: TopomapStage::Reading });
        let started = start(request);
        if let Err(reason) = started {
            self.fail(map, reason.to_owned());
        }
        started
    }

    /// Reads the map. Returns what the compute lane shall do.
    pub fn read(&self, request: TopomapRequest) -> Option<TopomapTask> {
        let config = TopomapConfig::default();
        match self.shared.store.topomap_source(request.map, &self.shared.profile, config) {
            Ok(source) => Some(TopomapTask { request, source }),
            Err(error) => {
                self.fail(request.map, texts::topomap_not_read(&error_with_causes(&error)));
                None
            }
        }
    }

    /// Finds nodes and edges, and hands them to the ledger.
    pub fn generate(&self, task: TopomapTask) {
        let TopomapTask { request: TopomapRequest { by, map, edit: id }, source } = task;
        self.publish(TopomapGeneration::Running { map, stage: TopomapStage::Generating });
        let made = source.generate();
        if made.nodes.is_empty() {
            return self.fail(map, texts::TOPOMAP_EMPTY.to_owned());
        }
        self.publish(TopomapGeneration::Running { map, stage: TopomapStage::Storing });
        let mut summary = summary_of(&made);
        let kept_nodes = Arc::new(AtomicUsize::new(0));
        let kept_in_site = Arc::clone(&kept_nodes);
        let this = self.clone();
        let handed_in = self.shared.ledger.change_site(SiteWork {
            by,
            make: Box::new(move |site: &Site| -> Edit {
                let replacement = made.replacement(site, map, id);
                kept_in_site.store(replacement.kept_nodes, Ordering::Relaxed);
                replacement.edit
            }),
            done: Box::new(move |outcome| match outcome {
                EditOutcome::Applied { .. } => {
                    summary.kept_nodes = kept_nodes.load(Ordering::Relaxed) as u32;
                    this.end(TopomapGeneration::Done { map, edit: id, summary });
                }
                EditOutcome::Refused(refusal) => {
                    this.fail(map, texts::topomap_not_stored(&refusal_reason(refusal)))
                }
            }),
        });
        if let Err(reason) = handed_in {
            self.fail(map, reason.to_owned());
        }
    }

    fn fail(&self, map: MapId, reason: String) {
        self.end(TopomapGeneration::Failed { map, reason });
    }

    fn end(&self, state: TopomapGeneration) {
        self.shared.is_running.store(false, Ordering::Release);
        self.publish(state);
    }

    fn publish(&self, state: TopomapGeneration) {
        self.shared.state_publisher.publish(Event::TopomapGeneration(state));
    }
}

fn summary_of(made: &GeneratedMap) -> TopomapSummary {
    let floors: BTreeSet<i32> = made.nodes.iter().map(|node| node.floor).collect();
    let blocked = made
        .blocked
        .iter()
        .take(MAX_BLOCKED_SEGMENTS)
        .map(|segment| [segment.from_m, segment.to_m].map(|at| Vec3::new(at.x, at.y, at.z)));
    TopomapSummary {
        nodes: made.nodes.len() as u32,
        edges: made.edges.len() as u32,
        docks: made.docks.len() as u32,
        floors: floors.len() as u32,
        length_m: made.length_m(),
        pieces: made.pieces as u32,
        blocked: blocked.collect(),
        kept_nodes: 0,
    }
}

#[cfg(test)]
#[path = "topomap_generation_tests.rs"]
mod tests;
