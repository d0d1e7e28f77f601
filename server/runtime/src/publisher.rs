//! Converts publications of the stack to events for clients, on a thread of its own: encoding must not delay the robot.

use crate::clock::RobotClock;
use crate::control_loop::LoopRequest;
use crate::convert;
use crate::jobs::Jobs;
use crate::lease_arbiter::LeaseArbiter;
use crate::live_map::LiveMap;
use crate::mailbox::Mailbox;
use crate::platform::{BatteryForecast, PlatformProbe};
use crate::pose_persistence::PosePersistence;
use crate::state_publisher::StatePublisher;
use crate::texts;
use crate::tile_recovery::TileRecovery;
use api::{CoreMessage, Event, Goal, Graph, LoopsChanged, MAX_GOALS, Quality, TilesChanged};
use crossbeam_channel::Sender;
use messages::{CorrectedScan, Estimate, GraphDelta, Keyframe, PoseInMap, Publication, Severity};
use ports::error_with_causes;
use std::sync::Arc;
use std::time::{Duration, Instant};
use store::StoreError;
use watchdog::Heartbeat;

/// Parameters of the [`PublisherWorker`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PublisherConfig {
    /// Shortest time between two estimates for clients. 20 Hz look smooth.
    pub estimate_period: Duration,
    /// Time between two reports on the resources of the server. Chosen: people read no faster.
    pub platform_period: Duration,
    /// Step to which coordinates are rounded in live scans, metres. It is that of saved maps.
    pub scan_resolution_m: f32,
}

impl Default for PublisherConfig {
    fn default() -> Self {
        Self {
            estimate_period: Duration::from_millis(50),
            platform_period: Duration::from_secs(1),
            scan_resolution_m: map_codec::POINT_RESOLUTION_M,
        }
    }
}

/// The publisher's thread.
pub struct PublisherWorker {
    pub config: PublisherConfig,
    pub mailbox: Arc<Mailbox>,
    pub state_publisher: Arc<StatePublisher>,
    pub lease: Arc<LeaseArbiter>,
    pub clock: Arc<RobotClock>,
    pub jobs: Jobs,
    pub live_map: LiveMap,
    pub platform: PlatformProbe,
    pub battery: BatteryForecast,
    pub persistence: PosePersistence,
    /// The latest state of the newest goals, the newest first.
    pub goals: Vec<Goal>,
    /// The docks as published last. `None` before the first publication, which repeats what is on disk.
    pub docks: Option<Arc<[PoseInMap]>>,
    /// Way to the control loop.
    pub requests: Sender<LoopRequest>,
    /// Whether the whole graph has to be asked for.
    pub needs_graph: bool,
    /// Whether the stack was asked for the whole graph and has not answered.
    pub is_graph_requested: bool,
    /// Tiles that have to be cut from the files of keyframes.
    pub tile_recovery: TileRecovery,
}

impl PublisherWorker {
    /// Publishes until the mailbox is closed.
    pub fn run(mut self, heartbeat: &Heartbeat) {
        self.state_publisher.publish(Event::Graph(Graph::default()));
        let mut estimate: Option<Estimate> = None;
        let mut estimate_at = Instant::now();
        let mut platform_at = Instant::now();
        loop {
            heartbeat.beat();
            let mut deadline = if estimate.is_some() { platform_at.min(estimate_at) } else { platform_at };
            if self.tile_recovery.is_ready() {
                deadline = Instant::now();
            }
            let mail = self.mailbox.wait(deadline);
            // What was dropped is older than what waits.
            self.needs_graph |= mail.is_graph_dropped;
            if let Some(dropped) = mail.dropped_keyframes {
                self.tile_recovery.add(dropped);
                // Their poses are in it.
                self.needs_graph = true;
            }
            for publication in mail.ordered {
                self.publish(publication);
            }
            self.request_graph();
            self.recover_tiles();
            if let Some(scan) = mail.scan.filter(|_| self.state_publisher.wants_scans()) {
                self.state_publisher.push(encode_scan(&scan, self.config.scan_resolution_m));
            }
            estimate = mail.estimate.or(estimate);
            let now = Instant::now();
            if let Some(estimate) = &estimate {
                self.persistence.update(now, estimate);
            }
            if now >= estimate_at
                && let Some(estimate) = estimate.take()
            {
                self.state_publisher.publish(Event::Estimate(convert::estimate(&estimate)));
                estimate_at = now + self.config.estimate_period;
            }
            if now >= platform_at {
                self.state_publisher.publish(Event::Platform(self.platform.read(self.clock.now())));
                platform_at = now + self.config.platform_period;
            }
            if mail.closed {
                return;
            }
        }
    }

