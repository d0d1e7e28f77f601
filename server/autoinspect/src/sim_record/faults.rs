//! Parses faults: `blind-lidar@60-80,leg-slip@30-40:0.2,0,0`.

use crate::failure::Failure;
use sim::ScheduledFault;
use vocab::{Span, Vec3};

/// One fault of the command line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaultName(ScheduledFault);

impl FaultName {
    /// The fault in the simulator's type.
    pub fn fault(&self) -> ScheduledFault {
        self.0
    }
}

/// Parses a list. Commas separate faults, and also the three numbers of a slip.
pub fn parse(text: &str) -> Result<Vec<FaultName>, Failure> {
    let mut faults: Vec<String> = Vec::new();
    for piece in text.split(',').map(str::trim).filter(|piece| !piece.is_empty()) {
        match faults.last_mut() {
            // A number after a comma belongs to the preceding slip.
            Some(last) if !piece.contains('@') => last.push_str(&format!(",{piece}")),
            _ => faults.push(piece.to_owned()),
        }
    }
    faults.iter().map(|fault| one(fault)).collect()
}

fn one(text: &str) -> Result<FaultName, Failure> {
    let explain = || Failure::usage(crate::texts::invalid_fault(text));
    let (name, rest) = text.split_once('@').ok_or_else(explain)?;
    let (times, amount) = rest.split_once(':').map_or((rest, None), |(times, amount)| (times, Some(amount)));
    let (from, until) = times.split_once('-').ok_or_else(explain)?;
    let seconds = |text: &str| text.trim().parse::<f64>().map(Span::from_secs_f64).map_err(|_| explain());
    let (from, until) = (seconds(from)?, seconds(until)?);
    match (name.trim(), amount) {
        ("blind-lidar", None) => Ok(FaultName(ScheduledFault::BlindLidar { from, until })),
        ("silent-lidar", None) => Ok(FaultName(ScheduledFault::SilentLidar { from, until })),
        ("silent-imu", None) => Ok(FaultName(ScheduledFault::SilentImu { from, until })),
        ("leg-slip", Some(amount)) => {
            let velocity = velocity(amount).ok_or_else(explain)?;
            Ok(FaultName(ScheduledFault::LegSlip { from, until, velocity }))
        }
        _ => Err(explain()),
    }
}

fn velocity(text: &str) -> Option<Vec3> {
    let numbers: Vec<f64> =
        text.split(',').map(|number| number.trim().parse().ok()).collect::<Option<_>>()?;
    let [x, y, z] = numbers[..] else { return None };
    Some(Vec3::new(x, y, z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_parsed_and_invalid_ones_are_rejected() {
        let seconds = |secs| Span::from_secs_f64(secs);
        let faults = parse("blind-lidar@60-80, leg-slip@30-40:0.2,0,-0.1,silent-imu@1.5-2").expect("faults");
        let expected = [
            ScheduledFault::BlindLidar { from: seconds(60.0), until: seconds(80.0) },
            ScheduledFault::LegSlip {
                from: seconds(30.0),
                until: seconds(40.0),
                velocity: Vec3::new(0.2, 0.0, -0.1),
            },
            ScheduledFault::SilentImu { from: seconds(1.5), until: seconds(2.0) },
        ];
        assert_eq!(faults.iter().map(FaultName::fault).collect::<Vec<_>>(), expected);
        for text in
            ["blind-lidar", "blind-lidar@60", "leg-slip@1-2", "leg-slip@1-2:1,2", "fog@1-2", "silent-imu@a-b"]
        {
            assert!(parse(text).is_err(), "{text}");
        }
    }
}
