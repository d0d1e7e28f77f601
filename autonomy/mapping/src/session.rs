//! One mapping session: its pose graph, the trajectory of the robot in the map, and the pose of the odometry's frame.

use crate::Odometer;
use crate::graph_element::{PoseGraphEdge, PoseGraphNode, renormalised};
use crate::graph_optimiser::OptimiserConfig;
use crate::pose_graph::PoseGraph;
use crate::registration_floor::RegistrationFloor;
use crate::vertical::MeasuredVertical;
use geometry::{Isometry, Matrix6, Vector3, Vector6, se3, so3};
use vocab::{KeyframeId, Span, Stamp};

/// Parameters of a [`Session`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SessionConfig {
    /// When a scan becomes a waypoint. It is that of the robot's profile.
    pub keyframes: KeyframePolicy,
    /// Least standard deviation of an odometry edge's rotation, radians. An edge is a registration like that of a loop, and
    /// [`RegistrationFloor`] is the default of both.
    pub min_rotation_std_rad: f64,
    /// The same for its translation, metres.
    pub min_translation_std_m: f64,
    /// Scans farther apart than this leave a gap that the LiDAR did not observe. Chosen: two periods of the slowest LiDARs, which turn twice a second, so that a single
    /// lost scan is no gap.
    pub max_scan_gap: Span,
    /// Standard deviation of a distance that only legs and IMU followed, as a share of the distance. Feet slip in ways that no filter models. Chosen: 3 % as a round
    /// number: less trusts slipping feet, more lets the next loop bend that part of the walk.
    pub dead_reckoning_std_share: f64,
    /// Greatest number of entries of the trajectory, 68 B each: a pose for each scan of the last hour and a half at 10 Hz, and fewer of the walk
    /// before. Chosen: they take 9 MB.
    pub max_trajectory_entries: usize,
    /// Degenerate scans at most this far apart belong to one segment. Chosen: five scans at 10 Hz.
    pub max_segment_gap: Span,
}

impl SessionConfig {
    /// With the keyframes of a robot's profile.
    pub fn new(keyframes: KeyframePolicy) -> Self {
        Self {
            keyframes,
            min_rotation_std_rad: RegistrationFloor::default().rotation_std_rad,
            min_translation_std_m: RegistrationFloor::default().translation_std_m,
            max_scan_gap: Span::from_millis(1_000),
            dead_reckoning_std_share: 0.03,
            max_trajectory_entries: 1 << 17,
            max_segment_gap: Span::from_millis(500),
        }
    }
}

/// When a scan becomes a waypoint: as soon as either limit is exceeded since the last one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyframePolicy {
    /// Translation, metres.
    pub distance_m: f64,
    /// Rotation, radians.
    pub rotation_rad: f64,
}

/// The relative pose of two successive waypoints by odometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdometryStep {
    /// Pose of the later one in the earlier one.
    pub pose: Isometry,
    /// Inverse covariance, `[rotation; translation]`.
    pub information: Matrix6,
}

impl OdometryStep {
    /// The pose with its covariance.
    pub fn relative_pose(&self) -> crate::UncertainPose {
        crate::UncertainPose::from_information(self.pose, &self.information)
    }
}

/// A scan far enough from the last waypoint: it becomes a keyframe or is a revisit of known ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// Stamp of the pose.
    pub stamp: Stamp,
    /// Pose of the base.
    pub map_from_base: Isometry,
    /// Odometry from the last waypoint; `None` for the first.
    pub step: Option<OdometryStep>,
    /// The vertical there, if odometry measures it.
    pub vertical: Option<MeasuredVertical>,
}

/// The odometry's pose of a motion-corrected scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanPose {
    /// The instant to which the points were corrected.
    pub stamp: Stamp,
    /// Pose of the base at `stamp`, and of the cloud.
    pub odom_from_base: Isometry,
    /// Stamp of the scan itself.
    pub scan_stamp: Stamp,
    /// Pose of the base at `scan_stamp`, for the trajectory.
    pub odom_from_base_at_scan: Isometry,
    /// Covariance of `odom_from_base`, `[rotation; translation]`. It grows along the walk.
    pub covariance: Matrix6,
    /// The part of the covariance that comes from gaps without any measurement. It stays the same for all later scans.
    pub covariance_inflation: Matrix6,
    /// Whether the LiDAR did not observe some direction.
    pub is_degenerate: bool,
    /// Whether an IMU measures gravity, so that the tilt of `odom_from_base` does not drift.
    pub is_gravity_measured: bool,
    /// Whether the LiDAR measured nothing, or nothing that fits the earlier scans. The pose is dead reckoning then, and the scan no waypoint.
    pub is_dead_reckoned: bool,
}

