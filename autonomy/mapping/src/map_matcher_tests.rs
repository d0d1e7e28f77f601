//! Alignment of maps of one site, of two sites, and of sites with symmetry.

use super::*;
use crate::testing::{SENSOR, World, at, ring, ring_poses, room, scan};

/// A map of a walk. The map's frame lies at `map_from_world`.
fn matcher(world: &World, poses: &[Isometry], map_from_world: &Isometry, seed: u64) -> MapMatcher {
    let mut matcher = MapMatcher::default();
    for (seed, pose) in (seed..).zip(poses) {
        matcher.push_cloud(&(map_from_world * pose), &scan(world, pose, seed), SENSOR);
    }
    matcher
}

#[test]
fn a_partial_map_of_another_day_is_aligned() {
    let world = ring();
    let mut first = matcher(&world, &ring_poses(0.0), &at(0.0, 0.0, 0.0), 0);
    // In the opposite direction along two of four sides, in a frame of its own.
    let part: Vec<Isometry> =
        ring_poses(-0.3)[5..32].iter().rev().map(|pose| pose * at(0.0, 0.0, 3.0)).collect();
    let second_from_world = at(-40.0, 13.0, 2.2);
    let mut second = matcher(&world, &part, &second_from_world, 1_000);
    let alignment =
        first.align(&mut second, &VerificationConfig::default()).expect("they have two corridors in common");
    let error = alignment.first_from_second * second_from_world;
    assert!(error.translation.vector.norm() < 0.3 && error.rotation.angle() < 0.02, "{error}");
    assert!(
        alignment.support >= MapMatcherConfig::default().min_support && alignment.links.len() >= 10,
        "{alignment:?}"
    );
    for link in &alignment.links {
        let truth = ring_poses(0.0)[link.from.0 as usize].inverse() * part[link.to.0 as usize];
        let off = (truth.inverse() * link.from_from_to).translation.vector.norm();
        assert!(off < 0.05, "{link:?}: {off} m");
    }
}

#[test]
fn a_map_of_another_site_is_not_aligned() {
    let mut first = matcher(&ring(), &ring_poses(0.0), &at(0.0, 0.0, 0.0), 0);
    let hall = room([-15.0, -11.0], [14.0, 9.0]);
    let walk: Vec<Isometry> = (0..24).map(|x| at(f64::from(x) - 12.0, -4.0, 0.3)).collect();
    let mut second = matcher(&hall, &walk, &at(3.0, 0.0, 1.0), 500);
    let refused = first.align(&mut second, &VerificationConfig::default());
    assert!(matches!(refused, Err(AlignmentError::TooFew(_))), "{refused:?}");
    assert_eq!(
        first.align(&mut MapMatcher::default(), &VerificationConfig::default()),
        Err(AlignmentError::TooFew(0))
    );
}

#[test]
fn an_ambiguous_alignment_is_refused() {
    // A ring that looks the same from the opposite side: the block alone, without cupboards.
    let world: World = ring().into_iter().take(7).collect();
    let mut first = matcher(&world, &ring_poses(0.0), &at(0.0, 0.0, 0.0), 0);
    let mut second = matcher(&world, &ring_poses(0.1)[3..40], &at(5.0, 5.0, 1.0), 800);
    let refused = first.align(&mut second, &VerificationConfig::default());
    assert!(matches!(refused, Err(AlignmentError::Ambiguous(..))), "{refused:?}");
}
