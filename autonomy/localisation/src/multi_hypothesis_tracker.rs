//! Multi-hypothesis tracking: poses at which the robot may be, each tracked until the scans of the moving robot leave one.
//!
//! Poses that look alike differ by little in each scan, and all scans from one position give the same information. Scores are therefore integrated
//! over the distance walked: each hypothesis gains what its scans fit, once for every `update_distance_m`, and is rejected when it falls behind the
//! best one by more than a margin. A robot that stands still therefore never rejects a hypothesis by its score.

use crate::global_localiser::GlobalLocaliser;
use crate::localisation_monitor::LocalisationStatus;
use crate::pose_hypothesis::{HypothesisTolerance, PoseHypothesis};
use crate::pose_tracker::{DownsampledScan, PoseTracker, PoseTrackerConfig, TrackedPose};
use geometry::{Isometry, Matrix6, Vector6};
use mapping::UncertainPose;
use std::sync::Arc;
use vocab::{Span, Stamp};

/// Parameters of [`MultiHypothesisTracker`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MultiHypothesisConfig {
    /// Parameters of the trackers.
    pub tracking: PoseTrackerConfig,
    /// Standard deviation of the orientation of a pose that was found from one scan, radians. Chosen: 3 degrees, far above the error of a right pose.
    pub initial_rotation_std_rad: f64,
    /// Standard deviation of the position of such a pose, metres. It is large, because a scan does not observe every direction, such as the one along
    /// a corridor. Chosen as a round number, far above the error of a right pose in observed directions.
    pub initial_translation_std_m: f64,
    /// Distance walked that counts as one update of the scores, metres. A scan from there gives new information. Chosen: the cell of the correlative search.
    pub update_distance_m: f64,
    /// A hypothesis is rejected when its score is this far behind the best one's. It is the margin that a single scan needs to distinguish two poses,
    /// and a third more, because a tracked scan is noisier than a refined one. Source: a single scan distinguishes poses by
    /// [`AcceptanceConfig::ambiguity_ratio`](crate::AcceptanceConfig), 0.15.
    pub rejection_margin: f64,
    /// The last hypothesis is accepted after this number of scans. Chosen: half a second at 10 Hz, so that people in one scan do not decide.
    pub min_scans: u32,
    /// Distance walked since the latest search of the whole map, metres, after which the hypotheses may not be all poses that look like the
    /// scan. Chosen: within it, the same places look alike.
    pub search_validity_m: f64,
    /// A found pose this near to a rejected hypothesis is that hypothesis. Chosen: twice [`AcceptanceConfig::same_pose`](crate::AcceptanceConfig), because a rejected
    /// hypothesis may have drifted.
    pub rejected_pose: HypothesisTolerance,
    /// An injected hypothesis starts this far behind the best score. Chosen: half of [`Self::rejection_margin`], so that neither is decided by the start.
    pub injection_handicap: f64,
    /// All hypotheses are given up after evidence against each of them for this time ... Chosen: a little more than the monitor's `lost_after`.
    pub abandon_after: Span,
    /// ... and over this distance, metres. Chosen: so that people who stand round a standing robot do not end them.
    pub abandon_distance_m: f64,
}

impl Default for MultiHypothesisConfig {
    fn default() -> Self {
        Self {
            tracking: PoseTrackerConfig::default(),
            initial_rotation_std_rad: 0.05,
            initial_translation_std_m: 0.4,
            update_distance_m: 0.4,
            rejection_margin: 0.2,
            min_scans: 5,
            search_validity_m: 1.0,
            rejected_pose: HypothesisTolerance { distance_m: 1.0, angle_rad: 0.3 },
            injection_handicap: 0.1,
            abandon_after: Span::from_millis(3_000),
            abandon_distance_m: 1.0,
        }
    }
}

