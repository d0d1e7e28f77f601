//! Loops judged by the truth.

use geometry::{Isometry, Matrix6, Vector3, so3};
use mapping::{Decision, UncertainPose, Verdict};
use messages::{EdgeKind, GraphEdge, LoopDecision, LoopVerdict};
use nalgebra::SymmetricEigen;
use sim::Site;

/// A revisit: an old place this near again, metres, after so much walking, metres.
const REVISIT_NEAR: f64 = 2.0;
const REVISIT_LEVEL: f64 = 0.6;
const REVISIT_WALKED: f64 = 15.0;
/// A revisit counts as closed if a loop was accepted within so much walking of it, metres: loops are made every other metre.
const CLOSED_WITHIN: f64 = 3.0;
/// A loop is wrong beyond this error, metres and radians.
const WRONG: (f64, f64) = (0.3, 0.052);

/// What became of a pair of keyframes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    Accepted,
    Held,
    Rejected,
    Dropped,
}

/// A pair of keyframes that was decided on.
#[derive(Clone, Copy, Debug)]
pub struct Judged {
    pub from: usize,
    pub to: usize,
    pub from_from_to: Isometry,
    pub information: Matrix6,
    pub outcome: Outcome,
}

impl From<&Decision> for Judged {
    fn from(decision: &Decision) -> Self {
        Self {
            from: decision.edge.from.0 as usize,
            to: decision.edge.to.0 as usize,
            from_from_to: decision.edge.from_from_to,
            information: decision.edge.information,
            outcome: match decision.verdict {
                Verdict::Accepted => Outcome::Accepted,
                Verdict::Held => Outcome::Held,
                Verdict::Rejected(_) => Outcome::Rejected,
                Verdict::Dropped => Outcome::Dropped,
            },
        }
    }
}

impl Judged {
    /// As the stack tells it, `edges` being those of its graph: what is not among them says nothing about its certainty.
    /// None where the pose is none.
    pub fn told(decision: &LoopDecision, edges: &[GraphEdge]) -> Option<Self> {
        let pair = (decision.task.from, decision.task.to);
        let edge = edges.iter().find(|edge| edge.kind == EdgeKind::Loop && (edge.from, edge.to) == pair);
        let information = edge.map_or([[0.0; 6]; 6], |edge| edge.information);
        Some(Self {
            from: decision.task.from.0 as usize,
            to: decision.task.to.0 as usize,
            from_from_to: geometry::isometry_from_pose(&decision.from_from_to)?,
            information: Matrix6::from_fn(|row, column| information[row][column]),
            outcome: match decision.verdict {
                LoopVerdict::Accepted => Outcome::Accepted,
                LoopVerdict::Held => Outcome::Held,
                LoopVerdict::Rejected => Outcome::Rejected,
                LoopVerdict::Dropped => Outcome::Dropped,
            },
        })
    }

    /// How far the loop is from the truth.
    fn off(&self, truth: &[Isometry]) -> Isometry {
        (truth[self.from].inverse() * truth[self.to]).inverse() * self.from_from_to
    }
}

/// One walk's score.
#[derive(Clone, Debug, Default)]
pub struct Score {
    pub keyframes: usize,
    /// Keyframes that saw an old place again.
    pub revisits: usize,
    pub closed: usize,
    /// Accepted loops, and those among them that are wrong.
    pub accepted: usize,
    pub wrong: usize,
    pub held: usize,
    pub rejected: usize,
    /// Root mean squares over right accepted loops: metres, radians.
    pub place_error: f64,
    pub turn_error: f64,
    /// Mean squared Mahalanobis distance of right loops from the truth, by their own information; 6 if honest.
    pub honesty: f64,
}

/// Error of a loop: metres, in the directions that it claims to know better than a metre, and radians.
pub fn error(judged: &Judged, truth: &[Isometry]) -> (f64, f64) {
    claimed_error(&judged.off(truth), &judged.information)
}

