//! The running estimate: starts it, and takes scans in.

use crate::carrier::{Carrier, Origin, Queues, Timed};
use crate::checks;
use crate::config::OdometryConfig;
use crate::event::{CorrectedScan, Estimate, Finding, OdometryEvent, PoseEvent, RegistrationReport, Started};
use crate::local_map::{Fitted, LocalMap, MIN_POINTS, Prediction, Thinned};
use crate::recovery::Recovery;
use crate::startup::{Bearing, level};
use crate::state::{
    ACCEL_BIAS, DIMENSION, ErrorVector, GRAVITY, GYRO_BIAS, LEG_SCALE, POSITION, ROTATION, State, VELOCITY,
};
use crate::sweep::Sweep;
use geometry::{Isometry, Matrix6, Rotation, Vector3, se3, so3};
use registration::blind_directions;
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
pub struct Tracker {
    config: OdometryConfig,
    carrier: Carrier,
    map: LocalMap,
    last_scan: Option<Timed<Isometry>>,
    last_middle: Option<Timed<Isometry>>,
    /// The last scan that entered the map.
    last_entered: Option<Timed<Isometry>>,
    /// Scans taken in.
    scans: usize,
    recovery: Recovery,
    /// Start of the first of the scans, all to the last, that had enough points and did not fit.
    lost_since: Option<Stamp>,
    /// Since when the body has seemed to be far faster than the legs.
    fast_since: Option<Stamp>,
    /// Whether the way since the last scan that entered the map has been booked as a guess.
    guessed: bool,
    /// Whether somebody carried the robot meanwhile: the legs were wrong, and with them all that they taught the filter.
    carried: bool,
    /// Whether legs and IMU have known the way since then.
    known_way: bool,
    /// Where to begin anew: the filter's velocity and sense of gravity are not to be believed any more.
    astray: Option<Origin>,
    /// Share of points that lie on their surfaces when sweeps are taken in parts and all is well.
    usual_share: f64,
    thinned: Thinned,
    corrected: Vec<[f32; 3]>,
}

/// What came of a scan or a part of one.
#[derive(Clone, Copy, Debug, Default)]
struct Outcome {
    report: RegistrationReport,
    /// Of what was used.
    information: Matrix6,
}

/// Where a scan may lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Whence {
    /// Where it is expected, to centimetres.
    Near,
    /// Perhaps elsewhere.
    Anywhere,
}

/// A thinned scan and where it was found to lie.
#[derive(Clone, Debug)]
struct Placed {
    thinned: Thinned,
    odom_from_body: Isometry,
    /// Whether it was fitted to the map.
    fitted: bool,
    /// Whether it may enter the map.
    worth: bool,
}

impl Tracker {
    /// Starts with gravity and bias from the first second.
    pub fn with_imu(
        config: &OdometryConfig,
        begin: Stamp,
        bearing: &Bearing,
        origin: &Origin,
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
        let (gravity, still) = (-bearing.up, bearing.still);
        out.push(OdometryEvent::Started(Started { stamp: begin, gravity, gyro_bias, still }));
        let mut tracker = Self::new(config, begin, body_from_base, origin, rotation, &deviations);
        tracker.carrier.inertial = true;
        tracker.carrier.filter.state.gyro_bias = gyro_bias;
        tracker
    }

    /// Starts level at the base, with any velocity.
    pub fn without_imu(
        config: &OdometryConfig,
        begin: Stamp,
        origin: &Origin,
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
        origin: &Origin,
        level_from_body: Rotation,
        deviations: &ErrorVector,
    ) -> Self {
        Self {
            config: *config,
            carrier: Carrier::new(config, begin, body_from_base, origin, level_from_body, deviations),
            map: LocalMap::new(config),
            last_scan: None,
            last_middle: None,
            last_entered: None,
            scans: 0,
            recovery: Recovery::default(),
            lost_since: None,
            fast_since: None,
            guessed: false,
            carried: false,
            known_way: true,
            astray: None,
            usual_share: 0.0,
            thinned: Thinned::default(),
            corrected: Vec::new(),
        }
    }

    /// What carries the estimate between scans.
    pub fn carrier(&self) -> &Carrier {
        &self.carrier
    }

    /// End of the newest scan taken in.
    pub fn last_scan_end(&self) -> Option<Stamp> {
        self.last_scan.map(|last| last.stamp)
    }

    /// Where all has to begin anew, from gravity on, if the way is lost.
    pub fn astray(&self) -> Option<Origin> {
        self.astray
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
        self.carry_on(to, queues);
        self.carrier.table.forget_before(self.carrier.time() - TABLE_KEPT);
    }

