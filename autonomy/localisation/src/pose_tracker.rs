//! Tracking the pose from scan to scan: odometry predicts it, and the surfaces of the map correct it.

use crate::localisation_map::LocalisationMap;
use crate::localisation_monitor::{
    LocalisationMonitor, LocalisationMonitorConfig, LocalisationStatus, PoseEvidence,
};
use geometry::{Isometry, Matrix6, Vector6, se3};
use mapping::UncertainPose;
use registration::{
    GaussNewtonConfig, MatchingConfig, ScanInformationConfig, WidthSchedule, gauss_newton, linearise,
    shrink_eigenvalues,
};
use std::sync::Arc;
use vocab::Stamp;

/// Parameters of [`PoseTracker`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseTrackerConfig {
    /// Parameters of the monitor.
    pub monitor: LocalisationMonitorConfig,
    /// How points are matched once the pose is nearly right. The map is made of thinned clouds.
    pub matching: MatchingConfig,
    /// Limits on the information of a scan. A scan of fewer points than its `min_points` does not correct the pose and gives no evidence.
    pub information: ScanInformationConfig,
    /// Iteration from a prediction that is good to centimetres. The prior takes the place of damping. The number of iterations bounds the time of a
    /// step, unlike that of the coarse alignment of
    /// global localisation, which begins far from its result.
    pub iteration: GaussNewtonConfig,
    /// A predicted position with a greater standard deviation, metres, is first matched with a gate and a kernel of twice the size. Chosen: up to it, the gate (0.1 m) is
    /// five standard deviations.
    pub double_gate_std_m: f64,
    /// A predicted position with a greater standard deviation, metres, is first matched with four times the size. Chosen: up to it, the double gate is three standard
    /// deviations.
    pub quadruple_gate_std_m: f64,
    /// Standard deviation of the rotation between two scans of a robot that stands, radians. Chosen: far below the map's own errors, so that a standing robot averages
    /// its scans.
    pub still_rotation_std_rad: f64,
    /// Standard deviation of the translation between two scans of a robot that stands, metres. Chosen: as [`Self::still_rotation_std_rad`].
    pub still_translation_std_m: f64,
    /// Standard deviation of the rotation for each metre walked, radians. Chosen: far above the error of the odometry in docs/benchmarks/odometry.md, so that the map
    /// decides.
    pub rotation_std_rad_per_m: f64,
    /// Standard deviation of the translation for each metre walked, metres. Chosen: 1 % of the distance, far above the error of the odometry in
    /// docs/benchmarks/odometry.md, so that the map decides.
    pub translation_std_m_per_m: f64,
    /// Standard deviation of the rotation for each radian turned, radians. Chosen: half a per cent, for errors of the gyroscope's scale.
    pub rotation_std_rad_per_rad: f64,
    /// Standard deviation of the translation for each radian turned, metres. Chosen: for an error of some millimetres of the lever from the base to the IMU.
    pub translation_std_m_per_rad: f64,
    /// Standard deviation of the map's own rotation errors, radians. Neighbouring scans see the same errors, so averaging over scans does not reduce
    /// them. They are added to the reported covariance and not propagated. Chosen: twice the least standard deviation of a registration (`mapping::RegistrationFloor`).
    pub map_rotation_std_rad: f64,
    /// Standard deviation of the map's own translation errors, metres; see `map_rotation_std_rad`. Chosen: about the least standard deviation of a registration, 5 mm
    /// (`mapping::RegistrationFloor`).
    pub map_translation_std_m: f64,
}

impl Default for PoseTrackerConfig {
    fn default() -> Self {
        Self {
            monitor: LocalisationMonitorConfig::default(),
            matching: MatchingConfig { noise_m: 0.015, front_facing_only: true, ..MatchingConfig::default() },
            information: ScanInformationConfig::default(),
            iteration: GaussNewtonConfig {
                max_iterations: 8,
                min_step: 1e-4,
                initial_width: 1.0,
                schedule: WidthSchedule::Halving,
                relative_damping: 0.0,
                absolute_damping: 0.0,
            },
            double_gate_std_m: 0.02,
            quadruple_gate_std_m: 0.06,
            still_rotation_std_rad: 1e-4,
            still_translation_std_m: 5e-4,
            rotation_std_rad_per_m: 1e-3,
            translation_std_m_per_m: 0.01,
            rotation_std_rad_per_rad: 5e-3,
            translation_std_m_per_rad: 2e-3,
            map_rotation_std_rad: 1e-3,
            map_translation_std_m: 6e-3,
        }
    }
}

/// A downsampled scan whose motion odometry has corrected.
#[derive(Clone, Copy, Debug)]
pub struct DownsampledScan<'a> {
    /// Instant of the pose.
    pub stamp: Stamp,
    /// Pose of the base by odometry.
    pub odom_from_base: Isometry,
    /// Covariance of that pose, `[rotation; translation]`.
    pub covariance: Matrix6,
    /// Some thousands of points, spread evenly, base frame, metres.
    pub points: &'a [[f32; 3]],
}

