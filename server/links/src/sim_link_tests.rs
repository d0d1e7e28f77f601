use super::*;
use messages::Sensor;
use ports::DRIVE_TIMEOUT;
use sim::SiteName;
use std::time::Duration;
use vocab::{Stamp, Twist, Vec3};

/// As fast as it goes, and cheap: what matters here is not what the LiDAR sees.
fn link() -> SimLink {
    let sim = SimConfig { lidar_columns: 10, people: 0, ..SimConfig::new(SiteName::B1, 1) };
    SimLink::start(SimLinkConfig { sim, speed: 1000.0 }).expect("starts")
}

fn next(arrivals: &Receiver<Arrival>) -> Arrival {
    arrivals.recv_timeout(Duration::from_secs(20)).expect("the simulation goes on")
}

#[test]
fn arrivals_come_in_order_and_the_clock_never_rests() {
    let link = link();
    let arrivals = link.arrivals();
    let mut last: Option<Stamp> = None;
    let mut kinds = [0; 4];
    for _ in 0..2_000 {
        let arrival = next(&arrivals);
        if let Some(last) = last {
            assert!(arrival.at >= last, "{arrival:?} after {last:?}");
            assert!(arrival.at - last <= Span::from_millis(50));
        }
        last = Some(arrival.at);
        match arrival.news {
            News::Sensor(Sensor::Imu(_)) => kinds[0] += 1,
            News::Sensor(Sensor::Scan(_)) => kinds[1] += 1,
            News::Sensor(Sensor::Legs(_)) => kinds[2] += 1,
            News::Clock => kinds[3] += 1,
            _ => {}
        }
    }
    assert!(kinds.iter().all(|count| *count > 10), "{kinds:?}");
}

#[test]
fn the_robot_walks_when_told_and_stops_when_commands_cease() {
    let link = link();
    let arrivals = link.arrivals();
    let forward = Twist { linear: Vec3::new(0.5, 0.0, 0.0), ..Twist::default() };
    let speed_of = |drive: Option<Drive>, seconds: i64| {
        let mut until = None;
        let mut speed = 0.0;
        loop {
            let arrival = next(&arrivals);
            if arrival.at > *until.get_or_insert(arrival.at + Span::from_millis(1000 * seconds)) {
                return speed;
            }
            if let Some(drive) = drive {
                link.drive(drive);
            }
            if let News::Sensor(Sensor::Legs(legs)) = arrival.news {
                speed = legs.base_velocity.linear.x;
            }
        }
    };
    // The queue between the two threads holds about a second, so each stretch is longer than that.
    let walking = speed_of(Some(Drive { velocity: forward }), 5);
    assert!(walking > 0.25, "walks at {walking} m/s");
    let stopped = speed_of(None, 5 + DRIVE_TIMEOUT.nanos() / 1_000_000_000);
    assert!(stopped.abs() < 0.1, "still moves at {stopped} m/s");
}

#[test]
fn a_link_nobody_reads_from_can_still_be_dropped() {
    let link = link();
    let arrivals = link.arrivals();
    while !arrivals.is_full() {
        std::thread::yield_now();
    }
    drop(link);
    assert_eq!(arrivals.iter().count(), crate::QUEUE_MAX);
}