    /// Carries the estimate to a stamp. In the dark nothing but legs and IMU know the way: where they contradict each other nobody does.
    fn carry_on(&mut self, to: Stamp, queues: &mut Queues) {
        self.carrier.advance(to, queues);
        self.known_way &= self.carrier.has_legs();
        if self.is_dark(to) && self.carrier.is_carried() {
            self.carried = true;
            self.guess_way();
        }
    }

    /// Whether no scan has entered the map for so long that the robot may be elsewhere.
    fn is_dark(&self, now: Stamp) -> bool {
        self.carrier.inertial && self.last_entered.is_some_and(|entered| now - entered.stamp > DARK)
    }

    /// Books the way since the last scan that entered the map as a guess, once.
    fn guess_way(&mut self) {
        if !std::mem::replace(&mut self.guessed, true) {
            self.carrier.book_guess();
        }
    }

    /// Takes a scan in and tells the pose at its end.
    pub fn take_scan(
        &mut self,
        mut sweep: Sweep,
        queues: &mut Queues,
        out: &mut Vec<OdometryEvent>,
        findings: &mut Vec<Finding>,
    ) {
        let outcome = if self.carrier.inertial || !sweep.timed || self.scans < COAST_WHOLE {
            self.take_part(&sweep, self.config.points_wanted, queues)
        } else {
            self.take_coasting(&sweep, queues)
        };
        if self.carrier.inertial && !outcome.report.rejected {
            findings.extend(self.compare_turns(&sweep));
        }
        self.scans += 1;
        findings.extend(self.begin_anew_if_lost(&sweep, &outcome.report));
        self.tell(&mut sweep, &outcome, out);
        self.carrier.table.forget_before(self.carrier.time() - TABLE_KEPT);
    }

    /// Gives the local map up when no scan has fitted for long, or the robot was carried in the dark, so that the way from here on is followed
    /// at least. A blind LiDAR alone is none of this: the map is as good as before when it sees again.
    fn begin_anew_if_lost(&mut self, sweep: &Sweep, report: &RegistrationReport) -> Option<Finding> {
        // In the dark it might begin anew in somebody's arms, where no second says which way is up.
        let sees = self.thinned.coarse.len() >= MIN_POINTS;
        let lost_since = (sees && report.rejected).then(|| self.lost_since.unwrap_or(sweep.start));
        self.lost_since = lost_since;
        let lost = lost_since.is_some_and(|since| self.carried || sweep.end - since >= LOST);
        let runs_away = self.runs_away(sweep.end) && sees;
        if !lost && !runs_away {
            return None;
        }
        if self.carrier.inertial {
            self.astray = Some(self.guess());
            return Some(checks::lost_way());
        }
        self.carrier.book_guess();
        self.map = LocalMap::new(&self.config);
        (self.recovery, self.usual_share, self.scans, self.lost_since) = (Recovery::default(), 0.0, 0, None);
        Some(checks::lost_way())
    }

    /// Whether the body has seemed to be far faster than the legs for long: where a LiDAR hardly sees how the robot moves, as along a
    /// corridor, scans follow a wrong velocity.
    fn runs_away(&mut self, now: Stamp) -> bool {
        let faster = self.carrier.faster_than_legs().filter(|_| self.carrier.inertial);
        let fast = faster.is_some_and(|faster| faster > FASTEST);
        self.fast_since = if fast { self.fast_since.or(Some(now)) } else { None };
        self.fast_since.is_some_and(|since| now - since >= TOO_FAST)
    }

    /// Where the robot may be, now that it sees nothing of what it saw before: where sensors carried it to, if they can be believed, or
    /// where it was last sure.
    fn guess(&self) -> Origin {
        let now = self.carrier.estimate();
        let sure = self.last_entered.map(|last| last.value * self.carrier.body_from_base);
        let odom_from_base = match sure {
            Some(sure) if now.velocity.norm() > FASTEST => sure,
            _ => now.odom_from_base,
        };
        let guessed = if self.guessed { self.carrier.guess_since() } else { self.carrier.guess() };
        Origin { odom_from_base, guessed }
    }

    /// Takes a sweep without an IMU: part by part, and where a part does not fit as parts usually do, as a whole.
    fn take_coasting(&mut self, sweep: &Sweep, queues: &mut Queues) -> Outcome {
        let before = (self.carrier.clone(), self.last_scan, queues.clone());
        let mut parts = Vec::with_capacity(COAST_PARTS);
        let outcome = match self.take_parts(sweep, queues, &mut parts) {
            Some(outcome) => {
                for part in &parts {
                    self.enter(part);
                }
                outcome
            }
            None => {
                (self.carrier, self.last_scan, *queues) = before;
                self.take_part(sweep, self.config.points_wanted, queues)
            }
        };
        self.correct(sweep);
        outcome
    }

