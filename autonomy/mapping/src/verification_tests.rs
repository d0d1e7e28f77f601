//! Which pairs are accepted as loops, and which only look alike.

use super::*;
use crate::testing::{World, at, corridor, furnished, room, submap};
use geometry::Vector6;

fn task(older: &World, newer: &World, guess: Isometry, source: CandidateSource) -> VerificationTask {
    let expected = UncertainPose {
        pose: guess,
        covariance: Matrix6::from_diagonal(&Vector6::new(1e-4, 1e-4, 4e-2, 0.1, 0.1, 0.02)),
    };
    let older = submap(older, &[at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0), at(-1.0, 0.0, 0.0)], 1);
    let newer = submap(newer, &[at(0.8, 0.5, 2.0), at(1.2, -0.4, 2.1)], 11);
    VerificationTask {
        from: KeyframeId(3),
        to: KeyframeId(90),
        comparison: Comparison {
            source,
            guesses: vec![guess],
            expected: Some(expected),
            tilt: None,
            older: Arc::new(older.into()),
            newer: Arc::new(newer.into()),
        },
    }
}

fn truth() -> Isometry {
    at(0.8, 0.5, 2.0)
}

#[test]
fn a_revisited_room_is_registered_within_a_centimetre() {
    let task = task(&furnished(), &furnished(), at(0.1, 1.0, 1.85), CandidateSource::Geometry);
    let found = verify(&task, &VerificationConfig::default());
    assert_eq!(found.rejection, None, "{:?}", found.evidence);
    let error = se3::local(&truth(), &found.edge.from_from_to);
    assert!(error.fixed_rows::<3>(3).norm() < 0.01 && error.norm() < 0.015, "{error}");
    assert!(found.edge.information.cholesky().is_some());
    assert!(error.dot(&(found.edge.information * error)) < CHI_99, "{}", found.edge.information);
    assert_eq!(found.evidence.degenerate_directions, 0);
    assert!(found.evidence.free_space_violation.iter().all(|share| *share < 0.02), "{:?}", found.evidence);
    assert_eq!(verify(&task, &VerificationConfig::default()), found, "a second run must give the same bits");
}

const CHI_99: f64 = 16.8;

#[test]
fn a_similar_room_with_a_wall_elsewhere_violates_free_space() {
    let mut larger = furnished();
    // In the larger room the far wall is 1.5 m farther away.
    larger[3] = [[6.5, -4.0, -0.5], [6.7, 4.0, 2.5]];
    larger[4] = [[-5.0, -4.2, -0.5], [6.5, -4.0, 2.5]];
    larger[5] = [[-5.0, 4.0, -0.5], [6.5, 4.2, 2.5]];
    for (older, newer) in [(&larger, &furnished()), (&furnished(), &larger)] {
        let found =
            verify(&task(older, newer, truth(), CandidateSource::Geometry), &VerificationConfig::default());
        assert_eq!(found.rejection, Some(RejectionReason::FreeSpaceViolation), "{:?}", found.evidence);
    }
}

/// Two rooms share a wall of 12 cm, and each keyframe sees one face of it. At this guess the faces coincide, 12 cm from the truth. They say nothing about the
/// distance across the wall.
#[test]
fn the_two_faces_of_a_thin_wall_are_not_taken_for_one() {
    let mut world = room([-6.0, -2.5], [6.0, 2.5]);
    world.push([[0.0, -2.5, -0.5], [0.12, 2.5, 2.5]]);
    let older = submap(&world, &[at(-0.9, 0.1, 0.0), at(-1.6, 0.0, 0.1), at(-2.4, 0.1, 0.0)], 1);
    let newer = submap(&world, &[at(1.1, -0.1, 0.2), at(1.6, 0.2, 0.3)], 11);
    let guess = at(1.88, -0.2, 0.2);
    let mut across = Vector6::zeros();
    across.fixed_rows_mut::<3>(3).copy_from(&(guess.rotation.inverse() * Vector3::x()));
    let information_across = |matching: &MatchingConfig| {
        let equations =
            linearise_from_viewpoint(&older.map, &newer.points, &guess, &newer.viewpoint, matching);
        (across.transpose() * equations.information * across)[0]
    };
    let VerificationConfig { coarse, fine, .. } = VerificationConfig::default();
    for with_sides in [coarse, fine] {
        let without = MatchingConfig { front_facing_only: false, ..with_sides };
        let [with_sides, without] = [with_sides, without].map(|matching| information_across(&matching));
        assert!(with_sides < 0.2 * without, "{with_sides} of {without}");
    }
}