/// The hypotheses.
#[derive(Debug)]
pub struct MultiHypothesisTracker {
    config: MultiHypothesisConfig,
    hypotheses: Vec<TrackedHypothesis>,
    /// Pose of odometry's frame in the map by each rejected hypothesis.
    rejected: Vec<Isometry>,
    /// Distance walked since the latest search of the whole map, metres.
    distance_since_search_m: f64,
    /// Pose by odometry at the latest scan.
    odom_from_base: Option<Isometry>,
    /// Stamp of the latest scan.
    stamp: Option<Stamp>,
    /// Duration of the evidence against every hypothesis.
    unsupported_time: Span,
    /// Distance walked during the evidence against every hypothesis, metres.
    unsupported_m: f64,
}

/// A pose that is tracked as if it were the right one.
#[derive(Debug)]
struct TrackedHypothesis {
    tracker: PoseTracker,
    /// Fit of its scans, integrated over the updates.
    score: f64,
    scans: u32,
    /// Whether its tracker is localised.
    is_localised: bool,
}

impl MultiHypothesisTracker {
    /// Without hypotheses.
    pub fn empty(config: MultiHypothesisConfig) -> Self {
        Self {
            config,
            hypotheses: Vec::new(),
            rejected: Vec::new(),
            distance_since_search_m: 0.0,
            odom_from_base: None,
            stamp: None,
            unsupported_time: Span::ZERO,
            unsupported_m: 0.0,
        }
    }

    /// Starts at the poses found for a scan that was taken at a moment of odometry. The score of each starts at its quality. That of the pose that
    /// was tracked so far starts at the best one's, because one scan has little weight against all previous ones.
    pub fn new(
        config: MultiHypothesisConfig,
        localiser: &GlobalLocaliser,
        found: &[PoseHypothesis],
        tracked: Option<&Isometry>,
        odom_from_base: &Isometry,
    ) -> Self {
        let best = found.iter().map(PoseHypothesis::quality).fold(0.0, f64::max);
        let same_pose = &localiser.config().acceptance.same_pose;
        let start = |pose: &PoseHypothesis| {
            let is_tracked = tracked.is_some_and(|tracked| same_pose.contains(&pose.map_from_base, tracked));
            let score = if is_tracked { best } else { pose.quality() };
            TrackedHypothesis::new(&config, localiser, pose, score, odom_from_base)
        };
        let hypotheses = found.iter().map(start).collect();
        Self { hypotheses, odom_from_base: Some(*odom_from_base), ..Self::empty(config) }
    }

    /// Number of hypotheses.
    pub fn len(&self) -> usize {
        self.hypotheses.len()
    }

    /// Whether no hypothesis is left.
    pub fn is_empty(&self) -> bool {
        self.hypotheses.is_empty()
    }

    /// Poses of the base in the map, the best score first.
    pub fn poses(&self) -> Vec<Isometry> {
        let mut order: Vec<&TrackedHypothesis> = self.hypotheses.iter().collect();
        order.sort_by(|a, b| b.score.total_cmp(&a.score));
        order.into_iter().map(|one| one.tracker.map_from_base().pose).collect()
    }

    /// Tracks every hypothesis by another scan. Rejects those whose tracker is lost, those whose score has fallen behind, and all of them where
    /// none has been localised for long. Costs a tracked scan for each.
    pub fn update(&mut self, scan: &DownsampledScan) {
        let previous = self.odom_from_base.replace(scan.odom_from_base).unwrap_or(scan.odom_from_base);
        let moved_m = (scan.odom_from_base.translation.vector - previous.translation.vector).norm();
        let updates = (moved_m / self.config.update_distance_m).min(1.0);
        self.distance_since_search_m += moved_m;
        let keep: Vec<bool> = self.hypotheses.iter_mut().map(|one| one.update(scan, updates)).collect();
        self.reject_behind(keep);
        self.abandon_unsupported(scan, moved_m);
    }