/// The pose after a scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackedPose {
    /// Pose of the base in the map.
    pub map_from_base: UncertainPose,
    /// Whether it can be trusted.
    pub status: LocalisationStatus,
    /// Evidence of the scan for and against it.
    pub evidence: PoseEvidence,
}

/// Tracks the pose of the base in a known map.
#[derive(Clone, Debug)]
pub struct PoseTracker {
    config: PoseTrackerConfig,
    map: Arc<LocalisationMap>,
    map_from_base: UncertainPose,
    /// Odometry at the latest scan.
    odom_from_base: Isometry,
    /// Covariance of that, if it is known.
    odometry_covariance: Option<Matrix6>,
    monitor: LocalisationMonitor,
}

impl PoseTracker {
    /// Starts at a pose with its covariance, at a moment of odometry. `odometry_covariance` is odometry's own covariance at that moment, if it is
    /// known. Only its growth from then on is used.
    pub fn new(
        config: PoseTrackerConfig,
        map: Arc<LocalisationMap>,
        map_from_base: UncertainPose,
        odom_from_base: &Isometry,
        odometry_covariance: Option<Matrix6>,
    ) -> Self {
        let monitor = LocalisationMonitor::new(config.monitor);
        Self { config, map, map_from_base, odom_from_base: *odom_from_base, odometry_covariance, monitor }
    }

    /// Pose of odometry's frame in the map.
    pub fn map_from_odom(&self) -> Isometry {
        self.map_from_base.pose * self.odom_from_base.inverse()
    }

    /// Pose of the base at the latest scan.
    pub fn map_from_base(&self) -> &UncertainPose {
        &self.map_from_base
    }

    /// Corrects the pose by the next scan. Matches its points eight times at most, and compares them with the nearest keyframes once.
    pub fn update(&mut self, scan: &DownsampledScan) -> TrackedPose {
        let predicted = self.predict(scan);
        let aligned = (scan.points.len() >= self.config.information.min_points)
            .then(|| align(&self.config, &self.map, &predicted, scan.points));
        let mut evidence = PoseEvidence::default();
        if let Some(aligned) = aligned {
            self.map_from_base = aligned.map_from_base;
            evidence.is_aligned = true;
            (evidence.matched_share, evidence.mapped_share) = (aligned.matched_share, aligned.mapped_share);
            evidence.free_space = self.map.check_free_space(&aligned.map_from_base.pose, scan.points);
        } else {
            self.map_from_base = predicted;
        }
        let UncertainPose { pose, covariance } = self.map_from_base;
        let map_from_base = UncertainPose { pose, covariance: covariance + self.map_covariance() };
        evidence.position_std_m = map_from_base.translation_std_m();
        let status = self.monitor.update(scan.stamp, &evidence);
        TrackedPose { map_from_base, status, evidence }
    }

    /// The pose moved by odometry's motion since the latest scan (equation 1). Its covariance grows by the motion, and by as much as
    /// odometry's own covariance has grown.
    fn predict(&mut self, scan: &DownsampledScan) -> UncertainPose {
        let previous = std::mem::replace(&mut self.odom_from_base, scan.odom_from_base);
        let previous_covariance =
            self.odometry_covariance.replace(scan.covariance).unwrap_or(scan.covariance);
        let motion = previous.inverse() * scan.odom_from_base;
        let (walked_m, turned_rad) = (motion.translation.vector.norm(), motion.rotation.angle());
        let variance = |still: f64, per_metre: f64, per_radian: f64| {
            (still + per_metre * walked_m + per_radian * turned_rad).powi(2)
        };
        let growth = (scan.covariance - previous_covariance).diagonal();
        let [rotation_growth, translation_growth] =
            [0, 3].map(|first| growth.fixed_rows::<3>(first).max().max(0.0));
        let config = &self.config;
        let rotation = variance(
            config.still_rotation_std_rad,
            config.rotation_std_rad_per_m,
            config.rotation_std_rad_per_rad,
        ) + rotation_growth;
        let translation = variance(
            config.still_translation_std_m,
            config.translation_std_m_per_m,
            config.translation_std_m_per_rad,
        ) + translation_growth;
        self.map_from_base
            .compose(&UncertainPose { pose: motion, covariance: diagonal(rotation, translation) })
    }

    /// Covariance of the map's own errors (equation 3).
    fn map_covariance(&self) -> Matrix6 {
        let (rotation, translation) = (self.config.map_rotation_std_rad, self.config.map_translation_std_m);
        diagonal(rotation * rotation, translation * translation)
    }
}

struct Aligned {
    map_from_base: UncertainPose,
    /// Share of the points on known surfaces.
    matched_share: f64,
    /// Share of the points near known surfaces.
    mapped_share: f64,
}

