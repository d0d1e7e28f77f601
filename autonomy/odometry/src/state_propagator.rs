//! Propagates the filter between scans: through the readings of the IMU, and past the measurements of the legs and of another
//! odometry.

use crate::config::{OdometryConfig, PropagationConfig};
use crate::event::Estimate;
use crate::filter::{ErrorStateFilter, FilterConfig, ImuNoise};
use crate::imu_lidar_consistency::ImuLidarConsistency;
use crate::imu_queue::{ImuQueue, ImuQueueConfig};
use crate::motion_model::MotionModel;
use crate::pickup_detector::PickupDetector;
use crate::pose_table::PoseTable;
use crate::state::{ErrorVector, State};
use crate::velocity_measurement::VelocityMeasurement;
use geometry::{Base, Body, External, Isometry, Matrix6, Rotation, Transform, Vector3, Vector6, se3, so3};
use std::collections::VecDeque;
use vocab::{Span, Stamp};

/// A value with its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stamped<T> {
    /// When it was valid.
    pub stamp: Stamp,
    /// The value.
    pub value: T,
}

/// Messages that wait to be processed, each queue in ascending order.
#[derive(Clone, Debug)]
pub struct Queues {
    /// Inertial readings.
    pub imu: ImuQueue,
    /// Velocity (m/s) and turn rate (rad/s) of the base, base frame.
    pub legs: VecDeque<Stamped<[Vector3; 2]>>,
    /// Poses of the external frame in its own origin.
    pub external: VecDeque<Stamped<Isometry>>,
}

impl Queues {
    /// Empty queues.
    pub fn new(imu: ImuQueueConfig) -> Self {
        Self { imu: ImuQueue::new(imu), legs: VecDeque::new(), external: VecDeque::new() }
    }
}

/// The pose at which an estimate begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StartingPose {
    /// Pose of the base. Only its position and heading are used; roll and pitch come from gravity.
    pub odom_from_base: Isometry,
    /// Covariance inflation of all later poses, `[rotation; translation]`, base frame.
    pub covariance_inflation: Matrix6,
}

impl Default for StartingPose {
    /// The origin, which is known by definition.
    fn default() -> Self {
        Self { odom_from_base: Isometry::identity(), covariance_inflation: Matrix6::zeros() }
    }
}

/// The filter with everything that propagates it.
#[derive(Clone, Debug)]
pub struct StatePropagator {
    config: PropagationConfig,
    noise: FilterConfig,
    legs_timeout: Span,
    base_from_external: Transform<Base, External>,
    /// The estimate.
    pub filter: ErrorStateFilter,
    /// Recent poses.
    pub table: PoseTable,
    /// Whether an IMU propagates the state at present.
    pub has_imu: bool,
    /// Whether readings were missing or at the end of their range since the last scan, so that the prediction is less precise than
    /// an IMU makes it.
    pub is_imprecise: bool,
    /// Compares the rotations of gyroscope and LiDAR.
    pub consistency: ImuLidarConsistency,
    /// Pose of the base in the body.
    pub body_from_base: Transform<Body, Base>,
    /// What lost tracking added to the covariance of every later pose, base frame.
    covariance_inflation: Matrix6,
    time: Stamp,
    /// The gyroscope bias of an IMU that is silent.
    saved_gyro_bias: Option<Vector3>,
    /// Latest reading of the gyroscope, rad/s.
    gyro: Vector3,
    last_legs: Option<Stamp>,
    /// Latest speed of the legs, m/s.
    legs_speed: f64,
    pickup_detector: PickupDetector,
    last_external: Option<Stamped<Isometry>>,
}

