//! The running estimate: propagates to the end of each scan, registers the scan with the local map, and decides when tracking is
//! lost.

use crate::config::OdometryConfig;
use crate::event::{DeskewedScan, Estimate, Finding, OdometryEvent, PoseEvent, RegistrationReport, Started};
use crate::findings;
use crate::initial_alignment::{InitialAlignment, level_from_body};
use crate::local_map::{DownsampledPoints, LocalMap, PriorQuality, ScanFit};
use crate::reinitialiser::Reinitialiser;
use crate::state::{ErrorVector, State};
use crate::state_propagator::{Queues, Stamped, StartingPose, StatePropagator};
use crate::sweep::Sweep;
use geometry::{Base, Body, Isometry, Matrix6, Rotation, Transform, Vector3, se3, so3};
use registration::degenerate_directions;
use std::sync::Arc;
use vocab::{Span, Stamp};

/// The running estimate.
#[derive(Clone, Debug)]
pub struct ScanTracker {
    config: OdometryConfig,
    propagator: StatePropagator,
    map: LocalMap,
    /// Pose of the body at the end of the last scan.
    last_scan: Option<Stamped<Isometry>>,
    /// Pose of the body at the middle of the last accepted scan.
    last_middle: Option<Stamped<Isometry>>,
    /// Pose of the body at the end of the last scan that entered the map.
    last_inserted: Option<Stamped<Isometry>>,
    /// Number of scans since the map was begun.
    scans: usize,
    reinitialiser: Reinitialiser,
    /// Start of the first of the latest consecutive scans that had enough points and were rejected.
    rejected_since: Option<Stamp>,
    /// Since when the estimate has been far faster than the legs.
    runaway_since: Option<Stamp>,
    /// Whether the covariance has been inflated since the last scan that entered the map.
    is_inflated: bool,
    /// Whether the robot was carried since then. The leg velocities were wrong then, and so are the filter's estimates from them.
    was_carried: bool,
    /// Whether legs and IMU have been consistent since then.
    is_dead_reckoning_consistent: bool,
    /// The pose at which to begin anew, once tracking is lost with an IMU. Velocity and gravity of the filter are wrong then.
    restart_pose: Option<StartingPose>,
    /// Running mean of the share of inliers of sweeps that were registered in parts; 0 before the first.
    typical_inlier_share: f64,
    downsampled: DownsampledPoints,
    deskewed: Vec<[f32; 3]>,
}

/// Result of a scan or a part of one.
#[derive(Clone, Copy, Debug, Default)]
struct RegistrationOutcome {
    report: RegistrationReport,
    /// Information of the points that were used.
    information: Matrix6,
}

/// Region in which the pose of a scan is searched for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SearchScope {
    /// Within centimetres of its prediction.
    Prediction,
    /// Anywhere, if the prediction may be wrong.
    Anywhere,
}

/// A downsampled scan at its registered pose.
#[derive(Clone, Debug)]
struct RegisteredScan {
    scan: DownsampledPoints,
    odom_from_body: Isometry,
    /// Whether it was fitted to the map.
    is_fitted: bool,
    /// Standard deviation of its points about planes of the map, metres; none if it was not fitted, or without planes.
    plane_deviation_m: Option<f64>,
    /// Whether it may enter the map.
    is_insertable: bool,
}

impl ScanTracker {
    /// Begins with gravity and gyroscope bias of the initial alignment.
    pub fn with_imu(
        config: &OdometryConfig,
        begin: Stamp,
        alignment: &InitialAlignment,
        initial: &StartingPose,
        out: &mut Vec<OdometryEvent>,
    ) -> Self {
        // With an IMU, the body is the IMU.
        let body_from_base = Transform::new(*config.mounting.base_from_imu.inverse().isometry());
        let rotation = level_from_body(&alignment.up, &body_from_base.isometry().rotation);
        let is_stationary = alignment.is_stationary;
        let gyro_bias = if is_stationary { alignment.turn_rate } else { Vector3::zeros() };
        let deviations = config.initial_alignment.deviations_with_imu(is_stationary);
        let gravity = -alignment.up;
        out.push(OdometryEvent::Started(Started { stamp: begin, gravity, gyro_bias, is_stationary }));
        let mut tracker = Self::new(config, begin, body_from_base, initial, rotation, &deviations);
        tracker.propagator.has_imu = true;
        tracker.propagator.filter.state.gyro_bias = gyro_bias;
        tracker
    }

