//! The last few metres of the walk, waypoint by waypoint, whether they became keyframes or not.

use crate::UncertainPose;
use crate::submap::{KeyframeCloud, LazySubmap};
use std::collections::VecDeque;
use std::sync::Arc;

/// Waypoints kept: more than are walked while a comparison is under way. 34 kB each.
const KEPT: usize = 32;

/// Waypoints are numbered in the order of the walk, from 0.
#[derive(Clone, Debug, Default)]
pub struct RecentScans {
    kept: VecDeque<Waypoint>,
    /// Number of the first one kept.
    first: u64,
}

#[derive(Clone, Debug)]
struct Waypoint {
    /// From the one before; identity for the first of the walk.
    step: UncertainPose,
    cloud: Arc<KeyframeCloud>,
}

impl RecentScans {
    /// Adds the waypoint that `step` leads to from the last one. Returns its number.
    pub fn push(&mut self, step: UncertainPose, cloud: Arc<KeyframeCloud>) -> u64 {
        self.kept.push_back(Waypoint { step, cloud });
        if self.kept.len() > KEPT {
            self.kept.pop_front();
            self.first += 1;
        }
        self.newest()
    }

    /// Number of the newest waypoint; 0 before the first.
    pub fn newest(&self) -> u64 {
        (self.first + self.kept.len() as u64).saturating_sub(1)
    }

    /// How the walk led from one waypoint to a later one; none where it is forgotten.
    pub fn way(&self, from: u64, to: u64) -> Option<UncertainPose> {
        let from = usize::try_from(from.checked_sub(self.first)?).ok()?;
        let to = usize::try_from(to.checked_sub(self.first)?).ok()?;
        let steps = self.kept.range(..).skip(from + 1).take(to.checked_sub(from)?);
        (to < self.kept.len())
            .then(|| steps.fold(UncertainPose::identity(), |way, waypoint| way.then(&waypoint.step)))
    }

    /// The newest waypoint with those up to `metres` of walk before it, `most` at most.
    pub fn submap(&self, metres: f64, most: usize) -> LazySubmap {
        let (mut members, mut walked, mut way) = (Vec::new(), 0.0, UncertainPose::identity());
        for waypoint in self.kept.iter().rev() {
            if walked > metres || members.len() > most {
                break;
            }
            members.push((way, Arc::clone(&waypoint.cloud)));
            walked += waypoint.step.pose.translation.vector.norm();
            way = way.then(&waypoint.step.inverse());
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

    fn trail(steps: u64) -> RecentScans {
        let cloud = Arc::new(KeyframeCloud::new(&[[1.0, 0.0, 0.0]], [0.0; 3], &mut Downsampler::default()));
        let mut trail = RecentScans::default();
        for number in 0..steps {
            let way = if number == 0 { at(0.0, 0.0, 0.0) } else { at(1.0, 0.0, 0.1) };
            let step = UncertainPose { pose: way, covariance: Matrix6::identity() * 1e-4 };
            assert_eq!(trail.push(step, Arc::clone(&cloud)), number);
        }
        trail
    }

    #[test]
    fn ways_are_known_between_what_is_kept() {
        let trail = trail(100);
        let expected = (0..5).fold(at(0.0, 0.0, 0.0), |way, _| way * at(1.0, 0.0, 0.1));
        let way = trail.way(90, 95);
        assert!(way.is_some_and(|way| (way.pose.inverse() * expected).translation.vector.norm() < 1e-12));
        assert_eq!(trail.way(99, 99), Some(UncertainPose::identity()));
        assert_eq!((trail.way(10, 95), trail.way(95, 100), trail.way(95, 94)), (None, None, None));
        assert!(trail.way(68, 69).is_some() && trail.way(67, 69).is_none());
    }

    #[test]
    fn a_submap_goes_back_so_far() {
        let members = |steps, metres, most| trail(steps).submap(metres, most).get().members.len();
        assert_eq!((members(20, 5.5, 8), members(20, 50.0, 8), members(3, 5.0, 8)), (6, 9, 3));
        let submap = trail(20).submap(5.5, 8);
        let (anchor_from_oldest, _) = &submap.get().members[0];
        let back = anchor_from_oldest.inverse();
        let expected = (0..5).fold(at(0.0, 0.0, 0.0), |way, _| way * at(1.0, 0.0, 0.1));
        assert!((back.inverse() * expected).translation.vector.norm() < 1e-9, "{back}");
    }
}
