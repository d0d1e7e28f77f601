//! Carries the filter through time: IMU, legs and another odometry between the scans.

use crate::config::{Mounting, NoiseConfig, OdometryConfig};
use crate::event::Estimate;
use crate::filter::ErrorStateFilter;
use crate::imu_lidar_consistency::ImuLidarConsistency;
use crate::imu_queue::ImuQueue;
use crate::motion_model::MotionModel;
use crate::pickup_detector::PickupDetector;
use crate::pose_table::PoseTable;
use crate::state::{ErrorVector, State};
use crate::velocity_measurement::VelocityMeasurement;
use geometry::{Isometry, Matrix6, Rotation, Vector3, Vector6, se3, so3};
use std::collections::VecDeque;
use vocab::{Span, Stamp};

/// How far off a robot may be that sees nothing of what it saw before, one standard deviation: radians and metres. Somebody may have
/// carried it away.
const ASTRAY: (f64, f64) = (0.5, 5.0);
/// Noise of readings at the end of their range, per √Hz: rad/s and m/s².
const SATURATED_GYRO: f64 = 3.0;
const SATURATED_ACCEL: f64 = 10.0;

/// Legs have spoken lately if it is no longer ago.
const LATELY: Span = Span::from_millis(300);

/// Something with its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stamped<T> {
    /// When.
    pub stamp: Stamp,
    /// What.
    pub value: T,
}

/// Messages that wait for their time, each in ascending order.
#[derive(Clone, Debug, Default)]
pub struct Queues {
    /// Inertial readings.
    pub imu: ImuQueue,
    /// Velocities and turn rates of the base in its own frame, m/s and rad/s.
    pub legs: VecDeque<Stamped<[Vector3; 2]>>,
    /// Poses of the external frame in its own origin.
    pub external: VecDeque<Stamped<Isometry>>,
}

/// Where an estimate begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialPose {
    /// The base: its place and heading count.
    pub odom_from_base: Isometry,
    /// How far that is a guess, `[rotation; translation]`, base frame.
    pub covariance_inflation: Matrix6,
}

impl Default for InitialPose {
    /// The origin by definition.
    fn default() -> Self {
        Self { odom_from_base: Isometry::identity(), covariance_inflation: Matrix6::zeros() }
    }
}

/// The filter and what carries it.
#[derive(Clone, Debug)]
pub struct StatePropagator {
    noise: NoiseConfig,
    mounting: Mounting,
    /// The estimate.
    pub filter: ErrorStateFilter,
    /// Poses over the last moments.
    pub table: PoseTable,
    /// Whether an IMU carries the motion now.
    pub has_imu: bool,
    /// Whether the present is less sure than an IMU makes it: readings were missing or at the end of their range.
    pub is_imprecise: bool,
    /// Compares the turns of gyroscope and LiDAR.
    pub imu_lidar_consistency: ImuLidarConsistency,
    /// Base in the body, which is the IMU; the base itself where there is none.
    pub body_from_base: Isometry,
    /// What stretches on which nothing was followed add to the covariance of every later pose, base frame.
    covariance_inflation: Matrix6,
    time: Stamp,
    /// The gyroscope's bias while the IMU is silent.
    saved_gyro_bias: Option<Vector3>,
    /// Latest turn rate as the gyroscope read it, rad/s.
    gyro: Vector3,
    last_legs: Option<Stamp>,
    /// How fast they were, m/s.
    legs_speed: f64,
    pickup_detector: PickupDetector,
    last_external: Option<Stamped<Isometry>>,
}

