//! The walk of the simulated robot, on a thread of its own: it does not wait for the stack, which is another thread's.

use crate::failure::Failure;
use crate::inputs::{InputReader, Message, ReadStatistics};
use crate::process::thread_cpu_time;
use crate::progress::Progress;
use crate::texts;
use crossbeam_channel::Sender;
use messages::{BootRecord, TICK_PERIOD};
use sim::{RouteFollower, SimConfig, SimulatedSite, Simulator, SiteRoute};
use std::sync::Arc;
use vocab::{Span, Stamp};

/// Name of the route in the site.
const ROUTE: &str = "round";

/// Parameters of the walk.
#[derive(Clone, Copy, Debug)]
pub struct ExampleWalkConfig {
    /// Seed of the simulation. Any number; the example is the same for all with one.
    pub seed: u64,
    /// Columns of a LiDAR sweep. Few are enough: a map of 200 has the same nodes as one of 2000, and is made in a third of the time.
    pub columns: u32,
    /// The walk ends after this time, or at the end of its route. Chosen: longer than the walk, which takes 582 s (docs/benchmarks/cost.md).
    pub minutes: f64,
    /// When it begins, on the robot's clock. Chosen by who makes the example: now, on the robot's clock.
    pub epoch: Stamp,
}

/// Starts the walk. Nobody else is on the site.
pub fn start(
    site: &Arc<SimulatedSite>,
    config: &ExampleWalkConfig,
    progress: Progress,
) -> Result<(BootRecord, InputReader), Failure> {
    let route = site.route(ROUTE).cloned();
    let route = route.ok_or_else(|| Failure::failed(texts::no_such_route(&site.name(), ROUTE, &[])))?;
    let simulator = Simulator::new(SimConfig {
        lidar_columns: config.columns,
        people: 0,
        start: Some(route.start),
        epoch: config.epoch,
        ..SimConfig::new(Arc::clone(site), config.seed)
    });
    let boot = simulator.boot();
    let duration = Span::from_secs_f64(60.0 * config.minutes);
    let reader =
        InputReader::spawn("walk", move |sender| walk(simulator, route, duration, progress, sender))?;
    Ok((boot, reader))
}

fn walk(
    mut simulator: Simulator,
    route: SiteRoute,
    duration: Span,
    mut progress: Progress,
    sender: &Sender<Message>,
) -> ReadStatistics {
    let mut walker = RouteFollower::new(route);
    let mut events = Vec::new();
    while simulator.elapsed() < duration {
        let Some(drive) = walker.drive(&simulator.truth()) else { break };
        simulator.command(drive);
        simulator.advance(simulator.now() + TICK_PERIOD, &mut events);
        for event in events.drain(..) {
            if sender.send(Ok((event.at, event.sensor))).is_err() {
                return ReadStatistics::default();
            }
        }
        progress.set_share(simulator.elapsed().secs_f64() / duration.secs_f64());
    }
    progress.finish();
    ReadStatistics { time: thread_cpu_time(), dropped_points: 0 }
}