/// A part of the walk in which the LiDAR did not observe some direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DegenerateSegment {
    /// First such scan.
    pub from: Stamp,
    /// Last such scan.
    pub until: Stamp,
    /// Distance walked in it, metres.
    pub distance_m: f64,
}

/// A map under construction: the one owner of its pose graph.
#[derive(Debug)]
pub struct Session {
    config: SessionConfig,
    graph: PoseGraph,
    map_from_odom: Isometry,
    trajectory: Vec<(Stamp, Isometry)>,
    /// For each entry of the trajectory, the keyframe with which it moves.
    trajectory_anchors: Vec<KeyframeId>,
    segments: Vec<DegenerateSegment>,
    odometer: Odometer,
    /// Stamp of the last scan that was not dead reckoning.
    last_scan: Option<Stamp>,
    /// Distance walked without such a scan since the last waypoint, metres.
    unobserved_m: f64,
    last_waypoint: Option<LastWaypoint>,
    /// The keyframe with which the robot moves.
    anchor: KeyframeId,
    /// Whether the last waypoint was on known ground.
    is_revisiting: bool,
}

/// The last waypoint in the odometry's frame.
#[derive(Clone, Copy, Debug)]
struct LastWaypoint {
    odom_from_base: Isometry,
    covariance: Matrix6,
    covariance_inflation: Matrix6,
}

impl Session {
    /// Begins a map at the robot: its origin is the base, its x axis the heading, its z axis up. `graph` is empty.
    pub fn begin(odom_from_base: &Isometry, config: SessionConfig, graph: PoseGraph) -> Self {
        let forward = odom_from_base.rotation * Vector3::x();
        let heading = so3::exp(&(Vector3::z() * forward.y.atan2(forward.x)));
        let odom_from_map = Isometry::from_parts(odom_from_base.translation, heading);
        Self {
            config,
            graph,
            map_from_odom: odom_from_map.inverse(),
            trajectory: Vec::new(),
            trajectory_anchors: Vec::new(),
            segments: Vec::new(),
            odometer: Odometer::default(),
            last_scan: None,
            unobserved_m: 0.0,
            last_waypoint: None,
            anchor: KeyframeId(0),
            is_revisiting: false,
        }
    }

    /// As [`Self::begin`], with an empty graph that is optimised.
    pub fn new(odom_from_base: &Isometry, config: SessionConfig) -> Self {
        Self::begin(odom_from_base, config, PoseGraph::new(OptimiserConfig::default()))
    }

    /// The pose graph.
    pub fn graph(&self) -> &PoseGraph {
        &self.graph
    }

    /// The pose graph, for adding keyframes and loops. Poses are changed by [`Self::optimise`] only.
    pub fn graph_mut(&mut self) -> &mut PoseGraph {
        &mut self.graph
    }

    /// Pose of the odometry's frame in the map.
    pub fn map_from_odom(&self) -> &Isometry {
        &self.map_from_odom
    }

    /// Adds the pose of a motion-corrected scan and makes every waypoint a keyframe. Returns the keyframe, if there is a new one.
    pub fn add_scan(&mut self, scan: &ScanPose) -> Option<PoseGraphNode> {
        let waypoint = self.add_scan_pose(scan)?;
        Some(self.add_keyframe(&waypoint))
    }

    /// Adds the pose of a motion-corrected scan. Returns it if it is a waypoint, which then becomes a keyframe ([`Self::add_keyframe`] or
    /// [`Self::anchor_at`]) or is a revisit ([`Self::mark_revisit`]). Constant time.
    pub fn add_scan_pose(&mut self, scan: &ScanPose) -> Option<Waypoint> {
        let at_scan = self.map_from_odom * scan.odom_from_base_at_scan;
        let step_m = self
            .trajectory
            .last()
            .map_or(0.0, |(_, last)| (last.translation.vector - at_scan.translation.vector).norm());
        if self.last_scan.is_some_and(|last| scan.stamp - last > self.config.max_scan_gap) {
            self.unobserved_m += step_m;
        }
        if !scan.is_dead_reckoned {
            self.last_scan = Some(scan.stamp);
        }
        // In the odometry's frame, because a correction of the map is not a walk.
        self.odometer.move_to(&scan.odom_from_base_at_scan.translation.vector);
        self.append_trajectory(scan.scan_stamp, at_scan);
        // On known ground, earlier scans of the place constrain the pose.
        if scan.is_degenerate && !self.is_revisiting {
            self.append_degenerate(scan.stamp, step_m);
        }
        if scan.is_dead_reckoned { None } else { self.waypoint(scan) }
    }

