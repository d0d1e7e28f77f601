//! The odometry as its callers see it: sensor messages in, events out. This file queues the messages and decides when a scan is
//! processed.

use crate::config::OdometryConfig;
use crate::event::{Estimate, Finding, FindingKind, OdometryEvent};
use crate::findings;
use crate::imu_queue::ImuReading;
use crate::initial_alignment::estimate_alignment;
use crate::scan_tracker::ScanTracker;
use crate::state_propagator::{Queues, Stamped, StartingPose, StatePropagator};
use crate::sweep::{ScanView, Sweep};
use geometry::{Isometry, Vector3};
use std::collections::VecDeque;
use vocab::Stamp;

/// LiDAR-inertial-leg odometry. A pure function of the calls: the same calls give the same bits.
#[derive(Clone, Debug)]
pub struct Odometry {
    config: OdometryConfig,
    queues: Queues,
    scans: VecDeque<Sweep>,
    /// Newest stamp of any source.
    newest: Option<Stamp>,
    /// Stamp of the first message of any source since the start or restart.
    oldest: Option<Stamp>,
    /// `None` until the estimate has begun, and while it begins anew.
    tracker: Option<ScanTracker>,
    /// The pose at which the estimate begins.
    initial: StartingPose,
    /// Whether the estimate begins anew after tracking was lost.
    is_restart: bool,
    /// Kinds of the findings published so far.
    published: Vec<FindingKind>,
    /// Number of consecutive scans whose clock differs from the IMU's.
    clock_mismatches: usize,
    /// Whether the IMU has sent anything since the last scan.
    has_imu_sent: bool,
    /// Number of scans since the IMU sent anything.
    scans_without_imu: usize,
    /// Working memory of [`Sweep::from_scan`].
    kept_indices: Vec<u32>,
}

impl Odometry {
    /// Waits for sensors.
    pub fn new(config: OdometryConfig) -> Self {
        Self {
            config,
            queues: Queues::new(config.imu_queue),
            scans: VecDeque::new(),
            newest: None,
            oldest: None,
            tracker: None,
            initial: StartingPose::default(),
            is_restart: false,
            published: Vec::new(),
            clock_mismatches: 0,
            has_imu_sent: false,
            scans_without_imu: 0,
            kept_indices: Vec::new(),
        }
    }

    /// Inserts a reading of the IMU: turn rate (rad/s) and specific force (m/s²), IMU frame.
    pub fn insert_imu(
        &mut self,
        stamp: Stamp,
        gyro: Vector3,
        specific_force: Vector3,
        out: &mut Vec<OdometryEvent>,
    ) {
        let is_finite = gyro.iter().chain(specific_force.iter()).all(|c| c.is_finite());
        if !self.config.sources.imu || !is_finite {
            return;
        }
        if self.queues.imu.push(ImuReading { stamp, gyro, specific_force, is_saturated: false }) {
            self.has_imu_sent = true;
            if self.queues.imu.is_saturated() {
                self.publish_finding(findings::saturated(), out);
            }
            self.on_message(stamp, out);
        } else {
            self.publish_finding(findings::backwards("IMU"), out);
        }
    }

