//! Publications of the stack, converted to events for clients. Runs on its own thread, so that encoding never delays the robot.

use crate::clock::RobotClock;
use crate::convert;
use crate::jobs::{DiskJob, Jobs};
use crate::live_map::LiveMap;
use crate::mailbox::Mailbox;
use crate::place_keeper::PlaceKeeper;
use crate::platform::{BatteryForecast, PlatformProbe};
use crate::recording::sentence;
use crate::state_publisher::StatePublisher;
use api::{CoreMessage, Event, Goal, Graph, LoopsChanged, MAX_GOALS, Quality, TilesChanged};
use messages::{CorrectedScan, Estimate, Keyframe, PoseInMap, Publication, Severity};
use std::sync::Arc;
use std::time::{Duration, Instant};
use store::StoreError;

/// Shortest time between estimates to clients: 20 Hz.
const ESTIMATE_EVERY: Duration = Duration::from_millis(50);
/// Time between reports about the server itself.
const PLATFORM_EVERY: Duration = Duration::from_secs(1);
/// Step of a live scan's lattice, metres.
const SCAN_RESOLUTION: f32 = 0.01;

/// The publisher's parts.
pub struct PublisherWorker {
    pub mailbox: Arc<Mailbox>,
    pub state_publisher: Arc<StatePublisher>,
    pub clock: Arc<RobotClock>,
    pub jobs: Jobs,
    pub live_map: LiveMap,
    pub platform: PlatformProbe,
    pub battery: BatteryForecast,
    pub place: PlaceKeeper,
    /// The newest goals, the newest first.
    pub goals: Vec<Goal>,
    /// The docks as published last; none before the first time, when they are as on the disk.
    pub docks: Option<Arc<[PoseInMap]>>,
}

impl PublisherWorker {
    /// Publishes until the mailbox is closed.
    pub fn run(mut self) {
        self.state_publisher.publish(Event::Graph(Graph::default()));
        let mut estimate: Option<Estimate> = None;
        let mut estimate_at = Instant::now();
        let mut platform_at = Instant::now();
        loop {
            let deadline = if estimate.is_some() { platform_at.min(estimate_at) } else { platform_at };
            let mail = self.mailbox.wait(deadline);
            for publication in mail.ordered {
                self.publish(publication);
            }
            if let Some(scan) = mail.scan.filter(|_| self.state_publisher.wants_scans()) {
                self.state_publisher.push(encoded(&scan));
            }
            estimate = mail.estimate.or(estimate);
            let now = Instant::now();
            if let Some(estimate) = &estimate {
                self.place.note(now, estimate);
            }
            if now >= estimate_at
                && let Some(estimate) = estimate.take()
            {
                self.state_publisher.publish(Event::Estimate(convert::estimate(&estimate)));
                estimate_at = now + ESTIMATE_EVERY;
            }
            if now >= platform_at {
                self.state_publisher.publish(Event::Platform(self.platform.read(self.clock.now())));
                platform_at = now + PLATFORM_EVERY;
            }
            if mail.closed {
                return;
            }
        }
    }

    fn publish(&mut self, publication: Publication) {
        match publication {
            Publication::Keyframe(keyframe) => self.keyframe(&keyframe),
            Publication::Graph(graph) => {
                self.state_publisher.publish(Event::Graph(convert::graph(&graph, self.live_map.session())));
            }
            Publication::GraphDelta(delta) => {
                let changed = convert::graph_changed(&delta, self.live_map.session());
                self.state_publisher.publish(Event::GraphChanged(changed));
            }
            Publication::Mapping(state) => {
                self.follow(&state);
                self.state_publisher.publish(Event::Mapping(convert::mapping(&state)));
                self.show_base(&state);
            }
            Publication::Localisation(state) => {
                self.place.follow(&state);
                self.state_publisher.publish(Event::Localisation(convert::localisation(&state)));
                let shown = self.live_map.show_known(&state);
                self.show(shown);
            }
            Publication::Docks(docks) => {
                if self.docks.as_ref().is_some_and(|before| *before != docks) {
                    self.place.save_docks(&docks);
                }
                self.state_publisher.publish(Event::Docks(convert::docks(&docks)));
                self.docks = Some(docks);
            }
            Publication::Goal(update) => {
                let goal = convert::goal(update);
                self.goals.retain(|known| known.id != goal.id);
                self.goals.insert(0, goal);
                self.goals.truncate(MAX_GOALS);
                self.state_publisher.publish(Event::Goals(self.goals.clone()));
            }
            Publication::Battery(state) => {
                self.state_publisher.publish(Event::Battery(self.battery.look(&state)))
            }
            other => {
                if let Some(event) = convert::event(other) {
                    self.state_publisher.publish(event);
                }
            }
        }
    }

    /// Clears the live map when its session has ended.
    fn follow(&mut self, state: &messages::MappingState) {
        let before = self.live_map.session();
        if let Some((session, tiles)) = self.live_map.follow(state) {
            self.jobs.start(DiskJob::Forget { session, tiles });
        }
        if self.live_map.session() != before {
            self.state_publisher.publish(Event::Tiles(TilesChanged { reset: true, added: Vec::new() }));
            self.state_publisher.publish(Event::Loops(LoopsChanged { reset: true, added: Vec::new() }));
            self.state_publisher.publish(Event::Quality(Quality::default()));
            self.state_publisher
                .publish(Event::Graph(Graph { session: self.live_map.session(), ..Graph::default() }));
        }
    }

    fn show_base(&mut self, state: &messages::MappingState) {
        let shown = self.live_map.show_base(state);
        self.show(shown);
    }

    /// Publishes a saved map.
    fn show(&mut self, shown: Result<Vec<Event>, StoreError>) {
        match shown {
            Ok(events) => events.into_iter().for_each(|event| self.state_publisher.publish(event)),
            Err(error) => {
                let text = format!("The map in use cannot be shown: {}.", sentence(&error));
                self.mailbox.notice(self.clock.now(), Severity::Warning, text);
            }
        }
    }

    fn keyframe(&mut self, keyframe: &Keyframe) {
        match self.live_map.add(keyframe) {
            Ok(tiles) => self.state_publisher.publish(tiles),
            Err(error) => {
                let text = format!("A part of the live map cannot be shown: {}.", sentence(&error));
                self.mailbox.notice(self.clock.now(), Severity::Warning, text);
            }
        }
    }
}

fn encoded(scan: &CorrectedScan) -> CoreMessage {
    CoreMessage::Scan {
        stamp: scan.stamp,
        map_from_base: scan.map_from_base,
        points: map_codec::encode_scan(&scan.cloud.xyz, &scan.cloud.intensity, SCAN_RESOLUTION),
    }
}
