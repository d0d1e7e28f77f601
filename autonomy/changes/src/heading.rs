//! How clearly points tell the heading of what they are on.

use crate::BoxFitConfig;
use crate::circle::Circle;
use crate::upright_box::{extent, turn};

/// Times that the sides of a box are put to the points on them. Chosen: points that change from one side to another are few.
const SIDE_ROUNDS: usize = 4;

/// How far points are from the sides that they are on.
pub(crate) struct SideNoise {
    /// Standard deviation, metres.
    pub(crate) deviation_m: f64,
    /// A point that is farther away by this number of deviations is on no side: it tells nothing of the heading.
    pub(crate) most_deviations: f64,
    /// Share of the points at each end of an axis beyond the sides of the box: single ones.
    pub(crate) stray_share: f64,
}

/// What points tell of a heading.
pub(crate) struct Evidence {
    /// Logarithm of how much likelier the points are with the first heading than with the second one.
    pub(crate) log_ratio: f64,
    /// Number of the points that were used.
    pub(crate) points: usize,
}

/// How much likelier points are on the sides of the box round them with the first heading, radians, than on those of the box with the second one, with normal noise
/// (docs/maths/changes.md, equation 10). `O(n log n)` in the points that are used, [`BoxFitConfig::max_fit_points`] at most.
pub(crate) fn evidence_of_heading(
    points: &[[f32; 3]],
    headings_rad: [f64; 2],
    noise: &SideNoise,
    config: &BoxFitConfig,
) -> Evidence {
    let level = level(points, config);
    let [own, other] = headings_rad.map(|yaw_rad| misfit(&level, yaw_rad, noise));
    Evidence { log_ratio: other - own, points: level[0].len() }
}

/// What points tell of the shape of what they are on.
pub(crate) struct ShapeEvidence {
    /// Logarithm of how much likelier the points are on the sides of the box round them than on a circle. What is round has no heading.
    pub(crate) corners: f64,
    /// Share of the points that are on the sides.
    pub(crate) on_sides: f64,
}

/// What points tell of the shape of what they are on, seen from above, if it has a heading, radians. The circle is fitted to the points that are on the sides
/// (docs/maths/changes.md, equation 11). `O(n log n)` in the points that are used.
pub(crate) fn evidence_of_shape(
    points: &[[f32; 3]],
    yaw_rad: f64,
    noise: &SideNoise,
    config: &BoxFitConfig,
) -> ShapeEvidence {
    let level = level(points, config);
    let from_sides_m = from_sides(&level, yaw_rad, noise);
    let places = || level[0].iter().zip(&level[1]).map(|(x, y)| [*x, *y]);
    let on_sides: Vec<[f64; 2]> = places()
        .zip(&from_sides_m)
        .filter(|(_, from_side_m)| noise.is_on(**from_side_m))
        .map(|(place, _)| place)
        .collect();
    let on_box: f64 = from_sides_m.iter().map(|from_side_m| noise.misfit(*from_side_m)).sum();
    let on_circle = Circle::fit(&on_sides)
        .map_or(f64::INFINITY, |circle| places().map(|place| noise.misfit(circle.distance_m(&place))).sum());
    ShapeEvidence {
        corners: on_circle - on_box,
        on_sides: on_sides.len() as f64 / level[0].len().max(1) as f64,
    }
}

/// Half of the sum over points of the squared distance from the nearest side of the box round them, in deviations.
fn misfit(level: &[Vec<f64>; 2], yaw_rad: f64, noise: &SideNoise) -> f64 {
    from_sides(level, yaw_rad, noise).into_iter().map(|at_m| noise.misfit(at_m)).sum()
}

/// The coordinates of the points that are used, seen from above.
fn level(points: &[[f32; 3]], config: &BoxFitConfig) -> [Vec<f64>; 2] {
    let step = points.len().div_ceil(config.max_fit_points).max(1);
    [0, 1].map(|axis| points.iter().step_by(step).map(|point| f64::from(point[axis])).collect())
}

/// Distance of each point from the nearest side of the box round them, metres. Each side is put to the mean of the points that are nearest to it and on it, again and again.
fn from_sides(level: &[Vec<f64>; 2], yaw_rad: f64, noise: &SideNoise) -> Vec<f64> {
    let mut turned = level.clone();
    turn(level, yaw_rad, &mut turned);
    let sides = turned.each_ref().map(|values| extent(values.clone(), noise.stray_share));
    let [Some([left, right]), Some([back, front])] = sides else { return Vec::new() };
    let mut sides_m = [left, right, back, front];
    let [along, across] = &turned;
    let nearest = |sides_m: &[f64; 4], (x, y): (&f64, &f64)| {
        let from_m = [x - sides_m[0], x - sides_m[1], y - sides_m[2], y - sides_m[3]];
        let side = (0..4).min_by(|a, b| from_m[*a].abs().total_cmp(&from_m[*b].abs())).unwrap_or(0);
        (side, from_m[side])
    };
    for _ in 0..SIDE_ROUNDS {
        let mut sums = [(0.0, 0.0); 4];
        for point in along.iter().zip(across) {
            let (side, from_m) = nearest(&sides_m, point);
            if noise.is_on(from_m.abs()) {
                sums[side] = (sums[side].0 + 1.0, sums[side].1 + from_m);
            }
        }
        for (side_m, (count, sum_m)) in sides_m.iter_mut().zip(sums) {
            *side_m += sum_m / f64::max(count, 1.0);
        }
    }
    along.iter().zip(across).map(|point| nearest(&sides_m, point).1.abs()).collect()
}