impl StatePropagator {
    /// At rest with the base at the origin. `level_from_body` is the body's rotation for a base that heads along x; `deviations` those
    /// of the error.
    pub fn new(
        config: &OdometryConfig,
        begin: Stamp,
        body_from_base: Isometry,
        origin: &InitialPose,
        level_from_body: Rotation,
        deviations: &ErrorVector,
    ) -> Self {
        let (_, _, heading) = origin.odom_from_base.rotation.euler_angles();
        let odom_from_level = Rotation::from_axis_angle(&Vector3::z_axis(), heading);
        let odom_from_base = Isometry::from_parts(
            origin.odom_from_base.translation,
            odom_from_level * level_from_body * body_from_base.rotation,
        );
        let odom_from_body = odom_from_base * body_from_base.inverse();
        let mut table = PoseTable::default();
        table.restart(begin, odom_from_body);
        Self {
            noise: config.noise,
            mounting: config.mounting,
            filter: ErrorStateFilter::new(State::at(odom_from_body), deviations),
            table,
            has_imu: false,
            is_imprecise: false,
            imu_lidar_consistency: ImuLidarConsistency::default(),
            body_from_base,
            covariance_inflation: origin.covariance_inflation,
            time: begin,
            saved_gyro_bias: None,
            gyro: Vector3::zeros(),
            last_legs: None,
            legs_speed: 0.0,
            pickup_detector: PickupDetector::default(),
            last_external: None,
        }
    }

    /// The present.
    pub fn time(&self) -> Stamp {
        self.time
    }

    /// The present uncertainty of the pose as that of a guess, of a robot that sees nothing of what it saw before. It is added to later
    /// covariances as it is, alike in all directions.
    pub fn guess(&self) -> Matrix6 {
        self.widened(ASTRAY)
    }

    /// The same, of one whose present pose has been [booked](Self::inflate_covariance) as a guess since.
    pub fn guess_since(&self) -> Matrix6 {
        self.widened((0.0, 0.0))
    }

    fn widened(&self, (radians, metres): (f64, f64)) -> Matrix6 {
        let pose = self.estimate().covariance;
        let widest = |first: usize| (first..first + 3).map(|i| pose[(i, i)]).fold(0.0, f64::max);
        let (rotation, position) = (widest(0) + radians * radians, widest(3) + metres * metres);
        Matrix6::from_diagonal(&Vector6::from_fn(|i, _| if i < 3 { rotation } else { position }))
    }

    /// Books the present pose as a [guess](Self::guess): scans that fit each other from here on take its uncertainty off the filter, and
    /// say nothing of the way before.
    pub fn inflate_covariance(&mut self) {
        self.covariance_inflation = self.guess();
    }

    /// Whether the IMU feels motion of which the legs know nothing: somebody carries the robot, or pushes it about.
    pub fn is_carried(&self) -> bool {
        self.has_imu && self.pickup_detector.is_carried(self.time)
    }

    /// Whether legs and IMU know the way, and agree on it.
    pub fn has_consistent_legs(&self) -> bool {
        self.has_imu && self.last_legs.is_some_and(|last| self.time - last <= LATELY) && !self.is_carried()
    }

    /// How much faster the body is than the legs say, m/s; none where they say nothing.
    pub fn speed_above_legs(&self) -> Option<f64> {
        let lately = self.last_legs.is_some_and(|last| self.time - last <= LATELY);
        lately.then(|| self.estimate().velocity.norm() - self.legs_speed)
    }

    /// Newest leg velocity taken in.
    pub fn last_legs(&self) -> Option<Stamp> {
        self.last_legs
    }

    /// Newest external pose taken in.
    pub fn last_external(&self) -> Option<Stamp> {
        self.last_external.map(|last| last.stamp)
    }

