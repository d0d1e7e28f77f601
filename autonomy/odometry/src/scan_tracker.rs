//! The running estimate: starts it, and takes scans in.

use crate::config::OdometryConfig;
use crate::event::{DeskewedScan, Estimate, Finding, OdometryEvent, PoseEvent, RegistrationReport, Started};
use crate::findings;
use crate::initial_alignment::{InitialAlignment, level};
use crate::local_map::{DownsampledScan, LocalMap, MIN_POINTS, PriorQuality, ScanFit};
use crate::reinitialiser::Reinitialiser;
use crate::state::{
    ACCEL_BIAS, DIMENSION, ErrorVector, GRAVITY, GYRO_BIAS, LEG_SCALE, POSITION, ROTATION, State, VELOCITY,
};
use crate::state_propagator::{InitialPose, Queues, Stamped, StatePropagator};
use crate::sweep::Sweep;
use geometry::{Isometry, Matrix6, Rotation, Vector3, se3, so3};
use registration::degenerate_directions;
use std::sync::Arc;
use vocab::{Span, Stamp};

/// Share of matched points that must lie on their surfaces for a scan to count.
const INLIERS_MIN: f64 = 0.35;
/// A direction with a larger standard deviation than this is told to be degenerate, metres.
const BLIND_DEVIATION: f64 = 0.03;
/// Poses older than this before the present are forgotten.
const TABLE_KEPT: Span = Span::from_millis(400);
/// Without an IMU a sweep is taken in so many parts, so that the estimate can follow the bounce of a walk.
const COAST_PARTS: usize = 4;
/// The first scans are taken whole: a part needs a map of all that it sees.
const COAST_WHOLE: usize = 8;
/// Passes of correction and registration of each part.
const COAST_PASSES: usize = 2;
/// A part with a smaller share of its points on their surfaces than this part of the usual is not followed: the whole sweep
/// is taken at once then. In a door one part sees nothing but what is new, and fits somewhere by chance.
const COAST_STEADY: f64 = 0.85;
/// Weight of one sweep in the usual share.
const COAST_LEARNING: f64 = 0.05;
/// After so long in which no scan fitted, the local map is begun anew.
const LOST: Span = Span::from_millis(3_000);
/// After so long in which no scan entered the map, one must fit as scans usually do: the robot may be elsewhere.
const DARK: Span = Span::from_millis(1_000);
/// And if that is no more than so many standard deviations from where it is expected, a poorer fit will do.
const EXPECTED: f64 = 4.0;
/// Where legs and IMU agree on the way there, much of what is seen may be new, if there is a share of it at most that is known, or such a
/// share of that lies on its surfaces.
const HARDLY_KNOWN: f64 = 0.1;
const KNOWN_FITS: f64 = 0.5;
/// A robot on legs that seems to be faster than this does not know how it moves, m/s; nor does one that seems to be faster than its legs by
/// so much for so long.
const FASTEST: f64 = 3.0;
const TOO_FAST: Span = Span::from_millis(1_000);
/// After so long without a scan, guesses are compared before one is followed.
const LONG_AGO: Span = Span::from_millis(150);

/// The running estimate.
#[derive(Clone, Debug)]
pub struct ScanTracker {
    config: OdometryConfig,
    propagator: StatePropagator,
    map: LocalMap,
    last_scan: Option<Stamped<Isometry>>,
    last_middle: Option<Stamped<Isometry>>,
    /// The last scan that entered the map.
    last_inserted: Option<Stamped<Isometry>>,
    /// Scans taken in.
    scans: usize,
    reinitialiser: Reinitialiser,
    /// Start of the first of the scans, all to the last, that had enough points and did not fit.
    lost_since: Option<Stamp>,
    /// Since when the body has seemed to be far faster than the legs.
    fast_since: Option<Stamp>,
    /// Whether the way since the last scan that entered the map has been booked as a guess.
    covariance_inflation: bool,
    /// Whether somebody carried the robot meanwhile: the legs were wrong, and with them all that they taught the filter.
    carried: bool,
    /// Whether legs and IMU have known the way since then.
    is_dead_reckoning_consistent: bool,
    /// Where to begin anew: the filter's velocity and sense of gravity are not to be believed any more.
    tracking_lost: Option<InitialPose>,
    /// Share of points that lie on their surfaces when sweeps are taken in parts and all is well.
    typical_inlier_share: f64,
    downsampled: DownsampledScan,
    deskewed: Vec<[f32; 3]>,
}

