//! The running estimate: carries the filter through time and takes scans in.

use crate::agreement::Agreement;
use crate::config::OdometryConfig;
use crate::event::{CorrectedScan, Estimate, Finding, OdometryEvent, PoseEvent, Started};
use crate::filter::Filter;
use crate::imu_queue::ImuQueue;
use crate::local_map::{Fitted, LocalMap, MIN_POINTS, Prediction, Thinned};
use crate::motion::Motion;
use crate::pose_table::PoseTable;
use crate::recovery::Recovery;
use crate::startup::{Bearing, level};
use crate::state::{
    ACCEL_BIAS, DIMENSION, ErrorVector, GRAVITY, GYRO_BIAS, LEG_SCALE, POSITION, ROTATION, State, VELOCITY,
};
use crate::sweep::Sweep;
use crate::velocity::VelocityMeasurement;
use geometry::{Isometry, Matrix6, Vector3, se3, so3};
use registration::blind_directions;
use std::collections::VecDeque;
use std::sync::Arc;
use vocab::{Span, Stamp};

/// Share of matched points that must lie on their surfaces for a scan to count.
const INLIERS_MIN: f64 = 0.35;
/// A direction with a larger standard deviation than this is told to be degenerate, metres.
const BLIND_DEVIATION: f64 = 0.03;
/// Poses older than this before the present are forgotten.
const TABLE_KEPT: Span = Span::from_millis(400);
/// Passes of correction and registration while the motion during the sweep is known from the scan itself only.
const COAST_PASSES: usize = 3;

/// Noise of readings at the end of their range, per √Hz: rad/s and m/s².
const SATURATED_GYRO: f64 = 0.3;
const SATURATED_ACCEL: f64 = 5.0;

/// Something with its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timed<T> {
    /// When.
    pub stamp: Stamp,
    /// What.
    pub value: T,
}

/// The running estimate.
#[derive(Clone, Debug)]
pub struct Tracker {
    config: OdometryConfig,
    body_from_base: Isometry,
    filter: Filter,
    time: Stamp,
    /// Whether an IMU carries the motion now.
    inertial: bool,
    /// The gyroscope's bias while the IMU is silent.
    bias_kept: Option<Vector3>,
    agreement: Agreement,
    /// Latest turn rate as the gyroscope read it, rad/s.
    gyro: Vector3,
    table: PoseTable,
    map: LocalMap,
    last_scan: Option<Timed<Isometry>>,
    last_middle: Option<Timed<Isometry>>,
    last_legs: Option<Stamp>,
    last_external: Option<Timed<Isometry>>,
    recovery: Recovery,
    thinned: Thinned,
    corrected: Vec<[f32; 3]>,
    share: Vec<f32>,
}

impl Tracker {
    /// Starts with gravity and bias from the first second.
    pub fn with_imu(
        config: &OdometryConfig,
        begin: Stamp,
        bearing: &Bearing,
        out: &mut Vec<OdometryEvent>,
    ) -> Self {
        let body_from_base = config.mounting.base_from_imu.inverse();
        let rotation = level(&bearing.up, &body_from_base.rotation);
        let gyro_bias = if bearing.still { bearing.rate } else { Vector3::zeros() };
        let mut deviations = deviations(1e-4);
        let (velocity, rate, tilt) = if bearing.still { (0.01, 1e-3, 0.1) } else { (1.0, 2e-2, 0.6) };
        set(&mut deviations, VELOCITY, velocity);
        set(&mut deviations, GYRO_BIAS, rate);
        set(&mut deviations, ACCEL_BIAS, 0.1);
        deviations[GRAVITY] = tilt;
        deviations[GRAVITY + 1] = tilt;
        out.push(OdometryEvent::Started(Started {
            stamp: begin,
            gravity: -bearing.up,
            gyro_bias,
            still: bearing.still,
        }));
        let mut tracker = Self::new(config, begin, body_from_base, rotation, &deviations);
        tracker.inertial = true;
        tracker.filter.state.gyro_bias = gyro_bias;
        tracker
    }

    /// Starts level at the base, with any velocity.
    pub fn without_imu(config: &OdometryConfig, begin: Stamp, out: &mut Vec<OdometryEvent>) -> Self {
        let mut deviations = deviations(1e-4);
        set(&mut deviations, VELOCITY, 5.0);
        set(&mut deviations, GYRO_BIAS, 1.0);
        out.push(OdometryEvent::Started(Started {
            stamp: begin,
            gravity: Vector3::zeros(),
            gyro_bias: Vector3::zeros(),
            still: false,
        }));
        Self::new(config, begin, Isometry::identity(), geometry::Rotation::identity(), &deviations)
    }