    /// Inserts velocity (m/s) and turn rate (rad/s) of the base as the legs measure them, base frame.
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
        // Some robots report no turn rate.
        let turn_rate = if is_finite(&turn_rate) { turn_rate } else { Vector3::zeros() };
        if push_newer(&mut self.queues.legs, Stamped { stamp, value: [velocity, turn_rate] }) {
            self.on_message(stamp, out);
        } else {
            self.publish_finding(findings::backwards("leg odometry"), out);
        }
    }

    /// Inserts a pose of another odometry's frame in that odometry's own drifting origin.
    pub fn insert_external_pose(
        &mut self,
        stamp: Stamp,
        odom_from_external: Isometry,
        out: &mut Vec<OdometryEvent>,
    ) {
        let is_finite = odom_from_external.to_homogeneous().iter().all(|c| c.is_finite());
        if !self.config.sources.external || !is_finite {
            return;
        }
        if push_newer(&mut self.queues.external, Stamped { stamp, value: odom_from_external }) {
            self.on_message(stamp, out);
        } else {
            self.publish_finding(findings::backwards("external odometry"), out);
        }
    }

    /// Inserts a LiDAR sweep. It is copied and waits until the other sources cover its end.
    pub fn insert_scan(&mut self, scan: ScanView<'_>, out: &mut Vec<OdometryEvent>) {
        if !self.config.sources.lidar {
            return;
        }
        let sweep = Sweep::from_scan(
            self.config.sweep,
            &scan,
            (self.config.min_range_m, self.config.max_range_m),
            self.config.self_filter.as_ref(),
            &self.config.mounting.base_from_lidar,
            &mut self.kept_indices,
        );
        let waiting_end = self.scans.back().map(|waiting| waiting.end);
        let processed_end = self.tracker.as_ref().and_then(ScanTracker::last_scan_end);
        if waiting_end.max(processed_end).is_some_and(|before| sweep.end <= before) {
            self.publish_finding(findings::backwards("LiDAR"), out);
            return;
        }
        if !sweep.has_times && !scan.xyz.is_empty() {
            self.publish_finding(findings::missing_times(), out);
        }
        self.scans_without_imu = if self.has_imu_sent { 0 } else { self.scans_without_imu + 1 };
        self.compare_clocks(&sweep, out);
        let end = sweep.end;
        self.scans.push_back(sweep);
        self.on_message(end, out);
    }

    /// Processes everything that waits, because no more messages will come.
    pub fn flush(&mut self, out: &mut Vec<OdometryEvent>) {
        self.process_queues(true, out);
    }

    /// Whether the motion is tracked: not before the start, nor while the estimate begins anew.
    pub fn is_tracking(&self) -> bool {
        self.tracker.is_some()
    }

    /// The estimate at an instant: between and after scans, the pose is propagated by the IMU. Before the start, and while the
    /// estimate begins anew, it is the pose at which the estimate will begin, with a large covariance.
    pub fn predict(&self, at: Stamp) -> Estimate {
        match &self.tracker {
            Some(tracker) => tracker.predict(at, &self.queues),
            None => Estimate {
                stamp: at,
                odom_from_base: self.initial.odom_from_base,
                velocity: Vector3::zeros(),
                turn_rate: Vector3::zeros(),
                covariance: geometry::Matrix6::identity() * self.config.unknown_pose_variance,
                covariance_inflation: self.initial.covariance_inflation,
            },
        }
    }

    /// Bytes of the local map.
    pub fn map_bytes(&self) -> usize {
        self.tracker.as_ref().map_or(0, ScanTracker::map_bytes)
    }

    /// Surface elements of the local map: position (odom frame, metres) and unit normal, which is zero where the surface is not flat.
    pub fn surfels(&self) -> Vec<([f64; 3], [f32; 3])> {
        self.tracker.as_ref().map(ScanTracker::surfels).unwrap_or_default()
    }

    fn on_message(&mut self, stamp: Stamp, out: &mut Vec<OdometryEvent>) {
        self.newest = self.newest.max(Some(stamp));
        self.oldest = Some(self.oldest.map_or(stamp, |oldest| oldest.min(stamp)));
        self.process_queues(false, out);
    }

    /// Begins the estimate if possible, then processes scans that need not wait any longer: all of them on the last call, else a few.
    fn process_queues(&mut self, is_last_call: bool, out: &mut Vec<OdometryEvent>) {
        if self.tracker.is_none() && !self.try_start(is_last_call, out) {
            while self.scans.len() > self.config.synchronisation.max_waiting_scans {
                self.scans.pop_front();
            }
            return;
        }
        let mut processed = 0;
        let max_processed =
            if is_last_call { usize::MAX } else { self.config.synchronisation.max_scans_per_message };
        while processed < max_processed
            && self.scans.front().is_some_and(|sweep| is_last_call || self.is_covered(sweep))
        {
            processed += 1;
            let (Some(sweep), Some(tracker)) = (self.scans.pop_front(), &mut self.tracker) else { return };
            let mut found = Vec::new();
            tracker.insert_scan(sweep, &mut self.queues, out, &mut found);
            let restart_pose = tracker.restart_pose();
            for finding in found {
                self.publish_finding(finding, out);
            }
            if let Some(initial) = restart_pose {
                (self.initial, self.tracker, self.is_restart) = (initial, None, true);
                self.oldest = self.newest;
                if !self.try_start(is_last_call, out) {
                    return;
                }
            }
        }
        self.report_silent_sources(out);
        if let (None, Some(newest), Some(tracker)) = (self.scans.front(), self.newest, &mut self.tracker) {
            // Keeps the queues short when no scan comes for long.
            let config = &self.config.synchronisation;
            if newest - tracker.propagator().time() > config.max_backlog {
                tracker.advance(newest - config.kept_backlog, &mut self.queues);
            }
        }
    }

    /// Whether every source that sends has sent past the end of a sweep, or has had enough time to.
    fn is_covered(&self, sweep: &Sweep) -> bool {
        let Some(newest) = self.newest else { return false };
        let config = &self.config.synchronisation;
        if newest - sweep.end > config.max_wait || self.scans.len() > config.max_waiting_scans {
            return true;
        }
        let covers = |last: Option<Stamp>| {
            last.is_none_or(|last| last >= sweep.end || newest - last > config.silent_after)
        };
        let propagator = self.tracker.as_ref().map(ScanTracker::propagator);
        let waiting_legs = self.queues.legs.back().map(|legs| legs.stamp);
        let legs = waiting_legs.or(propagator.and_then(StatePropagator::last_legs));
        let waiting_external = self.queues.external.back().map(|pose| pose.stamp);
        let external = waiting_external.or(propagator.and_then(StatePropagator::last_external));
        covers(self.queues.imu.newest()) && covers(legs) && covers(external)
    }

    /// Begins the estimate as soon as it is clear which sensors there are and which direction is up. Returns whether it has begun.
    fn try_start(&mut self, is_last_call: bool, out: &mut Vec<OdometryEvent>) -> bool {
        let (Some(newest), Some(oldest)) = (self.newest, self.oldest) else { return false };
        let config = self.config.synchronisation;
        let alignment_config = self.config.initial_alignment;
        let first_scan = self.scans.front().map(|sweep| (sweep.start, sweep.end));
        let Some(imu_oldest) = self.queues.imu.oldest() else {
            let has_waited = first_scan
                .is_some_and(|(_, end)| newest - end >= config.max_initial_wait || !self.config.sources.imu);
            let has_velocity_only = first_scan.is_none() && newest - oldest > alignment_config.max_window;
            if !(has_waited || has_velocity_only || is_last_call) {
                return false;
            }
            self.start_without_imu(first_scan.map_or(oldest, |(start, _)| start.min(oldest)), out);
            return true;
        };
        let Some(imu_newest) = self.queues.imu.newest() else { return false };
        // An IMU that has stopped is not waited for. An IMU with another clock is handled by `compare_clocks`.
        if self.scans_without_imu > config.silent_imu_scans
            && newest - imu_newest > config.max_clock_difference
        {
            self.publish_finding(findings::silent_imu(), out);
            self.start_without_imu(first_scan.map_or(oldest, |(start, _)| start), out);
            return true;
        }
        let begin = first_scan.map_or(imu_oldest, |(start, _)| start.min(imu_oldest));
        let covered = imu_newest - imu_oldest;
        if covered < alignment_config.stationary_window && !is_last_call {
            return false;
        }
        let since = imu_newest - alignment_config.stationary_window;
        let recent = self.queues.imu.iter().filter(move |reading| reading.stamp >= since);
        let stationary =
            estimate_alignment(recent, &alignment_config).filter(|alignment| alignment.is_stationary);
        let alignment = match stationary {
            Some(alignment) => alignment,
            None if covered < alignment_config.max_window && !is_last_call => return false,
            None => match estimate_alignment(self.queues.imu.iter(), &alignment_config) {
                Some(alignment) => alignment,
                None => {
                    self.start_without_imu(begin, out);
                    return true;
                }
            },
        };
        let base_from_imu = self.config.mounting.base_from_imu.isometry().rotation;
        for finding in findings::at_start(&alignment, &base_from_imu, &alignment_config) {
            self.publish_finding(finding, out);
        }
        let begin = if self.is_restart && alignment.is_stationary { begin.max(since) } else { begin };
        if self.is_restart {
            self.discard_before(begin);
        }
        self.tracker = Some(ScanTracker::with_imu(&self.config, begin, &alignment, &self.initial, out));
        true
    }

    /// Drops the messages from before the robot stood still: the estimate begins there, at rest.
    fn discard_before(&mut self, begin: Stamp) {
        self.queues.imu.discard_before(begin);
        self.queues.legs.retain(|legs| legs.stamp >= begin);
        self.queues.external.retain(|external| external.stamp >= begin);
        self.scans.retain(|sweep| sweep.start >= begin);
    }

    /// Begins without an IMU. An IMU that sends later is ignored.
    fn start_without_imu(&mut self, begin: Stamp, out: &mut Vec<OdometryEvent>) {
        self.config.sources.imu = false;
        self.queues.imu.clear();
        self.tracker = Some(ScanTracker::without_imu(&self.config, begin, &self.initial, out));
    }

    /// Reports sources that have sent before and have been silent for long.
    fn report_silent_sources(&mut self, out: &mut Vec<OdometryEvent>) {
        let Some(newest) = self.newest else { return };
        let limit = self.config.synchronisation.report_silent_after;
        let is_silent = |last: Option<Stamp>| last.is_some_and(|last| newest - last > limit);
        if is_silent(self.queues.imu.newest()) {
            self.publish_finding(findings::silent_imu(), out);
        }
        if is_silent(self.tracker.as_ref().and_then(ScanTracker::last_scan_end)) && self.scans.is_empty() {
            self.publish_finding(findings::silent_lidar(), out);
        }
    }

    /// Detects scans and readings without a common clock, and goes on without the IMU then.
    fn compare_clocks(&mut self, sweep: &Sweep, out: &mut Vec<OdometryEvent>) {
        let Some(imu) = self.queues.imu.newest() else { return };
        // The stamps of a silent IMU are old for another reason.
        if !std::mem::take(&mut self.has_imu_sent) {
            return;
        }
        let config = &self.config.synchronisation;
        let difference = if imu > sweep.end { imu - sweep.end } else { sweep.end - imu };
        let is_mismatch = difference > config.max_clock_difference;
        self.clock_mismatches = if is_mismatch { self.clock_mismatches + 1 } else { 0 };
        if self.clock_mismatches == config.clock_mismatches {
            self.publish_finding(findings::clocks_apart(imu - sweep.end), out);
            self.config.sources.imu = false;
            self.queues.imu.clear();
            self.newest = Some(sweep.end);
            self.oldest = self.scans.front().map(|first| first.start);
            self.tracker = None;
        }
    }

    /// Publishes a finding once for each kind; lost tracking every time.
    fn publish_finding(&mut self, finding: Finding, out: &mut Vec<OdometryEvent>) {
        if finding.kind == FindingKind::TrackingLost || !self.published.contains(&finding.kind) {
            self.published.push(finding.kind);
            out.push(OdometryEvent::Finding(finding));
        }
    }
}

/// Appends an item unless it is older than the last one. Returns whether it was appended.
fn push_newer<T>(queue: &mut VecDeque<Stamped<T>>, item: Stamped<T>) -> bool {
    let is_newer = queue.back().is_none_or(|last| item.stamp > last.stamp);
    if is_newer {
        queue.push_back(item);
    }
    is_newer
}
