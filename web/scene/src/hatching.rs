//! Hatching of areas.

use glam::DVec2;

/// Parallel lines inside an area by its corners, at 45 degrees to the axes, `step` apart; farther apart where that would be more than `max_lines`. Linear in lines times
/// corners.
pub fn hatching(corners: &[DVec2], step: f64, max_lines: u32) -> Vec<[DVec2; 2]> {
    let along = DVec2::new(1.0, 1.0).normalize();
    let across = along.perp();
    let offsets = || corners.iter().map(|corner| corner.dot(across));
    let (low, high) = (offsets().fold(f64::INFINITY, f64::min), offsets().fold(f64::NEG_INFINITY, f64::max));
    let is_finite = corners.iter().all(|corner| corner.is_finite());
    if corners.len() < 3 || !is_finite || high <= low || step <= 0.0 {
        return Vec::new();
    }
    let step = step.max((high - low) / f64::from(max_lines.max(1)));
    let mut lines = Vec::new();
    let mut offset = (low / step).ceil() * step;
    while offset < high {
        let mut crossings: Vec<f64> = crossings(corners, across, offset).map(|at| at.dot(along)).collect();
        crossings.sort_by(f64::total_cmp);
        let inside = crossings.chunks_exact(2).map(|ends| [ends[0], ends[1]]);
        lines.extend(inside.map(|ends| ends.map(|at| along * at + across * offset)));
        offset += step;
    }
    lines
}

/// Where the sides of an area cross a line.
fn crossings(corners: &[DVec2], across: DVec2, offset: f64) -> impl Iterator<Item = DVec2> {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).filter_map(move |(a, b)| {
        let (from, to) = (a.dot(across), b.dot(across));
        let is_crossed = (from <= offset) != (to <= offset);
        is_crossed.then(|| a.lerp(*b, (offset - from) / (to - from)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 0.1;

    #[test]
    fn lines_lie_inside_an_area_that_is_not_convex() {
        // An L of 3: of the square from (0, 0) to (2, 2), the one from (1, 1) on is missing.
        let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let lines = hatching(&corners.map(DVec2::from_array), STEP, 1_000);
        let area: f64 = lines.iter().map(|[a, b]| a.distance(*b) * STEP).sum();
        assert!((area - 3.0).abs() < 0.1, "{area}");
        let is_inside = |at: DVec2| at.min_element() >= -1e-9 && at.max_element() <= 2.0 + 1e-9;
        let is_in_gap = |at: DVec2| at.min_element() > 1.0 + 1e-9;
        for [a, b] in lines {
            assert!(is_inside(a) && is_inside(b) && !is_in_gap(a.midpoint(b)), "{a} {b}");
        }
    }

    #[test]
    fn a_large_area_has_few_lines_and_no_area_has_none() {
        let large = [[0.0, 0.0], [1e6, 0.0], [0.0, 1e6]].map(DVec2::from_array);
        let lines = hatching(&large, STEP, 50);
        assert!((30..=50).contains(&lines.len()), "{}", lines.len());
        for corners in [
            &[[0.0, 0.0], [1.0, 0.0]][..],
            &[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]],
            &[[0.0, f64::NAN], [1.0, 1.0], [2.0, 0.0]],
            &[[0.0, 0.0], [f64::INFINITY, 1.0], [2.0, 0.0]],
        ] {
            let corners: Vec<DVec2> = corners.iter().map(|corner| DVec2::from_array(*corner)).collect();
            assert!(hatching(&corners, STEP, 50).is_empty(), "{corners:?}");
        }
    }
}
