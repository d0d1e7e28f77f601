//! How well one keyframe's place is known from another: along the walk alone, or over every edge there is.

use crate::UncertainPose;
use geometry::{Isometry, Matrix6, se3};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Lever at which rotation counts against translation where one number has to stand for a covariance, metres: half of
/// what an XT-32 overlooks indoors.
const LEVER: f64 = 10.0;

/// The walk by odometry alone: the relative pose of any two keyframes of one stretch and its covariance, in constant time.
///
/// Errors of the edges are independent, so their sum in the frame of the first keyframe is a running sum of which any
/// stretch is a difference. A stretch ends where the walk goes on over known ground, and another begins where it leaves that.
/// 352 B a keyframe.
#[derive(Clone, Debug)]
pub struct OdometryChain {
    /// First keyframe to each, and the summed covariance of the way there, perturbed on the left (in the first's frame).
    sums: Vec<(Isometry, Matrix6)>,
    /// Metres walked to each.
    walked: Vec<f64>,
    /// First keyframe of each one's stretch.
    stretch: Vec<u32>,
    /// Metres walked in all.
    odometer: f64,
}

impl Default for OdometryChain {
    fn default() -> Self {
        let sums = vec![(Isometry::identity(), Matrix6::zeros())];
        Self { sums, walked: vec![0.0], stretch: vec![0], odometer: 0.0 }
    }
}

impl OdometryChain {
    /// Adds the keyframe that `step` leads to from the last one. The first keyframe is there from the beginning.
    pub fn push(&mut self, step: &UncertainPose) {
        self.walk(step.pose.translation.vector.norm());
        self.attach(self.len() - 1, step);
    }

    /// Metres were walked that led to no keyframe.
    pub fn walk(&mut self, metres: f64) {
        self.odometer += metres;
    }

    /// Adds the keyframe that `way` leads to from an old one, its metres having been walked already. If that is not the
    /// last one, another stretch begins. An old one that is not there counts as the last.
    pub fn attach(&mut self, from: usize, way: &UncertainPose) {
        let last = self.len() - 1;
        let from = from.min(last);
        let (pose, sum) = self.sums[from];
        let next = pose * way.pose;
        let ad = se3::adjoint(&next);
        self.sums.push((next, sum + ad * way.covariance * ad.transpose()));
        self.walked.push(self.odometer);
        self.stretch.push(if from == last { self.stretch[last] } else { last as u32 + 1 });
    }

    /// Adds a keyframe that no way leads to, its metres having been walked already: another stretch begins.
    pub fn begin(&mut self, first_from_keyframe: &Isometry) {
        self.stretch.push(self.sums.len() as u32);
        self.sums.push((*first_from_keyframe, Matrix6::zeros()));
        self.walked.push(self.odometer);
    }

    /// Number of keyframes.
    pub fn len(&self) -> usize {
        self.sums.len()
    }

    /// Never: there is always a first keyframe.
    pub fn is_empty(&self) -> bool {
        self.sums.is_empty()
    }

    /// The keyframe's pose in the first, by odometry alone.
    pub fn pose(&self, keyframe: usize) -> Option<&Isometry> {
        self.sums.get(keyframe).map(|(pose, _)| pose)
    }

    /// Metres walked from one keyframe to another, whichever came first.
    pub fn walked(&self, a: usize, b: usize) -> Option<f64> {
        Some((self.walked.get(a)? - self.walked.get(b)?).abs())
    }

    /// Metres walked since a keyframe.
    pub fn since(&self, keyframe: usize) -> Option<f64> {
        Some(self.odometer - self.walked.get(keyframe)?)
    }

