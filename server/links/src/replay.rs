//! Replays a recording as a robot: its messages arrive as if they were measured now. Drive commands have no effect.

use crate::pacer::RealTimePacer;
use crate::stoppable_thread::{ArrivalSender, StoppableThread, Stopped};
use crate::texts;
use crossbeam_channel::Receiver;
use messages::{BootRecord, Drive, Sensor, TICK_PERIOD};
use ports::{Arrival, LinkError, RobotEvent, RobotLink};
use std::time::Instant;
use vocab::{Span, Stamp};

/// Parameters of a [`ReplayLink`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReplayConfig {
    /// Recorded seconds per second of this computer. The default is real time.
    pub speed: f64,
    /// Longest time between arrivals; [`RobotEvent::Clock`] fills longer gaps between messages. It is the period of the control loop's ticks.
    pub clock_interval: Span,
    /// Longest gap between two messages that is replayed; a longer one is skipped. Chosen: a person who watches does not wait longer.
    pub max_gap: Span,
    /// Largest number of arrivals in the queue to the control loop: about 1 s of a robot with all sensors. While it is full, the replay waits.
    pub max_queued_arrivals: usize,
}

impl Default for ReplayConfig {
    fn default() -> Self {
        Self {
            speed: 1.0,
            clock_interval: TICK_PERIOD,
            max_gap: Span::from_millis(10_000),
            max_queued_arrivals: 1_000,
        }
    }
}

/// The recording to replay.
pub struct ReplaySource {
    /// Boot record of the recorded robot.
    pub boot: BootRecord,
    /// Readable sensor messages with their time of arrival, in order.
    pub messages: Box<dyn Iterator<Item = (Stamp, Sensor)> + Send>,
}

/// Replays a recording on a separate thread.
pub struct ReplayLink {
    boot: BootRecord,
    arrivals: Receiver<Arrival>,
    _thread: StoppableThread,
}

impl ReplayLink {
    /// Starts the replay.
    ///
    /// # Errors
    /// When the thread cannot be started.
    pub fn start(source: ReplaySource, config: ReplayConfig) -> Result<Self, LinkError> {
        let boot = source.boot;
        let (sender, arrivals) = crossbeam_channel::bounded(config.max_queued_arrivals);
        let thread = StoppableThread::start("link-replay", move |stop| {
            // The recording ended or the link was dropped: the thread ends either way.
            let _ = play(source.messages, &config, &mut ArrivalSender::new(sender, stop));
        })
        .map_err(LinkError::Thread)?;
        Ok(Self { boot, arrivals, _thread: thread })
    }
}

impl RobotLink for ReplayLink {
    fn boot(&self) -> BootRecord {
        self.boot.clone()
    }

    fn arrivals(&self) -> Receiver<Arrival> {
        self.arrivals.clone()
    }

    fn drive(&self, _drive: Drive) {}
}

fn play(
    messages: impl Iterator<Item = (Stamp, Sensor)>,
    config: &ReplayConfig,
    sender: &mut ArrivalSender,
) -> Result<(), Stopped> {
    let mut pacer = RealTimePacer::new(config.speed);
    let mut clock: Option<Stamp> = None;
    for (at, sensor) in messages {
        let mut now = *clock.get_or_insert(at);
        if at - now > config.max_gap {
            now = at;
            pacer.restart();
        }
        while now + config.clock_interval < at {
            now += config.clock_interval;
            sender.stop.sleep(pacer.delay(now, Instant::now()))?;
            sender.send(Arrival { at: now, event: RobotEvent::Clock })?;
        }
        sender.stop.sleep(pacer.delay(at, Instant::now()))?;
        let at = at.max(now);
        sender.send(Arrival { at, event: RobotEvent::Sensor(sensor) })?;
        clock = Some(at);
    }
    let at = clock.unwrap_or_default();
    let event = RobotEvent::Ended(texts::RECORDING_ENDED.to_owned());
    sender.send(Arrival { at, event })
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::ImuSample;
    use std::time::Duration;

    fn imu(millis: i64) -> (Stamp, Sensor) {
        let stamp = Stamp::EPOCH + Span::from_millis(millis);
        (stamp, Sensor::Imu(ImuSample { stamp, ..ImuSample::default() }))
    }

    #[test]
    fn every_message_is_replayed_in_order_and_in_time_and_the_end_is_reported() {
        let messages = [imu(0), imu(20), imu(200), imu(190), imu(60_000)];
        let source = ReplaySource { boot: BootRecord::default(), messages: Box::new(messages.into_iter()) };
        let link = ReplayLink::start(source, ReplayConfig { speed: 1000.0, ..ReplayConfig::default() })
            .expect("starts");
        let arrivals = link.arrivals();
        let mut received = Vec::new();
        loop {
            let arrival = arrivals.recv_timeout(Duration::from_secs(20)).expect("the replay continues");
            let kind = match arrival.event {
                RobotEvent::Sensor(_) => "imu",
                RobotEvent::Clock => "clock",
                _ => break,
            };
            received.push((arrival.at.nanos() / 1_000_000, kind));
        }
        let expected = [
            (0, "imu"),
            (20, "imu"),
            (70, "clock"),
            (120, "clock"),
            (170, "clock"),
            (200, "imu"),
            (200, "imu"),
            (60_000, "imu"),
        ];
        assert_eq!(received, expected);
    }
}