    /// Begins level at the base, with unknown velocity.
    pub fn without_imu(
        config: &OdometryConfig,
        begin: Stamp,
        initial: &StartingPose,
        out: &mut Vec<OdometryEvent>,
    ) -> Self {
        let deviations = config.initial_alignment.deviations_without_imu();
        let unknown = Vector3::zeros();
        out.push(OdometryEvent::Started(Started {
            stamp: begin,
            gravity: unknown,
            gyro_bias: unknown,
            is_stationary: false,
        }));
        Self::new(config, begin, Transform::identity(), initial, Rotation::identity(), &deviations)
    }

    fn new(
        config: &OdometryConfig,
        begin: Stamp,
        body_from_base: Transform<Body, Base>,
        initial: &StartingPose,
        level_from_body: Rotation,
        deviations: &ErrorVector,
    ) -> Self {
        Self {
            config: *config,
            propagator: StatePropagator::new(
                config,
                begin,
                body_from_base,
                initial,
                level_from_body,
                deviations,
            ),
            map: LocalMap::new(config.local_map),
            last_scan: None,
            last_middle: None,
            last_inserted: None,
            scans: 0,
            reinitialiser: Reinitialiser::new(config.reinitialiser),
            rejected_since: None,
            runaway_since: None,
            is_inflated: false,
            was_carried: false,
            is_dead_reckoning_consistent: true,
            restart_pose: None,
            typical_inlier_share: 0.0,
            downsampled: DownsampledPoints::default(),
            deskewed: Vec::new(),
        }
    }

    /// What propagates the estimate between scans.
    pub fn propagator(&self) -> &StatePropagator {
        &self.propagator
    }

    /// End of the newest scan processed.
    pub fn last_scan_end(&self) -> Option<Stamp> {
        self.last_scan.map(|last| last.stamp)
    }

    /// The pose at which the estimate has to begin anew from gravity on, if tracking is lost.
    pub fn restart_pose(&self) -> Option<StartingPose> {
        self.restart_pose
    }

    /// Bytes of the local map.
    pub fn map_bytes(&self) -> usize {
        self.map.gaussians().bytes()
    }

    /// Surface elements of the local map.
    pub fn surfels(&self) -> Vec<([f64; 3], [f32; 3])> {
        self.map.gaussians().surfels()
    }

    /// Propagates to a stamp without a scan.
    pub fn advance(&mut self, to: Stamp, queues: &mut Queues) {
        self.propagate(to, queues);
        self.discard_old_poses();
    }

    /// Propagates to a stamp. During a LiDAR outage only legs and IMU measure the motion; if they contradict each other, the pose is
    /// unknown.
    fn propagate(&mut self, to: Stamp, queues: &mut Queues) {
        self.propagator.advance(to, queues);
        self.is_dead_reckoning_consistent &= self.propagator.has_consistent_legs();
        if self.is_lidar_outage(to) && self.propagator.is_carried() {
            self.was_carried = true;
            self.inflate_covariance_once();
        }
    }

    fn discard_old_poses(&mut self) {
        self.propagator.table.discard_before(self.propagator.time() - self.config.tracking.pose_history);
    }

    /// Whether no scan has entered the map for so long that the robot may be elsewhere.
    fn is_lidar_outage(&self, now: Stamp) -> bool {
        let outage_after = self.config.tracking.outage_after;
        self.propagator.has_imu && self.last_inserted.is_some_and(|last| now - last.stamp > outage_after)
    }

    /// Inflates the covariance, once between two scans that enter the map.
    fn inflate_covariance_once(&mut self) {
        if !std::mem::replace(&mut self.is_inflated, true) {
            self.propagator.inflate_covariance();
        }
    }