impl StatePropagator {
    /// At rest at the initial pose. `level_from_body` is the rotation of the body for a base that heads along x; `deviations` are the
    /// standard deviations of the error.
    pub fn new(
        config: &OdometryConfig,
        begin: Stamp,
        body_from_base: Transform<Body, Base>,
        initial: &StartingPose,
        level_from_body: Rotation,
        deviations: &ErrorVector,
    ) -> Self {
        let (_, _, heading) = initial.odom_from_base.rotation.euler_angles();
        let odom_from_level = Rotation::from_axis_angle(&Vector3::z_axis(), heading);
        let odom_from_base = Isometry::from_parts(
            initial.odom_from_base.translation,
            odom_from_level * level_from_body * body_from_base.isometry().rotation,
        );
        let odom_from_body = odom_from_base * body_from_base.inverse().isometry();
        let mut table = PoseTable::default();
        table.restart(begin, odom_from_body);
        Self {
            config: config.propagation,
            noise: config.filter,
            legs_timeout: config.pickup.legs_timeout,
            base_from_external: config.mounting.base_from_external,
            filter: ErrorStateFilter::new(config.filter, State::at(odom_from_body), deviations),
            table,
            has_imu: false,
            is_imprecise: false,
            consistency: ImuLidarConsistency::new(config.consistency),
            body_from_base,
            covariance_inflation: initial.covariance_inflation,
            time: begin,
            saved_gyro_bias: None,
            gyro: Vector3::zeros(),
            last_legs: None,
            legs_speed: 0.0,
            pickup_detector: PickupDetector::new(config.pickup),
            last_external: None,
        }
    }

    /// The time up to which the state has been propagated.
    pub fn time(&self) -> Stamp {
        self.time
    }

    /// The covariance of the present pose with that of lost tracking added, the same in all directions (docs/maths/odometry.md,
    /// equation 20).
    pub fn inflated_covariance(&self) -> Matrix6 {
        self.isotropic_covariance(self.config.lost_rotation_rad, self.config.lost_position_m)
    }

    /// The covariance of a pose that has been [inflated](Self::inflate_covariance) already, the same in all directions.
    pub fn present_covariance(&self) -> Matrix6 {
        self.isotropic_covariance(0.0, 0.0)
    }

    /// The largest variances of rotation and position of the present pose, plus those of the given deviations, on a diagonal.
    fn isotropic_covariance(&self, rotation_rad: f64, position_m: f64) -> Matrix6 {
        let pose = self.estimate().covariance;
        let largest = |first: usize| (first..first + 3).map(|i| pose[(i, i)]).fold(0.0, f64::max);
        let rotation = largest(0) + rotation_rad * rotation_rad;
        let position = largest(3) + position_m * position_m;
        Matrix6::from_diagonal(&Vector6::from_fn(|i, _| if i < 3 { rotation } else { position }))
    }

    /// Adds the covariance of lost tracking to this and all later poses. Later scans that fit each other reduce the covariance of the
    /// filter, but say nothing about the motion before, so this part is kept apart from the filter.
    pub fn inflate_covariance(&mut self) {
        self.covariance_inflation = self.inflated_covariance();
    }

    /// Whether the robot is carried or pushed: the IMU moves and the legs stand.
    pub fn is_carried(&self) -> bool {
        self.has_imu && self.pickup_detector.is_carried(self.time)
    }

    /// Whether both legs and IMU measure the motion and agree.
    pub fn has_consistent_legs(&self) -> bool {
        self.has_imu && self.has_recent_legs() && !self.is_carried()
    }

    /// Speed of the base minus the speed that the legs report, m/s. `None` without a recent message of the legs.
    pub fn speed_above_legs(&self) -> Option<f64> {
        self.has_recent_legs().then(|| self.estimate().velocity.norm() - self.legs_speed)
    }

    fn has_recent_legs(&self) -> bool {
        self.last_legs.is_some_and(|last| self.time - last <= self.legs_timeout)
    }

    /// Stamp of the newest leg velocity used.
    pub fn last_legs(&self) -> Option<Stamp> {
        self.last_legs
    }

    /// Stamp of the newest external pose used.
    pub fn last_external(&self) -> Option<Stamp> {
        self.last_external.map(|last| last.stamp)
    }