/// The pose at which prediction and surfaces agree best: iterated Gauss-Newton with the prediction as prior (equation 2).
fn align(
    config: &PoseTrackerConfig,
    map: &LocalisationMap,
    predicted: &UncertainPose,
    points: &[[f32; 3]],
) -> Aligned {
    let prior = predicted.information();
    let position_std_m = predicted.translation_std_m();
    let initial_width = if position_std_m > config.quadruple_gate_std_m {
        4.0
    } else if position_std_m > config.double_gate_std_m {
        2.0
    } else {
        config.iteration.initial_width
    };
    let iteration = GaussNewtonConfig { initial_width, ..config.iteration };
    let squares: f64 = points.iter().map(|p| p.iter().map(|c| f64::from(c * c)).sum::<f64>()).sum();
    let granted = &config.information;
    let lever_arm_m = (squares / points.len().max(1) as f64).sqrt().max(granted.min_lever_arm_m);
    let (mut information, mut matched_share, mut mapped_share) = (Matrix6::zeros(), 0.0, 0.0);
    let pose = gauss_newton(predicted.pose, &config.matching, &iteration, |pose, matching| {
        let equations = linearise(map.surfaces(), points, pose, matching);
        let shrunk = shrink_eigenvalues(
            &equations.information,
            &equations.gradient,
            lever_arm_m,
            granted.eigenvalue_shrinkage,
        );
        information = shrunk.information / granted.correlated_points;
        [matched_share, mapped_share] =
            [equations.inliers, equations.matched].map(|count| count as f64 / points.len().max(1) as f64);
        let offset = se3::local(&predicted.pose, pose);
        let gradient = shrunk.gradient / granted.correlated_points + prior * offset;
        let step = iteration.solve(&(information + prior), &gradient)?;
        Some((se3::retract(pose, &step), step.norm()))
    });
    let covariance = (information + prior).cholesky().map_or(predicted.covariance, |factor| factor.inverse());
    let covariance = (covariance + covariance.transpose()) * 0.5;
    Aligned { map_from_base: UncertainPose { pose, covariance }, matched_share, mapped_share }
}

/// A covariance with these variances of each axis.
fn diagonal(rotation: f64, translation: f64) -> Matrix6 {
    Matrix6::from_diagonal(&Vector6::new(rotation, rotation, rotation, translation, translation, translation))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{at, room_keyframe, rooms};
    use vocab::Span;

    fn scan<'a>(
        millis: i64,
        odom_from_base: &Isometry,
        covariance: f64,
        points: &'a [[f32; 3]],
    ) -> DownsampledScan<'a> {
        DownsampledScan {
            stamp: Stamp::EPOCH + Span::from_millis(millis),
            odom_from_base: *odom_from_base,
            covariance: Matrix6::identity() * covariance,
            points,
        }
    }

    #[test]
    fn scans_correct_a_pose_that_is_wrong_by_20_cm() {
        let rooms = rooms();
        let map = Arc::new(LocalisationMap::new(vec![room_keyframe(&rooms, 4.0, 4.0, 0.0)]));
        let truth = at(4.2, 4.1, 0.1);
        let points: Vec<[f32; 3]> = room_keyframe(&rooms, 4.2, 4.1, 0.1).1.points().collect();
        let start = UncertainPose { pose: at(4.05, 4.2, 0.13), covariance: diagonal(0.05_f64.powi(2), 0.16) };
        let odom = Isometry::identity();
        let mut tracker = PoseTracker::new(PoseTrackerConfig::default(), map, start, &odom, None);
        let mut pose = None;
        for step in 0..5 {
            pose = Some(tracker.update(&scan(100 * step, &odom, 1e-6, &points)));
        }
        let Some(pose) = pose else { panic!("five scans were tracked") };
        let error = truth.inverse() * pose.map_from_base.pose;
        assert!(error.translation.vector.norm() < 0.02 && error.rotation.angle() < 0.01, "{error}");
        assert_eq!(pose.status, LocalisationStatus::Localised, "{:?}", pose.evidence);
    }

    #[test]
    fn without_points_odometry_moves_the_pose_and_its_covariance_grows_with_the_motion() {
        let config = PoseTrackerConfig::default();
        let map = Arc::new(LocalisationMap::new(Vec::new()));
        let start = UncertainPose { pose: at(1.0, 2.0, 0.0), covariance: Matrix6::zeros() };
        let mut tracker = PoseTracker::new(config, map, start, &Isometry::identity(), None);
        tracker.update(&scan(0, &at(2.0, 0.0, 0.0), 1e-6, &[]));
        let moved = *tracker.map_from_base();
        assert!((moved.pose.translation.vector - at(3.0, 2.0, 0.0).translation.vector).norm() < 1e-12);
        let expected = (5e-4_f64 + 0.01 * 2.0).powi(2);
        assert!((moved.covariance[(3, 3)] - expected).abs() < 1e-12, "{}", moved.covariance);
        // A stretch without LiDAR counts as much as odometry says.
        tracker.update(&scan(100, &at(2.0, 0.0, 0.0), 0.01, &[]));
        let grown = tracker.map_from_base().covariance - moved.covariance;
        assert!((grown[(3, 3)] - (0.01 - 1e-6 + 2.5e-7)).abs() < 1e-9, "{grown}");
    }
}
