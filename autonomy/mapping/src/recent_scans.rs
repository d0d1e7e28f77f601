//! The scans of the last waypoints of the walk, whether they became keyframes or not.

use crate::UncertainPose;
use crate::submap::{KeyframeCloud, LazySubmap};
use std::collections::VecDeque;
use std::sync::Arc;

/// Parameters of [`RecentScans`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecentScansConfig {
    /// Number of scans kept, 30 kB each. More waypoints than are walked while a comparison is running. Chosen: half a minute of walking, 1 MB.
    pub capacity: usize,
}

impl Default for RecentScansConfig {
    fn default() -> Self {
        Self { capacity: 32 }
    }
}

/// The newest waypoints' scans. Waypoints are numbered in the order of the walk, from 0.
#[derive(Clone, Debug, Default)]
pub struct RecentScans {
    config: RecentScansConfig,
    scans: VecDeque<RecentScan>,
    /// Number of the first scan kept.
    first: u64,
}

#[derive(Clone, Debug)]
struct RecentScan {
    /// Pose in the waypoint before; identity for the first of the walk.
    step: UncertainPose,
    cloud: Arc<KeyframeCloud>,
}

impl RecentScans {
    /// Adds the waypoint that `step` leads to from the last one. Returns its number.
    pub fn push(&mut self, step: UncertainPose, cloud: Arc<KeyframeCloud>) -> u64 {
        self.scans.push_back(RecentScan { step, cloud });
        if self.scans.len() > self.config.capacity {
            self.scans.pop_front();
            self.first += 1;
        }
        self.newest()
    }

    /// Number of the newest waypoint; 0 before the first.
    pub fn newest(&self) -> u64 {
        (self.first + self.scans.len() as u64).saturating_sub(1)
    }

    /// Pose of a waypoint in an earlier one, by odometry. `None` where one of them is not kept any more.
    pub fn relative_pose(&self, from: u64, to: u64) -> Option<UncertainPose> {
        let from = usize::try_from(from.checked_sub(self.first)?).ok()?;
        let to = usize::try_from(to.checked_sub(self.first)?).ok()?;
        let steps = self.scans.range(..).skip(from + 1).take(to.checked_sub(from)?);
        (to < self.scans.len())
            .then(|| steps.fold(UncertainPose::identity(), |pose, scan| pose.compose(&scan.step)))
    }

    /// Submap of the newest waypoint and those before it within `length_m` of walk, `max_neighbours` of them at most.
    pub fn submap(&self, length_m: f64, max_neighbours: usize) -> LazySubmap {
        let (mut members, mut walked_m, mut newest_from_scan) = (Vec::new(), 0.0, UncertainPose::identity());
        for scan in self.scans.iter().rev() {
            if walked_m > length_m || members.len() > max_neighbours {
                break;
            }
            members.push((newest_from_scan, Arc::clone(&scan.cloud)));
            walked_m += scan.step.pose.translation.vector.norm();
            newest_from_scan = newest_from_scan.compose(&scan.step.inverse());
        }
        // In the order of the walk.
        members.reverse();
        let own = members.len().saturating_sub(1);
        LazySubmap::new(members, own)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::at;
    use geometry::Matrix6;
    use points::Downsampler;

    fn recent_scans(steps: u64) -> RecentScans {
        let cloud = Arc::new(KeyframeCloud::new(&[[1.0, 0.0, 0.0]], [0.0; 3], &mut Downsampler::default()));
        let mut scans = RecentScans::default();
        for number in 0..steps {
            let pose = if number == 0 { at(0.0, 0.0, 0.0) } else { at(1.0, 0.0, 0.1) };
            let step = UncertainPose { pose, covariance: Matrix6::identity() * 1e-4 };
            assert_eq!(scans.push(step, Arc::clone(&cloud)), number);
        }
        scans
    }

    #[test]
    fn relative_poses_are_known_between_kept_scans() {
        let scans = recent_scans(100);
        let expected = (0..5).fold(at(0.0, 0.0, 0.0), |pose, _| pose * at(1.0, 0.0, 0.1));
        let pose = scans.relative_pose(90, 95);
        assert!(pose.is_some_and(|pose| (pose.pose.inverse() * expected).translation.vector.norm() < 1e-12));
        assert_eq!(scans.relative_pose(99, 99), Some(UncertainPose::identity()));
        assert_eq!(
            (scans.relative_pose(10, 95), scans.relative_pose(95, 100), scans.relative_pose(95, 94)),
            (None, None, None)
        );
        assert!(scans.relative_pose(68, 69).is_some() && scans.relative_pose(67, 69).is_none());
    }

    #[test]
    fn a_submap_is_bounded_by_length_and_count() {
        let members = |steps, length_m, most| recent_scans(steps).submap(length_m, most).get().members.len();
        assert_eq!((members(20, 5.5, 8), members(20, 50.0, 8), members(3, 5.0, 8)), (6, 9, 3));
        let submap = recent_scans(20).submap(5.5, 8);
        let (anchor_from_oldest, _) = &submap.get().members[0];
        let back = anchor_from_oldest.inverse();
        let expected = (0..5).fold(at(0.0, 0.0, 0.0), |pose, _| pose * at(1.0, 0.0, 0.1));
        assert!((back.inverse() * expected).translation.vector.norm() < 1e-9, "{back}");
    }
}
