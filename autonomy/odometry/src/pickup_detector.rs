//! Whether a robot whose legs stand is carried: an IMU at rest is quiet, one in somebody's arms is not.
//!
//! Nothing here depends on what the filter believes, which being carried spoils: legs that hang say that the body stands, and the filter
//! learns wrong biases from that.

use geometry::Vector3;
use vocab::{Span, Stamp};

/// Legs that are no faster stand, or hang, m/s and rad/s.
const STANDING: (f64, f64) = (0.15, 0.1);
/// What they do counts from so long after they came to stand on, and until so long after they spoke last.
const SETTLED: Span = Span::from_millis(1_000);
const LATELY: Span = Span::from_millis(300);
/// Readings of an IMU at rest deviate by no more, m/s² and rad/s: ten times the noise of poor ones, and a third of what steps of
/// people who carry it do.
const QUIET: (f64, f64) = (0.6, 0.08);
/// Over so long, seconds.
const OVER: f64 = 0.5;
/// A knock is over sooner, seconds.
const KNOCKED: f64 = 0.7;

/// What legs and IMU say of it.
#[derive(Clone, Copy, Debug, Default)]
pub struct PickupDetector {
    /// Since when the legs stand, and when they spoke last.
    standing: Option<(Stamp, Stamp)>,
    force: Spread,
    gyro: Spread,
    /// For how long the IMU has not been quiet, seconds.
    unquiet: f64,
}

impl PickupDetector {
    /// How fast the legs are, m/s and rad/s.
    pub fn update_legs(&mut self, at: Stamp, speed: f64, turning: f64) {
        self.standing = match self.standing {
            _ if speed > STANDING.0 || turning > STANDING.1 => None,
            Some((since, last)) if at - last <= LATELY => Some((since, at)),
            _ => {
                *self = Self::default();
                Some((at, at))
            }
        };
    }

    /// Specific force, m/s², and turn rate, rad/s, for so long, seconds.
    pub fn update_imu(&mut self, dt: f64, force: &Vector3, gyro: &Vector3) {
        self.force.add(dt, force);
        self.gyro.add(dt, gyro);
        let is_quiet = self.force.deviation() <= QUIET.0 && self.gyro.deviation() <= QUIET.1;
        self.unquiet = if is_quiet { 0.0 } else { self.unquiet + dt };
    }

    /// Whether the legs stand and the IMU moves all the same: somebody carries the robot, or pushes it about.
    pub fn is_carried(&self, now: Stamp) -> bool {
        let stands =
            self.standing.is_some_and(|(since, last)| now - last <= LATELY && last - since >= SETTLED);
        stands && self.unquiet >= KNOCKED
    }
}

/// Running mean of a vector, and of the squared distance from that.
#[derive(Clone, Copy, Debug, Default)]
struct Spread(Option<(Vector3, f64)>);

impl Spread {
    fn add(&mut self, dt: f64, value: &Vector3) {
        let share = (dt / OVER).clamp(0.0, 1.0);
        let (mean, variance) = self.0.unwrap_or((*value, 0.0));
        let off = value - mean;
        self.0 = Some((mean + off * share, variance + (off.norm_squared() - variance) * share));
    }

    fn deviation(&self) -> f64 {
        self.0.map_or(0.0, |(_, variance)| variance.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::RngTree;

    /// Legs and IMU at 100 Hz for so long, with such an amplitude of force at two steps a second.
    fn run(
        pickup_detector: &mut PickupDetector,
        now: &mut Stamp,
        seconds: f64,
        (speed, turning): (f64, f64),
        amplitude: f64,
    ) {
        let mut rng = RngTree::new(5).child("rest").rng();
        for tick in 0..(seconds * 100.0) as i64 {
            *now += Span::from_millis(10);
            let mut noise = |scale: f64| Vector3::new(rng.normal(), rng.normal(), rng.normal()) * scale;
            let bounce = Vector3::z() * (9.81 + amplitude * (tick as f64 * 0.13).sin());
            pickup_detector.update_imu(
                0.01,
                &(bounce + noise(0.05)),
                &(Vector3::z() * turning + noise(0.005)),
            );
            pickup_detector.update_legs(*now, speed, turning);
        }
    }

    #[test]
    fn who_stands_and_is_shaken_is_carried() {
        let (mut pickup_detector, mut now) = (PickupDetector::default(), Stamp::EPOCH);
        let mut goes = |seconds: f64, speeds: (f64, f64), amplitude: f64| {
            run(&mut pickup_detector, &mut now, seconds, speeds, amplitude);
            pickup_detector.is_carried(now)
        };
        assert!(!goes(3.0, (0.8, 0.0), 3.0), "it walks");
        assert!(!goes(3.0, (0.0, 0.0), 0.0), "it stands");
        assert!(!goes(3.0, (0.02, 0.8), 1.0), "it turns on the spot");
        assert!(!goes(2.0, (0.0, 0.0), 0.0), "it stands again");
        assert!(!goes(0.3, (0.0, 0.0), 4.0) && !goes(2.0, (0.0, 0.0), 0.0), "somebody knocked against it");
        assert!(goes(2.0, (0.0, 0.0), 2.0));
        now += Span::from_millis(500);
        assert!(!pickup_detector.is_carried(now), "the legs have fallen silent");
    }
}