    /// Takes a sweep part by part, each a small scan of its own; `None` as soon as one does not fit. What shall enter the map
    /// is left in `parts`.
    fn take_parts(&mut self, sweep: &Sweep, queues: &mut Queues, parts: &mut Vec<Placed>) -> Option<Outcome> {
        let wanted = self.config.points_wanted / COAST_PARTS;
        let mut whole = Outcome::default();
        for index in 0..COAST_PARTS {
            let (Outcome { report, information }, placed) =
                self.place(&sweep.part(index, COAST_PARTS), wanted, queues, Whence::Near);
            if report.rejected || report.inlier_share < COAST_STEADY * self.usual_share {
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
        let learning = if self.usual_share > 0.0 { COAST_LEARNING } else { 1.0 };
        self.usual_share += (whole.report.inlier_share - self.usual_share) * learning;
        Some(whole)
    }

    /// Carries the estimate to the end of a sweep, corrects it by what the points say, of which about `wanted` enter, and adds
    /// them to the map.
    fn take_part(&mut self, sweep: &Sweep, wanted: usize, queues: &mut Queues) -> Outcome {
        let (outcome, placed) = self.place(sweep, wanted, queues, Whence::Anywhere);
        self.enter(&placed);
        outcome
    }

    /// Adds points to the map, if they are worth it.
    fn enter(&mut self, placed: &Placed) {
        let Placed { thinned, odom_from_body, fitted, worth } = placed;
        if *fitted {
            self.recovery.learn(&self.map, thinned, odom_from_body);
        }
        if *worth {
            self.map.insert(thinned, odom_from_body);
            self.last_entered = self.last_scan;
            (self.guessed, self.carried, self.known_way) = (false, false, true);
        }
    }

    /// Carries the estimate to the end of a sweep, or part of one, and corrects it by what the points say.
    fn place(
        &mut self,
        sweep: &Sweep,
        wanted: usize,
        queues: &mut Queues,
        whence: Whence,
    ) -> (Outcome, Placed) {
        self.carry_on(sweep.end, queues);
        let prior = self.carrier.filter.state.odom_from_body;
        let passes = if self.carrier.inertial || !sweep.timed { 1 } else { COAST_PASSES };
        let mut fitted = None;
        for pass in 0..passes {
            self.correct(sweep);
            self.map.thin(&self.corrected, wanted, &self.carrier.body_from_base, &mut self.thinned);
            fitted = self.fit(sweep, fitted, whence);
            let Some(Fitted { state, .. }) = fitted else { break };
            if pass + 1 < passes {
                self.follow_scan(sweep, &state);
            }
        }
        let accepted = fitted.filter(|fitted| !fitted.report.rejected && !self.carried);
        let mut report = fitted.map(|fitted| fitted.report).unwrap_or_default();
        report.rejected = accepted.is_none() && !self.map.gaussians().is_empty();
        if let Some(fitted) = accepted {
            let surprising = self.is_dark(sweep.end)
                && !self.carrier.filter.expects(&fitted.state.odom_from_body, EXPECTED);
            self.carrier.filter.absorb_pose(fitted.state, &fitted.information);
            // It fits somewhere in what was seen before, but legs and IMU came by another way: it may as well be somewhere alike.
            if surprising {
                self.guess_way();
            }
        }
        let posterior = self.carrier.filter.state.odom_from_body;
        if passes > 1 {
            self.carrier.table.set_last(posterior);
        } else {
            self.carrier.table.shift(&(posterior * prior.inverse()));
        }
        self.last_scan = Some(Timed { stamp: sweep.end, value: posterior });
        self.carrier.rough = false;
        let placed = Placed {
            worth: self.thinned.fine.len() >= MIN_POINTS && !report.rejected,
            thinned: self.thinned.clone(),
            odom_from_body: posterior,
            fitted: accepted.is_some(),
        };
        let information = accepted.map_or_else(Matrix6::zeros, |fitted| fitted.information);
        (Outcome { report, information }, placed)
    }

    /// Frees a sweep of the motion during it.
    fn correct(&mut self, sweep: &Sweep) {
        let base_from_lidar = &self.config.mounting.base_from_lidar;
        sweep.correct(
            &self.carrier.table,
            base_from_lidar,
            &self.carrier.body_from_base,
            &mut self.corrected,
        );
    }

    /// Fits the thinned scan; `None` when it has too few points or there is no map yet. `previous` is the result of the
    /// last pass.
    fn fit(&mut self, sweep: &Sweep, previous: Option<Fitted>, whence: Whence) -> Option<Fitted> {
        if self.thinned.coarse.len() < MIN_POINTS || self.map.gaussians().is_empty() {
            return None;
        }
        let mut start = previous.map_or(self.carrier.filter.state, |fitted| fitted.state);
        let dark = self.is_dark(sweep.end);
        if whence == Whence::Near || (self.carrier.inertial && !self.carrier.rough && !dark) {
            return Some(judged(self.map.fit(&self.carrier.filter, start, &self.thinned, Prediction::Close)));
        }
        let long_ago = self.last_scan.is_some_and(|last| sweep.end - last.stamp > LONG_AGO);
        let mut searched = previous.is_some_and(|fitted| fitted.report.searched);
        if !(long_ago && previous.is_none()) {
            let fitted = judged(self.map.fit(&self.carrier.filter, start, &self.thinned, Prediction::Loose));
            let fits = match dark {
                true => self.is_believable(&fitted),
                false => self.recovery.fits(&self.map, &self.thinned, &fitted.state.odom_from_body),
            };
            if previous.is_some() || (fits && !fitted.report.rejected) {
                return Some(fitted);
            }
        }
        if let Some(last) = self.last_scan {
            let guess = start.odom_from_body;
            let guesses = [guess, last.value, se3::interpolate(&last.value, &guess, 0.5)];
            let found = self.recovery.best_start(&self.map, &self.thinned, &guesses);
            start.odom_from_body = found.map_from_body;
            searched |= found.searched;
        }
        let mut fitted = judged(self.map.fit(&self.carrier.filter, start, &self.thinned, Prediction::Loose));
        fitted.report.searched = searched;
        fitted.report.rejected |= dark && !self.is_believable(&fitted);
        Some(fitted)
    }

    /// Whether a scan after darkness fits as well as it has to where it was found.
    fn is_believable(&mut self, fitted: &Fitted) -> bool {
        let found = &fitted.state.odom_from_body;
        if !self.carrier.filter.expects(found, EXPECTED) {
            return self.recovery.fits_well(&self.map, &self.thinned, found);
        }
        let RegistrationReport { matched, points_used, inlier_share, .. } = fitted.report;
        let hardly_known = (matched as f64) < HARDLY_KNOWN * points_used as f64;
        (self.known_way && (hardly_known || inlier_share >= KNOWN_FITS))
            || self.recovery.fits(&self.map, &self.thinned, found)
    }

    /// Without inertial readings, makes the motion during the sweep the one that its points imply.
    fn follow_scan(&mut self, sweep: &Sweep, state: &State) {
        let from = sweep.start.min(self.last_scan_end().unwrap_or(sweep.start));
        self.carrier.table.make_uniform(from, sweep.end);
        self.carrier.table.set_last(state.odom_from_body);
    }

    /// Whether LiDAR and gyroscope saw the same turn since the last scan.
    fn compare_turns(&mut self, sweep: &Sweep) -> Option<Finding> {
        let middle = sweep.start + Span::from_nanos((sweep.end - sweep.start).nanos() / 2);
        let pose = Timed { stamp: middle, value: self.carrier.table.at(middle)? };
        let last = self.last_middle.replace(pose)?;
        let seen = so3::log(&(last.value.rotation.inverse() * pose.value.rotation));
        self.carrier.agreement.turn(last.stamp, middle, seen)
    }

    fn tell(&self, sweep: &mut Sweep, outcome: &Outcome, out: &mut Vec<OdometryEvent>) {
        let carrier = &self.carrier;
        let state = &carrier.filter.state;
        let estimate = carrier.estimate();
        let odom_from_body_at_scan = carrier.table.at(sweep.stamp).unwrap_or(state.odom_from_body);
        let base_from_body = carrier.body_from_base.rotation.inverse();
        let degenerate = blind_directions(&outcome.information, BLIND_DEVIATION)
            .map(|direction| direction.map(|axis| base_from_body * axis));
        out.push(OdometryEvent::Pose(Box::new(PoseEvent {
            estimate,
            scan_stamp: sweep.stamp,
            odom_from_base_at_scan: odom_from_body_at_scan * carrier.body_from_base,
            degenerate,
            registration: outcome.report,
            blind: outcome.report.rejected || self.thinned.coarse.len() < MIN_POINTS,
            gyro_bias: state.gyro_bias,
            accel_bias: state.accel_bias,
            leg_scale: state.leg_scale,
        })));
        out.push(OdometryEvent::Scan(CorrectedScan {
            stamp: sweep.end,
            odom_from_base: estimate.odom_from_base,
            xyz: Arc::new(self.corrected.clone()),
            intensity: Arc::new(sweep.take_intensity()),
        }));
    }

    /// The estimate at an instant, carried on from the present by the readings that wait.
    pub fn predict(&self, at: Stamp, queues: &Queues) -> Estimate {
        self.carrier.predict(at, &queues.imu)
    }
}

/// Whether so many points lie off their surfaces that the scan had better not be used.
fn judged(mut fitted: Fitted) -> Fitted {
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
