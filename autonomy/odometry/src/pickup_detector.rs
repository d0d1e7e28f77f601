//! Detects that a robot whose legs stand is carried: an IMU at rest is quiet, the IMU of a carried robot is not.
//!
//! The detector uses measurements only and no estimate of the filter, because carrying spoils the filter: hanging legs report
//! standstill, and the filter learns wrong biases from that.

use geometry::Vector3;
use vocab::{Span, Stamp};

/// Parameters of a [`PickupDetector`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PickupConfig {
    /// Legs at most this fast stand or hang, m/s. Chosen: hanging legs sway, and a walk is faster.
    pub max_standing_speed_m_s: f64,
    /// Legs that turn the base at most this fast stand or hang, rad/s. Chosen for the same reason.
    pub max_standing_turn_rate_rad_s: f64,
    /// Legs count as standing after this time of standstill. Chosen: two steps of a walk.
    pub min_standing: Span,
    /// A message of the legs is valid for this time. Chosen: some messages at 10 Hz and more.
    pub legs_timeout: Span,
    /// Greatest deviation of the specific force of an IMU at rest, m/s²: ten times the noise of poor IMUs, and a third of what the
    /// steps of people who carry the robot cause.
    pub max_force_deviation_m_s2: f64,
    /// Greatest deviation of the turn rate of an IMU at rest, rad/s, for the same reasons.
    pub max_gyro_deviation_rad_s: f64,
    /// Time constant of the running means of the deviations, seconds. Chosen: a step of people who carry the robot.
    pub averaging_time_s: f64,
    /// The IMU has to be unquiet for this time, seconds. A knock against the robot is over sooner. Chosen a little longer than [`Self::averaging_time_s`].
    pub min_unquiet_s: f64,
}

impl Default for PickupConfig {
    fn default() -> Self {
        Self {
            max_standing_speed_m_s: 0.15,
            max_standing_turn_rate_rad_s: 0.1,
            min_standing: Span::from_millis(1_000),
            legs_timeout: Span::from_millis(300),
            max_force_deviation_m_s2: 0.6,
            max_gyro_deviation_rad_s: 0.08,
            averaging_time_s: 0.5,
            min_unquiet_s: 0.7,
        }
    }
}

/// An interval in which the legs stand.
#[derive(Clone, Copy, Debug)]
struct Standstill {
    since: Stamp,
    /// Newest message of the legs.
    last: Stamp,
}

/// Detects that a robot whose legs stand is carried.
#[derive(Clone, Copy, Debug)]
pub struct PickupDetector {
    config: PickupConfig,
    standstill: Option<Standstill>,
    force: RunningVariance,
    gyro: RunningVariance,
    /// For how long the IMU has not been quiet, seconds.
    unquiet_s: f64,
}

impl PickupDetector {
    /// Without measurements.
    pub fn new(config: PickupConfig) -> Self {
        let (force, gyro) = (RunningVariance::default(), RunningVariance::default());
        Self { config, standstill: None, force, gyro, unquiet_s: 0.0 }
    }

    /// Adds a measurement of the legs: speed (m/s) and turn rate (rad/s) of the base.
    pub fn update_legs(&mut self, at: Stamp, speed: f64, turn_rate: f64) {
        let moves = speed > self.config.max_standing_speed_m_s
            || turn_rate > self.config.max_standing_turn_rate_rad_s;
        self.standstill = match self.standstill {
            _ if moves => None,
            Some(held) if at - held.last <= self.config.legs_timeout => Some(Standstill { last: at, ..held }),
            _ => {
                *self = Self::new(self.config);
                Some(Standstill { since: at, last: at })
            }
        };
    }

    /// Adds the mean specific force (m/s²) and turn rate (rad/s) over `dt` seconds.
    pub fn update_imu(&mut self, dt: f64, force: &Vector3, gyro: &Vector3) {
        let share = (dt / self.config.averaging_time_s).clamp(0.0, 1.0);
        self.force.update(share, force);
        self.gyro.update(share, gyro);
        let is_quiet = self.force.deviation() <= self.config.max_force_deviation_m_s2
            && self.gyro.deviation() <= self.config.max_gyro_deviation_rad_s;
        self.unquiet_s = if is_quiet { 0.0 } else { self.unquiet_s + dt };
    }

    /// Whether the legs stand although the IMU moves: the robot is carried or pushed.
    pub fn is_carried(&self, now: Stamp) -> bool {
        let stands = self.standstill.is_some_and(|held| {
            now - held.last <= self.config.legs_timeout && held.last - held.since >= self.config.min_standing
        });
        stands && self.unquiet_s >= self.config.min_unquiet_s
    }
}

/// Running mean of a vector and of its squared distance from that mean.
#[derive(Clone, Copy, Debug, Default)]
struct RunningVariance(Option<(Vector3, f64)>);

impl RunningVariance {
    /// Moves both means by a share of their difference from the new value.
    fn update(&mut self, share: f64, value: &Vector3) {
        let (mean, variance) = self.0.unwrap_or((*value, 0.0));
        let error = value - mean;
        self.0 = Some((mean + error * share, variance + (error.norm_squared() - variance) * share));
    }

    fn deviation(&self) -> f64 {
        self.0.map_or(0.0, |(_, variance)| variance.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::RngTree;

    /// Legs and IMU at 100 Hz, with a specific force that oscillates by `amplitude` at two steps a second.
    fn run(
        detector: &mut PickupDetector,
        now: &mut Stamp,
        seconds: f64,
        (speed, turn_rate): (f64, f64),
        amplitude: f64,
    ) {
        let mut rng = RngTree::new(5).child("rest").rng();
        for tick in 0..(seconds * 100.0) as i64 {
            *now += Span::from_millis(10);
            let mut noise = |scale: f64| Vector3::new(rng.normal(), rng.normal(), rng.normal()) * scale;
            let bounce = Vector3::z() * (9.81 + amplitude * (tick as f64 * 0.13).sin());
            detector.update_imu(0.01, &(bounce + noise(0.05)), &(Vector3::z() * turn_rate + noise(0.005)));
            detector.update_legs(*now, speed, turn_rate);
        }
    }

    #[test]
    fn a_robot_that_stands_and_is_shaken_is_carried() {
        let (mut detector, mut now) = (PickupDetector::new(PickupConfig::default()), Stamp::EPOCH);
        let mut is_carried_after = |seconds: f64, speeds: (f64, f64), amplitude: f64| {
            run(&mut detector, &mut now, seconds, speeds, amplitude);
            detector.is_carried(now)
        };
        assert!(!is_carried_after(3.0, (0.8, 0.0), 3.0), "it walks");
        assert!(!is_carried_after(3.0, (0.0, 0.0), 0.0), "it stands");
        assert!(!is_carried_after(3.0, (0.02, 0.8), 1.0), "it turns in place");
        assert!(!is_carried_after(2.0, (0.0, 0.0), 0.0), "it stands again");
        assert!(!is_carried_after(0.3, (0.0, 0.0), 4.0), "somebody knocks against it");
        assert!(!is_carried_after(2.0, (0.0, 0.0), 0.0), "after the knock");
        assert!(is_carried_after(2.0, (0.0, 0.0), 2.0));
        now += Span::from_millis(500);
        assert!(!detector.is_carried(now), "the legs are silent");
    }
}