    /// Processes a scan and publishes the pose at its end.
    pub fn insert_scan(
        &mut self,
        mut sweep: Sweep,
        queues: &mut Queues,
        out: &mut Vec<OdometryEvent>,
        findings: &mut Vec<Finding>,
    ) {
        let is_whole = self.propagator.has_imu
            || !sweep.has_times
            || self.scans < self.config.tracking.first_whole_sweeps;
        let outcome = if is_whole {
            self.track_sweep(&sweep, self.config.local_map.target_points, queues)
        } else {
            self.track_without_imu(&sweep, queues)
        };
        if self.propagator.has_imu && !outcome.report.rejected {
            findings.extend(self.compare_rotations(&sweep));
        }
        self.scans += 1;
        findings.extend(self.restart_if_lost(&sweep, &outcome.report));
        self.publish(&mut sweep, &outcome, out);
        self.discard_old_poses();
    }

    /// Whether a downsampled scan has enough points to be registered.
    fn has_points(&self) -> bool {
        self.downsampled.coarse.len() >= self.config.local_map.information.min_points
    }

    /// Gives up the local map if tracking is lost: no scan has fitted for long, the robot was carried during an outage, or the
    /// velocity has diverged. A LiDAR that measures nothing is no reason: the map is still valid when it measures again.
    fn restart_if_lost(&mut self, sweep: &Sweep, report: &RegistrationReport) -> Option<Finding> {
        // Without points, the estimate does not begin anew. A person may still be carrying the robot, and gravity cannot be measured then.
        let has_points = self.has_points();
        let rejected_since =
            (has_points && report.rejected).then(|| self.rejected_since.unwrap_or(sweep.start));
        self.rejected_since = rejected_since;
        let lost_after = self.config.tracking.lost_after;
        let is_lost = rejected_since.is_some_and(|since| self.was_carried || sweep.end - since >= lost_after);
        let is_runaway = self.is_velocity_runaway(sweep.end) && has_points;
        if !is_lost && !is_runaway {
            return None;
        }
        if self.propagator.has_imu {
            self.restart_pose = Some(self.compute_restart_pose());
            return Some(findings::tracking_lost());
        }
        self.propagator.inflate_covariance();
        self.map = LocalMap::new(self.config.local_map);
        self.reinitialiser = Reinitialiser::new(self.config.reinitialiser);
        (self.typical_inlier_share, self.scans, self.rejected_since) = (0.0, 0, None);
        Some(findings::tracking_lost())
    }

    /// Whether the estimate has been far faster than the legs for a while. Where a LiDAR hardly observes the motion, as along a
    /// corridor, scans follow a wrong velocity.
    fn is_velocity_runaway(&mut self, now: Stamp) -> bool {
        let config = self.config.tracking;
        let excess = self.propagator.speed_above_legs().filter(|_| self.propagator.has_imu);
        let is_fast = excess.is_some_and(|excess| excess > config.max_speed_above_legs_m_s);
        self.runaway_since = if is_fast { self.runaway_since.or(Some(now)) } else { None };
        self.runaway_since.is_some_and(|since| now - since >= config.runaway_after)
    }

    /// The most probable pose of a robot that has lost tracking: the propagated one, or the last one that was registered if the
    /// propagated velocity is not believable.
    fn compute_restart_pose(&self) -> StartingPose {
        let now = self.propagator.estimate();
        let registered =
            self.last_inserted.map(|last| last.value * self.propagator.body_from_base.isometry());
        let odom_from_base = match registered {
            Some(pose) if now.velocity.norm() > self.config.tracking.max_believable_speed_m_s => pose,
            _ => now.odom_from_base,
        };
        let covariance_inflation = if self.is_inflated {
            self.propagator.present_covariance()
        } else {
            self.propagator.inflated_covariance()
        };
        StartingPose { odom_from_base, covariance_inflation }
    }