/// What came of a scan or a part of one.
#[derive(Clone, Copy, Debug, Default)]
struct RegistrationOutcome {
    report: RegistrationReport,
    /// Of what was used.
    information: Matrix6,
}

/// Where a scan may lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SearchScope {
    /// Where it is expected, to centimetres.
    Near,
    /// Perhaps elsewhere.
    Anywhere,
}

/// A thinned scan and where it was found to lie.
#[derive(Clone, Debug)]
struct RegisteredScan {
    downsampled: DownsampledScan,
    odom_from_body: Isometry,
    /// Whether it was fitted to the map.
    fitted: bool,
    /// Whether it may enter the map.
    worth: bool,
}

impl ScanTracker {
    /// Starts with gravity and bias from the first second.
    pub fn with_imu(
        config: &OdometryConfig,
        begin: Stamp,
        initial_alignment: &InitialAlignment,
        origin: &InitialPose,
        out: &mut Vec<OdometryEvent>,
    ) -> Self {
        let body_from_base = config.mounting.base_from_imu.inverse();
        let rotation = level(&initial_alignment.up, &body_from_base.rotation);
        let gyro_bias = if initial_alignment.still { initial_alignment.rate } else { Vector3::zeros() };
        let mut deviations = deviations(1e-4);
        let (velocity, rate, tilt) =
            if initial_alignment.still { (0.01, 1e-3, 0.1) } else { (1.0, 2e-2, 0.6) };
        set(&mut deviations, VELOCITY, velocity);
        set(&mut deviations, GYRO_BIAS, rate);
        set(&mut deviations, ACCEL_BIAS, 0.1);
        deviations[GRAVITY] = tilt;
        deviations[GRAVITY + 1] = tilt;
        let (gravity, still) = (-initial_alignment.up, initial_alignment.still);
        out.push(OdometryEvent::Started(Started { stamp: begin, gravity, gyro_bias, still }));
        let mut tracker = Self::new(config, begin, body_from_base, origin, rotation, &deviations);
        tracker.propagator.has_imu = true;
        tracker.propagator.filter.state.gyro_bias = gyro_bias;
        tracker
    }

    /// Starts level at the base, with any velocity.
    pub fn without_imu(
        config: &OdometryConfig,
        begin: Stamp,
        origin: &InitialPose,
        out: &mut Vec<OdometryEvent>,
    ) -> Self {
        let mut deviations = deviations(1e-4);
        set(&mut deviations, VELOCITY, 5.0);
        set(&mut deviations, GYRO_BIAS, 1.0);
        let unknown = Vector3::zeros();
        out.push(OdometryEvent::Started(Started {
            stamp: begin,
            gravity: unknown,
            gyro_bias: unknown,
            still: false,
        }));
        Self::new(config, begin, Isometry::identity(), origin, Rotation::identity(), &deviations)
    }

    fn new(
        config: &OdometryConfig,
        begin: Stamp,
        body_from_base: Isometry,
        origin: &InitialPose,
        level_from_body: Rotation,
        deviations: &ErrorVector,
    ) -> Self {
        Self {
            config: *config,
            propagator: StatePropagator::new(
                config,
                begin,
                body_from_base,
                origin,
                level_from_body,
                deviations,
            ),
            map: LocalMap::new(config),
            last_scan: None,
            last_middle: None,
            last_inserted: None,
            scans: 0,
            reinitialiser: Reinitialiser::default(),
            lost_since: None,
            fast_since: None,
            covariance_inflation: false,
            carried: false,
            is_dead_reckoning_consistent: true,
            tracking_lost: None,
            typical_inlier_share: 0.0,
            downsampled: DownsampledScan::default(),
            deskewed: Vec::new(),
        }
    }

    /// What carries the estimate between scans.
    pub fn propagator(&self) -> &StatePropagator {
        &self.propagator
    }

