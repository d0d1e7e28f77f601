//! The estimator as its callers see it: sensors in, events out.

use crate::config::OdometryConfig;
use crate::event::{Estimate, Finding, FindingKind, OdometryEvent};
use crate::findings;
use crate::imu_queue::ImuReading;
use crate::scan_tracker::ScanTracker;
use crate::state_propagator::{InitialPose, Queues, Stamped, StatePropagator};
use crate::sweep::{ScanView, Sweep};
use geometry::{Isometry, Vector3};
use std::collections::VecDeque;
use vocab::{Span, Stamp};

/// A scan waits at most so long, by the stamps of later messages, for the other sensors to cover its end.
const PATIENCE: Span = Span::from_millis(200);
/// At the start it waits so long for other sensors to speak at all.
const FIRST_PATIENCE: Span = Span::from_millis(400);
/// A source that has been silent for so long is not waited for.
const SILENT: Span = Span::from_millis(500);
/// Time spent judging whether the robot stands still, and the most spent hoping that it will.
const STILL_WINDOW: Span = Span::from_millis(500);
const START_WINDOW: Span = Span::from_millis(1_000);
/// Without scans, readings older than this are worked through.
const BACKLOG: Span = Span::from_millis(600);
/// IMU and LiDAR stamps farther apart than this have no common clock.
const CLOCKS_APART: Span = Span::from_millis(3_000);
/// An IMU that has not spoken during so many scans has stopped.
const QUIET: usize = 3;
/// Scans that may wait; more mean that something is badly wrong, and the oldest goes ahead as it is.
const WAITING_MAX: usize = 40;

/// LiDAR-inertial-leg odometry. A pure function of the calls made: same calls, same bits.
#[derive(Clone, Debug)]
pub struct Odometry {
    config: OdometryConfig,
    queues: Queues,
    scans: VecDeque<Sweep>,
    /// Newest stamp of any source: the only clock.
    newest: Option<Stamp>,
    /// Stamp of the first message of any source.
    oldest: Option<Stamp>,
    /// `None` until started, and while it begins anew.
    tracker: Option<ScanTracker>,
    /// Where the estimate begins, and whether it does for a second time or more.
    origin: InitialPose,
    anew: bool,
    findings: Vec<FindingKind>,
    /// Consecutive scans whose clock has nothing to do with the IMU's.
    apart: usize,
    /// Whether the IMU spoke since the last scan, and scans since it spoke.
    imu_spoke: bool,
    quiet: usize,
    kept: Vec<u32>,
}

impl Odometry {
    /// Waits for sensors.
    pub fn new(config: OdometryConfig) -> Self {
        Self {
            config,
            queues: Queues::default(),
            scans: VecDeque::new(),
            newest: None,
            oldest: None,
            tracker: None,
            origin: InitialPose::default(),
            anew: false,
            findings: Vec::new(),
            apart: 0,
            imu_spoke: false,
            quiet: 0,
            kept: Vec::new(),
        }
    }

    /// An IMU reads: turn rate (rad/s) and specific force (m/s²), IMU frame.
    pub fn insert_imu(
        &mut self,
        stamp: Stamp,
        gyro: Vector3,
        specific_force: Vector3,
        out: &mut Vec<OdometryEvent>,
    ) {
        let finite = gyro.iter().chain(specific_force.iter()).all(|c| c.is_finite());
        if !self.config.sources.imu || !finite {
            return;
        }
        if self.queues.imu.push(ImuReading { stamp, gyro, specific_force, saturated: false }) {
            self.imu_spoke = true;
            if self.queues.imu.saturated() {
                self.find(findings::saturated(), out);
            }
            self.on_message(stamp, out);
        } else {
            self.find(findings::backwards("IMU"), out);
        }
    }