    /// Makes a waypoint a keyframe, with an edge from the last keyframe. Each waypoint before must have become one, too.
    pub fn add_keyframe(&mut self, waypoint: &Waypoint) -> PoseGraphNode {
        let edge = self.graph.nodes().last().zip(waypoint.step).map(|(last, step)| PoseGraphEdge {
            from: last.id,
            to: self.graph.next_id(),
            from_from_to: step.pose,
            information: step.information,
        });
        if let Some(edge) = &edge {
            self.graph.add_distance(edge.from_from_to.translation.vector.norm());
        }
        let node = self.graph.add_keyframe(waypoint.stamp, &waypoint.map_from_base, edge.as_ref());
        self.anchor_at(node.id);
        node
    }

    /// The newest waypoint became this keyframe of the graph: the robot moves with it.
    pub fn anchor_at(&mut self, keyframe: KeyframeId) {
        (self.anchor, self.is_revisiting) = (keyframe, false);
    }

    /// Whether the last waypoint was on known ground.
    pub fn is_revisiting(&self) -> bool {
        self.is_revisiting
    }

    /// The newest waypoint is on known ground. Nothing of it is stored.
    pub fn mark_revisit(&mut self) {
        self.is_revisiting = true;
    }

    /// The robot's pose is known from another keyframe, see [`crate::Reanchoring`]. The trajectory since then moves along, and nothing else does.
    /// Linear in that part.
    pub fn reanchor(&mut self, since: Stamp, anchor: KeyframeId, anchor_from_waypoint: &Isometry) {
        let (Some(last), Some(node)) = (self.last_waypoint, self.graph.nodes().get(anchor.0 as usize)) else {
            return;
        };
        let before = self.map_from_odom;
        self.map_from_odom =
            renormalised(&(node.map_from_keyframe * anchor_from_waypoint * last.odom_from_base.inverse()));
        let correction = self.map_from_odom * before.inverse();
        let first = self.trajectory.partition_point(|(stamp, _)| *stamp < since);
        for (entry, moves_with) in self.trajectory.iter_mut().zip(&mut self.trajectory_anchors).skip(first) {
            entry.1 = correction * entry.1;
            *moves_with = anchor;
        }
        self.anchor = anchor;
    }

    /// Optimises the graph. The trajectory and the odometry's frame move along, each with its keyframe, so that there is no jump at the robot.
    /// Returns whether the graph could be optimised, see [`PoseGraph::failure`]. Linear in the trajectory, some 10 ns an entry, besides the
    /// optimisation.
    pub fn optimise(&mut self) -> bool {
        let corrections = self.graph.optimise();
        corrections.inspect(|corrections| self.apply(corrections)).is_some()
    }

    /// Sets the poses of the first keyframes, see [`PoseGraph::move_keyframes`]. The trajectory and the odometry's frame move along.
    pub fn move_keyframes(&mut self, poses: &[Isometry]) {
        let corrections = self.graph.move_keyframes(poses);
        self.apply(&corrections);
    }

    /// Moves the trajectory and the odometry's frame by the corrections of their keyframes.
    fn apply(&mut self, corrections: &[Isometry]) {
        let last = corrections.last().copied().unwrap_or_else(Isometry::identity);
        let correction = |anchor: KeyframeId| corrections.get(anchor.0 as usize).unwrap_or(&last);
        for ((_, pose), anchor) in self.trajectory.iter_mut().zip(&self.trajectory_anchors) {
            *pose = correction(*anchor) * *pose;
        }
        self.map_from_odom = renormalised(&(correction(self.anchor) * self.map_from_odom));
    }

    /// Distance walked, metres.
    pub fn distance_m(&self) -> f64 {
        self.odometer.distance()
    }

    /// Pose of the base in the map after every scan. In long sessions, only some of the poses from more than an hour and a half ago.
    pub fn trajectory(&self) -> &[(Stamp, Isometry)] {
        &self.trajectory
    }

