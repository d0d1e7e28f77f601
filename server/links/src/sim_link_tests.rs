use super::*;
use messages::DRIVE_LIFETIME;
use messages::Sensor;
use sim::SiteName;
use std::time::Duration;
use vocab::{Stamp, Twist, Vec3};

/// A link that runs as fast as possible, with few LiDAR columns: these tests use no details of the scans.
fn link() -> SimLink {
    let sim = SimConfig { lidar_columns: 10, people: 0, ..SimConfig::new(SiteName::B1, 1) };
    SimLink::start(SimLinkConfig::new(sim, 1000.0)).expect("starts")
}

fn next(arrivals: &Receiver<Arrival>) -> Arrival {
    arrivals.recv_timeout(Duration::from_secs(20)).expect("the simulation goes on")
}

#[test]
fn arrivals_come_in_order_at_most_50_ms_apart() {
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
        match arrival.event {
            RobotEvent::Sensor(Sensor::Imu(_)) => kinds[0] += 1,
            RobotEvent::Sensor(Sensor::Scan(_)) => kinds[1] += 1,
            RobotEvent::Sensor(Sensor::Legs(_)) => kinds[2] += 1,
            RobotEvent::Clock => kinds[3] += 1,
            _ => {}
        }
    }
    assert!(kinds.iter().all(|count| *count > 10), "{kinds:?}");
}

#[test]
fn the_robot_walks_on_commands_and_stops_when_they_cease() {
    let link = link();
    let arrivals = link.arrivals();
    let forward = Drive { velocity: Twist { linear: Vec3::new(0.5, 0.0, 0.0), ..Twist::default() } };
    // While this thread sleeps, the simulation may fill its queue. That takes longer than a command is valid, so the robot may stop
    // in between. The test therefore waits until a speed is reached.
    let reaches = |drive: Option<Drive>, seconds: i64, is_wanted: fn(f64) -> bool| {
        let mut until = None;
        loop {
            let arrival = next(&arrivals);
            if arrival.at > *until.get_or_insert(arrival.at + Span::from_millis(1000 * seconds)) {
                return false;
            }
            if let Some(drive) = drive {
                link.drive(drive);
            }
            if let RobotEvent::Sensor(Sensor::Legs(legs)) = arrival.event
                && is_wanted(legs.base_velocity.linear.x)
            {
                return true;
            }
        }
    };
    assert!(reaches(Some(forward), 60, |speed| speed > 0.4), "never walks at the commanded speed");
    // The arrivals in the queue are from walking. After them the last command is valid for its time, and the legs come to rest.
    let rest = 5 + DRIVE_LIFETIME.nanos() / 1_000_000_000;
    assert!(!reaches(None, rest, |_| false), "always false, so this only lets {rest} s pass");
    assert!(!reaches(None, 3, |speed| speed.abs() > 0.1), "still moves {rest} s after the last command");
}

#[test]
fn a_link_with_a_full_queue_can_be_dropped() {
    let link = link();
    let arrivals = link.arrivals();
    while !arrivals.is_full() {
        std::thread::yield_now();
    }
    drop(link);
    assert_eq!(arrivals.iter().count(), crate::CONFIG.max_queued_arrivals);
}

#[test]
fn injected_faults_blind_the_lidar_until_they_are_cleared() {
    let link = link();
    let arrivals = link.arrivals();
    let sees = |expected: bool, seconds: i64| {
        let mut until = None;
        loop {
            let arrival = next(&arrivals);
            if arrival.at > *until.get_or_insert(arrival.at + Span::from_millis(1000 * seconds)) {
                return false;
            }
            if let RobotEvent::Sensor(Sensor::Scan(scan)) = arrival.event
                && scan.xyz.is_empty() != expected
            {
                return true;
            }
        }
    };
    assert!(sees(true, 10));
    assert_eq!(link.inject_fault(SimulatedFault::CoverLidar(Span::from_millis(3_600_000))), Ok(()));
    assert!(sees(false, 60), "the LiDAR is covered");
    assert_eq!(link.inject_fault(SimulatedFault::End), Ok(()));
    assert!(sees(true, 60), "the LiDAR is clear again");
    assert_eq!(link.inject_fault(SimulatedFault::CarryAway), Ok(()));
    assert!(sees(false, 60) && sees(true, 60), "the LiDAR is covered again and clear again");
}