    /// End of the newest scan taken in.
    pub fn last_scan_end(&self) -> Option<Stamp> {
        self.last_scan.map(|last| last.stamp)
    }

    /// Where all has to begin anew, from gravity on, if the way is lost.
    pub fn tracking_lost(&self) -> Option<InitialPose> {
        self.tracking_lost
    }

    /// Bytes of the local map.
    pub fn map_bytes(&self) -> usize {
        self.map.gaussians().bytes()
    }

    /// Surface elements of the local map.
    pub fn surfels(&self) -> Vec<([f64; 3], [f32; 3])> {
        self.map.gaussians().surfels()
    }

    /// Goes on to a stamp without a scan.
    pub fn advance(&mut self, to: Stamp, queues: &mut Queues) {
        self.propagate(to, queues);
        self.propagator.table.discard_before(self.propagator.time() - TABLE_KEPT);
    }

    /// Carries the estimate to a stamp. In the dark nothing but legs and IMU know the way: where they contradict each other nobody does.
    fn propagate(&mut self, to: Stamp, queues: &mut Queues) {
        self.propagator.advance(to, queues);
        self.is_dead_reckoning_consistent &= self.propagator.has_consistent_legs();
        if self.is_lidar_outage(to) && self.propagator.is_carried() {
            self.carried = true;
            self.inflate_covariance_once();
        }
    }

    /// Whether no scan has entered the map for so long that the robot may be elsewhere.
    fn is_lidar_outage(&self, now: Stamp) -> bool {
        self.propagator.has_imu && self.last_inserted.is_some_and(|entered| now - entered.stamp > DARK)
    }

    /// Books the way since the last scan that entered the map as a guess, once.
    fn inflate_covariance_once(&mut self) {
        if !std::mem::replace(&mut self.covariance_inflation, true) {
            self.propagator.inflate_covariance();
        }
    }

    /// Takes a scan in and tells the pose at its end.
    pub fn insert_scan(
        &mut self,
        mut sweep: Sweep,
        queues: &mut Queues,
        out: &mut Vec<OdometryEvent>,
        findings: &mut Vec<Finding>,
    ) {
        let outcome = if self.propagator.has_imu || !sweep.timed || self.scans < COAST_WHOLE {
            self.track_sweep(&sweep, self.config.target_points, queues)
        } else {
            self.track_without_imu(&sweep, queues)
        };
        if self.propagator.has_imu && !outcome.report.rejected {
            findings.extend(self.compare_turns(&sweep));
        }
        self.scans += 1;
        findings.extend(self.restart_if_lost(&sweep, &outcome.report));
        self.publish(&mut sweep, &outcome, out);
        self.propagator.table.discard_before(self.propagator.time() - TABLE_KEPT);
    }

    /// Gives the local map up when no scan has fitted for long, or the robot was carried in the dark, so that the way from here on is followed
    /// at least. A blind LiDAR alone is none of this: the map is as good as before when it sees again.
    fn restart_if_lost(&mut self, sweep: &Sweep, report: &RegistrationReport) -> Option<Finding> {
        // In the dark it might begin anew in somebody's arms, where no second says which way is up.
        let sees = self.downsampled.coarse.len() >= MIN_POINTS;
        let lost_since = (sees && report.rejected).then(|| self.lost_since.unwrap_or(sweep.start));
        self.lost_since = lost_since;
        let lost = lost_since.is_some_and(|since| self.carried || sweep.end - since >= LOST);
        let is_velocity_runaway = self.is_velocity_runaway(sweep.end) && sees;
        if !lost && !is_velocity_runaway {
            return None;
        }
        if self.propagator.has_imu {
            self.tracking_lost = Some(self.guess());
            return Some(findings::tracking_lost());
        }
        self.propagator.inflate_covariance();
        self.map = LocalMap::new(&self.config);
        (self.reinitialiser, self.typical_inlier_share, self.scans, self.lost_since) =
            (Reinitialiser::default(), 0.0, 0, None);
        Some(findings::tracking_lost())
    }

