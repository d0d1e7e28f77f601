//! One mapping session.

use crate::Odometer;
use geometry::{Isometry, Matrix6, Rotation, Vector6, se3, so3};
use vocab::{KeyframeId, Span, Stamp};

/// Floor of the standard deviation of an odometry edge: rotation (rad) and translation (m). What a cell size of some
/// centimetres and unmodelled vibration leave even where the filter believes itself perfect.
const EDGE_FLOOR: (f64, f64) = (1e-3, 5e-3);
/// Scans farther apart than this leave a stretch between them that the LiDAR did not see.
const UNSEEN_AFTER: Span = Span::from_millis(1_000);
/// Standard deviation of a way that only legs and IMU followed, as a share of its length: feet slip in ways that no filter knows of.
const UNSEEN_SHARE: f64 = 0.03;
/// Entries of the trajectory at most, 76 B each: a pose a scan for the last hour and a half at
/// 10 Hz and more, and fewer of what was walked before.
const TRAJECTORY: usize = 1 << 17;
/// Degenerate scans closer together than this belong to one stretch.
const STRETCH_GAP: Span = Span::from_millis(500);

/// When a scan becomes a keyframe: as soon as either is exceeded since the last one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyframePolicy {
    /// Metres moved.
    pub distance: f64,
    /// Radians turned.
    pub rotation: f64,
}

impl Default for KeyframePolicy {
    /// A metre or 40 degrees: neighbouring XT-32 scans then overlap by more than 80 % indoors.
    fn default() -> Self {
        Self { distance: 1.0, rotation: 0.7 }
    }
}

/// A keyframe's place in the graph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Counts from 0.
    pub id: KeyframeId,
    /// When it was made.
    pub stamp: Stamp,
    /// Where.
    pub map_from_keyframe: Isometry,
}

/// A measured relative pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Parent.
    pub from: KeyframeId,
    /// Child.
    pub to: KeyframeId,
    /// Pose of the child in the parent.
    pub from_from_to: Isometry,
    /// Inverse covariance, `[rotation; translation]`.
    pub information: Matrix6,
}

/// The way between two waypoints by odometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Pose of the later one in the earlier one.
    pub pose: Isometry,
    /// Its inverse covariance, `[rotation; translation]`.
    pub information: Matrix6,
}

/// A scan far enough from the last waypoint to be one: it becomes a keyframe, or is a visit to known ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// When.
    pub stamp: Stamp,
    /// Where.
    pub map_from_base: Isometry,
    /// From the last waypoint; none to the first.
    pub step: Option<Step>,
}

/// What odometry says of one motion-corrected scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanPose {
    /// The instant to which its points were moved.
    pub stamp: Stamp,
    /// Base at `stamp`: the pose of the cloud.
    pub odom_from_base: Isometry,
    /// The scan's own stamp.
    pub scan_stamp: Stamp,
    /// Base at `scan_stamp`: what the trajectory lists.
    pub odom_from_base_at_scan: Isometry,
    /// Of `odom_from_base`, `[rotation; translation]`, growing along the walk.
    pub covariance: Matrix6,
    /// What of it stretches left on which nothing was followed, the same for all scans after them.
    pub guessed: Matrix6,
    /// Whether the LiDAR did not see some direction.
    pub degenerate: bool,
    /// Whether it saw nothing, or nothing that fits what was seen before: the pose is a guess then, and no waypoint.
    pub blind: bool,
}

/// A stretch of the walk in which the LiDAR did not see some direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DegenerateSegment {
    /// First such scan.
    pub from: Stamp,
    /// Last such scan.
    pub until: Stamp,
    /// Metres walked in it.
    pub distance: f64,
}

/// A map under construction.
#[derive(Clone, Debug)]
pub struct Session {
    policy: KeyframePolicy,
    map_from_odom: Isometry,
    nodes: Vec<Node>,
    edges: Vec<Edge>,
    loops: Vec<Edge>,
    trajectory: Vec<(Stamp, Isometry)>,
    /// For each entry of the trajectory, the keyframe with which it moves.
    trajectory_anchors: Vec<KeyframeId>,
    stretches: Vec<DegenerateSegment>,
    odometer: Odometer,
    /// When the last scan was that saw, and metres walked without one since the last waypoint.
    last_scan: Option<Stamp>,
    unseen: f64,
    /// The last waypoint in odometry's frame, with its covariance there and what of it is a guess.
    last_waypoint: Option<(Isometry, Matrix6, Matrix6)>,
    /// The keyframe with which the robot moves, and whether it is on known ground.
    anchor: KeyframeId,
    visiting: bool,
    revision: u64,
}

