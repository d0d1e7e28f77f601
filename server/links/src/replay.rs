//! A recording, played as if it happened now. Drive commands go nowhere: what was walked was walked.

use crate::pacer::RealTimePacer;
use crate::{ArrivalSender, LinkThread, Stopped};
use crossbeam_channel::Receiver;
use messages::{BootRecord, Drive, Sensor};
use ports::{Arrival, LinkError, RobotEvent, RobotLink};
use std::time::Instant;
use vocab::{Span, Stamp};

/// Longest stretch of robot time without an arrival.
const CLOCK_EVERY: Span = Span::from_millis(50);
/// A longer gap between two messages is not waited for.
const GAP_MAX: Span = Span::from_millis(10_000);

/// What to play.
pub struct ReplaySource {
    /// The robot it was recorded on.
    pub boot: BootRecord,
    /// Sensor messages with their arrival, in order. What cannot be read is left out before it comes here.
    pub messages: Box<dyn Iterator<Item = (Stamp, Sensor)> + Send>,
}

/// A recording on a thread of its own.
pub struct ReplayLink {
    boot: BootRecord,
    arrivals: Receiver<Arrival>,
    _thread: LinkThread,
}

impl ReplayLink {
    /// Starts playing, `speed` times as fast as it happened.
    ///
    /// # Errors
    /// When the thread cannot be started.
    pub fn start(source: ReplaySource, speed: f64) -> Result<Self, LinkError> {
        let boot = source.boot;
        let (thread, arrivals) = LinkThread::start("link-replay", move |sender| {
            // Whether it was played to its end or the link was dropped, the thread is done.
            let _ = play(source.messages, RealTimePacer::new(speed), &sender);
        })?;
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
    mut pacer: RealTimePacer,
    sender: &ArrivalSender,
) -> Result<(), Stopped> {
    let mut clock: Option<Stamp> = None;
    for (at, sensor) in messages {
        let mut now = *clock.get_or_insert(at);
        if at - now > GAP_MAX {
            now = at;
            pacer.restart();
        }
        while now + CLOCK_EVERY < at {
            now += CLOCK_EVERY;
            sender.sleep(pacer.delay(now, Instant::now()))?;
            sender.send(Arrival { at: now, event: RobotEvent::Clock })?;
        }
        sender.sleep(pacer.delay(at, Instant::now()))?;
        let at = at.max(now);
        sender.send(Arrival { at, event: RobotEvent::Sensor(sensor) })?;
        clock = Some(at);
    }
    let at = clock.unwrap_or_default();
    let event = RobotEvent::Ended(
        "The recording has been played to its end. The map so far can be saved.".to_owned(),
    );
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
    fn plays_every_message_in_order_with_the_time_between_and_says_when_it_ends() {
        let messages = [imu(0), imu(20), imu(200), imu(190), imu(60_000)];
        let source = ReplaySource { boot: BootRecord::default(), messages: Box::new(messages.into_iter()) };
        let link = ReplayLink::start(source, 1000.0).expect("starts");
        let arrivals = link.arrivals();
        let mut heard = Vec::new();
        loop {
            let arrival = arrivals.recv_timeout(Duration::from_secs(20)).expect("goes on");
            let kind = match arrival.event {
                RobotEvent::Sensor(_) => "imu",
                RobotEvent::Clock => "clock",
                RobotEvent::Ended(_) => break,
            };
            heard.push((arrival.at.nanos() / 1_000_000, kind));
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
        assert_eq!(heard, expected);
    }
}