    /// Processes a sweep without an IMU: in parts, or whole if a part does not fit as parts usually do.
    fn track_without_imu(&mut self, sweep: &Sweep, queues: &mut Queues) -> RegistrationOutcome {
        let before = (self.propagator.clone(), self.last_scan, queues.clone());
        let mut parts = Vec::with_capacity(self.config.tracking.sweep_parts);
        let outcome = match self.track_parts(sweep, queues, &mut parts) {
            Some(outcome) => {
                for part in &parts {
                    self.insert_into_map(part);
                }
                outcome
            }
            None => {
                (self.propagator, self.last_scan, *queues) = before;
                self.track_sweep(sweep, self.config.local_map.target_points, queues)
            }
        };
        self.deskew(sweep);
        outcome
    }

    /// Registers a sweep part by part, each as a small scan. `None` as soon as one does not fit. The registered parts are appended to
    /// `parts`.
    fn track_parts(
        &mut self,
        sweep: &Sweep,
        queues: &mut Queues,
        parts: &mut Vec<RegisteredScan>,
    ) -> Option<RegistrationOutcome> {
        let config = self.config.tracking;
        let target_points = self.config.local_map.target_points / config.sweep_parts;
        let mut whole = RegistrationOutcome::default();
        for index in 0..config.sweep_parts {
            let part = sweep.part(index, config.sweep_parts);
            let (RegistrationOutcome { report, information }, registered) =
                self.register(&part, target_points, queues, SearchScope::Prediction);
            let min_inlier_share = config.min_part_inlier_ratio * self.typical_inlier_share;
            if report.rejected || report.inlier_share < min_inlier_share {
                return None;
            }
            parts.push(registered);
            whole.information += information;
            let before = whole.report;
            whole.report = RegistrationReport {
                points_used: before.points_used + report.points_used,
                matched: before.matched + report.matched,
                inlier_share: before.inlier_share + report.inlier_share / config.sweep_parts as f64,
                iterations: before.iterations + report.iterations,
                searched: before.searched || report.searched,
                ..report
            };
        }
        let rate = if self.typical_inlier_share > 0.0 { config.inlier_share_learning_rate } else { 1.0 };
        self.typical_inlier_share += (whole.report.inlier_share - self.typical_inlier_share) * rate;
        Some(whole)
    }

    /// Registers a whole sweep with about `target_points` points and adds it to the map.
    fn track_sweep(
        &mut self,
        sweep: &Sweep,
        target_points: usize,
        queues: &mut Queues,
    ) -> RegistrationOutcome {
        let (outcome, registered) = self.register(sweep, target_points, queues, SearchScope::Anywhere);
        self.insert_into_map(&registered);
        outcome
    }

    /// Adds a registered scan to the map if it is good enough.
    fn insert_into_map(&mut self, registered: &RegisteredScan) {
        let RegisteredScan { scan, odom_from_body, is_fitted, plane_deviation_m, is_insertable } = registered;
        if let Some(deviation_m) = plane_deviation_m {
            self.map.adapt_plane_thickness(*deviation_m);
        }
        if *is_fitted {
            self.reinitialiser.update_typical_score(&self.map, scan, odom_from_body);
        }
        if *is_insertable {
            self.map.insert(scan, odom_from_body);
            self.last_inserted = self.last_scan;
            self.is_inflated = false;
            self.was_carried = false;
            self.is_dead_reckoning_consistent = true;
        }
    }

