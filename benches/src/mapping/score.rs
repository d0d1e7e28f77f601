//! Loops judged by the truth.

use crate::walk::Recorded;
use geometry::{Isometry, Vector3, so3};
use mapping::{Decision, Uncertain, Verdict};
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
pub fn error(decision: &Decision, recorded: &[Recorded]) -> (f64, f64) {
    let [from, to] = [decision.edge.from, decision.edge.to].map(|k| recorded[k.0 as usize].site_from_base);
    let off = (from.inverse() * to).inverse() * decision.edge.from_from_to;
    // In the frame of the newer base, as the covariance.
    let shift = off.rotation.inverse() * off.translation.vector;
    let measured = Uncertain::from_information(decision.edge.from_from_to, &decision.edge.information);
    let eigen = SymmetricEigen::new(measured.covariance.fixed_view::<3, 3>(3, 3).into_owned());
    let known = eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter());
    let claimed = known.filter(|(variance, _)| **variance < 1.0).map(|(_, axis)| axis.dot(&shift).powi(2));
    (claimed.sum::<f64>().sqrt(), so3::log(&off.rotation).norm())
}

/// Whether a loop is wrong.
pub fn is_wrong(decision: &Decision, recorded: &[Recorded]) -> bool {
    let (place, turn) = error(decision, recorded);
    place > WRONG.0 || turn > WRONG.1
}

/// Judges what was decided on a walk.
pub fn score(site: &Site, recorded: &[Recorded], decisions: &[Decision]) -> Score {
    let walked = walked(recorded);
    let mut score = Score { keyframes: recorded.len(), ..Score::default() };
    let mut closed_at = Vec::new();
    for decision in decisions {
        match decision.verdict {
            Verdict::Accepted => {
                score.accepted += 1;
                if is_wrong(decision, recorded) {
                    score.wrong += 1;
                } else {
                    closed_at.push(walked[decision.edge.to.0 as usize]);
                    score.add_error(decision, recorded);
                }
            }
            Verdict::Held => score.held += 1,
            Verdict::Rejected(_) => score.rejected += 1,
            Verdict::Dropped => {}
        }
    }
    let right = closed_at.len().max(1) as f64;
    score.place_error = (score.place_error / right).sqrt();
    score.turn_error = (score.turn_error / right).sqrt();
    score.honesty /= right;
    for newer in revisits(site, recorded) {
        score.revisits += 1;
        let near = |at: &f64| (at - walked[newer]).abs() <= CLOSED_WITHIN;
        score.closed += usize::from(closed_at.iter().any(near));
    }
    score
}

impl Score {
    fn add_error(&mut self, decision: &Decision, recorded: &[Recorded]) {
        let (place, turn) = error(decision, recorded);
        self.place_error += place * place;
        self.turn_error += turn * turn;
        let [from, to] =
            [decision.edge.from, decision.edge.to].map(|k| recorded[k.0 as usize].site_from_base);
        let off = geometry::se3::local(&decision.edge.from_from_to, &(from.inverse() * to));
        self.honesty += off.dot(&(decision.edge.information * off));
    }
}

/// Metres walked to each keyframe, truly.
fn walked(recorded: &[Recorded]) -> Vec<f64> {
    let mut sum = 0.0;
    let mut last: Option<Vector3> = None;
    recorded
        .iter()
        .map(|keyframe| {
            let place = keyframe.site_from_base.translation.vector;
            sum += last.map_or(0.0, |last| (place - last).norm());
            last = Some(place);
            sum
        })
        .collect()
}

/// Keyframes that are truly back: near an old one, on its floor and in its sight.
pub fn revisits(site: &Site, recorded: &[Recorded]) -> Vec<usize> {
    let walked = walked(recorded);
    let eye = |pose: &Isometry| pose.translation.vector + Vector3::z() * 0.3;
    (0..recorded.len())
        .filter(|&newer| {
            (0..newer).any(|older| {
                let (a, b) = (eye(&recorded[older].site_from_base), eye(&recorded[newer].site_from_base));
                let (way, far) = (b - a, (b - a).norm());
                walked[newer] - walked[older] > REVISIT_WALKED
                    && way.xy().norm() < REVISIT_NEAR
                    && way.z.abs() < REVISIT_LEVEL
                    && (far < 1e-3 || site.cast(&a, &(way / far), far).is_none())
            })
        })
        .collect()
}
