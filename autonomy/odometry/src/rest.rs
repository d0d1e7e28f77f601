//! Whether a robot whose legs stand is at rest: an IMU at rest is quiet, one in somebody's arms is not.
//!
//! Nothing here depends on what the filter believes, which being carried spoils: legs that hang say that the body stands, and the filter
//! learns wrong biases from that.

use geometry::Vector3;
use vocab::{Span, Stamp};

/// Legs that are no faster stand, or hang, m/s.
const STANDING: f64 = 0.15;
/// What they do counts from so long after they came to stand on, and until so long after they spoke last.
const SETTLED: Span = Span::from_millis(1_000);
const LATELY: Span = Span::from_millis(300);
/// Readings of an IMU at rest deviate by no more, m/s² and rad/s: ten times the noise of poor ones, and a third of what steps of
/// people who carry it do.
const QUIET: (f64, f64) = (0.6, 0.08);
/// Over so long, seconds.
const OVER: f64 = 0.5;

/// What legs and IMU say of it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rest {
    /// Since when the legs stand, and when they spoke last.
    standing: Option<(Stamp, Stamp)>,
    force: Spread,
    gyro: Spread,
}

impl Rest {
    /// How fast the legs are, m/s.
    pub fn legs(&mut self, at: Stamp, speed: f64) {
        self.standing = match self.standing {
            _ if speed > STANDING => None,
            Some((since, last)) if at - last <= LATELY => Some((since, at)),
            _ => {
                (self.force, self.gyro) = (Spread::default(), Spread::default());
                Some((at, at))
            }
        };
    }

    /// Specific force, m/s², and turn rate, rad/s, for so long, seconds.
    pub fn imu(&mut self, dt: f64, force: &Vector3, gyro: &Vector3) {
        self.force.add(dt, force);
        self.gyro.add(dt, gyro);
    }

    /// Whether the legs stand, and the IMU is quiet.
    pub fn is_at_rest(&self, now: Stamp) -> bool {
        self.stands(now) && !self.is_unquiet()
    }

    /// Whether the legs stand and the IMU moves all the same: somebody carries the robot, or pushes it about.
    pub fn is_carried(&self, now: Stamp) -> bool {
        self.stands(now) && self.is_unquiet()
    }

    fn stands(&self, now: Stamp) -> bool {
        self.standing.is_some_and(|(since, last)| now - last <= LATELY && last - since >= SETTLED)
    }

    fn is_unquiet(&self) -> bool {
        self.force.deviation() > QUIET.0 || self.gyro.deviation() > QUIET.1
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
    fn run(rest: &mut Rest, now: &mut Stamp, seconds: f64, speed: f64, amplitude: f64) {
        let mut rng = RngTree::new(5).child("rest").rng();
        for tick in 0..(seconds * 100.0) as i64 {
            *now += Span::from_millis(10);
            let mut noise = |scale: f64| Vector3::new(rng.normal(), rng.normal(), rng.normal()) * scale;
            let bounce = Vector3::z() * (9.81 + amplitude * (tick as f64 * 0.13).sin());
            rest.imu(0.01, &(bounce + noise(0.05)), &noise(0.005));
            rest.legs(*now, speed);
        }
    }

    #[test]
    fn who_stands_and_is_shaken_is_carried() {
        let (mut rest, mut now) = (Rest::default(), Stamp::EPOCH);
        run(&mut rest, &mut now, 3.0, 0.8, 3.0);
        assert!(!rest.is_at_rest(now) && !rest.is_carried(now), "it walks");
        run(&mut rest, &mut now, 0.8, 0.0, 0.0);
        assert!(!rest.is_at_rest(now) && !rest.is_carried(now), "it has hardly come to stand");
        run(&mut rest, &mut now, 1.0, 0.0, 0.0);
        assert!(rest.is_at_rest(now) && !rest.is_carried(now));
        run(&mut rest, &mut now, 2.0, 0.0, 2.0);
        assert!(!rest.is_at_rest(now) && rest.is_carried(now));
        now += Span::from_millis(500);
        assert!(!rest.is_carried(now), "the legs have fallen silent");
    }
}
