//! Pairs poses of the truth and the estimate at the same instant.

use super::Track;
use geometry::Isometry;
use vocab::{Span, Stamp};

/// Matching of instants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Matching {
    /// The truth is interpolated at the instants of the estimate.
    Interpolate,
    /// Each pose of the shorter trajectory is matched with the nearest of the longer.
    Nearest,
}

/// A pose of the truth and of the estimate at the same instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    pub stamp: Stamp,
    pub truth: Isometry,
    pub estimate: Isometry,
}

/// The pairs in order of time.
///
/// - `offset`: added to the estimate's stamps to get the truth's.
/// - `max_gap`: for interpolation the longest gap in the truth that is interpolated, otherwise the greatest difference of the stamps.
pub fn pair(truth: &Track, estimate: &Track, offset: Span, matching: Matching, max_gap: Span) -> Vec<Pair> {
    let estimate = estimate.iter().map(|(stamp, pose)| (*stamp + offset, *pose));
    match matching {
        Matching::Interpolate => estimate
            .filter_map(|(stamp, estimate)| {
                let truth = at(truth, stamp, max_gap)?;
                Some(Pair { stamp, truth, estimate })
            })
            .collect(),
        Matching::Nearest => nearest(truth, &estimate.collect(), max_gap),
    }
}

/// The pose at an instant, interpolated between the two around it.
fn at(track: &Track, stamp: Stamp, max_gap: Span) -> Option<Isometry> {
    let after = track.partition_point(|(other, _)| *other < stamp);
    let (next_stamp, next) = track.get(after)?;
    if *next_stamp == stamp {
        return Some(*next);
    }
    let (last_stamp, last) = track.get(after.checked_sub(1)?)?;
    let gap = *next_stamp - *last_stamp;
    if gap > max_gap {
        return None;
    }
    let fraction = (stamp - *last_stamp).secs_f64() / gap.secs_f64();
    Some(last.lerp_slerp(next, fraction))
}

fn nearest(truth: &Track, estimate: &Track, max_difference: Span) -> Vec<Pair> {
    let truth_is_longer = truth.len() > estimate.len();
    let (short, long) = if truth_is_longer { (estimate, truth) } else { (truth, estimate) };
    short
        .iter()
        .filter_map(|(stamp, pose)| {
            let after = long.partition_point(|(other, _)| other < stamp);
            let around = [after.checked_sub(1), Some(after)];
            let candidates = around.into_iter().flatten().filter_map(|index| long.get(index));
            let difference = |other: &Stamp| (*other - *stamp).nanos().abs();
            let (other, found) = candidates.min_by_key(|(other, _)| difference(other))?;
            (difference(other) <= max_difference.nanos()).then(|| {
                let (truth, estimate) = if truth_is_longer { (*found, *pose) } else { (*pose, *found) };
                Pair { stamp: *stamp, truth, estimate }
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(points: &[(i64, f64)]) -> Track {
        points
            .iter()
            .map(|(millis, x)| {
                (Stamp::EPOCH + Span::from_millis(*millis), Isometry::translation(*x, 0.0, 0.0))
            })
            .collect()
    }

    fn xs(pairs: &[Pair]) -> Vec<(f64, f64)> {
        let x = |pose: &Isometry| (pose.translation.x * 1e6).round() / 1e6;
        pairs.iter().map(|pair| (x(&pair.truth), x(&pair.estimate))).collect()
    }

    #[test]
    fn truth_is_interpolated_but_not_over_gaps_nor_beyond_its_ends() {
        let truth = track(&[(0, 0.0), (100, 1.0), (2000, 20.0)]);
        let estimate = track(&[(-60, 9.0), (0, 9.0), (15, 9.0), (500, 9.0), (3000, 9.0)]);
        let pairs =
            pair(&truth, &estimate, Span::from_millis(10), Matching::Interpolate, Span::from_millis(500));
        assert_eq!(xs(&pairs), [(0.1, 9.0), (0.25, 9.0)]);
    }

    #[test]
    fn the_nearest_pose_is_matched_if_its_stamp_is_near_enough() {
        let truth = track(&[(0, 0.0), (100, 1.0), (200, 2.0)]);
        let estimate = track(&[(94, 5.0), (150, 6.0)]);
        let pairs = pair(&truth, &estimate, Span::ZERO, Matching::Nearest, Span::from_millis(10));
        assert_eq!(xs(&pairs), [(1.0, 5.0)]);
    }
}
