//! What is converted to a message and back must be what it was: the results of jobs come back from the log.

use super::*;
use geometry::{Isometry, Rotation, Vector3};
use mapping::ComparedPair;
use messages::LoopRejection;
use uuid::Uuid;
use vocab::{KeyframeId, Pose, Stamp};

const SESSION: SessionId = SessionId(Uuid::from_u128(7));
const SOURCES: [(CandidateSource, LoopSource); 3] = [
    (CandidateSource::Geometry, LoopSource::Geometry),
    (CandidateSource::Appearance(0.25), LoopSource::Appearance(0.25)),
    (CandidateSource::Person, LoopSource::Person),
];
const REJECTIONS: [(RejectionReason, LoopRejection); 6] = [
    (RejectionReason::NoFit, LoopRejection::NoFit),
    (RejectionReason::Overlap, LoopRejection::Overlap),
    (RejectionReason::Residual, LoopRejection::Residual),
    (RejectionReason::FreeSpaceViolation, LoopRejection::FreeSpaceViolation),
    (RejectionReason::Ambiguous, LoopRejection::Ambiguous),
    (RejectionReason::Degenerate, LoopRejection::Degenerate),
];

fn pose() -> Isometry {
    Isometry::from_parts(Vector3::new(1.0, -2.0, 0.5).into(), Rotation::from_euler_angles(0.1, -0.2, 2.5))
}

fn information() -> Matrix6 {
    Matrix6::from_fn(|row, column| (6 * row + column) as f64)
}

fn evidence(source: CandidateSource) -> PairEvidence {
    PairEvidence {
        source,
        score: 0.75,
        overlap: [0.5, 0.25],
        residual_m: 0.03,
        free_space_violation: [0.01, 0.02],
        runner_up_ratio: 0.4,
        degenerate_directions: 2,
        conditioning: 0.06,
        correction_m: 0.7,
        correction_rad: 0.08,
        mahalanobis_squared: Some(9.0),
    }
}

fn result(source: CandidateSource, rejection: Option<RejectionReason>) -> ComparisonResult {
    ComparisonResult { pose: pose(), information: information(), evidence: evidence(source), rejection }
}

fn loop_task(source: LoopSource) -> LoopTask {
    let guess = pose_from_isometry(&pose());
    LoopTask { session: SESSION, from: KeyframeId(3), to: KeyframeId(9), source, guess }
}

fn revisit_task() -> RevisitTask {
    let (stamp, guess) = (Stamp::from_nanos(5), pose_from_isometry(&pose()));
    RevisitTask { session: SESSION, waypoint: 4, stamp, keyframe: KeyframeId(3), guess }
}

/// Equal, but for the rounding of the rotation on its way through a quaternion.
fn assert_same(found: &ComparisonResult, expected: &ComparisonResult) {
    assert!((found.pose.inverse() * expected.pose).translation.vector.norm() < 1e-12);
    assert!(found.pose.rotation.angle_to(&expected.pose.rotation) < 1e-7);
    assert_eq!(ComparisonResult { pose: expected.pose, ..*found }, *expected);
}

#[test]
fn the_result_of_a_pair_comes_back_from_the_log() {
    let rejections = REJECTIONS.map(|(reason, _)| Some(reason)).into_iter().chain([None]);
    for (source, plain_source) in SOURCES {
        for rejection in rejections.clone() {
            let result = result(source, rejection);
            let plain = verified_to_plain(&loop_task(plain_source), &result);
            assert_same(&verified_from_plain(&plain).expect("finite"), &result);
        }
    }
    for (reason, plain) in REJECTIONS {
        assert_eq!(rejection_to_plain(reason), plain);
    }
}

#[test]
fn the_result_of_a_revisit_comes_back_from_the_log() {
    let result = result(CandidateSource::Geometry, Some(RejectionReason::Degenerate));
    let plain = compared_to_plain(&revisit_task(), &result);
    assert_eq!(plain.task, revisit_task());
    assert_same(&compared_from_plain(&plain).expect("finite"), &result);
}

#[test]
fn a_pose_that_is_not_finite_is_no_result() {
    let not_finite = Pose { position: vocab::Vec3::new(f64::NAN, 0.0, 0.0), ..Pose::IDENTITY };
    let result = result(CandidateSource::Person, None);
    let verified = verified_to_plain(&loop_task(LoopSource::Person), &result);
    assert_eq!(verified_from_plain(&VerifiedLoop { from_from_to: not_finite, ..verified }), None);
    let compared = compared_to_plain(&revisit_task(), &result);
    assert_eq!(compared_from_plain(&ComparedRevisit { keyframe_from_base: not_finite, ..compared }), None);
}

