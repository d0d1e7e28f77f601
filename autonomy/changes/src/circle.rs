//! A circle on a plane, fitted to points.

use nalgebra::{Matrix3, Vector3};

/// Steps of the fit at most. Chosen: it converges in five from the start that it has.
const MOST_STEPS: usize = 10;
/// A step that moves the circle by less ends the fit, metres. Chosen: far below the noise of points.
const LEAST_STEP_M: f64 = 1e-5;

/// A circle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Circle {
    centre_m: [f64; 2],
    radius_m: f64,
}

impl Circle {
    /// The circle of which the sum of the squared distances of points is least; none if the points do not tell it, as those on a straight line. It starts with the circle that is least by squares of
    /// squares, which is a linear problem (Kåsa, *A circle fitting procedure and its error analysis*, 1976). Linear in the points.
    pub(crate) fn fit(points: &[[f64; 2]]) -> Option<Self> {
        let count = points.len().max(1) as f64;
        let middle = [0, 1].map(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / count);
        let offsets: Vec<[f64; 2]> =
            points.iter().map(|point| [point[0] - middle[0], point[1] - middle[1]]).collect();
        let mut circle = Self::start(&offsets)?;
        for _ in 0..MOST_STEPS {
            let step = circle.step(&offsets)?;
            circle = Self {
                centre_m: [circle.centre_m[0] + step.x, circle.centre_m[1] + step.y],
                radius_m: circle.radius_m + step.z,
            };
            if step.norm() < LEAST_STEP_M {
                break;
            }
        }
        let [x, y] = circle.centre_m;
        Some(Self { centre_m: [x + middle[0], y + middle[1]], ..circle })
    }

    /// x² + y² = a x + b y + c, by least squares.
    fn start(points: &[[f64; 2]]) -> Option<Self> {
        let (mut matrix, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for [x, y] in points {
            let row = Vector3::new(*x, *y, 1.0);
            matrix += row * row.transpose();
            right += row * (x * x + y * y);
        }
        let [a, b, c] = matrix.cholesky()?.solve(&right).into();
        let squared_m2 = c + (a * a + b * b) / 4.0;
        (squared_m2 > 0.0 && squared_m2.is_finite())
            .then(|| Self { centre_m: [a / 2.0, b / 2.0], radius_m: squared_m2.sqrt() })
    }

    /// A step of Gauss and Newton: changes of the centre and the radius.
    fn step(&self, points: &[[f64; 2]]) -> Option<Vector3<f64>> {
        let (mut matrix, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for point in points {
            let (from_m, row) = self.linearised(point)?;
            matrix += row * row.transpose();
            right -= row * from_m;
        }
        let step = matrix.cholesky()?.solve(&right);
        step.iter().all(|part| part.is_finite()).then_some(step)
    }

    /// How far a point is outside, metres, and its derivatives by the centre and the radius; none at the centre.
    fn linearised(&self, point: &[f64; 2]) -> Option<(f64, Vector3<f64>)> {
        let [x, y] = [0, 1].map(|axis| point[axis] - self.centre_m[axis]);
        let away_m = x.hypot(y);
        (away_m > 0.0).then(|| (away_m - self.radius_m, Vector3::new(-x / away_m, -y / away_m, -1.0)))
    }

    /// Distance of a point from the circle, metres.
    pub(crate) fn distance_m(&self, point: &[f64; 2]) -> f64 {
        ((point[0] - self.centre_m[0]).hypot(point[1] - self.centre_m[1]) - self.radius_m).abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::RngTree;

    #[test]
    fn the_circle_of_half_of_its_points_is_found() {
        let mut rng = RngTree::new(3).child("circle").rng();
        let mut point = || {
            let (around, away_m) = (rng.range(0.3, 3.4), 0.2 + 0.002 * rng.normal());
            [4.0 + away_m * f64::cos(around), -7.0 + away_m * f64::sin(around)]
        };
        let points: Vec<[f64; 2]> = (0..200).map(|_| point()).collect();
        let circle = Circle::fit(&points).expect("a circle");
        assert!((circle.centre_m[0] - 4.0).hypot(circle.centre_m[1] + 7.0) < 2e-3, "{circle:?}");
        assert!((circle.radius_m - 0.2).abs() < 2e-3, "{circle:?}");
        let squares = |circle: &Circle| points.iter().map(|at| circle.distance_m(at).powi(2)).sum::<f64>();
        for [x, y, radius_m] in [[1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0], [0.0, 0.0, 1e-3]] {
            let [cx, cy] = circle.centre_m;
            let other = Circle { centre_m: [cx + x, cy + y], radius_m: circle.radius_m + radius_m };
            assert!(squares(&other) > squares(&circle));
        }
    }

    #[test]
    fn the_derivatives_are_those_of_the_distance() {
        let circle = Circle { centre_m: [0.3, -0.2], radius_m: 0.4 };
        let point = [0.9, 0.5];
        let (_, row) = circle.linearised(&point).expect("not the centre");
        for part in 0..3 {
            let moved = |by: f64| {
                let mut parts = [circle.centre_m[0], circle.centre_m[1], circle.radius_m];
                parts[part] += by;
                Circle { centre_m: [parts[0], parts[1]], radius_m: parts[2] }
            };
            let from_m = |by: f64| moved(by).linearised(&point).expect("not the centre").0;
            let difference = (from_m(1e-6) - from_m(-1e-6)) / 2e-6;
            assert!((row[part] - difference).abs() < 1e-8, "{part}");
        }
    }

    #[test]
    fn points_that_tell_no_circle_have_none() {
        assert!(Circle::fit(&[]).is_none());
        assert!(Circle::fit(&[[1.0, 2.0]; 5]).is_none());
        let line: Vec<[f64; 2]> = (0..20).map(|x| [f64::from(x), 0.0]).collect();
        assert!(Circle::fit(&line).is_none());
    }
}