    /// Carries the filter to a stamp, through every message on the way.
    pub fn advance(&mut self, to: Stamp, queues: &mut Queues) {
        let Queues { imu, legs, external } = queues;
        while self.time < to {
            let expected = self.has_imu || self.saved_gyro_bias.is_some();
            let next_imu = if expected { imu.next_after(self.time) } else { None };
            let next_legs = legs.front().map(|legs| legs.stamp);
            let next_external = external.front().map(|external| external.stamp);
            let next = [next_imu, next_legs, next_external]
                .into_iter()
                .flatten()
                .min()
                .map_or(to, |next| next.min(to));
            let twist = self.external_twist(external.front());
            if next > self.time {
                self.step(next, imu, twist);
                imu.discard_before(next);
            }
            while legs.front().is_some_and(|legs| legs.stamp <= next) {
                if let Some(measured) = legs.pop_front() {
                    self.update_legs(&measured);
                }
            }
            while external.front().is_some_and(|external| external.stamp <= next) {
                if let Some(measured) = external.pop_front() {
                    self.update_external(&measured);
                }
            }
        }
    }

    /// One step of propagation, to the next instant at which anything is known.
    fn step(&mut self, to: Stamp, imu: &ImuQueue, twist: Option<MotionModel>) {
        let dt = (to - self.time).secs_f64();
        let expected = self.has_imu || self.saved_gyro_bias.is_some();
        let readings = if expected { imu.mean(self.time, to) } else { None };
        self.switch_imu(readings.is_some());
        self.is_imprecise |= !self.has_imu;
        let mut noise = self.noise;
        let motion = match (readings, twist) {
            (Some(mean), _) => {
                self.gyro = mean.gyro;
                self.pickup_detector.update_imu(dt, &mean.specific_force, &mean.gyro);
                noise.gyro *= self.imu_lidar_consistency.gyro_noise_factor();
                self.is_imprecise |= mean.saturated;
                if mean.saturated {
                    noise.gyro = SATURATED_GYRO;
                    noise.accel = SATURATED_ACCEL;
                }
                self.imu_lidar_consistency.insert_turn_rate(
                    to,
                    dt,
                    &(mean.gyro - self.filter.state.gyro_bias),
                );
                MotionModel::Inertial { gyro: mean.gyro, specific_force: mean.specific_force }
            }
            (None, Some(twist)) => twist,
            (None, None) => MotionModel::DecayingVelocity,
        };
        self.filter.propagate(&motion, dt, &noise);
        self.time = to;
        self.table.push(to, self.filter.state.odom_from_body);
    }

    /// When the IMU falls silent the body goes on as it turned last, and when it speaks again its bias is what it was.
    fn switch_imu(&mut self, on_message: bool) {
        if on_message == self.has_imu || (on_message && self.saved_gyro_bias.is_none()) {
            return;
        }
        if on_message {
            self.filter.replace_gyro_bias(self.saved_gyro_bias.take().unwrap_or_default(), 2e-3);
        } else {
            let bias = self.filter.state.gyro_bias;
            self.saved_gyro_bias = Some(bias);
            self.filter.replace_gyro_bias(bias - self.gyro, 0.5);
        }
        self.has_imu = on_message;
    }

    fn update_legs(&mut self, measured: &Stamped<[Vector3; 2]>) {
        let [velocity, turn_rate] = measured.value;
        self.last_legs = Some(measured.stamp);
        let gyro = if self.has_imu { self.gyro } else { Vector3::zeros() };
        let measurement = VelocityMeasurement {
            velocity,
            body_from_frame: self.body_from_base,
            gyro,
            deviation: self.noise.legs,
            scaled: true,
        };
        measurement.apply(&mut self.filter);
        self.legs_speed = velocity.norm();
        self.pickup_detector.update_legs(measured.stamp, self.legs_speed, turn_rate.norm());
    }

    /// Without an IMU, the other odometry's twist between its last pose and its next one carries the motion.
    fn external_twist(&self, next: Option<&Stamped<Isometry>>) -> Option<MotionModel> {
        let (last, next) = (self.last_external.as_ref()?, next?);
        let (turn_rate, velocity) = self.body_twist(last, next)?;
        Some(MotionModel::Twist { turn_rate, velocity })
    }