/// The same for an error of a pose by its information.
pub fn claimed_error(off: &Isometry, information: &Matrix6) -> (f64, f64) {
    // In the frame of the newer base, as the covariance.
    let shift = off.rotation.inverse() * off.translation.vector;
    let measured = UncertainPose::from_information(Isometry::identity(), information);
    let eigen = SymmetricEigen::new(measured.covariance.fixed_view::<3, 3>(3, 3).into_owned());
    let known = eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter());
    let claimed = known.filter(|(variance, _)| **variance < 1.0).map(|(_, axis)| axis.dot(&shift).powi(2));
    (claimed.sum::<f64>().sqrt(), so3::log(&off.rotation).norm())
}

/// Whether a loop is wrong.
pub fn is_wrong(judged: &Judged, truth: &[Isometry]) -> bool {
    is_far(error(judged, truth))
}

/// Whether an error, metres and radians, is that of another place.
pub fn is_far((place, turn): (f64, f64)) -> bool {
    place > WRONG.0 || turn > WRONG.1
}

/// Whether a revisit after so many metres is closed by loops after those.
pub fn is_closed(walked: f64, closed_at: &[f64]) -> bool {
    closed_at.iter().any(|at| (at - walked).abs() <= CLOSED_WITHIN)
}

/// Judges what was decided on a walk.
///
/// - `truth`: the base in the site at every keyframe.
pub fn score(site: &Site, truth: &[Isometry], decisions: &[Judged]) -> Score {
    let walked = walked(truth);
    let mut score = Score { keyframes: truth.len(), ..Score::default() };
    let mut closed_at = Vec::new();
    for judged in decisions {
        match judged.outcome {
            Outcome::Accepted => {
                score.accepted += 1;
                if is_wrong(judged, truth) {
                    score.wrong += 1;
                } else {
                    closed_at.push(walked[judged.to]);
                    score.add_error(judged, truth);
                }
            }
            Outcome::Held => score.held += 1,
            Outcome::Rejected => score.rejected += 1,
            Outcome::Dropped => {}
        }
    }
    let right = closed_at.len().max(1) as f64;
    score.place_error = (score.place_error / right).sqrt();
    score.turn_error = (score.turn_error / right).sqrt();
    score.honesty /= right;
    for newer in revisits(site, truth) {
        score.revisits += 1;
        score.closed += usize::from(is_closed(walked[newer], &closed_at));
    }
    score
}

impl Score {
    fn add_error(&mut self, judged: &Judged, truth: &[Isometry]) {
        let (place, turn) = error(judged, truth);
        self.place_error += place * place;
        self.turn_error += turn * turn;
        let relative = truth[judged.from].inverse() * truth[judged.to];
        let off = geometry::se3::local(&judged.from_from_to, &relative);
        self.honesty += off.dot(&(judged.information * off));
    }
}

/// Metres walked to each keyframe, truly.
pub fn walked(truth: &[Isometry]) -> Vec<f64> {
    let mut sum = 0.0;
    let mut last: Option<Vector3> = None;
    truth
        .iter()
        .map(|site_from_base| {
            let place = site_from_base.translation.vector;
            sum += last.map_or(0.0, |last| (place - last).norm());
            last = Some(place);
            sum
        })
        .collect()
}

/// Keyframes that are truly back: near an old one, on its floor and in its sight.
pub fn revisits(site: &Site, truth: &[Isometry]) -> Vec<usize> {
    let walked = walked(truth);
    let eye = |pose: &Isometry| pose.translation.vector + Vector3::z() * 0.3;
    (0..truth.len())
        .filter(|&newer| {
            (0..newer).any(|older| {
                let (a, b) = (eye(&truth[older]), eye(&truth[newer]));
                let (way, far) = (b - a, (b - a).norm());
                walked[newer] - walked[older] > REVISIT_WALKED
                    && way.xy().norm() < REVISIT_NEAR
                    && way.z.abs() < REVISIT_LEVEL
                    && (far < 1e-3 || site.cast_ray(&a, &(way / far), far).is_none())
            })
        })
        .collect()
}