    /// Propagates the filter to a stamp and uses every measurement before it.
    pub fn advance(&mut self, to: Stamp, queues: &mut Queues) {
        let Queues { imu, legs, external } = queues;
        while self.time < to {
            let next_imu = if self.expects_imu() { imu.next_after(self.time) } else { None };
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

    /// Whether there is an IMU, be it silent at present.
    fn expects_imu(&self) -> bool {
        self.has_imu || self.saved_gyro_bias.is_some()
    }

    /// One step of propagation, to the next instant at which anything was measured.
    fn step(&mut self, to: Stamp, imu: &ImuQueue, twist: Option<MotionModel>) {
        let dt = (to - self.time).secs_f64();
        let readings = if self.expects_imu() { imu.mean_between(self.time, to) } else { None };
        self.switch_imu(readings.is_some());
        self.is_imprecise |= !self.has_imu;
        let mut imu_noise = self.noise.imu_noise;
        let motion = match (readings, twist) {
            (Some(mean), _) => {
                self.gyro = mean.gyro;
                self.pickup_detector.update_imu(dt, &mean.specific_force, &mean.gyro);
                imu_noise = self.imu_noise(mean.is_saturated);
                self.is_imprecise |= mean.is_saturated;
                self.consistency.insert_turn_rate(to, dt, &(mean.gyro - self.filter.state.gyro_bias));
                MotionModel::Inertial { gyro: mean.gyro, specific_force: mean.specific_force }
            }
            (None, Some(twist)) => twist,
            (None, None) => MotionModel::DecayingVelocity(self.noise.decay),
        };
        self.filter.propagate(&motion, dt, &imu_noise);
        self.time = to;
        self.table.push(to, self.filter.state.odom_from_body);
    }

    fn imu_noise(&self, is_saturated: bool) -> ImuNoise {
        if is_saturated {
            return self.noise.saturated_imu_noise;
        }
        let mut noise = self.noise.imu_noise;
        noise.gyro_density_rad_s_per_sqrt_hz *= self.consistency.gyro_noise_factor();
        noise
    }

    /// Switches between propagation with and without the IMU. When the IMU falls silent, the body keeps its last turn rate. When it sends again, its
    /// bias has its previous value.
    fn switch_imu(&mut self, has_reading: bool) {
        if has_reading == self.has_imu || (has_reading && self.saved_gyro_bias.is_none()) {
            return;
        }
        if has_reading {
            let bias = self.saved_gyro_bias.take().unwrap_or_default();
            self.filter.replace_gyro_bias(bias, self.config.returned_gyro_bias_rad_s);
        } else {
            let bias = self.filter.state.gyro_bias;
            self.saved_gyro_bias = Some(bias);
            self.filter.replace_gyro_bias(bias - self.gyro, self.config.silent_turn_rate_rad_s);
        }
        self.has_imu = has_reading;
    }

    fn update_legs(&mut self, measured: &Stamped<[Vector3; 2]>) {
        let [velocity, turn_rate] = measured.value;
        self.last_legs = Some(measured.stamp);
        let gyro = if self.has_imu { self.gyro } else { Vector3::zeros() };
        let measurement = VelocityMeasurement {
            velocity,
            body_from_frame: *self.body_from_base.isometry(),
            gyro,
            deviation: self.noise.leg_velocity_m_s,
            uses_leg_scale: true,
        };
        measurement.apply(&mut self.filter);
        self.legs_speed = velocity.norm();
        self.pickup_detector.update_legs(measured.stamp, self.legs_speed, turn_rate.norm());
    }

    /// Without an IMU, the mean twist of the external odometry between its last and its next pose propagates the state.
    fn external_twist(&self, next: Option<&Stamped<Isometry>>) -> Option<MotionModel> {
        let (last, next) = (self.last_external.as_ref()?, next?);
        let (turn_rate, velocity) = self.body_twist(last, next)?;
        Some(MotionModel::Twist { turn_rate, velocity })
    }

    /// Mean turn rate (rad/s) and velocity (m/s) of the body between two external poses, body frame.
    fn body_twist(&self, last: &Stamped<Isometry>, next: &Stamped<Isometry>) -> Option<(Vector3, Vector3)> {
        let dt = (next.stamp - last.stamp).secs_f64();
        if dt <= 0.0 || dt > self.config.max_external_gap_s {
            return None;
        }
        let body_from_external: Transform<Body, External> = self.body_from_base * self.base_from_external;
        let body_from_external = body_from_external.isometry();
        let moved = body_from_external * last.value.inverse() * next.value * body_from_external.inverse();
        let turn = so3::log(&moved.rotation);
        // The velocity in the axes half-way through the interval, as `MotionModel::Twist` integrates it.
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
                velocity: so3::exp(&(turn_rate * -self.config.external_half_interval_s)) * velocity,
                body_from_frame: Isometry::identity(),
                gyro: self.gyro,
                deviation: self.noise.min_external_velocity_m_s
                    + self.noise.external_share_per_sqrt_s * velocity.norm(),
                uses_leg_scale: false,
            };
            measurement.apply(&mut self.filter);
        }
    }