    /// Parts of the walk in which the LiDAR alone did not observe the motion.
    pub fn degenerate_segments(&self) -> &[DegenerateSegment] {
        &self.segments
    }

    fn waypoint(&mut self, scan: &ScanPose) -> Option<Waypoint> {
        let step = match self.last_waypoint {
            None => None,
            Some(last) => {
                let pose = renormalised(&(last.odom_from_base.inverse() * scan.odom_from_base));
                let policy = &self.config.keyframes;
                let is_far = pose.translation.vector.norm() > policy.distance_m
                    || so3::log(&pose.rotation).norm() > policy.rotation_rad;
                if !is_far {
                    return None;
                }
                let unobserved_std_m =
                    self.config.dead_reckoning_std_share * std::mem::take(&mut self.unobserved_m);
                let tracked = (
                    last.covariance - last.covariance_inflation,
                    scan.covariance - scan.covariance_inflation,
                );
                let inflation = scan.covariance_inflation - last.covariance_inflation;
                let added_variances = inflation.diagonal().map(|variance| variance.max(0.0))
                    + Vector6::new(0.0, 0.0, 0.0, 1.0, 1.0, 1.0) * (unobserved_std_m * unobserved_std_m);
                let information =
                    edge_information(&tracked.0, &tracked.1, &pose, &added_variances, &self.config);
                Some(OdometryStep { pose, information })
            }
        };
        let ScanPose { odom_from_base, covariance, covariance_inflation, .. } = *scan;
        self.last_waypoint = Some(LastWaypoint { odom_from_base, covariance, covariance_inflation });
        let map_from_base = self.map_from_odom * scan.odom_from_base;
        let inflated = covariance_inflation.fixed_view::<3, 3>(0, 0).diagonal().max();
        let vertical = scan.is_gravity_measured.then(|| MeasuredVertical {
            up: odom_from_base.rotation.inverse() * Vector3::z(),
            inflation_rad2: inflated,
        });
        Some(Waypoint { stamp: scan.stamp, map_from_base, step, vertical })
    }

    /// Appends to the trajectory. If it is full, every second entry of its older half is dropped first.
    fn append_trajectory(&mut self, stamp: Stamp, map_from_base: Isometry) {
        if self.trajectory.len() >= self.config.max_trajectory_entries {
            thin_older_half(&mut self.trajectory);
            thin_older_half(&mut self.trajectory_anchors);
        }
        self.trajectory.push((stamp, map_from_base));
        self.trajectory_anchors.push(self.anchor);
    }

    fn append_degenerate(&mut self, stamp: Stamp, step_m: f64) {
        match self.segments.last_mut() {
            Some(segment) if stamp - segment.until <= self.config.max_segment_gap => {
                segment.until = stamp;
                segment.distance_m += step_m;
            }
            _ => self.segments.push(DegenerateSegment { from: stamp, until: stamp, distance_m: 0.0 }),
        }
    }
}

/// Drops every second entry of the first half.
fn thin_older_half<T>(entries: &mut Vec<T>) {
    let (mut count, half) = (0, entries.len() / 2);
    entries.retain(|_| {
        count += 1;
        count > half || count % 2 == 1
    });
}

/// Information of the relative pose between two moments of one odometry (docs/maths/loops.md, equation 12).
///
/// It comes from the growth of the absolute covariance, after the old one was moved into the new frame. Only the diagonal of the difference is used,
/// with a floor, because the difference of two estimates of a filter need not be positive definite. Where it shrank, the pose was corrected by
/// about as much. `added_variances` are added.
fn edge_information(
    before: &Matrix6,
    after: &Matrix6,
    from_from_to: &Isometry,
    added_variances: &Vector6,
    config: &SessionConfig,
) -> Matrix6 {
    let ad = se3::adjoint(&from_from_to.inverse());
    let growth = after - ad * before * ad.transpose();
    Matrix6::from_fn(|row, column| {
        if row != column {
            return 0.0;
        }
        let floor = if row < 3 { config.min_rotation_std_rad } else { config.min_translation_std_m };
        let variance = growth[(row, row)].abs().max(floor * floor) + added_variances[row];
        if variance.is_finite() { 1.0 / variance } else { 0.0 }
    })
}

#[cfg(test)]
#[path = "session_tests.rs"]
mod tests;