    /// Propagates the estimate to the end of a sweep, or of a part of one, and corrects it by the points.
    fn register(
        &mut self,
        sweep: &Sweep,
        target_points: usize,
        queues: &mut Queues,
        scope: SearchScope,
    ) -> (RegistrationOutcome, RegisteredScan) {
        let config = self.config.tracking;
        self.propagate(sweep.end, queues);
        let prior = self.propagator.filter.state.odom_from_body;
        let passes = if self.propagator.has_imu || !sweep.has_times { 1 } else { config.part_passes };
        let mut fitted = None;
        for pass in 0..passes {
            self.deskew(sweep);
            let body_from_base = self.propagator.body_from_base;
            let base_from_lidar = self.config.mounting.base_from_lidar;
            self.map.downsample(
                &self.deskewed,
                target_points,
                &body_from_base,
                &base_from_lidar,
                &mut self.downsampled,
            );
            fitted = self.fit(sweep, fitted, scope);
            let Some(ScanFit { state, .. }) = fitted else { break };
            if pass + 1 < passes {
                self.use_registered_motion(sweep, &state);
            }
        }
        let accepted = fitted.filter(|fitted| !fitted.report.rejected && !self.was_carried);
        let mut report = fitted.map(|fitted| fitted.report).unwrap_or_default();
        report.rejected = accepted.is_none() && !self.map.gaussians().is_empty();
        if let Some(fitted) = accepted {
            let filter = &self.propagator.filter;
            let is_surprising = self.is_lidar_outage(sweep.end)
                && !filter.is_within_gate(&fitted.state.odom_from_body, config.outage_gate_deviations);
            self.propagator.filter.correct_pose(fitted.state, &fitted.information);
            // The scan fits the map somewhere, but legs and IMU contradict: it may be another place that looks alike.
            if is_surprising {
                self.inflate_covariance_once();
            }
        }
        let posterior = self.propagator.filter.state.odom_from_body;
        if passes > 1 {
            self.propagator.table.set_last(posterior);
        } else {
            self.propagator.table.apply_correction(&(posterior * prior.inverse()));
        }
        self.last_scan = Some(Stamped { stamp: sweep.end, value: posterior });
        self.propagator.is_imprecise = false;
        let min_points = self.config.local_map.information.min_points;
        let registered = RegisteredScan {
            is_insertable: self.downsampled.fine.len() >= min_points && !report.rejected,
            scan: self.downsampled.clone(),
            odom_from_body: posterior,
            is_fitted: accepted.is_some(),
            plane_deviation_m: accepted.and_then(|fitted| fitted.plane_deviation_m),
        };
        let information = accepted.map_or_else(Matrix6::zeros, |fitted| fitted.information);
        (RegistrationOutcome { report, information }, registered)
    }

    /// Corrects a sweep for the motion during it.
    fn deskew(&mut self, sweep: &Sweep) {
        let base_from_lidar = &self.config.mounting.base_from_lidar;
        sweep.deskew(
            &self.propagator.table,
            base_from_lidar,
            &self.propagator.body_from_base,
            &mut self.deskewed,
        );
    }

    /// Fits the downsampled scan to the map. `None` if it has too few points or there is no map yet. `previous` is the result of the
    /// last pass.
    fn fit(&mut self, sweep: &Sweep, previous: Option<ScanFit>, scope: SearchScope) -> Option<ScanFit> {
        if !self.has_points() || self.map.gaussians().is_empty() {
            return None;
        }
        let mut start = previous.map_or(self.propagator.filter.state, |fitted| fitted.state);
        let is_outage = self.is_lidar_outage(sweep.end);
        let is_prediction_good = self.propagator.has_imu && !self.propagator.is_imprecise && !is_outage;
        if scope == SearchScope::Prediction || is_prediction_good {
            return Some(self.fit_from(start, PriorQuality::Tight));
        }
        let compare_after = self.config.tracking.compare_starts_after;
        let is_long_ago = self.last_scan.is_some_and(|last| sweep.end - last.stamp > compare_after);
        let mut searched = previous.is_some_and(|fitted| fitted.report.searched);
        if !(is_long_ago && previous.is_none()) {
            let fitted = self.fit_from(start, PriorQuality::Loose);
            let fits = if is_outage {
                self.is_plausible(&fitted)
            } else {
                let found = &fitted.state.odom_from_body;
                self.reinitialiser.is_typical_fit(&self.map, &self.downsampled, found)
            };
            if previous.is_some() || (fits && !fitted.report.rejected) {
                return Some(fitted);
            }
        }
        if let Some(last) = self.last_scan {
            let predicted = start.odom_from_body;
            let candidates = [predicted, last.value, se3::interpolate(&last.value, &predicted, 0.5)];
            let found = self.reinitialiser.find_start(&self.map, &self.downsampled, &candidates);
            start.odom_from_body = found.map_from_body;
            searched |= found.searched;
        }
        let mut fitted = self.fit_from(start, PriorQuality::Loose);
        fitted.report.searched = searched;
        fitted.report.rejected |= is_outage && !self.is_plausible(&fitted);
        Some(fitted)
    }