#[test]
fn a_queued_comparison_becomes_a_job_with_its_numbers() {
    let (from, to, guess) = (KeyframeId(3), KeyframeId(9), pose());
    let pair = QueuedComparison::Pair { from, to, source: CandidateSource::Person, guess };
    assert_eq!(ComparisonTask::new(SESSION, &pair).job(), Job::VerifyLoop(loop_task(LoopSource::Person)));
    let stamp = Stamp::from_nanos(5);
    let revisit = QueuedComparison::Revisit { waypoint: 4, stamp, keyframe: from, guess };
    assert_eq!(ComparisonTask::new(SESSION, &revisit).job(), Job::CompareRevisit(revisit_task()));
}

#[test]
fn every_outcome_has_its_verdict_and_a_reason() {
    let edge = PoseGraphEdge {
        from: KeyframeId(3),
        to: KeyframeId(9),
        from_from_to: pose(),
        information: information(),
    };
    let source = CandidateSource::Appearance(0.25);
    let pair = ComparedPair { source, guess: pose(), edge, evidence: evidence(source) };
    let outcomes = [
        (LoopOutcome::AcceptedByPerson, LoopVerdict::Accepted, true),
        (LoopOutcome::RejectedByPerson, LoopVerdict::Rejected, true),
        (LoopOutcome::Decided(Verdict::Accepted), LoopVerdict::Accepted, false),
        (LoopOutcome::Decided(Verdict::Held), LoopVerdict::Held, false),
        (LoopOutcome::Decided(Verdict::Rejected(RejectionReason::NoFit)), LoopVerdict::Rejected, false),
        (LoopOutcome::Decided(Verdict::Dropped), LoopVerdict::Dropped, false),
    ];
    for (outcome, verdict, by_hand) in outcomes {
        let record = LoopRecord { pair, outcome, agreeing: 1 };
        let decision = decision_to_plain(SESSION, &record, &VerificationConfig::default());
        assert_eq!((decision.verdict, decision.by_hand), (verdict, by_hand), "{outcome:?}");
        assert_eq!(decision.task, loop_task(LoopSource::Appearance(0.25)));
        assert_eq!(decision.evidence, evidence_to_plain(&pair.evidence));
        assert!(decision.reason.ends_with('.'), "{}", decision.reason);
    }
}

#[test]
fn a_search_reports_its_newest_link_or_why_it_failed() {
    let link = |to| PoseGraphEdge {
        from: KeyframeId(3),
        to: KeyframeId(to),
        from_from_to: pose(),
        information: information(),
    };
    let links = vec![link(2), link(8), link(5)];
    let alignment = MapAlignment { first_from_second: pose(), links, support: 3, runner_up_support: 1 };
    let found = search_to_plain(Ok((alignment.clone(), 100)));
    let MapSearchOutcome::Found { keyframe, waypoint, support, runner_up_support, .. } = found else {
        panic!("found: {found:?}");
    };
    assert_eq!((keyframe, waypoint, support, runner_up_support), (KeyframeId(3), 108, 3, 1));
    let fix = fix_from_plain(&found).expect("a pose");
    assert_eq!((fix.keyframe, fix.waypoint), (KeyframeId(3), 108));
    let without_links = MapAlignment { links: Vec::new(), ..alignment };
    for (search, outcome) in [
        (Ok((without_links, 100)), MapSearchOutcome::NotFound(0)),
        (Err(AlignmentError::TooFew(2)), MapSearchOutcome::NotFound(2)),
        (Err(AlignmentError::Ambiguous(4, 3)), MapSearchOutcome::Ambiguous(4, 3)),
    ] {
        let plain = search_to_plain(search);
        assert_eq!(plain, outcome);
        assert!(fix_from_plain(&plain).is_none());
    }
}

#[test]
fn the_graph_lists_odometry_before_loops() {
    let edge = |to| PoseGraphEdge {
        from: KeyframeId(0),
        to: KeyframeId(to),
        from_from_to: pose(),
        information: information(),
    };
    let node =
        mapping::PoseGraphNode { id: KeyframeId(1), stamp: Stamp::from_nanos(5), map_from_keyframe: pose() };
    let changes = GraphChanges {
        base_revision: 3,
        revision: 4,
        nodes: vec![node],
        edges: vec![edge(1)],
        removed_loops: vec![(KeyframeId(0), KeyframeId(7))],
        loops: vec![edge(9)],
    };
    let delta = changes_to_plain(SESSION, &changes);
    assert_eq!(delta.session, SESSION);
    assert_eq!((delta.base_revision, delta.revision), (3, 4));
    assert_eq!(delta.removed_loops, changes.removed_loops);
    assert_eq!(delta.nodes[0].map_from_keyframe, pose_from_isometry(&pose()));
    let edges: Vec<(u32, EdgeKind)> = delta.edges.iter().map(|edge| (edge.to.0, edge.kind)).collect();
    assert_eq!(edges, [(1, EdgeKind::Odometry), (9, EdgeKind::Loop)]);
    assert_eq!(from_rows(&delta.edges[0].information), information());
}