    /// Rejects hypotheses that are not to be kept, and those that have fallen behind the best of the others (equation 8).
    fn reject_behind(&mut self, mut keep: Vec<bool>) {
        let kept = self.hypotheses.iter().zip(&keep).filter(|(_, keep)| **keep);
        let best = kept.map(|(one, _)| one.score).fold(0.0, f64::max);
        for (one, keep) in self.hypotheses.iter().zip(&mut keep) {
            *keep &= best - one.score <= self.config.rejection_margin;
            if !*keep {
                self.rejected.push(one.tracker.map_from_odom());
            }
        }
        let mut keep = keep.into_iter();
        self.hypotheses.retain(|_| keep.next().unwrap_or(false));
    }

    /// Gives up all hypotheses where none has been localised for long enough, and over a long enough distance.
    fn abandon_unsupported(&mut self, scan: &DownsampledScan, moved_m: f64) {
        let PoseTrackerConfig { monitor, information, .. } = &self.config.tracking;
        let elapsed = self.stamp.replace(scan.stamp).map_or(Span::ZERO, |last| scan.stamp - last);
        if self.hypotheses.iter().any(|one| one.is_localised) {
            (self.unsupported_time, self.unsupported_m) = (Span::ZERO, 0.0);
        } else if scan.points.len() >= information.min_points {
            self.unsupported_time = self.unsupported_time + elapsed.min(monitor.max_scan_gap);
            self.unsupported_m += moved_m;
        }
        if self.unsupported_time > self.config.abandon_after
            && self.unsupported_m > self.config.abandon_distance_m
        {
            self.hypotheses.clear();
        }
    }

    /// Whether the whole map was searched so recently that only the hypotheses, and those that were rejected, can look like the scan.
    pub fn is_search_recent(&self) -> bool {
        self.distance_since_search_m <= self.config.search_validity_m
    }

    /// Processes the result of a search of the whole map, for a scan taken at a moment of odometry, while one pose was tracked. Poses that fit as
    /// well, and were not rejected before, become hypotheses. The reason is that the robot may be at none of the poses that looked alike at the
    /// start.
    pub fn inject_hypotheses(
        &mut self,
        localiser: &GlobalLocaliser,
        found: &[PoseHypothesis],
        tracked: &Isometry,
        odom_from_base: &Isometry,
    ) {
        self.distance_since_search_m = 0.0;
        let is_tracked = |one: &PoseHypothesis| {
            localiser.config().acceptance.same_pose.contains(&one.map_from_base, tracked)
        };
        let least = found.iter().find(|one| is_tracked(one)).map_or(0.0, PoseHypothesis::quality);
        let accepted = localiser.classify(found).into_accepted();
        let new = accepted.iter().filter(|one| {
            one.quality() >= least
                && !is_tracked(one)
                && !self.is_rejected(&one.map_from_base, odom_from_base)
        });
        let best = self.hypotheses.iter().map(|one| one.score).fold(0.0, f64::max);
        let score = best - self.config.injection_handicap;
        let new: Vec<TrackedHypothesis> = new
            .map(|pose| TrackedHypothesis::new(&self.config, localiser, pose, score, odom_from_base))
            .collect();
        self.hypotheses.extend(new);
    }

    /// Whether a pose of the base is that of a rejected hypothesis.
    fn is_rejected(&self, map_from_base: &Isometry, odom_from_base: &Isometry) -> bool {
        let tolerance = &self.config.rejected_pose;
        self.rejected.iter().any(|map_from_odom| {
            let offset = (map_from_odom * odom_from_base).inverse() * map_from_base;
            offset.translation.vector.norm() <= tolerance.distance_m
                && offset.rotation.angle() <= tolerance.angle_rad
        })
    }

    /// The tracker of the last hypothesis, once it has seen enough scans and there is no evidence against it.
    pub fn converged(&self) -> Option<&PoseTracker> {
        match self.hypotheses.as_slice() {
            [last] if last.scans >= self.config.min_scans && last.is_localised => Some(&last.tracker),
            _ => None,
        }
    }
}

