//! The walk by odometry alone: the relative pose of two keyframes and its covariance, in constant time.

use crate::UncertainPose;
use geometry::{Isometry, Matrix6, se3};

/// Prefix sums of the odometry edges.
///
/// The errors of the edges are independent. Their covariances, expressed in the frame of the first keyframe, therefore add up along the
/// walk, and the covariance between two keyframes is a difference of two sums (docs/maths/loops.md, equation 5). This holds within one
/// segment of the walk. A segment ends where the walk continues over known ground, and a new one begins where it leaves known ground.
/// Takes 356 B a keyframe.
#[derive(Clone, Debug)]
pub struct OdometryChain {
    /// For each keyframe: its pose in the first keyframe, and the summed covariance of the walk there, perturbed on the left.
    sums: Vec<(Isometry, Matrix6)>,
    /// For each keyframe: the distance walked until then, metres.
    distances_m: Vec<f64>,
    /// For each keyframe: the first keyframe of its segment.
    segments: Vec<u32>,
    /// Distance walked in all, metres.
    total_distance_m: f64,
}

impl Default for OdometryChain {
    fn default() -> Self {
        let sums = vec![(Isometry::identity(), Matrix6::zeros())];
        Self { sums, distances_m: vec![0.0], segments: vec![0], total_distance_m: 0.0 }
    }
}

impl OdometryChain {
    /// Adds the keyframe that `step` leads to from the last one. The first keyframe exists from the beginning.
    pub fn push(&mut self, step: &UncertainPose) {
        self.add_distance(step.pose.translation.vector.norm());
        self.push_from(self.len() - 1, step);
    }

    /// Adds a distance walked without a new keyframe, metres.
    pub fn add_distance(&mut self, distance_m: f64) {
        self.total_distance_m += distance_m;
    }

    /// Adds the keyframe that `relative` leads to from the keyframe `from`. The distance has to be added before. A new segment begins
    /// if `from` is not the last keyframe. An unknown `from` is replaced by the last keyframe.
    pub fn push_from(&mut self, from: usize, relative: &UncertainPose) {
        let last = self.len() - 1;
        let from = from.min(last);
        let (pose, sum) = self.sums[from];
        let next = pose * relative.pose;
        let ad = se3::adjoint(&next);
        self.sums.push((next, sum + ad * relative.covariance * ad.transpose()));
        self.distances_m.push(self.total_distance_m);
        self.segments.push(if from == last { self.segments[last] } else { last as u32 + 1 });
    }

    /// Adds a keyframe that no edge leads to: a new segment begins. The distance has to be added before.
    pub fn push_detached(&mut self, first_from_keyframe: &Isometry) {
        self.segments.push(self.sums.len() as u32);
        self.sums.push((*first_from_keyframe, Matrix6::zeros()));
        self.distances_m.push(self.total_distance_m);
    }

    /// Number of keyframes.
    pub fn len(&self) -> usize {
        self.sums.len()
    }

    /// Always false: the first keyframe always exists.
    pub fn is_empty(&self) -> bool {
        self.sums.is_empty()
    }

    /// Pose of a keyframe in the first one, by odometry alone.
    pub fn pose(&self, keyframe: usize) -> Option<&Isometry> {
        self.sums.get(keyframe).map(|(pose, _)| pose)
    }

    /// Distance walked between two keyframes, in either order, metres.
    pub fn distance_between(&self, a: usize, b: usize) -> Option<f64> {
        Some((self.distances_m.get(a)? - self.distances_m.get(b)?).abs())
    }

    /// Distance walked since a keyframe, metres.
    pub fn distance_since(&self, keyframe: usize) -> Option<f64> {
        Some(self.total_distance_m - self.distances_m.get(keyframe)?)
    }

    /// Pose of `b` in `a`, by odometry alone (equation 5). `None` if they belong to different segments.
    pub fn relative_pose(&self, a: usize, b: usize) -> Option<UncertainPose> {
        if b < a {
            return Some(self.relative_pose(b, a)?.inverse());
        }
        if self.segments.get(a)? != self.segments.get(b)? {
            return None;
        }
        let ((from, before), (to, after)) = (self.sums.get(a)?, self.sums.get(b)?);
        let ad = se3::adjoint(&to.inverse());
        let covariance = ad * (after - before) * ad.transpose();
        Some(UncertainPose {
            pose: from.inverse() * to,
            covariance: (covariance + covariance.transpose()) * 0.5,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{at, near, step};

    #[test]
    fn a_relative_pose_is_the_composition_of_its_steps() {
        let mut chain = OdometryChain::default();
        let steps: Vec<UncertainPose> = (0..200).map(|i| step(0.1 * f64::from(i % 7 - 3), 0.01)).collect();
        steps.iter().for_each(|s| chain.push(s));
        let expected = steps[40..150].iter().fold(UncertainPose::identity(), |pose, next| pose.compose(next));
        let Some(found) = chain.relative_pose(40, 150) else { panic!("no such keyframes") };
        assert!(near(&found, &expected), "{:?}", found.covariance - expected.covariance);
        assert!(chain.relative_pose(150, 40).is_some_and(|back| near(&back, &expected.inverse())));
        assert_eq!(chain.distance_between(10, 30).map(f64::round), Some(20.0));
        assert_eq!((chain.len(), chain.relative_pose(0, 201)), (201, None));
    }

    #[test]
    fn known_ground_ends_a_segment_and_counts_as_distance() {
        let mut chain = OdometryChain::default();
        (0..10).for_each(|_| chain.push(&step(0.0, 0.01)));
        chain.add_distance(25.0);
        // Over a keyframe that exists already, and on from it.
        chain.push_from(4, &step(0.3, 0.01));
        chain.push(&step(0.0, 0.01));
        assert_eq!((chain.relative_pose(10, 11), chain.relative_pose(3, 12)), (None, None));
        assert!(chain.relative_pose(11, 12).is_some_and(|pose| near(&pose, &step(0.0, 0.01))));
        assert_eq!(chain.distance_between(10, 12).map(f64::round), Some(26.0));
        let expected = at(4.0, 0.0, 0.0) * step(0.3, 0.01).pose;
        assert!(chain.pose(11).is_some_and(|pose| se3::local(pose, &expected).norm() < 1e-9));
    }
}