    fn new(
        config: &OdometryConfig,
        begin: Stamp,
        body_from_base: Isometry,
        rotation: geometry::Rotation,
        deviations: &ErrorVector,
    ) -> Self {
        // The base starts at the origin.
        let odom_from_base =
            Isometry::from_parts(Vector3::zeros().into(), rotation * body_from_base.rotation);
        let odom_from_body = odom_from_base * body_from_base.inverse();
        let mut table = PoseTable::default();
        table.restart(begin, odom_from_body);
        Self {
            config: *config,
            body_from_base,
            filter: Filter::new(State::at(odom_from_body), deviations),
            time: begin,
            inertial: false,
            bias_kept: None,
            agreement: Agreement::default(),
            gyro: Vector3::zeros(),
            table,
            map: LocalMap::new(config),
            last_scan: None,
            last_middle: None,
            last_legs: None,
            last_external: None,
            recovery: Recovery::default(),
            thinned: Thinned::default(),
            corrected: Vec::new(),
            share: Vec::new(),
        }
    }

    /// The present of the filter.
    pub fn time(&self) -> Stamp {
        self.time
    }

    /// End of the newest scan taken in.
    pub fn last_scan_end(&self) -> Option<Stamp> {
        self.last_scan.map(|last| last.stamp)
    }

    /// Newest leg velocity taken in.
    pub fn last_legs(&self) -> Option<Stamp> {
        self.last_legs
    }

    /// Newest external pose taken in.
    pub fn last_external(&self) -> Option<Stamp> {
        self.last_external.map(|last| last.stamp)
    }

    /// Bytes of the local map.
    pub fn map_bytes(&self) -> usize {
        self.map.gaussians().bytes()
    }

    /// Surface elements of the local map.
    pub fn surfels(&self) -> Vec<([f64; 3], [f32; 3])> {
        self.map.gaussians().surfels()
    }