#[test]
fn another_room_does_not_fit() {
    let other = room([-3.0, -9.0], [12.0, 2.5]);
    let found = verify(
        &task(&furnished(), &other, truth(), CandidateSource::Appearance(0.3)),
        &VerificationConfig::default(),
    );
    assert!(found.rejection.is_some(), "{:?}", found.evidence);
}

#[test]
fn a_bare_corridor_is_degenerate_along_its_axis() {
    let looks = task(&corridor(), &corridor(), at(1.6, 0.4, 2.0), CandidateSource::Appearance(0.1));
    let found = verify(&looks, &VerificationConfig::default());
    assert_eq!(found.rejection, Some(RejectionReason::Degenerate), "{:?}", found.evidence);

    // If the graph knows the pose well, the pair may become an edge without information along the axis.
    let mut known = task(&corridor(), &corridor(), at(1.0, 0.4, 2.0), CandidateSource::Geometry);
    if let Some(expected) = &mut known.comparison.expected {
        expected.covariance *= 0.1;
    }
    let found = verify(&known, &VerificationConfig::default());
    assert_eq!((found.rejection, found.evidence.degenerate_directions), (None, 1), "{:?}", found.evidence);
    let measured = UncertainPose::from_information(found.edge.from_from_to, &found.edge.information);
    // The corridor's axis in the frame of the newer base.
    let axis = truth().rotation.inverse() * Vector3::x();
    let across = truth().rotation.inverse() * Vector3::y();
    let block = measured.covariance.fixed_view::<3, 3>(3, 3).into_owned();
    let deviation = |direction: &Vector3| direction.dot(&(block * direction)).sqrt();
    assert!(
        deviation(&axis) > 1.0 && deviation(&across) < 0.05,
        "{} {}",
        deviation(&axis),
        deviation(&across)
    );
    let error = truth().inverse() * found.edge.from_from_to;
    assert!(across.dot(&error.translation.vector).abs() < 0.02, "{error}");
}

#[test]
fn repeating_structure_is_ambiguous_if_the_graph_is_uncertain() {
    // Equal niches, 1.2 m apart, along a corridor.
    let mut comb = corridor();
    for i in -40..40 {
        let x = 1.2 * f64::from(i);
        comb.push([[x, 0.9, -0.5], [x + 0.3, 1.2, 2.5]]);
    }
    let found =
        verify(&task(&comb, &comb, truth(), CandidateSource::Geometry), &VerificationConfig::default());
    assert_eq!(found.rejection, Some(RejectionReason::Ambiguous), "{:?}", found.evidence);
    let mut known = task(&comb, &comb, truth(), CandidateSource::Geometry);
    if let Some(expected) = &mut known.comparison.expected {
        expected.covariance *= 0.01;
    }
    assert_ne!(verify(&known, &VerificationConfig::default()).rejection, Some(RejectionReason::Ambiguous));
}

#[test]
fn empty_and_invalid_input_do_not_fit() {
    let mut broken = task(&furnished(), &furnished(), at(f64::NAN, 0.0, 0.0), CandidateSource::Geometry);
    assert_eq!(verify(&broken, &VerificationConfig::default()).rejection, Some(RejectionReason::NoFit));
    broken.comparison.guesses.clear();
    assert_eq!(verify(&broken, &VerificationConfig::default()).rejection, Some(RejectionReason::NoFit));
    broken.comparison.guesses.push(truth());
    broken.comparison.newer = Arc::new(LazySubmap::new(Vec::new(), 0));
    assert_eq!(verify(&broken, &VerificationConfig::default()).rejection, Some(RejectionReason::NoFit));
    std::mem::swap(&mut broken.comparison.older, &mut broken.comparison.newer);
    assert_eq!(verify(&broken, &VerificationConfig::default()).rejection, Some(RejectionReason::NoFit));
}