impl Session {
    /// Begins where the robot stands: the map's origin is the base, its x axis the heading, its z axis up.
    pub fn begin(odom_from_base: &Isometry, policy: KeyframePolicy) -> Self {
        let forward = odom_from_base.rotation * geometry::Vector3::x();
        let heading = so3::exp(&(geometry::Vector3::z() * forward.y.atan2(forward.x)));
        let odom_from_map = Isometry::from_parts(odom_from_base.translation, heading);
        Self {
            policy,
            map_from_odom: odom_from_map.inverse(),
            nodes: Vec::new(),
            edges: Vec::new(),
            loops: Vec::new(),
            trajectory: Vec::new(),
            trajectory_anchors: Vec::new(),
            stretches: Vec::new(),
            odometer: Odometer::default(),
            last_scan: None,
            unseen: 0.0,
            last_waypoint: None,
            anchor: KeyframeId(0),
            visiting: false,
            revision: 0,
        }
    }

    /// Goes on from a finished map with these keyframes (numbered from 0), ways and loops. Where the robot is in it is told by
    /// [`Self::reanchor`]; until then poses are as if the map began here.
    pub fn resume(
        odom_from_base: &Isometry,
        policy: KeyframePolicy,
        (nodes, edges, loops): (Vec<Node>, Vec<Edge>, Vec<Edge>),
    ) -> Self {
        Self { nodes, edges, loops, revision: 1, ..Self::begin(odom_from_base, policy) }
    }

    /// Where the odometry's frame is in the map.
    pub fn map_from_odom(&self) -> &Isometry {
        &self.map_from_odom
    }

    /// Adds the pose of a motion-corrected scan, every waypoint becoming a keyframe; returns it if it did.
    pub fn add_scan(&mut self, scan: &ScanPose) -> Option<Node> {
        let waypoint = self.add_scan_pose(scan)?;
        let edge = self.edge_to(&waypoint);
        Some(self.add_keyframe(&waypoint, edge))
    }

    /// The edge from the last keyframe to a waypoint, if that was the waypoint before.
    pub fn edge_to(&self, waypoint: &Waypoint) -> Option<Edge> {
        let (last, step) = self.nodes.last().zip(waypoint.step)?;
        let (from, to) = (last.id, self.next_id());
        Some(Edge { from, to, from_from_to: step.pose, information: step.information })
    }

    /// Follows the pose of a motion-corrected scan; returns it if it is a waypoint, which then either becomes a keyframe
    /// ([`Self::add_keyframe`]) or is one on known ground ([`Self::mark_revisit`]). Constant time.
    pub fn add_scan_pose(&mut self, scan: &ScanPose) -> Option<Waypoint> {
        let at_scan = self.map_from_odom * scan.odom_from_base_at_scan;
        let step = self
            .trajectory
            .last()
            .map_or(0.0, |(_, last)| (last.translation.vector - at_scan.translation.vector).norm());
        if self.last_scan.is_some_and(|last| scan.stamp - last > UNSEEN_AFTER) {
            self.unseen += step;
        }
        if !scan.blind {
            self.last_scan = Some(scan.stamp);
        }
        // In odometry's frame: what moves the map is no walk.
        self.odometer.move_to(&scan.odom_from_base_at_scan.translation.vector);
        self.note(scan.scan_stamp, at_scan);
        // What is known ground is held by what was seen of it before.
        if scan.degenerate && !self.visiting {
            self.note_degenerate(scan.stamp, step);
        }
        if scan.blind { None } else { self.waypoint(scan) }
    }