    /// Mean turn rate and velocity of the body between two external poses, body frame.
    fn body_twist(&self, last: &Stamped<Isometry>, next: &Stamped<Isometry>) -> Option<(Vector3, Vector3)> {
        let dt = (next.stamp - last.stamp).secs_f64();
        if dt <= 0.0 || dt > 1.5 {
            return None;
        }
        let body_from_external = self.body_from_base * self.mounting.base_from_external;
        let moved = body_from_external * last.value.inverse() * next.value * body_from_external.inverse();
        let turn = so3::log(&moved.rotation);
        // Rotations half-way, as Motion::Twist integrates it.
        let velocity = so3::exp(&(turn * -0.5)) * moved.translation.vector / dt;
        Some((turn / dt, velocity))
    }

    fn update_external(&mut self, measured: &Stamped<Isometry>) {
        let last = self.last_external.replace(*measured);
        let Some((turn_rate, velocity)) = last.and_then(|last| self.body_twist(&last, measured)) else {
            return;
        };
        if self.has_imu {
            let measurement = VelocityMeasurement {
                velocity: so3::exp(&(turn_rate * -0.05)) * velocity,
                body_from_frame: Isometry::identity(),
                gyro: self.gyro,
                deviation: 0.1 + self.noise.external * velocity.norm(),
                scaled: false,
            };
            measurement.apply(&mut self.filter);
        }
    }

    /// The estimate at an instant, carried on from the present by the readings that wait.
    pub fn predict(&self, at: Stamp, imu: &ImuQueue) -> Estimate {
        let mut ahead = self.filter.clone();
        let mut time = self.time;
        let mut turn_rate = self.turn_rate(&ahead.state, self.gyro);
        // Beyond a second nothing carries it.
        let until = at.min(self.time + Span::from_millis(1_000));
        while time < until {
            let next = imu.next_after(time).filter(|_| self.has_imu).map_or(until, |next| next.min(until));
            let dt = (next - time).secs_f64();
            let motion = match imu.mean(time, next).filter(|_| self.has_imu) {
                Some(mean) => {
                    turn_rate = self.turn_rate(&ahead.state, mean.gyro);
                    MotionModel::Inertial { gyro: mean.gyro, specific_force: mean.specific_force }
                }
                None if self.has_imu => break,
                None => MotionModel::DecayingVelocity,
            };
            ahead.state = motion.propagate_mean(&ahead.state, dt);
            time = next;
        }
        Estimate { turn_rate, ..self.estimate_of(&ahead, at) }
    }

    /// Turn rate of the base in its own frame, given what the gyroscope reads.
    fn turn_rate(&self, state: &State, gyro: Vector3) -> Vector3 {
        let gyro = if self.has_imu { gyro } else { Vector3::zeros() };
        self.body_from_base.rotation.inverse() * (gyro - state.gyro_bias)
    }

    /// The base's motion now.
    pub fn estimate(&self) -> Estimate {
        self.estimate_of(&self.filter, self.time)
    }

    /// The base's motion as a filter has it.
    fn estimate_of(&self, filter: &ErrorStateFilter, stamp: Stamp) -> Estimate {
        let state = &filter.state;
        let odom_from_base = state.odom_from_body * self.body_from_base;
        let turn_rate = self.turn_rate(state, self.gyro);
        let in_body = state.odom_from_body.rotation.inverse() * state.velocity;
        let body_rate = self.body_from_base.rotation * turn_rate;
        let at_base = in_body + body_rate.cross(&self.body_from_base.translation.vector);
        // An error of the body's pose seen at the base.
        let adjoint = se3::adjoint(&self.body_from_base.inverse());
        let pose: Matrix6 = filter.covariance.fixed_view::<6, 6>(0, 0).into();
        Estimate {
            stamp,
            odom_from_base,
            velocity: self.body_from_base.rotation.inverse() * at_base,
            turn_rate,
            covariance: adjoint * pose * adjoint.transpose() + self.covariance_inflation,
            covariance_inflation: self.covariance_inflation,
        }
    }
}
