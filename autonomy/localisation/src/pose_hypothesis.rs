//! Poses at which a scan may have been taken, and the classification of a list of them.

use geometry::{Isometry, so3};
use mapping::VerificationConfig;

/// A pose of the base at which a scan may have been taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseHypothesis {
    /// Pose of the base in the map.
    pub map_from_base: Isometry,
    /// How well the scan fits the map's surfaces there, 0 to 1.
    pub fit: f64,
    /// Share of the points inside the keyframes' view that lie where the keyframes saw free space.
    pub violation_share: f64,
}

impl PoseHypothesis {
    /// The fit, reduced by the share of free-space violations (equation 5).
    pub fn quality(&self) -> f64 {
        self.fit * (1.0 - self.violation_share)
    }
}

/// Greatest difference of two poses that count as one.
/// The field of a configuration that has this type says where both values come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HypothesisTolerance {
    /// Distance of the positions, metres.
    pub distance_m: f64,
    /// Angle between the orientations, radians.
    pub angle_rad: f64,
}

impl HypothesisTolerance {
    /// Whether two poses count as one.
    pub fn contains(&self, a: &Isometry, b: &Isometry) -> bool {
        let differs = (a.translation.vector - b.translation.vector).norm() > self.distance_m
            || so3::log(&(a.rotation.inverse() * b.rotation)).norm() > self.angle_rad;
        !differs
    }
}

/// Thresholds by which the hypotheses of one scan are accepted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AcceptanceConfig {
    /// Least fit of a pose that may be the right one. Chosen: above the 0.45 to 0.7 of poses near the end of a map ([`Self::min_low_confidence_fit`]).
    pub min_fit: f64,
    /// Greatest share of free-space violations of such a pose. Chosen: people and moved things make some per cent; a local minimum 0.28 m beside the right pose had 7 %
    /// (docs/maths/localisation.md), so that it does not suffice alone.
    pub max_violation_share: f64,
    /// A pose is ambiguous if another one reaches this share of its quality. Chosen: nearer to 1, a scan with people in it decides between places that look alike;
    /// farther from it, more poses have to be resolved by walking.
    pub ambiguity_ratio: f64,
    /// Least fit of a pose of low confidence. Near the end of a map, where much of a scan is in no map, the right pose has a fit of 0.45 to 0.7. Chosen below that.
    pub min_low_confidence_fit: f64,
    /// A pose of low confidence is dropped if another one reaches this share of its quality. Source: docs/maths/localisation.md: near the end of a map no other pose
    /// reaches two thirds of the right one's quality.
    pub low_confidence_ambiguity_ratio: f64,
    /// A tracked pose is contradicted if its quality is less than this share of another pose's. Chosen: nearer to 1, noise contradicts right poses; farther from it,
    /// wrong ones stay.
    pub contradiction_ratio: f64,
    /// Two hypotheses this near to each other are the same pose. Its default is the distance at which the verification of loops tells two registrations
    /// apart ([`VerificationConfig::distinct_m`], [`VerificationConfig::distinct_rad`]).
    pub same_pose: HypothesisTolerance,
}

impl Default for AcceptanceConfig {
    fn default() -> Self {
        let verification = VerificationConfig::default();
        Self {
            min_fit: 0.72,
            max_violation_share: 0.1,
            ambiguity_ratio: 0.85,
            min_low_confidence_fit: 0.4,
            low_confidence_ambiguity_ratio: 0.75,
            contradiction_ratio: 0.93,
            same_pose: HypothesisTolerance {
                distance_m: verification.distinct_m,
                angle_rad: verification.distinct_rad,
            },
        }
    }
}

/// Classification of the hypotheses of one scan.
#[derive(Clone, Debug, PartialEq)]
pub enum RelocalisationResult {
    /// One pose fits, and no other one.
    Unique(PoseHypothesis),
    /// Several poses fit, the best first. The robot has to move before wrong ones can be rejected.
    Ambiguous(Vec<PoseHypothesis>),
    /// One pose fits partly and no other one nearly as well. One scan is not enough to accept it.
    LowConfidence(PoseHypothesis),
    /// Nothing fits.
    NotFound,
}

impl RelocalisationResult {
    /// The poses that fit well: one, several or none. A pose of low confidence is not among them.
    pub fn into_accepted(self) -> Vec<PoseHypothesis> {
        match self {
            Self::Unique(best) => vec![best],
            Self::Ambiguous(several) => several,
            Self::LowConfidence(_) | Self::NotFound => Vec::new(),
        }
    }
}