    /// The legs say how fast the base moves, m/s, base frame.
    pub fn insert_leg_velocity(
        &mut self,
        stamp: Stamp,
        [velocity, turn_rate]: [Vector3; 2],
        out: &mut Vec<OdometryEvent>,
    ) {
        let is_finite = |v: &Vector3| v.iter().all(|c| c.is_finite());
        if !self.config.sources.legs || !is_finite(&velocity) {
            return;
        }
        // Some legs say nothing of it.
        let turn_rate = if is_finite(&turn_rate) { turn_rate } else { Vector3::zeros() };
        if push_newer(&mut self.queues.legs, Stamped { stamp, value: [velocity, turn_rate] }) {
            self.on_message(stamp, out);
        } else {
            self.find(findings::backwards("leg odometry"), out);
        }
    }

    /// Another odometry says where its frame is in its own, drifting origin.
    pub fn insert_external_pose(
        &mut self,
        stamp: Stamp,
        odom_from_external: Isometry,
        out: &mut Vec<OdometryEvent>,
    ) {
        let finite = odom_from_external.to_homogeneous().iter().all(|c| c.is_finite());
        if !self.config.sources.external || !finite {
            return;
        }
        if push_newer(&mut self.queues.external, Stamped { stamp, value: odom_from_external }) {
            self.on_message(stamp, out);
        } else {
            self.find(findings::backwards("external odometry"), out);
        }
    }

    /// A LiDAR sweep. It is copied and waits until the other sources cover its end.
    pub fn insert_scan(&mut self, scan: ScanView<'_>, out: &mut Vec<OdometryEvent>) {
        if !self.config.sources.lidar {
            return;
        }
        let sweep = Sweep::take(
            &scan,
            (self.config.range_min, self.config.range_max),
            self.config.hidden.as_ref(),
            &self.config.mounting.base_from_lidar,
            &mut self.kept,
        );
        let last = self.scans.back().map(|waiting| waiting.end);
        let done = self.tracker.as_ref().and_then(ScanTracker::last_scan_end);
        if last.max(done).is_some_and(|before| sweep.end <= before) {
            self.find(findings::backwards("LiDAR"), out);
            return;
        }
        if !sweep.timed && !scan.xyz.is_empty() {
            self.find(findings::missing_times(), out);
        }
        self.quiet = if self.imu_spoke { 0 } else { self.quiet + 1 };
        self.compare_clocks(&sweep, out);
        let end = sweep.end;
        self.scans.push_back(sweep);
        self.on_message(end, out);
    }

    /// No more messages will come: works through everything that waits.
    pub fn flush(&mut self, out: &mut Vec<OdometryEvent>) {
        self.work(true, out);
    }

    /// Whether it follows the motion now: not before the start, nor while it begins anew.
    pub fn is_tracking(&self) -> bool {
        self.tracker.is_some()
    }

    /// The estimate at an instant: between and after scans the pose is carried by the IMU. Before the start, and while it begins anew,
    /// where it is to begin, with a large covariance.
    pub fn predict(&self, at: Stamp) -> Estimate {
        match &self.tracker {
            Some(tracker) => tracker.predict(at, &self.queues),
            None => Estimate {
                stamp: at,
                odom_from_base: self.origin.odom_from_base,
                velocity: Vector3::zeros(),
                turn_rate: Vector3::zeros(),
                covariance: geometry::Matrix6::identity() * 1e6,
                covariance_inflation: self.origin.covariance_inflation,
            },
        }
    }

    /// Bytes held by the local map.
    pub fn map_bytes(&self) -> usize {
        self.tracker.as_ref().map_or(0, ScanTracker::map_bytes)
    }

    /// Surface elements of the local map: position (odom frame) and unit normal, zero where not flat.
    pub fn surfels(&self) -> Vec<([f64; 3], [f32; 3])> {
        self.tracker.as_ref().map(ScanTracker::surfels).unwrap_or_default()
    }

    fn on_message(&mut self, stamp: Stamp, out: &mut Vec<OdometryEvent>) {
        self.newest = self.newest.max(Some(stamp));
        self.oldest = Some(self.oldest.map_or(stamp, |oldest| oldest.min(stamp)));
        self.work(false, out);
    }

