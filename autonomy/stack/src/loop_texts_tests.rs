//! The figures that the sentences give, and that every refusal is a sentence.

use super::*;
use geometry::{Isometry, Matrix6};
use mapping::{CandidateSource, ComparedPair, PoseGraphEdge};
use vocab::KeyframeId;

fn record(outcome: LoopOutcome, agreeing: usize, mahalanobis_squared: Option<f64>) -> LoopRecord {
    let source = CandidateSource::Geometry;
    let edge = PoseGraphEdge {
        from: KeyframeId(3),
        to: KeyframeId(9),
        from_from_to: Isometry::identity(),
        information: Matrix6::identity(),
    };
    let evidence = PairEvidence {
        source,
        score: 0.5,
        overlap: [0.2, 0.31],
        residual_m: 0.085,
        free_space_violation: [0.004, 0.052],
        runner_up_ratio: 0.97,
        degenerate_directions: 2,
        conditioning: 0.01,
        correction_m: 0.0,
        correction_rad: 0.0,
        mahalanobis_squared,
    };
    LoopRecord {
        pair: ComparedPair { source, guess: Isometry::identity(), edge, evidence },
        outcome,
        agreeing,
    }
}

#[test]
fn a_rejection_gives_the_figure_and_its_limit() {
    let config = VerificationConfig {
        min_overlap_better: 0.6,
        min_overlap_worse: 0.4,
        max_residual_m: 0.05,
        max_free_space_violation: 0.02,
        ..VerificationConfig::default()
    };
    for (rejection, figures) in [
        (RejectionReason::Overlap, ["31 % and 20 %", "60 % and 40 %"]),
        (RejectionReason::Residual, ["85 mm", "50 mm"]),
        (RejectionReason::FreeSpaceViolation, ["5.2 %", "2.0 %"]),
        (RejectionReason::Ambiguous, ["97 %", "as well"]),
        (RejectionReason::Degenerate, ["2 directions", "graph"]),
        (RejectionReason::NoFit, ["could not be fitted", "."]),
    ] {
        let text = reason(&record(LoopOutcome::Decided(Verdict::Rejected(rejection)), 1, None), &config);
        for figure in figures {
            assert!(text.contains(figure), "{figure} in: {text}");
        }
    }
}

#[test]
fn a_held_pair_says_what_it_waits_for() {
    let config = VerificationConfig::default();
    let held = LoopOutcome::Decided(Verdict::Held);
    let text = reason(&record(held, 3, Some(40.0)), &config);
    assert!(text.contains("2 so far"), "{text}");
    let text = reason(&record(held, 1, None), &config);
    assert!(text.contains("nothing else connects"), "{text}");
}

#[test]
fn every_refusal_is_a_sentence_that_names_the_keyframes() {
    let pair = (KeyframeId(3), KeyframeId(9));
    for error in [
        LoopCommandError::AlreadyLoop(pair),
        LoopCommandError::NotCompared(pair),
        LoopCommandError::NotRegistered(pair),
        LoopCommandError::UnknownKeyframes(pair),
        LoopCommandError::NoLoop(pair),
    ] {
        for text in [refusal(&error), proposal_refusal(&error)] {
            assert!(text.starts_with("Keyframes 3 and 9 ") && text.ends_with('.'), "{text}");
        }
    }
    assert!(proposal_refusal(&LoopCommandError::AlreadyLoop(pair)).ends_with("Reject it first."));
    assert!(refusal(&LoopCommandError::Neighbours).ends_with('.'));
}