impl TrackedHypothesis {
    fn new(
        config: &MultiHypothesisConfig,
        localiser: &GlobalLocaliser,
        pose: &PoseHypothesis,
        score: f64,
        odom_from_base: &Isometry,
    ) -> Self {
        let rotation = config.initial_rotation_std_rad * config.initial_rotation_std_rad;
        let translation = config.initial_translation_std_m * config.initial_translation_std_m;
        let covariance = Matrix6::from_diagonal(&Vector6::new(
            rotation,
            rotation,
            rotation,
            translation,
            translation,
            translation,
        ));
        let map_from_base = UncertainPose { pose: pose.map_from_base, covariance };
        // The growth of odometry's own covariance counts from the first scan on.
        let map = Arc::clone(localiser.map());
        let tracker = PoseTracker::new(config.tracking, map, map_from_base, odom_from_base, None);
        Self { tracker, score, scans: 0, is_localised: false }
    }

    /// Tracks a scan that counts as a share of an update (equation 7). Returns whether the robot may still be there.
    fn update(&mut self, scan: &DownsampledScan, updates: f64) -> bool {
        let TrackedPose { status, evidence, .. } = self.tracker.update(scan);
        self.score += updates * evidence.matched_share * (1.0 - evidence.free_space.violation_share());
        self.scans += 1;
        self.is_localised = status == LocalisationStatus::Localised;
        !matches!(status, LocalisationStatus::Lost(_))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::localisation_map::LocalisationMap;
    use crate::testing::{at, room_keyframe, rooms, rooms_keyframes};
    use mapping::KeyframeDescriptor;

    fn pose(x: f64, fit: f64) -> PoseHypothesis {
        PoseHypothesis { map_from_base: Isometry::translation(x, 0.0, 0.0), fit, violation_share: 0.0 }
    }

    fn localiser(keyframes: Vec<(Isometry, KeyframeDescriptor)>) -> GlobalLocaliser {
        GlobalLocaliser::new(Arc::new(LocalisationMap::new(keyframes)))
    }

    fn start(localiser: &GlobalLocaliser, found: &[PoseHypothesis]) -> MultiHypothesisTracker {
        let config = MultiHypothesisConfig::default();
        MultiHypothesisTracker::new(config, localiser, found, None, &Isometry::identity())
    }

    /// A scan without points, of a robot that has walked this far along x.
    fn empty_scan(stamp: Stamp, walked_m: f64) -> DownsampledScan<'static> {
        let odom_from_base = Isometry::translation(walked_m, 0.0, 0.0);
        DownsampledScan { stamp, odom_from_base, covariance: Matrix6::identity() * 1e-6, points: &[] }
    }

    #[test]
    fn all_hypotheses_are_given_up_after_evidence_against_each_for_time_and_distance() {
        // The map is empty, so that the points are nowhere.
        let points: Vec<[f32; 3]> = (0..100_u8).map(|x| [f32::from(x) * 0.1, 1.0, 0.0]).collect();
        let localiser = localiser(Vec::new());
        let scans_until_none = |walked_m: f64, points: &[[f32; 3]]| {
            let mut tracker = start(&localiser, &[pose(0.0, 0.9), pose(5.0, 0.9)]);
            (0..100).find(|&scan| {
                let stamp = Stamp::EPOCH + Span::from_millis(100 * scan);
                let scan = empty_scan(stamp, walked_m * scan as f64 / 50.0);
                tracker.update(&DownsampledScan { points, ..scan });
                assert!(tracker.converged().is_none());
                tracker.is_empty()
            })
        };
        let scans = scans_until_none(2.0, &points);
        assert!(scans.is_some_and(|scans| (25..40).contains(&scans)), "{scans:?}");
        assert_eq!(scans_until_none(0.0, &points), None, "a robot that stands learns nothing");
        assert_eq!(scans_until_none(0.1, &[]), None, "neither does one that sees nothing");
    }