    /// Starts if possible, then takes every scan whose time has come.
    fn work(&mut self, last_call: bool, out: &mut Vec<OdometryEvent>) {
        if self.tracker.is_none() && !self.start(last_call, out) {
            while self.scans.len() > WAITING_MAX {
                self.scans.pop_front();
            }
            return;
        }
        while self.scans.front().is_some_and(|sweep| last_call || self.is_covered(sweep)) {
            let (Some(sweep), Some(tracker)) = (self.scans.pop_front(), &mut self.tracker) else { return };
            let mut found = Vec::new();
            tracker.insert_scan(sweep, &mut self.queues, out, &mut found);
            let tracking_lost = tracker.tracking_lost();
            for finding in found {
                self.find(finding, out);
            }
            if let Some(origin) = tracking_lost {
                (self.origin, self.tracker, self.anew) = (origin, None, true);
                self.oldest = self.newest;
                if !self.start(last_call, out) {
                    return;
                }
            }
        }
        self.report_silent_sources(out);
        if let (None, Some(newest), Some(tracker)) = (self.scans.front(), self.newest, &mut self.tracker) {
            // Keeps the queues short when no scan comes for long.
            if newest - tracker.propagator().time() > BACKLOG {
                let until = newest - Span::from_millis(BACKLOG.nanos() / 2_000_000);
                tracker.advance(until, &mut self.queues);
            }
        }
    }

    /// Whether every source that speaks has spoken past the end of a sweep, or has had its chance.
    fn is_covered(&self, sweep: &Sweep) -> bool {
        let Some(newest) = self.newest else { return false };
        if newest - sweep.end > PATIENCE || self.scans.len() > WAITING_MAX {
            return true;
        }
        let covers =
            |last: Option<Stamp>| last.is_none_or(|last| last >= sweep.end || newest - last > SILENT);
        let propagator = self.tracker.as_ref().map(ScanTracker::propagator);
        let legs = self
            .queues
            .legs
            .back()
            .map(|legs| legs.stamp)
            .or(propagator.and_then(StatePropagator::last_legs));
        let external = self
            .queues
            .external
            .back()
            .map(|pose| pose.stamp)
            .or(propagator.and_then(StatePropagator::last_external));
        covers(self.queues.imu.newest()) && covers(legs) && covers(external)
    }

    /// Begins the estimate once it is clear which sensors there are and which way is up.
    fn start(&mut self, last_call: bool, out: &mut Vec<OdometryEvent>) -> bool {
        let (Some(newest), Some(oldest)) = (self.newest, self.oldest) else { return false };
        let first_scan = self.scans.front().map(|sweep| (sweep.start, sweep.end));
        let Some(imu_oldest) = self.queues.imu.oldest() else {
            let waited =
                first_scan.is_some_and(|(_, end)| newest - end >= FIRST_PATIENCE || !self.config.sources.imu);
            let only_velocity = first_scan.is_none() && newest - oldest > START_WINDOW;
            if !(waited || only_velocity || last_call) {
                return false;
            }
            self.start_without_imu(first_scan.map_or(oldest, |(start, _)| start.min(oldest)), out);
            return true;
        };
        let Some(imu_newest) = self.queues.imu.newest() else { return false };
        // One that has stopped speaking is not waited for; one whose clock is another is another matter.
        if self.quiet > QUIET && newest - imu_newest > CLOCKS_APART {
            self.find(findings::silent("IMU", "Check its cable, power and driver."), out);
            self.start_without_imu(first_scan.map_or(oldest, |(start, _)| start), out);
            return true;
        }
        let begin = first_scan.map_or(imu_oldest, |(start, _)| start.min(imu_oldest));
        let seen = imu_newest - imu_oldest;
        if seen < STILL_WINDOW && !last_call {
            return false;
        }
        let since = imu_newest - STILL_WINDOW;
        let recent = self.queues.imu.iter().filter(move |reading| reading.stamp >= since);
        let initial_alignment = crate::initial_alignment::initial_alignment(recent)
            .filter(|initial_alignment| initial_alignment.still);
        let initial_alignment = match initial_alignment {
            Some(initial_alignment) => initial_alignment,
            None if seen < START_WINDOW && !last_call => return false,
            None => match crate::initial_alignment::initial_alignment(self.queues.imu.iter()) {
                Some(initial_alignment) => initial_alignment,
                None => {
                    self.start_without_imu(begin, out);
                    return true;
                }
            },
        };
        for finding in findings::at_start(&initial_alignment, &self.config.mounting) {
            self.find(finding, out);
        }
        let begin = if self.anew && initial_alignment.still { begin.max(since) } else { begin };
        if self.anew {
            self.discard_before(begin);
        }
        self.tracker =
            Some(ScanTracker::with_imu(&self.config, begin, &initial_alignment, &self.origin, out));
        true
    }