    /// Registers the downsampled scan, and rejects the result if too many points lie off their surfaces.
    fn fit_from(&self, start: State, prior_quality: PriorQuality) -> ScanFit {
        let mut fitted = self.map.fit(&self.propagator.filter, start, &self.downsampled, prior_quality);
        let report = &mut fitted.report;
        let matched_share = report.matched as f64 / report.points_used.max(1) as f64;
        let config = &self.config.tracking;
        report.rejected =
            report.inlier_share < config.min_inlier_share && matched_share > config.min_matched_share;
        fitted
    }

    /// Whether a scan after a LiDAR outage fits well enough where it was found.
    fn is_plausible(&mut self, fitted: &ScanFit) -> bool {
        let config = self.config.tracking;
        let found = &fitted.state.odom_from_body;
        if !self.propagator.filter.is_within_gate(found, config.outage_gate_deviations) {
            return self.reinitialiser.is_confident_fit(&self.map, &self.downsampled, found);
        }
        let RegistrationReport { matched, points_used, inlier_share, .. } = fitted.report;
        let is_new_area = (matched as f64) < config.max_new_area_matched_share * points_used as f64;
        let is_known_area = inlier_share >= config.min_known_area_inlier_share;
        (self.is_dead_reckoning_consistent && (is_new_area || is_known_area))
            || self.reinitialiser.is_typical_fit(&self.map, &self.downsampled, found)
    }

    /// Without an IMU, replaces the motion during the sweep by the one that its registration implies.
    fn use_registered_motion(&mut self, sweep: &Sweep, state: &State) {
        let from = sweep.start.min(self.last_scan_end().unwrap_or(sweep.start));
        self.propagator.table.make_uniform(from, sweep.end);
        self.propagator.table.set_last(state.odom_from_body);
    }

    /// Compares the rotation between the middles of the last two scans with the gyroscope's.
    fn compare_rotations(&mut self, sweep: &Sweep) -> Option<Finding> {
        let middle = sweep.start + Span::from_nanos((sweep.end - sweep.start).nanos() / 2);
        let pose = Stamped { stamp: middle, value: self.propagator.table.at(middle)? };
        let last = self.last_middle.replace(pose)?;
        let rotation = so3::log(&(last.value.rotation.inverse() * pose.value.rotation));
        self.propagator.consistency.insert_rotation(last.stamp, middle, rotation)
    }

    fn publish(&self, sweep: &mut Sweep, outcome: &RegistrationOutcome, out: &mut Vec<OdometryEvent>) {
        let state = &self.propagator.filter.state;
        let estimate = self.propagator.estimate();
        let body_from_base = self.propagator.body_from_base.isometry();
        let odom_from_body_at_scan = self.propagator.table.at(sweep.stamp).unwrap_or(state.odom_from_body);
        let base_from_body = body_from_base.rotation.inverse();
        let degenerate_directions =
            degenerate_directions(&outcome.information, self.config.tracking.degenerate_deviation_m)
                .map(|direction| direction.map(|axis| base_from_body * axis));
        out.push(OdometryEvent::Pose(Box::new(PoseEvent {
            estimate,
            scan_stamp: sweep.stamp,
            odom_from_base_at_scan: odom_from_body_at_scan * body_from_base,
            degenerate_directions,
            registration: outcome.report,
            is_gravity_measured: self.propagator.has_imu,
            is_dead_reckoned: outcome.report.rejected || !self.has_points(),
            gyro_bias: state.gyro_bias,
            accel_bias: state.accel_bias,
            leg_scale: state.leg_scale,
        })));
        out.push(OdometryEvent::Scan(DeskewedScan {
            stamp: sweep.end,
            odom_from_base: estimate.odom_from_base,
            xyz: Arc::new(self.deskewed.clone()),
            intensity: Arc::new(sweep.take_intensity()),
        }));
    }

    /// The estimate at an instant, propagated from the present through the waiting readings.
    pub fn predict(&self, at: Stamp, queues: &Queues) -> Estimate {
        self.propagator.predict(at, &queues.imu)
    }
}