    /// The estimate at an instant, propagated from the present through the waiting readings. The covariance is the present one.
    pub fn predict(&self, at: Stamp, imu: &ImuQueue) -> Estimate {
        let mut ahead = self.filter.clone();
        let mut time = self.time;
        let mut turn_rate = self.turn_rate(&ahead.state, self.gyro);
        let until = at.min(self.time + self.config.max_prediction);
        while time < until {
            let next = imu.next_after(time).filter(|_| self.has_imu).map_or(until, |next| next.min(until));
            let dt = (next - time).secs_f64();
            let motion = match imu.mean_between(time, next).filter(|_| self.has_imu) {
                Some(mean) => {
                    turn_rate = self.turn_rate(&ahead.state, mean.gyro);
                    MotionModel::Inertial { gyro: mean.gyro, specific_force: mean.specific_force }
                }
                None if self.has_imu => break,
                None => MotionModel::DecayingVelocity(self.noise.decay),
            };
            ahead.state = motion.propagate_mean(&ahead.state, dt);
            time = next;
        }
        Estimate { turn_rate, ..self.estimate_of(&ahead, at) }
    }

    /// Turn rate of the base, rad/s, base frame, for a reading of the gyroscope.
    fn turn_rate(&self, state: &State, gyro: Vector3) -> Vector3 {
        let gyro = if self.has_imu { gyro } else { Vector3::zeros() };
        self.body_from_base.isometry().rotation.inverse() * (gyro - state.gyro_bias)
    }

    /// The estimate at the present.
    pub fn estimate(&self) -> Estimate {
        self.estimate_of(&self.filter, self.time)
    }

    /// The motion of the base that a filter estimates.
    fn estimate_of(&self, filter: &ErrorStateFilter, stamp: Stamp) -> Estimate {
        let body_from_base = self.body_from_base.isometry();
        let state = &filter.state;
        let odom_from_base = state.odom_from_body * body_from_base;
        let turn_rate = self.turn_rate(state, self.gyro);
        let body_velocity = state.odom_from_body.rotation.inverse() * state.velocity;
        let body_rate = body_from_base.rotation * turn_rate;
        let base_velocity = body_velocity + body_rate.cross(&body_from_base.translation.vector);
        // Maps an error of the body's pose to one of the base's pose.
        let adjoint = se3::adjoint(self.body_from_base.inverse().isometry());
        let pose: Matrix6 = filter.covariance.fixed_view::<6, 6>(0, 0).into();
        Estimate {
            stamp,
            odom_from_base,
            velocity: body_from_base.rotation.inverse() * base_velocity,
            turn_rate,
            covariance: adjoint * pose * adjoint.transpose() + self.covariance_inflation,
            covariance_inflation: self.covariance_inflation,
        }
    }
}