    /// Drops what was said before the robot stood still: the estimate begins there, at rest.
    fn discard_before(&mut self, begin: Stamp) {
        self.queues.imu.discard_before(begin);
        self.queues.legs.retain(|legs| legs.stamp >= begin);
        self.queues.external.retain(|external| external.stamp >= begin);
        self.scans.retain(|sweep| sweep.start >= begin);
    }

    /// Begins without an IMU, and without waiting for one any more.
    fn start_without_imu(&mut self, begin: Stamp, out: &mut Vec<OdometryEvent>) {
        self.config.sources.imu = false;
        self.queues.imu.clear();
        self.tracker = Some(ScanTracker::without_imu(&self.config, begin, &self.origin, out));
    }

    /// Says once when a source that spoke has been silent for long.
    fn report_silent_sources(&mut self, out: &mut Vec<OdometryEvent>) {
        let Some(newest) = self.newest else { return };
        let long = |last: Option<Stamp>| last.is_some_and(|last| newest - last > SILENT * 4);
        if long(self.queues.imu.newest()) {
            self.find(findings::silent("IMU", "Check its cable, power and driver."), out);
        }
        if long(self.tracker.as_ref().and_then(ScanTracker::last_scan_end)) && self.scans.is_empty() {
            self.find(findings::silent("LiDAR", "Check its cable, power, address and driver."), out);
        }
    }

    /// Notices scans and readings that share no clock, and goes on without the IMU then.
    fn compare_clocks(&mut self, sweep: &Sweep, out: &mut Vec<OdometryEvent>) {
        let Some(imu) = self.queues.imu.newest() else { return };
        // One that is silent is another matter.
        if !std::mem::take(&mut self.imu_spoke) {
            return;
        }
        let apart = if imu > sweep.end { imu - sweep.end } else { sweep.end - imu };
        self.apart = if apart > CLOCKS_APART { self.apart + 1 } else { 0 };
        if self.apart == 3 {
            self.find(findings::clocks_apart(imu - sweep.end), out);
            self.config.sources.imu = false;
            self.queues.imu.clear();
            self.newest = Some(sweep.end);
            self.oldest = self.scans.front().map(|first| first.start);
            self.tracker = None;
        }
    }

    /// Tells a finding, once for each kind; that the way was lost, every time.
    fn find(&mut self, finding: Finding, out: &mut Vec<OdometryEvent>) {
        if finding.kind == FindingKind::TrackingLost || !self.findings.contains(&finding.kind) {
            self.findings.push(finding.kind);
            out.push(OdometryEvent::Finding(finding));
        }
    }
}

fn push_newer<T>(queue: &mut VecDeque<Stamped<T>>, item: Stamped<T>) -> bool {
    let newer = queue.back().is_none_or(|last| item.stamp > last.stamp);
    if newer {
        queue.push_back(item);
    }
    newer
}