    /// A waypoint becomes a keyframe, that `edge` leads to from an old one; none leads to the first.
    pub fn add_keyframe(&mut self, waypoint: &Waypoint, edge: Option<Edge>) -> Node {
        let node =
            Node { id: self.next_id(), stamp: waypoint.stamp, map_from_keyframe: waypoint.map_from_base };
        self.edges.extend(edge);
        self.nodes.push(node);
        (self.anchor, self.visiting) = (node.id, false);
        self.revision += 1;
        node
    }

    /// Whether the last waypoint was on known ground.
    pub fn is_revisiting(&self) -> bool {
        self.visiting
    }

    /// The newest waypoint is on known ground: nothing is kept of it.
    pub fn mark_revisit(&mut self) {
        self.visiting = true;
    }

    /// The robot's place is known anew, see [`crate::Reanchoring`]: what was walked since moves along, and nothing else does.
    /// Linear in that.
    pub fn reanchor(&mut self, since: Stamp, anchor: KeyframeId, anchor_from_waypoint: &Isometry) {
        let (Some((odom_from_waypoint, ..)), Some(node)) =
            (self.last_waypoint, self.nodes.get(anchor.0 as usize))
        else {
            return;
        };
        let before = self.map_from_odom;
        self.map_from_odom =
            unit(&(node.map_from_keyframe * anchor_from_waypoint * odom_from_waypoint.inverse()));
        let moved = self.map_from_odom * before.inverse();
        let first = self.trajectory.partition_point(|(stamp, _)| *stamp < since);
        for (entry, moves_with) in self.trajectory.iter_mut().zip(&mut self.trajectory_anchors).skip(first) {
            entry.1 = moved * entry.1;
            *moves_with = anchor;
        }
        self.anchor = anchor;
    }

    /// Adds a loop that was accepted. Moves nothing: that is for whoever optimises, see [`Session::move_keyframes`].
    pub fn add_loop(&mut self, edge: Edge) {
        self.loops.push(edge);
        self.revision += 1;
    }

    /// Takes a loop back, a person having found it wrong. Says whether it was there.
    pub fn remove_loop(&mut self, from: KeyframeId, to: KeyframeId) -> bool {
        let before = self.loops.len();
        self.loops.retain(|edge| (edge.from, edge.to) != (from, to));
        let removed = self.loops.len() < before;
        self.revision += u64::from(removed);
        removed
    }

    /// Loops that were accepted, in that order.
    pub fn loops(&self) -> &[Edge] {
        &self.loops
    }

    /// Puts keyframes where an optimisation found them: `poses` are those of the first keyframes in the map. Keyframes made
    /// since it began, the trajectory and the odometry's frame move along rigidly, each with the keyframe it is told from, so that
    /// nothing tears at the robot. Poses that are not finite are left out. Linear in the trajectory, some 10 ns an entry.
    pub fn move_keyframes(&mut self, poses: &[Isometry]) {
        let mut moved = Vec::with_capacity(self.nodes.len());
        let mut last = Isometry::identity();
        for (index, node) in self.nodes.iter_mut().enumerate() {
            let found = poses.get(index).filter(|pose| pose.to_homogeneous().iter().all(|c| c.is_finite()));
            let before = node.map_from_keyframe;
            // On a found pose exactly, so that rounding never adds up.
            node.map_from_keyframe = unit(&found.copied().unwrap_or(last * before));
            if found.is_some() {
                last = unit(&(node.map_from_keyframe * before.inverse()));
            }
            moved.push(last);
        }
        let moves = |anchor: KeyframeId| moved.get(anchor.0 as usize).unwrap_or(&last);
        for ((_, pose), anchor) in self.trajectory.iter_mut().zip(&self.trajectory_anchors) {
            *pose = moves(*anchor) * *pose;
        }
        self.map_from_odom = unit(&(moves(self.anchor) * self.map_from_odom));
        self.revision += 1;
    }

    /// Metres walked.
    pub fn distance(&self) -> f64 {
        self.odometer.distance()
    }

    /// Keyframes in the order of their ids.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The keyframe nearest to a pose in the map, and that pose in it. Linear in the keyframes.
    pub fn nearest(&self, map_from_base: &Isometry) -> Option<(KeyframeId, Isometry)> {
        let ways = self.nodes.iter().map(|node| (node.id, node.map_from_keyframe.inverse() * map_from_base));
        ways.min_by(|(_, a), (_, b)| {
            a.translation.vector.norm_squared().total_cmp(&b.translation.vector.norm_squared())
        })
    }