    /// Whether the body has seemed to be far faster than the legs for long: where a LiDAR hardly sees how the robot moves, as along a
    /// corridor, scans follow a wrong velocity.
    fn is_velocity_runaway(&mut self, now: Stamp) -> bool {
        let faster = self.propagator.speed_above_legs().filter(|_| self.propagator.has_imu);
        let fast = faster.is_some_and(|faster| faster > FASTEST);
        self.fast_since = if fast { self.fast_since.or(Some(now)) } else { None };
        self.fast_since.is_some_and(|since| now - since >= TOO_FAST)
    }

    /// Where the robot may be, now that it sees nothing of what it saw before: where sensors carried it to, if they can be believed, or
    /// where it was last sure.
    fn guess(&self) -> InitialPose {
        let now = self.propagator.estimate();
        let sure = self.last_inserted.map(|last| last.value * self.propagator.body_from_base);
        let odom_from_base = match sure {
            Some(sure) if now.velocity.norm() > FASTEST => sure,
            _ => now.odom_from_base,
        };
        let covariance_inflation =
            if self.covariance_inflation { self.propagator.guess_since() } else { self.propagator.guess() };
        InitialPose { odom_from_base, covariance_inflation }
    }

    /// Takes a sweep without an IMU: part by part, and where a part does not fit as parts usually do, as a whole.
    fn track_without_imu(&mut self, sweep: &Sweep, queues: &mut Queues) -> RegistrationOutcome {
        let before = (self.propagator.clone(), self.last_scan, queues.clone());
        let mut parts = Vec::with_capacity(COAST_PARTS);
        let outcome = match self.track_parts(sweep, queues, &mut parts) {
            Some(outcome) => {
                for part in &parts {
                    self.insert_into_map(part);
                }
                outcome
            }
            None => {
                (self.propagator, self.last_scan, *queues) = before;
                self.track_sweep(sweep, self.config.target_points, queues)
            }
        };
        self.deskew(sweep);
        outcome
    }

    /// Takes a sweep part by part, each a small scan of its own; `None` as soon as one does not fit. What shall enter the map
    /// is left in `parts`.
    fn track_parts(
        &mut self,
        sweep: &Sweep,
        queues: &mut Queues,
        parts: &mut Vec<RegisteredScan>,
    ) -> Option<RegistrationOutcome> {
        let wanted = self.config.target_points / COAST_PARTS;
        let mut whole = RegistrationOutcome::default();
        for index in 0..COAST_PARTS {
            let (RegistrationOutcome { report, information }, placed) =
                self.place(&sweep.part(index, COAST_PARTS), wanted, queues, SearchScope::Near);
            if report.rejected || report.inlier_share < COAST_STEADY * self.typical_inlier_share {
                return None;
            }
            parts.push(placed);
            whole.information += information;
            let before = whole.report;
            whole.report = RegistrationReport {
                points_used: before.points_used + report.points_used,
                matched: before.matched + report.matched,
                inlier_share: before.inlier_share + report.inlier_share / COAST_PARTS as f64,
                iterations: before.iterations + report.iterations,
                searched: before.searched || report.searched,
                ..report
            };
        }
        let learning = if self.typical_inlier_share > 0.0 { COAST_LEARNING } else { 1.0 };
        self.typical_inlier_share += (whole.report.inlier_share - self.typical_inlier_share) * learning;
        Some(whole)
    }

    /// Carries the estimate to the end of a sweep, corrects it by what the points say, of which about `wanted` enter, and adds
    /// them to the map.
    fn track_sweep(&mut self, sweep: &Sweep, wanted: usize, queues: &mut Queues) -> RegistrationOutcome {
        let (outcome, placed) = self.place(sweep, wanted, queues, SearchScope::Anywhere);
        self.insert_into_map(&placed);
        outcome
    }

    /// Adds points to the map, if they are worth it.
    fn insert_into_map(&mut self, placed: &RegisteredScan) {
        let RegisteredScan { downsampled, odom_from_body, fitted, worth } = placed;
        if *fitted {
            self.reinitialiser.update_typical_score(&self.map, downsampled, odom_from_body);
        }
        if *worth {
            self.map.insert(downsampled, odom_from_body);
            self.last_inserted = self.last_scan;
            (self.covariance_inflation, self.carried, self.is_dead_reckoning_consistent) =
                (false, false, true);
        }
    }