impl AcceptanceConfig {
    /// Classifies the hypotheses of one scan, the best first.
    pub fn classify(&self, found: &[PoseHypothesis]) -> RelocalisationResult {
        let Some(best) = found.first() else { return RelocalisationResult::NotFound };
        let fits = |min_fit: f64| best.fit >= min_fit && best.violation_share <= self.max_violation_share;
        if !fits(self.min_fit) {
            let plausible = fits(self.min_low_confidence_fit);
            let least = self.low_confidence_ambiguity_ratio * best.quality();
            let unrivalled = found.iter().skip(1).all(|other| other.quality() < least);
            return if plausible && unrivalled {
                RelocalisationResult::LowConfidence(*best)
            } else {
                RelocalisationResult::NotFound
            };
        }
        let least = self.ambiguity_ratio * best.quality();
        let similar: Vec<PoseHypothesis> =
            found.iter().filter(|one| one.quality() >= least).copied().collect();
        if similar.len() == 1 {
            RelocalisationResult::Unique(*best)
        } else {
            RelocalisationResult::Ambiguous(similar)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Translation3;

    fn at(x: f64, fit: f64, violation_share: f64) -> PoseHypothesis {
        PoseHypothesis { map_from_base: Isometry::translation(x, 0.0, 0.0), fit, violation_share }
    }

    #[test]
    fn one_good_pose_is_unique_and_several_of_similar_quality_are_ambiguous() {
        let config = AcceptanceConfig::default();
        assert_eq!(config.classify(&[]), RelocalisationResult::NotFound);
        let (best, other, poor) = (at(0.0, 0.9, 0.0), at(9.0, 0.9, 0.1), at(20.0, 0.7, 0.0));
        assert_eq!(config.classify(&[best]), RelocalisationResult::Unique(best));
        assert_eq!(config.classify(&[best, poor]), RelocalisationResult::Unique(best));
        assert_eq!(config.classify(&[best, other, poor]), RelocalisationResult::Ambiguous(vec![best, other]));
        let violating = at(0.0, 0.9, 0.11);
        assert_eq!(config.classify(&[violating]), RelocalisationResult::NotFound);
    }

    #[test]
    fn a_partial_fit_is_of_low_confidence_only_without_a_similar_one() {
        let config = AcceptanceConfig::default();
        let partial = at(0.0, 0.6, 0.0);
        let accepted =
            |found: &[PoseHypothesis]| config.classify(found) == RelocalisationResult::LowConfidence(partial);
        assert!(accepted(&[partial]) && accepted(&[partial, at(9.0, 0.44, 0.0)]));
        assert!(!accepted(&[partial, at(9.0, 0.46, 0.0)]));
        assert_eq!(config.classify(&[at(0.0, 0.39, 0.0)]), RelocalisationResult::NotFound);
        assert!(RelocalisationResult::LowConfidence(partial).into_accepted().is_empty());
    }

    /// Laws that hold for any list of hypotheses.
    #[test]
    fn accepted_poses_come_from_the_list_in_its_order_and_are_of_similar_quality() {
        let config = AcceptanceConfig::default();
        let mut results = [0; 4];
        for seed in 0..2_000 {
            let mut rng = geometry::RngTree::new(seed).child("poses").rng();
            let mut found: Vec<PoseHypothesis> = (0..seed % 6)
                .map(|number| at(3.0 * number as f64, rng.range(0.3, 1.0), rng.range(0.0, 0.12)))
                .collect();
            found.sort_by(|a, b| b.quality().total_cmp(&a.quality()));
            let result = config.classify(&found);
            results[match &result {
                RelocalisationResult::Unique(_) => 0,
                RelocalisationResult::Ambiguous(_) => 1,
                RelocalisationResult::LowConfidence(_) => 2,
                RelocalisationResult::NotFound => 3,
            }] += 1;
            let accepted = result.into_accepted();
            assert_eq!(accepted, found[..accepted.len()], "{found:?}");
            let least = found.first().map_or(0.0, |best| config.ambiguity_ratio * best.quality());
            assert!(accepted.iter().all(|one| one.quality() >= least), "{found:?}");
            let rest = if accepted.is_empty() { &[] } else { &found[accepted.len()..] };
            assert!(rest.iter().all(|one| one.quality() < least), "{found:?}");
        }
        assert!(results.iter().all(|count| *count > 20), "{results:?}");
    }

    #[test]
    fn a_tolerance_bounds_distance_and_angle() {
        let tolerance = HypothesisTolerance { distance_m: 0.5, angle_rad: 0.15 };
        let pose = |x: f64, yaw: f64| {
            let turn = so3::exp(&geometry::Vector3::new(0.0, 0.0, yaw));
            Isometry::from_parts(Translation3::new(x, 0.0, 0.0), turn)
        };
        assert!(tolerance.contains(&pose(0.0, 0.0), &pose(0.49, 0.14)));
        assert!(!tolerance.contains(&pose(0.0, 0.0), &pose(0.51, 0.0)));
        assert!(!tolerance.contains(&pose(0.0, 0.0), &pose(0.0, -0.16)));
    }
}