    /// Pose of `b` in `a`, by odometry alone; none where they are not of one stretch.
    pub fn relative(&self, a: usize, b: usize) -> Option<UncertainPose> {
        if b < a {
            return Some(self.relative(b, a)?.inverse());
        }
        if self.stretch.get(a)? != self.stretch.get(b)? {
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

/// All edges between keyframes, odometry and loops.
#[derive(Clone, Debug, Default)]
pub struct CovarianceGraph {
    /// For each keyframe its neighbours, with the way there.
    links: Vec<Vec<Link>>,
}

#[derive(Clone, Debug)]
struct Link {
    to: usize,
    way: UncertainPose,
    cost: f64,
    /// Whether it was walked; a loop otherwise.
    walked: bool,
}

impl CovarianceGraph {
    /// Adds a loop; keyframes it names exist from then on.
    pub fn connect(&mut self, from: usize, to: usize, way: &UncertainPose) {
        self.link(from, to, way, false);
    }

    /// Adds a way that was walked, which nobody takes back; keyframes it names exist from then on.
    pub fn connect_walked(&mut self, from: usize, to: usize, way: &UncertainPose) {
        self.link(from, to, way, true);
    }

    fn link(&mut self, from: usize, to: usize, way: &UncertainPose, walked: bool) {
        let needed = from.max(to) + 1;
        if self.links.len() < needed {
            self.links.resize_with(needed, Vec::new);
        }
        let back = way.inverse();
        self.links[from].push(Link { to, way: *way, cost: cost(way), walked });
        self.links[to].push(Link { to: from, way: back, cost: cost(way), walked });
    }

    /// Takes the last loop between two keyframes back. Says whether there was one.
    pub fn disconnect(&mut self, from: usize, to: usize) -> bool {
        let mut cut = |a: usize, b: usize| {
            let links = self.links.get_mut(a)?;
            let index = links.iter().rposition(|link| link.to == b && !link.walked)?;
            Some(links.remove(index))
        };
        cut(from, to).is_some() & cut(to, from).is_some()
    }

    /// The best known pose of every keyframe in `from`: along the way whose edges' variances sum up least. Its
    /// covariance is a bound, since other ways could only add to what is known. `O((n + e) log n)`.
    ///
    /// Source of the idea: Olson, *Recognizing places using spectrally clustered local matches*, RAS 2009.
    pub fn reach(&self, from: usize) -> Vec<Option<UncertainPose>> {
        self.spread(from, UncertainPose::identity(), usize::MAX)
    }

    /// As [`CovarianceGraph::reach`], from the place that `way` leads to from a keyframe.
    pub fn reach_along(&self, from: usize, way: &UncertainPose) -> Vec<Option<UncertainPose>> {
        self.spread(from, way.inverse(), usize::MAX)
    }

    /// The best known pose of `to` in `from`, as [`CovarianceGraph::reach`] has it; stops once it is found.
    pub fn between(&self, from: usize, to: usize) -> Option<UncertainPose> {
        self.spread(from, UncertainPose::identity(), to).get(to).copied().flatten()
    }

    /// Reaches keyframes from the surest on, until `last`. `first` is where `from` is.
    fn spread(&self, from: usize, first: UncertainPose, last: usize) -> Vec<Option<UncertainPose>> {
        let mut reached: Vec<Option<UncertainPose>> = vec![None; self.links.len()];
        let mut heap = BinaryHeap::new();
        let mut least = vec![f64::INFINITY; self.links.len()];
        if from < self.links.len() {
            least[from] = 0.0;
            heap.push(Revisit { cost: 0.0, keyframe: from, by: None });
        }
        while let Some(Revisit { cost, keyframe, by }) = heap.pop() {
            if reached[keyframe].is_some() {
                continue;
            }
            reached[keyframe] = Some(match by {
                Some((parent, link)) => {
                    let before: &Option<UncertainPose> = &reached[parent];
                    before.unwrap_or_else(UncertainPose::identity).then(&self.links[parent][link].way)
                }
                None => first,
            });
            if keyframe == last {
                break;
            }
            for (index, link) in self.links[keyframe].iter().enumerate() {
                let there = cost + link.cost;
                if there < least[link.to] {
                    least[link.to] = there;
                    heap.push(Revisit { cost: there, keyframe: link.to, by: Some((keyframe, index)) });
                }
            }
        }
        reached
    }
}

/// One number for a covariance: the variances of place and, at the lever, of rotation.
fn cost(way: &UncertainPose) -> f64 {
    let variance = |index: usize| way.covariance[(index, index)];
    let sum = (0..3).map(|i| variance(i) * LEVER * LEVER + variance(i + 3)).sum::<f64>();
    if sum.is_finite() { sum.max(1e-12) } else { f64::MAX }
}

/// Least cost first out of a heap; ties go to the older keyframe.
#[derive(PartialEq)]
struct Revisit {
    cost: f64,
    keyframe: usize,
    by: Option<(usize, usize)>,
}

impl Eq for Revisit {}

impl Ord for Revisit {
    fn cmp(&self, other: &Self) -> Ordering {
        other.cost.total_cmp(&self.cost).then(other.keyframe.cmp(&self.keyframe))
    }
}

impl PartialOrd for Revisit {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Vector3, Vector6};

    fn step(yaw: f64, deviation: f64) -> UncertainPose {
        let pose = Isometry::new(Vector3::new(1.0, 0.0, 0.0), Vector3::z() * yaw);
        let variances = Vector6::new(1e-6, 1e-6, 4e-6, 1.0, 1.0, 1.0);
        let scale = Vector6::new(1.0, 1.0, 1.0, deviation, deviation, deviation).map(|v| v * v);
        UncertainPose { pose, covariance: Matrix6::from_diagonal(&variances.component_mul(&scale)) }
    }

    fn near(a: &UncertainPose, b: &UncertainPose) -> bool {
        se3::local(&a.pose, &b.pose).norm() < 1e-9 && (a.covariance - b.covariance).norm() < 1e-9
    }

    #[test]
    fn any_stretch_of_the_walk_is_the_sum_of_its_steps() {
        let mut chain = OdometryChain::default();
        let steps: Vec<UncertainPose> = (0..200).map(|i| step(0.1 * f64::from(i % 7 - 3), 0.01)).collect();
        steps.iter().for_each(|s| chain.push(s));
        let expected = steps[40..150].iter().fold(UncertainPose::identity(), |way, next| way.then(next));
        let Some(found) = chain.relative(40, 150) else { panic!("no such keyframes") };
        assert!(near(&found, &expected), "{:?}", found.covariance - expected.covariance);
        assert!(chain.relative(150, 40).is_some_and(|back| near(&back, &expected.inverse())));
        assert_eq!(chain.walked(10, 30).map(f64::round), Some(20.0));
        assert_eq!((chain.len(), chain.relative(0, 201)), (201, None));
    }

    #[test]
    fn known_ground_ends_a_stretch_and_counts_as_walked() {
        let mut chain = OdometryChain::default();
        (0..10).for_each(|_| chain.push(&step(0.0, 0.01)));
        chain.walk(25.0);
        // Over a keyframe that is known already, and on from it.
        chain.attach(4, &step(0.3, 0.01));
        chain.push(&step(0.0, 0.01));
        assert_eq!((chain.relative(10, 11), chain.relative(3, 12)), (None, None));
        assert!(chain.relative(11, 12).is_some_and(|way| near(&way, &step(0.0, 0.01))));
        assert_eq!(chain.walked(10, 12).map(f64::round), Some(26.0));
        let expected = Isometry::new(Vector3::new(4.0, 0.0, 0.0), Vector3::zeros()) * step(0.3, 0.01).pose;
        assert!(chain.pose(11).is_some_and(|pose| se3::local(pose, &expected).norm() < 1e-9));
    }

    #[test]
    fn a_loop_shortens_the_way_to_old_places() {
        let (mut web, mut chain) = (CovarianceGraph::default(), OdometryChain::default());
        for index in 0..100 {
            // A circle of 100 steps.
            let step = step(std::f64::consts::TAU / 100.0, 0.02);
            web.connect_walked(index, index + 1, &step);
            chain.push(&step);
        }
        let before = web.reach(100);
        let Some(open) = before[0] else { panic!("not reached") };
        assert!(chain.relative(100, 0).is_some_and(|way| near(&way, &open)), "the only way is the walk");
        // 0.2 m of steps and 20 mrad over the circle's lever of 16 m.
        assert!((0.3..0.6).contains(&open.translation_std_m()), "{}", open.translation_std_m());
        web.connect(2, 100, &UncertainPose { pose: step(0.0, 0.0).pose, ..step(0.0, 0.01) });
        let Some(closed) = web.reach(100)[0] else { panic!("not reached") };
        assert_eq!((web.between(100, 0), web.between(100, 4_000)), (Some(closed), None));
        let ahead = step(0.2, 0.01);
        let seen = web.reach_along(100, &ahead)[0];
        assert!(seen.is_some_and(|seen| near(&seen, &ahead.inverse().then(&closed))));
        assert!(closed.translation_std_m() < 0.04, "{}", closed.translation_std_m());
        assert!(web.disconnect(2, 100) && !web.disconnect(2, 100) && !web.disconnect(7, 4_000));
        assert!(!web.disconnect(2, 3), "it was walked");
        assert_eq!(web.reach(100), before);
        assert!(web.reach(1000).iter().all(Option::is_none));
    }
}