    /// Carries the estimate to the end of a sweep, or part of one, and corrects it by what the points say.
    fn place(
        &mut self,
        sweep: &Sweep,
        wanted: usize,
        queues: &mut Queues,
        scope: SearchScope,
    ) -> (RegistrationOutcome, RegisteredScan) {
        self.propagate(sweep.end, queues);
        let prior = self.propagator.filter.state.odom_from_body;
        let passes = if self.propagator.has_imu || !sweep.timed { 1 } else { COAST_PASSES };
        let mut fitted = None;
        for pass in 0..passes {
            self.deskew(sweep);
            self.map.downsample(
                &self.deskewed,
                wanted,
                &self.propagator.body_from_base,
                &mut self.downsampled,
            );
            fitted = self.fit(sweep, fitted, scope);
            let Some(ScanFit { state, .. }) = fitted else { break };
            if pass + 1 < passes {
                self.use_registered_motion(sweep, &state);
            }
        }
        let accepted = fitted.filter(|fitted| !fitted.report.rejected && !self.carried);
        let mut report = fitted.map(|fitted| fitted.report).unwrap_or_default();
        report.rejected = accepted.is_none() && !self.map.gaussians().is_empty();
        if let Some(fitted) = accepted {
            let surprising = self.is_lidar_outage(sweep.end)
                && !self.propagator.filter.is_within_gate(&fitted.state.odom_from_body, EXPECTED);
            self.propagator.filter.correct_pose(fitted.state, &fitted.information);
            // It fits somewhere in what was seen before, but legs and IMU came by another way: it may as well be somewhere alike.
            if surprising {
                self.inflate_covariance_once();
            }
        }
        let posterior = self.propagator.filter.state.odom_from_body;
        if passes > 1 {
            self.propagator.table.set_last(posterior);
        } else {
            self.propagator.table.shift(&(posterior * prior.inverse()));
        }
        self.last_scan = Some(Stamped { stamp: sweep.end, value: posterior });
        self.propagator.is_imprecise = false;
        let placed = RegisteredScan {
            worth: self.downsampled.fine.len() >= MIN_POINTS && !report.rejected,
            downsampled: self.downsampled.clone(),
            odom_from_body: posterior,
            fitted: accepted.is_some(),
        };
        let information = accepted.map_or_else(Matrix6::zeros, |fitted| fitted.information);
        (RegistrationOutcome { report, information }, placed)
    }

    /// Frees a sweep of the motion during it.
    fn deskew(&mut self, sweep: &Sweep) {
        let base_from_lidar = &self.config.mounting.base_from_lidar;
        sweep.deskew(
            &self.propagator.table,
            base_from_lidar,
            &self.propagator.body_from_base,
            &mut self.deskewed,
        );
    }

    /// Fits the thinned scan; `None` when it has too few points or there is no map yet. `previous` is the result of the
    /// last pass.
    fn fit(&mut self, sweep: &Sweep, previous: Option<ScanFit>, scope: SearchScope) -> Option<ScanFit> {
        if self.downsampled.coarse.len() < MIN_POINTS || self.map.gaussians().is_empty() {
            return None;
        }
        let mut start = previous.map_or(self.propagator.filter.state, |fitted| fitted.state);
        let dark = self.is_lidar_outage(sweep.end);
        if scope == SearchScope::Near || (self.propagator.has_imu && !self.propagator.is_imprecise && !dark) {
            return Some(reject_poor_fit(self.map.fit(
                &self.propagator.filter,
                start,
                &self.downsampled,
                PriorQuality::Close,
            )));
        }
        let long_ago = self.last_scan.is_some_and(|last| sweep.end - last.stamp > LONG_AGO);
        let mut searched = previous.is_some_and(|fitted| fitted.report.searched);
        if !(long_ago && previous.is_none()) {
            let fitted = reject_poor_fit(self.map.fit(
                &self.propagator.filter,
                start,
                &self.downsampled,
                PriorQuality::Loose,
            ));
            let is_typical_fit = match dark {
                true => self.is_plausible(&fitted),
                false => self.reinitialiser.is_typical_fit(
                    &self.map,
                    &self.downsampled,
                    &fitted.state.odom_from_body,
                ),
            };
            if previous.is_some() || (is_typical_fit && !fitted.report.rejected) {
                return Some(fitted);
            }
        }
        if let Some(last) = self.last_scan {
            let guess = start.odom_from_body;
            let guesses = [guess, last.value, se3::interpolate(&last.value, &guess, 0.5)];
            let found = self.reinitialiser.find_start(&self.map, &self.downsampled, &guesses);
            start.odom_from_body = found.map_from_body;
            searched |= found.searched;
        }
        let mut fitted = reject_poor_fit(self.map.fit(
            &self.propagator.filter,
            start,
            &self.downsampled,
            PriorQuality::Loose,
        ));
        fitted.report.searched = searched;
        fitted.report.rejected |= dark && !self.is_plausible(&fitted);
        Some(fitted)
    }