    /// Carries the filter to a stamp, through every message on the way.
    pub fn advance(
        &mut self,
        to: Stamp,
        imu: &mut ImuQueue,
        legs: &mut VecDeque<Timed<Vector3>>,
        external: &mut VecDeque<Timed<Isometry>>,
    ) {
        while self.time < to {
            let expected = self.inertial || self.bias_kept.is_some();
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
                imu.forget_before(next);
            }
            while legs.front().is_some_and(|legs| legs.stamp <= next) {
                if let Some(measured) = legs.pop_front() {
                    self.take_legs(&measured);
                }
            }
            while external.front().is_some_and(|external| external.stamp <= next) {
                if let Some(measured) = external.pop_front() {
                    self.take_external(&measured);
                }
            }
        }
    }

    /// One step of propagation, to the next instant at which anything is known.
    fn step(&mut self, to: Stamp, imu: &ImuQueue, twist: Option<Motion>) {
        let dt = (to - self.time).secs_f64();
        let expected = self.inertial || self.bias_kept.is_some();
        let readings = if expected { imu.mean(self.time, to) } else { None };
        self.hand_over(readings.is_some());
        let mut noise = self.config.noise;
        let motion = match (readings, twist) {
            (Some(mean), _) => {
                self.gyro = mean.gyro;
                noise.gyro *= self.agreement.doubt();
                if mean.saturated {
                    noise.gyro = SATURATED_GYRO;
                    noise.accel = SATURATED_ACCEL;
                }
                self.agreement.rate(to, dt, &(mean.gyro - self.filter.state.gyro_bias));
                Motion::Inertial { gyro: mean.gyro, specific_force: mean.specific_force }
            }
            (None, Some(twist)) => twist,
            (None, None) => Motion::Coast,
        };
        self.filter.propagate(&motion, dt, &noise);
        self.time = to;
        self.table.push(to, self.filter.state.odom_from_body);
    }

    /// When the IMU falls silent the body goes on as it turned last, and when it speaks again its bias is what it was.
    fn hand_over(&mut self, heard: bool) {
        if heard == self.inertial || (heard && self.bias_kept.is_none()) {
            return;
        }
        if heard {
            self.filter.replace_gyro_bias(self.bias_kept.take().unwrap_or_default(), 2e-3);
        } else {
            let bias = self.filter.state.gyro_bias;
            self.bias_kept = Some(bias);
            self.filter.replace_gyro_bias(bias - self.gyro, 0.5);
        }
        self.inertial = heard;
    }

    fn take_legs(&mut self, measured: &Timed<Vector3>) {
        self.last_legs = Some(measured.stamp);
        let gyro = if self.inertial { self.gyro } else { Vector3::zeros() };
        let measurement = VelocityMeasurement {
            velocity: measured.value,
            body_from_frame: self.body_from_base,
            gyro,
            deviation: self.config.noise.legs,
            scaled: true,
        };
        measurement.apply(&mut self.filter);
    }

    /// Without an IMU, the other odometry's twist between its last pose and its next one carries the motion.
    fn external_twist(&self, next: Option<&Timed<Isometry>>) -> Option<Motion> {
        let (last, next) = (self.last_external.as_ref()?, next?);
        let (turn_rate, velocity) = self.body_twist(last, next)?;
        Some(Motion::Twist { turn_rate, velocity })
    }

    /// Mean turn rate and velocity of the body between two external poses, body frame.
    fn body_twist(&self, last: &Timed<Isometry>, next: &Timed<Isometry>) -> Option<(Vector3, Vector3)> {
        let dt = (next.stamp - last.stamp).secs_f64();
        if dt <= 0.0 || dt > 1.5 {
            return None;
        }
        let body_from_external = self.body_from_base * self.config.mounting.base_from_external;
        let moved = body_from_external * last.value.inverse() * next.value * body_from_external.inverse();
        let turn = so3::log(&moved.rotation);
        // Rotations half-way, as Motion::Twist integrates it.
        let velocity = so3::exp(&(turn * -0.5)) * moved.translation.vector / dt;
        Some((turn / dt, velocity))
    }

    fn take_external(&mut self, measured: &Timed<Isometry>) {
        let last = self.last_external.replace(*measured);
        let Some((turn_rate, velocity)) = last.and_then(|last| self.body_twist(&last, measured)) else {
            return;
        };
        if self.inertial {
            let measurement = VelocityMeasurement {
                velocity: so3::exp(&(turn_rate * -0.05)) * velocity,
                body_from_frame: Isometry::identity(),
                gyro: self.gyro,
                deviation: 0.1 + self.config.noise.external * velocity.norm(),
                scaled: false,
            };
            measurement.apply(&mut self.filter);
        }
    }

    /// Takes a scan in whose end is the present, and tells the pose.
    pub fn take_scan(&mut self, mut sweep: Sweep, out: &mut Vec<OdometryEvent>, findings: &mut Vec<Finding>) {
        let prior = self.filter.state.odom_from_body;
        let base_from_lidar = self.config.mounting.base_from_lidar;
        let passes = if self.inertial || !sweep.timed { 1 } else { COAST_PASSES };
        let mut fitted = None;
        for pass in 0..passes {
            sweep.correct(
                &self.table,
                &base_from_lidar,
                &self.body_from_base,
                &mut self.corrected,
                &mut self.share,
            );
            let mut thinned = std::mem::take(&mut self.thinned);
            self.map.thin(&self.corrected, &self.body_from_base, &mut thinned);
            self.thinned = thinned;
            fitted = self.fit(fitted);
            let Some(Fitted { state, .. }) = fitted else { break };
            if pass + 1 < passes && !self.follow_scan(&sweep, &state) {
                break;
            }
        }
        let accepted = fitted.filter(|fitted| !fitted.report.rejected);
        let mut report = fitted.map(|fitted| fitted.report).unwrap_or_default();
        report.rejected = accepted.is_none() && !self.map.gaussians().is_empty();
        if let Some(fitted) = accepted {
            self.filter.absorb_pose(fitted.state, &fitted.information);
        }
        let posterior = self.filter.state.odom_from_body;
        if passes > 1 {
            self.table.set_last(posterior);
        } else {
            self.table.shift(&(posterior * prior.inverse()));
        }
        if !self.inertial && accepted.is_some() {
            self.recovery.learn(&self.map, &self.thinned, &posterior);
        }
        if self.thinned.fine.len() >= MIN_POINTS && !report.rejected {
            self.map.insert(&self.thinned, &posterior);
        }
        if self.inertial && accepted.is_some() {
            findings.extend(self.compare_turns(&sweep));
        }
        self.tell(&mut sweep, report, accepted.map(|fitted| fitted.information), out);
        self.last_scan = Some(Timed { stamp: sweep.end, value: posterior });
        self.table.forget_before(self.time - TABLE_KEPT);
    }

    /// Whether LiDAR and gyroscope saw the same turn since the last scan.
    fn compare_turns(&mut self, sweep: &Sweep) -> Option<Finding> {
        let middle = sweep.start + Span::from_nanos((sweep.end - sweep.start).nanos() / 2);
        let pose = Timed { stamp: middle, value: self.table.at(middle)? };
        let last = self.last_middle.replace(pose)?;
        let seen = so3::log(&(last.value.rotation.inverse() * pose.value.rotation));
        self.agreement.turn(last.stamp, middle, seen)
    }

    /// Fits the thinned scan; `None` when it has too few points or there is no map yet.
    fn fit(&mut self, previous: Option<Fitted>) -> Option<Fitted> {
        if self.thinned.coarse.len() < MIN_POINTS || self.map.gaussians().is_empty() {
            return None;
        }
        let mut start = previous.map_or(self.filter.state, |fitted| fitted.state);
        let mut searched = previous.is_some_and(|fitted| fitted.report.searched);
        let prediction = if self.inertial { Prediction::Close } else { Prediction::Loose };
        if let (Prediction::Loose, None, Some(last)) = (prediction, previous, &self.last_scan) {
            let guesses =
                [start.odom_from_body, last.value, se3::interpolate(&last.value, &start.odom_from_body, 0.5)];
            let found = self.recovery.best_start(&self.map, &self.thinned, &guesses);
            start.odom_from_body = found.map_from_body;
            searched = found.searched;
        }
        let mut fitted = self.map.fit(&self.filter, start, &self.thinned, prediction);
        let report = &mut fitted.report;
        report.searched = searched;
        let matched = report.matched as f64 / report.points_used as f64;
        report.rejected = report.inlier_share < INLIERS_MIN && matched > 0.3;
        Some(fitted)
    }

    /// Without inertial readings, makes the motion during the sweep the one that the scan itself implies. Says whether
    /// that changed anything.
    fn follow_scan(&mut self, sweep: &Sweep, state: &State) -> bool {
        let before = self.table.at(sweep.end).unwrap_or_default();
        self.table.make_uniform(sweep.start.min(self.last_scan_end().unwrap_or(sweep.start)), sweep.end);
        self.table.set_last(state.odom_from_body);
        se3::local(&before, &state.odom_from_body).norm() > 2e-3
    }

    fn tell(
        &mut self,
        sweep: &mut Sweep,
        registration: crate::event::RegistrationReport,
        information: Option<Matrix6>,
        out: &mut Vec<OdometryEvent>,
    ) {
        let estimate = self.estimate(&self.filter, self.time);
        let odom_from_body_at_scan = self.table.at(sweep.stamp).unwrap_or(self.filter.state.odom_from_body);
        let base_from_body = self.body_from_base.rotation.inverse();
        let degenerate = blind_directions(&information.unwrap_or_else(Matrix6::zeros), BLIND_DEVIATION)
            .map(|direction| direction.map(|axis| base_from_body * axis));
        out.push(OdometryEvent::Pose(Box::new(PoseEvent {
            estimate,
            scan_stamp: sweep.stamp,
            odom_from_base_at_scan: odom_from_body_at_scan * self.body_from_base,
            degenerate,
            registration,
            gyro_bias: self.filter.state.gyro_bias,
            accel_bias: self.filter.state.accel_bias,
            leg_scale: self.filter.state.leg_scale,
        })));
        out.push(OdometryEvent::Scan(CorrectedScan {
            stamp: sweep.end,
            odom_from_base: estimate.odom_from_base,
            xyz: Arc::new(self.corrected.clone()),
            intensity: Arc::new(sweep.take_intensity()),
        }));
    }

    /// The estimate at an instant, carried on from the present by the readings that wait.
    pub fn predict(&self, at: Stamp, imu: &ImuQueue) -> Estimate {
        let mut ahead = self.filter.clone();
        let mut time = self.time;
        let mut turn_rate = self.turn_rate(&ahead.state, self.gyro);
        // Beyond a second nothing carries it.
        let until = at.min(self.time + Span::from_millis(1_000));
        while time < until {
            let next = imu.next_after(time).filter(|_| self.inertial).map_or(until, |next| next.min(until));
            let dt = (next - time).secs_f64();
            let motion = match imu.mean(time, next).filter(|_| self.inertial) {
                Some(mean) => {
                    turn_rate = self.turn_rate(&ahead.state, mean.gyro);
                    Motion::Inertial { gyro: mean.gyro, specific_force: mean.specific_force }
                }
                None if self.inertial => break,
                None => Motion::Coast,
            };
            ahead.state = motion.mean(&ahead.state, dt);
            time = next;
        }
        Estimate { turn_rate, ..self.estimate(&ahead, at) }
    }

    /// Turn rate of the base in its own frame, given what the gyroscope reads.
    fn turn_rate(&self, state: &State, gyro: Vector3) -> Vector3 {
        let gyro = if self.inertial { gyro } else { Vector3::zeros() };
        self.body_from_base.rotation.inverse() * (gyro - state.gyro_bias)
    }

    /// The base's motion as a filter has it.
    fn estimate(&self, filter: &Filter, stamp: Stamp) -> Estimate {
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
            covariance: adjoint * pose * adjoint.transpose(),
        }
    }
}

/// Standard deviations of the parts that every start knows equally well: the pose is the origin by definition.
fn deviations(pose: f64) -> ErrorVector {
    let mut deviations = ErrorVector::repeat(1e-4);
    set(&mut deviations, ROTATION, pose);
    set(&mut deviations, POSITION, pose);
    deviations[LEG_SCALE] = 0.05;
    debug_assert_eq!(LEG_SCALE + 1, DIMENSION);
    deviations
}

fn set(deviations: &mut ErrorVector, first: usize, value: f64) {
    deviations.fixed_rows_mut::<3>(first).fill(value);
}
