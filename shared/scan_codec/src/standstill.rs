//! Whether the robot stands, by what its IMU and its legs measure.

use messages::{ImuSample, Sensor};
use vocab::{Span, Stamp, Vec3};

/// Parameters of [`StandstillDetector`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StandstillConfig {
    /// Angular velocity above which the robot moves, rad/s: twice the bias that the datasheet of a BMI085 allows at switch-on, plus its noise. A
    /// robot that walks or is carried turns at 0.1 rad/s and more.
    pub max_angular_velocity_rad_s: f64,
    /// Difference of the specific force from its mean above which the robot moves, m/s². The noise of the same part is 0.03; steps of a person
    /// or of the robot make more than 1.
    pub max_specific_force_difference_m_s2: f64,
    /// Time constant of that mean. Chosen: longer than a step, so that the mean is that of gravity.
    pub mean_time: Span,
    /// Speed of the base by the legs above which the robot moves, m/s. Chosen: above the noise of legs that stand, and below the slowest walk.
    pub max_leg_speed_m_s: f64,
    /// Angular velocity by the legs above which it moves, rad/s. Chosen for the same reason.
    pub max_leg_angular_velocity_rad_s: f64,
    /// Time without motion after which the robot stands. Chosen: a robot that only pauses between two steps does not count.
    pub settle_time: Span,
    /// Time without a sample of the IMU, or of the legs if there are any, after which nothing says that the robot stands. Chosen: ten samples and more of an IMU, and
    /// several of legs.
    pub max_silence: Span,
}

impl Default for StandstillConfig {
    fn default() -> Self {
        Self {
            max_angular_velocity_rad_s: 0.05,
            max_specific_force_difference_m_s2: 0.5,
            mean_time: Span::from_millis(1_000),
            max_leg_speed_m_s: 0.02,
            max_leg_angular_velocity_rad_s: 0.02,
            settle_time: Span::from_millis(2_000),
            max_silence: Span::from_millis(100),
        }
    }
}

/// Finds out whether the robot stands. It does so only while the IMU says it, and the legs too where the robot has any: a sensor that falls silent means
/// that it may move.
#[derive(Clone, Debug, Default)]
pub struct StandstillDetector {
    config: StandstillConfig,
    /// Last sample of the IMU.
    imu: Option<Stamp>,
    mean_force: Option<Vec3>,
    /// Last sample of the legs.
    legs: Option<Stamp>,
    /// Since when nothing has moved.
    still_since: Option<Stamp>,
}

impl StandstillDetector {
    /// A detector that has seen nothing.
    pub fn new(config: StandstillConfig) -> Self {
        Self { config, ..Self::default() }
    }

    /// Learns from a message that arrives at `at`.
    pub fn update(&mut self, at: Stamp, sensor: &Sensor) {
        let moves = match sensor {
            Sensor::Imu(sample) => self.imu_moves(at, sample),
            Sensor::Legs(legs) => {
                self.legs = Some(at);
                norm(&legs.base_velocity.linear) > self.config.max_leg_speed_m_s
                    || norm(&legs.base_velocity.angular) > self.config.max_leg_angular_velocity_rad_s
            }
            Sensor::Scan(_) | Sensor::Odometry(_) | Sensor::Battery(_) => return,
        };
        if moves {
            self.still_since = None;
        } else {
            self.still_since.get_or_insert(at);
        }
    }

    /// Whether the robot stands at `at`.
    pub fn is_standing(&self, at: Stamp) -> bool {
        let is_recent = |last: Stamp| at - last <= self.config.max_silence;
        self.imu.is_some_and(is_recent)
            && self.legs.is_none_or(is_recent)
            && self.still_since.is_some_and(|since| at - since >= self.config.settle_time)
    }

    fn imu_moves(&mut self, at: Stamp, sample: &ImuSample) -> bool {
        let since = self.imu.replace(at).map_or(Span::ZERO, |last| at - last);
        if since > self.config.max_silence {
            self.still_since = None;
        }
        let force = sample.specific_force;
        let mean = self.mean_force.get_or_insert(force);
        let difference = Vec3::new(force.x - mean.x, force.y - mean.y, force.z - mean.z);
        let share = (since.secs_f64() / self.config.mean_time.secs_f64()).clamp(0.0, 1.0);
        mean.x += share * difference.x;
        mean.y += share * difference.y;
        mean.z += share * difference.z;
        // NaN moves too.
        let is_still = norm(&sample.angular_velocity) <= self.config.max_angular_velocity_rad_s
            && norm(&difference) <= self.config.max_specific_force_difference_m_s2;
        !is_still
    }
}

fn norm(v: &Vec3) -> f64 {
    (v.x * v.x + v.y * v.y + v.z * v.z).sqrt()
}