    fn publish(&mut self, publication: Publication) {
        match publication {
            Publication::Keyframe(keyframe) => self.publish_keyframe(&keyframe),
            Publication::Graph { session, graph } => {
                (self.is_graph_requested, self.needs_graph) = (false, false);
                self.state_publisher.publish(Event::Graph(convert::graph(&graph, Some(session))));
                self.tile_recovery.set_graph(session, &graph);
            }
            Publication::GraphDelta(delta) => self.change_graph(&delta),
            Publication::Mapping(state) => {
                self.set_session(&state);
                self.state_publisher.publish(Event::Mapping(convert::mapping(&state)));
                let shown = self.live_map.show_extended(&state);
                self.publish_saved_map(shown);
            }
            Publication::Localisation(state) => {
                self.persistence.set_localisation(&state);
                self.state_publisher.publish(Event::Localisation(convert::localisation(&state)));
                let shown = self.live_map.show_saved(&state);
                self.publish_saved_map(shown);
            }
            Publication::Docks(docks) => {
                if self.docks.as_ref().is_some_and(|last| *last != docks) {
                    self.persistence.save_docks(&docks);
                }
                self.state_publisher.publish(Event::Docks(convert::docks(&docks)));
                self.docks = Some(docks);
            }
            Publication::Control(state) => self.lease.set_lease(state, Instant::now()),
            Publication::Goal(update) => {
                let goal = convert::goal(update);
                self.goals.retain(|known| known.id != goal.id);
                self.goals.insert(0, goal);
                self.goals.truncate(MAX_GOALS);
                self.state_publisher.publish(Event::Goals(self.goals.clone()));
            }
            Publication::Battery(state) => {
                self.state_publisher.publish(Event::Battery(self.battery.update(&state)))
            }
            other => {
                if let Some(event) = convert::event(other) {
                    self.state_publisher.publish(event);
                }
            }
        }
    }

    /// Publishes changes of the graph. If they do not apply to the published graph, they are dropped and the stack is asked for the whole graph.
    fn change_graph(&mut self, delta: &GraphDelta) {
        if !self.state_publisher.publish_graph_changes(convert::graph_changed(delta)) {
            tracing::warn!(base_revision = delta.base_revision, "changes of the pose graph do not apply");
            self.needs_graph = true;
            self.request_graph();
        }
    }

    /// Asks the stack for the whole graph, once. While the queue of requests is full, the next turn asks again.
    fn request_graph(&mut self) {
        if std::mem::take(&mut self.needs_graph) && !self.is_graph_requested {
            self.is_graph_requested = self.requests.try_send(LoopRequest::WholeGraph).is_ok();
            self.needs_graph = !self.is_graph_requested;
        }
    }

    /// Shows the next keyframes that the mailbox has dropped.
    fn recover_tiles(&mut self) {
        for node in self.tile_recovery.take_next(self.live_map.session()) {
            match self.live_map.recover_keyframe(&node) {
                Ok(Some(tiles)) => self.state_publisher.publish(tiles),
                Ok(None) => {}
                Err(error) => self.keyframe_not_shown(&error),
            }
        }
    }

    /// Clears the live map of the clients when the session has changed.
    fn set_session(&mut self, state: &messages::MappingState) {
        let last = self.live_map.session();
        if let Some((session, tiles)) = self.live_map.set_mapping(state) {
            self.jobs.forget(session, tiles);
        }
        if self.live_map.session() != last {
            self.is_graph_requested = false;
            self.state_publisher.publish(Event::Tiles(TilesChanged { reset: true, added: Vec::new() }));
            self.state_publisher.publish(Event::Loops(LoopsChanged { reset: true, added: Vec::new() }));
            self.state_publisher.publish(Event::Quality(Quality::default()));
            self.state_publisher
                .publish(Event::Graph(Graph { session: self.live_map.session(), ..Graph::default() }));
        }
    }

    /// Publishes the events that show a saved map, or a notice that it cannot be read.
    fn publish_saved_map(&mut self, shown: Result<Vec<Event>, StoreError>) {
        match shown {
            Ok(events) => events.into_iter().for_each(|event| self.state_publisher.publish(event)),
            Err(error) => {
                let text = texts::map_not_shown(&error_with_causes(&error));
                self.mailbox.notice(self.clock.now(), Severity::Warning, text);
            }
        }
    }

    fn publish_keyframe(&mut self, keyframe: &Keyframe) {
        match self.live_map.insert_keyframe(keyframe) {
            Ok(tiles) => self.state_publisher.publish(tiles),
            Err(error) => self.keyframe_not_shown(&error),
        }
    }

    fn keyframe_not_shown(&self, error: &StoreError) {
        let text = texts::keyframe_not_shown(&error_with_causes(error));
        self.mailbox.notice(self.clock.now(), Severity::Warning, text);
    }
}

fn encode_scan(scan: &CorrectedScan, resolution_m: f32) -> CoreMessage {
    CoreMessage::Scan {
        stamp: scan.stamp,
        map_from_base: scan.map_from_base,
        points: map_codec::encode_scan(&scan.cloud.xyz, &scan.cloud.intensity, resolution_m),
    }
}

#[cfg(test)]
#[path = "publisher_tests.rs"]
mod tests;