    /// Edges in the order of creation.
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// Base in the map after every scan; in long sessions, of what was walked more than an hour and a half ago, after some of them.
    pub fn trajectory(&self) -> &[(Stamp, Isometry)] {
        &self.trajectory
    }

    /// Stretches that the LiDAR alone could not have followed.
    pub fn degenerate_stretches(&self) -> &[DegenerateSegment] {
        &self.stretches
    }

    /// Grows with every change of the graph.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    fn next_id(&self) -> KeyframeId {
        KeyframeId(u32::try_from(self.nodes.len()).unwrap_or(u32::MAX))
    }

    fn waypoint(&mut self, scan: &ScanPose) -> Option<Waypoint> {
        let step = match &self.last_waypoint {
            None => None,
            Some((last, covariance, guessed)) => {
                let pose = unit(&(last.inverse() * scan.odom_from_base));
                let moved = pose.translation.vector.norm() > self.policy.distance
                    || so3::log(&pose.rotation).norm() > self.policy.rotation;
                if !moved {
                    return None;
                }
                let unseen = UNSEEN_SHARE * std::mem::take(&mut self.unseen);
                let followed = (covariance - guessed, scan.covariance - scan.guessed);
                let on_top = (scan.guessed - guessed).diagonal().map(|variance| variance.max(0.0))
                    + Vector6::new(0.0, 0.0, 0.0, 1.0, 1.0, 1.0) * (unseen * unseen);
                let information = edge_information(&followed.0, &followed.1, &pose, &on_top);
                Some(Step { pose, information })
            }
        };
        self.last_waypoint = Some((scan.odom_from_base, scan.covariance, scan.guessed));
        let map_from_base = self.map_from_odom * scan.odom_from_base;
        Some(Waypoint { stamp: scan.stamp, map_from_base, step })
    }

    /// Adds to the trajectory. When that is full, every second entry of the older half goes.
    fn note(&mut self, stamp: Stamp, map_from_base: Isometry) {
        if self.trajectory.len() >= TRAJECTORY {
            thin_older_half(&mut self.trajectory);
            thin_older_half(&mut self.trajectory_anchors);
        }
        self.trajectory.push((stamp, map_from_base));
        self.trajectory_anchors.push(self.anchor);
    }

    fn note_degenerate(&mut self, stamp: Stamp, step: f64) {
        match self.stretches.last_mut() {
            Some(stretch) if stamp - stretch.until <= STRETCH_GAP => {
                stretch.until = stamp;
                stretch.distance += step;
            }
            _ => self.stretches.push(DegenerateSegment { from: stamp, until: stamp, distance: 0.0 }),
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

/// The pose with its rotation made a unit quaternion again. Products of products drift off by rounding, and since inverses take the
/// norm to be one, whatever is computed from its own last value over and over would drift off exponentially.
pub fn unit(pose: &Isometry) -> Isometry {
    let rotation = Rotation::new_normalize(pose.rotation.into_inner());
    Isometry::from_parts(pose.translation, rotation)
}

/// Information of the relative pose between two moments of one odometry.
///
/// What the absolute covariance grew by, after moving the old one into the new frame; only the diagonal of that
/// difference is kept and floored, because the difference of two estimates of a filter need not be positive definite. Where it
/// shrank, the pose was corrected by about as much. `on_top` are variances that are added.
fn edge_information(before: &Matrix6, after: &Matrix6, from_from_to: &Isometry, on_top: &Vector6) -> Matrix6 {
    let ad = se3::adjoint(&from_from_to.inverse());
    let growth = after - ad * before * ad.transpose();
    Matrix6::from_fn(|row, column| {
        if row != column {
            return 0.0;
        }
        let floor = if row < 3 { EDGE_FLOOR.0 } else { EDGE_FLOOR.1 };
        let variance = growth[(row, row)].abs().max(floor * floor) + on_top[row];
        if variance.is_finite() { 1.0 / variance } else { 0.0 }
    })
}

#[cfg(test)]
#[path = "session_tests.rs"]
mod tests;