impl SideNoise {
    /// Whether a point at a distance from a side may be on it, metres.
    fn is_on(&self, distance_m: f64) -> bool {
        distance_m < self.most_deviations * self.deviation_m
    }

    /// Negative logarithm of the likelihood of a point at a distance from what it may be on, metres, without its constant part.
    fn misfit(&self, distance_m: f64) -> f64 {
        (distance_m / self.deviation_m).min(self.most_deviations).powi(2) / 2.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Rng, RngTree};
    use std::f64::consts::TAU;

    const NOISE: SideNoise = SideNoise { deviation_m: 0.014, most_deviations: 3.0, stray_share: 0.02 };

    fn rng(name: &str) -> Rng {
        RngTree::new(7).child(name).rng()
    }

    /// Points on the two sides of a square that one view sees, with noise.
    fn square(side_m: f64, yaw_rad: f64, count: usize, rng: &mut Rng) -> Vec<[f32; 3]> {
        let (sine, cosine) = yaw_rad.sin_cos();
        let mut point = || {
            let (along, across) =
                (rng.range(-side_m / 2.0, side_m / 2.0), -side_m / 2.0 + 0.01 * rng.normal());
            let [x, y] = if rng.uniform() < 0.5 { [along, across] } else { [across, along] };
            [cosine * x - sine * y, sine * x + cosine * y, 0.1].map(|at| at as f32)
        };
        (0..count).map(|_| point()).collect()
    }

    fn ratio_of_point(points: &[[f32; 3]], headings_rad: [f64; 2]) -> f64 {
        let evidence = evidence_of_heading(points, headings_rad, &NOISE, &BoxFitConfig::default());
        assert_eq!(evidence.points, points.len());
        evidence.log_ratio / evidence.points as f64
    }

    #[test]
    fn points_on_two_sides_of_a_small_cube_tell_its_heading_and_that_it_has_corners() {
        let mut rng = rng("square");
        for turn_rad in [0.5, 0.8, 1.0] {
            let points = square(0.15, 0.3, 120, &mut rng);
            let ShapeEvidence { corners, on_sides } =
                evidence_of_shape(&points, 0.3, &NOISE, &BoxFitConfig::default());
            assert!(corners > 5.0 && on_sides > 0.9, "{corners} {on_sides}");
            let ratio = ratio_of_point(&points, [0.3, 0.3 + turn_rad]);
            assert!(ratio > 0.1, "{turn_rad} {ratio}");
            assert!((ratio + ratio_of_point(&points, [0.3 + turn_rad, 0.3])).abs() < 1e-9);
        }
    }

    #[test]
    fn points_on_a_round_post_or_barrel_tell_no_heading_and_no_corners() {
        let mut rng = rng("post");
        for (radius_m, count) in [(0.08, 90), (0.3, 1_500)] {
            let mut point = || {
                let (around, away_m) = (rng.range(0.0, 0.6 * TAU), radius_m + 0.01 * rng.normal());
                [away_m * around.cos(), away_m * around.sin(), 0.5].map(|at| at as f32)
            };
            let points: Vec<[f32; 3]> = (0..count).map(|_| point()).collect();
            for heading_rad in [0.0, 0.3, 0.7, 1.2] {
                let ratio = ratio_of_point(&points, [heading_rad, heading_rad + 0.6]);
                let shape = evidence_of_shape(&points, heading_rad, &NOISE, &BoxFitConfig::default());
                assert!(
                    ratio < 0.15 && shape.corners < 6.9,
                    "{radius_m} {heading_rad} {ratio} {}",
                    shape.corners
                );
            }
        }
    }

    #[test]
    fn no_points_tell_nothing() {
        let evidence = evidence_of_heading(&[], [0.0, 1.0], &NOISE, &BoxFitConfig::default());
        assert_eq!((evidence.log_ratio, evidence.points), (0.0, 0));
        let shape = evidence_of_shape(&[], 0.0, &NOISE, &BoxFitConfig::default());
        assert!(shape.on_sides == 0.0, "{}", shape.on_sides);
    }
}