    /// Whether a scan after darkness fits as well as it has to where it was found.
    fn is_plausible(&mut self, fitted: &ScanFit) -> bool {
        let found = &fitted.state.odom_from_body;
        if !self.propagator.filter.is_within_gate(found, EXPECTED) {
            return self.reinitialiser.is_confident_fit(&self.map, &self.downsampled, found);
        }
        let RegistrationReport { matched, points_used, inlier_share, .. } = fitted.report;
        let hardly_known = (matched as f64) < HARDLY_KNOWN * points_used as f64;
        (self.is_dead_reckoning_consistent && (hardly_known || inlier_share >= KNOWN_FITS))
            || self.reinitialiser.is_typical_fit(&self.map, &self.downsampled, found)
    }

    /// Without inertial readings, makes the motion during the sweep the one that its points imply.
    fn use_registered_motion(&mut self, sweep: &Sweep, state: &State) {
        let from = sweep.start.min(self.last_scan_end().unwrap_or(sweep.start));
        self.propagator.table.make_uniform(from, sweep.end);
        self.propagator.table.set_last(state.odom_from_body);
    }

    /// Whether LiDAR and gyroscope saw the same turn since the last scan.
    fn compare_turns(&mut self, sweep: &Sweep) -> Option<Finding> {
        let middle = sweep.start + Span::from_nanos((sweep.end - sweep.start).nanos() / 2);
        let pose = Stamped { stamp: middle, value: self.propagator.table.at(middle)? };
        let last = self.last_middle.replace(pose)?;
        let seen = so3::log(&(last.value.rotation.inverse() * pose.value.rotation));
        self.propagator.imu_lidar_consistency.insert_turn(last.stamp, middle, seen)
    }

    fn publish(&self, sweep: &mut Sweep, outcome: &RegistrationOutcome, out: &mut Vec<OdometryEvent>) {
        let propagator = &self.propagator;
        let state = &propagator.filter.state;
        let estimate = propagator.estimate();
        let odom_from_body_at_scan = propagator.table.at(sweep.stamp).unwrap_or(state.odom_from_body);
        let base_from_body = propagator.body_from_base.rotation.inverse();
        let degenerate = degenerate_directions(&outcome.information, BLIND_DEVIATION)
            .map(|direction| direction.map(|axis| base_from_body * axis));
        out.push(OdometryEvent::Pose(Box::new(PoseEvent {
            estimate,
            scan_stamp: sweep.stamp,
            odom_from_base_at_scan: odom_from_body_at_scan * propagator.body_from_base,
            degenerate_directions: degenerate,
            registration: outcome.report,
            is_dead_reckoned: outcome.report.rejected || self.downsampled.coarse.len() < MIN_POINTS,
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

    /// The estimate at an instant, carried on from the present by the readings that wait.
    pub fn predict(&self, at: Stamp, queues: &Queues) -> Estimate {
        self.propagator.predict(at, &queues.imu)
    }
}

/// Whether so many points lie off their surfaces that the scan had better not be used.
fn reject_poor_fit(mut fitted: ScanFit) -> ScanFit {
    let report = &mut fitted.report;
    let matched = report.matched as f64 / report.points_used.max(1) as f64;
    report.rejected = report.inlier_share < INLIERS_MIN && matched > 0.3;
    fitted
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