    #[test]
    fn injected_hypotheses_fit_as_well_as_the_last_one_and_were_not_rejected() {
        let localiser = localiser(Vec::new());
        let mut tracker = start(&localiser, &[pose(0.0, 0.9), pose(5.0, 0.5)]);
        tracker.update(&empty_scan(Stamp::EPOCH, 0.0));
        assert_eq!(tracker.len(), 1, "the other fits worse by more than the margin");
        tracker.update(&empty_scan(Stamp::EPOCH + Span::from_millis(100), 1.5));
        assert!(!tracker.is_search_recent());
        let (odom, tracked) = (Isometry::translation(1.5, 0.0, 0.0), Isometry::translation(1.5, 0.0, 0.0));
        let found = [pose(20.0, 0.95), pose(6.5, 0.94), pose(30.0, 0.92), pose(1.5, 0.93)];
        tracker.inject_hypotheses(&localiser, &found, &tracked, &odom);
        assert!(tracker.is_search_recent());
        let positions: Vec<f64> = tracker.poses().iter().map(|pose| pose.translation.x).collect();
        assert_eq!(positions, [1.5, 20.0], "6.5 was rejected, and 30 fits less");
        tracker.inject_hypotheses(&localiser, &[pose(1.5, 0.4)], &tracked, &odom);
        assert_eq!(tracker.len(), 2, "a scan that fits nowhere well injects nothing");
    }

    #[test]
    fn the_pose_tracked_before_starts_level_with_the_best() {
        let localiser = localiser(Vec::new());
        let (better, tracked) = (pose(20.0, 0.9), pose(0.0, 0.6));
        let alone = start(&localiser, &[better, tracked]);
        assert!((alone.hypotheses[1].score - 0.6).abs() < 1e-12);
        let before = Some(&tracked.map_from_base);
        let config = MultiHypothesisConfig::default();
        let odom = Isometry::identity();
        let level = MultiHypothesisTracker::new(config, &localiser, &[better, tracked], before, &odom);
        assert_eq!(level.hypotheses[1].score, 0.9);
    }

    /// Number of hypotheses after each scan of a robot that walks out of the first of two rooms that are alike, and along the corridor past
    /// the box; and whether the last one is the right one.
    fn walk(poses: impl Iterator<Item = Isometry>) -> (Vec<usize>, bool) {
        let localiser = localiser(rooms_keyframes());
        let (first, second) = (at(24.0, 6.0, -1.57), at(4.0, 6.0, -1.57));
        let alike = [first, second].map(|map_from_base| PoseHypothesis {
            map_from_base,
            fit: 0.9,
            violation_share: 0.0,
        });
        let mut tracker = start(&localiser, &alike);
        let walls = rooms();
        let mut counts = Vec::new();
        let mut truth = first;
        for (scan, pose) in (0..).zip(poses) {
            truth = pose;
            let (x, y) = (pose.translation.x, pose.translation.y);
            let yaw = geometry::so3::log(&pose.rotation).z;
            let points: Vec<[f32; 3]> = room_keyframe(&walls, x, y, yaw).1.points().collect();
            tracker.update(&DownsampledScan {
                stamp: Stamp::EPOCH + Span::from_millis(100 * scan),
                odom_from_base: first.inverse() * pose,
                covariance: Matrix6::identity() * 1e-6,
                points: &points,
            });
            counts.push(tracker.len());
        }
        let right = tracker.converged().is_some_and(|tracker| {
            (tracker.map_from_base().pose.translation.vector - truth.translation.vector).norm() < 0.1
        });
        // Odometry starts at the first room, whatever the robot believes.
        (counts, right)
    }

    #[test]
    fn look_alikes_are_distinguished_by_walking_and_not_by_standing() {
        let out = (0..50).map(|step| at(24.0, 6.0 - 0.12 * f64::from(step).min(45.0), -1.57));
        let along = (0..60).map(|step| at(24.0 + 0.12 * f64::from(step), 0.6, -1.57));
        let (counts, right) = walk(out.chain(along));
        assert_eq!(counts[20], 2, "inside the room both fit: {counts:?}");
        assert_eq!(counts.last(), Some(&1), "the box in the corridor rejects one: {counts:?}");
        assert!(right, "{counts:?}");
        let (counts, right) = walk((0..60).map(|_| at(24.0, 6.0, -1.57)));
        assert!(!right && counts.iter().all(|count| *count == 2), "{counts:?}");
    }
}
