//! The place, size and heading of an object.

use crate::BoxFitConfig;
use geometry::Vector3;
use std::f64::consts::FRAC_PI_2;

/// A box with a heading that stands upright.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UprightBox {
    /// Its middle, metres, map frame.
    pub centre_m: Vector3,
    /// Length, width and height, metres. The length is along the heading and at least the width.
    pub size_m: [f64; 3],
    /// Heading of its length, radians, from 0 to below pi.
    pub yaw_rad: f64,
}

impl UprightBox {
    /// The box round points, metres, map frame: the heading with most points near two of its sides. None without points. Source of the criterion: Zhang and others,
    /// *Efficient L-Shape Fitting for Vehicle Detection Using Laser Scanners*, 2017 ("closeness"). Linear in the points, of which [`BoxFitConfig::max_fit_points`] are used at most.
    pub fn around(points: &[[f32; 3]], config: &BoxFitConfig) -> Option<Self> {
        let step = points.len().div_ceil(config.max_fit_points).max(1);
        let points: Vec<Vector3> =
            points.iter().step_by(step).map(|point| Vector3::from(point.map(f64::from))).collect();
        let heading = |step: usize| step as f64 / config.headings as f64 * FRAC_PI_2;
        let level: [Vec<f64>; 2] = [0, 1].map(|axis| points.iter().map(|point| point[axis]).collect());
        let mut turned = level.clone();
        let scores: Vec<f64> = (0..config.headings)
            .map(|step| closeness(&level, heading(step), config.on_side_m, &mut turned))
            .collect();
        let best = (0..config.headings).max_by(|a, b| scores[*a].total_cmp(&scores[*b]).then(b.cmp(a)))?;
        let yaw_rad = heading(best);
        turn(&level, yaw_rad, &mut turned);
        let [x, y] = turned.map(|values| extent(values, config.trimmed_share));
        let z = extent(points.iter().map(|point| point.z).collect(), config.trimmed_height_share);
        let ([x, y], z) = ([x?, y?], z?);
        let (sine, cosine) = yaw_rad.sin_cos();
        let (middle_x, middle_y) = ((x[0] + x[1]) / 2.0, (y[0] + y[1]) / 2.0);
        let centre_m = Vector3::new(
            cosine * middle_x - sine * middle_y,
            sine * middle_x + cosine * middle_y,
            (z[0] + z[1]) / 2.0,
        );
        let (length, width, height) = (x[1] - x[0], y[1] - y[0], z[1] - z[0]);
        Some(if length >= width {
            Self { centre_m, size_m: [length, width, height], yaw_rad }
        } else {
            Self { centre_m, size_m: [width, length, height], yaw_rad: yaw_rad + FRAC_PI_2 }
        })
    }

    /// Height of its lower side, metres.
    pub fn bottom_m(&self) -> f64 {
        self.centre_m.z - self.size_m[2] / 2.0
    }

    /// The same box down to another height, metres.
    pub fn down_to(&self, bottom_m: f64) -> Self {
        let top_m = self.centre_m.z + self.size_m[2] / 2.0;
        let [length, width, _] = self.size_m;
        let centre_m = Vector3::new(self.centre_m.x, self.centre_m.y, (top_m + bottom_m) / 2.0);
        Self { centre_m, size_m: [length, width, top_m - bottom_m], ..*self }
    }

    /// The box, larger by a margin on all sides, metres.
    pub(crate) fn wider(&self, margin_m: f64) -> Self {
        Self { size_m: self.size_m.map(|side_m| side_m + 2.0 * margin_m), ..*self }
    }

    /// Where a ray from `start` along a unit `direction` enters the box and leaves it, metres along the ray; none if it misses.
    pub(crate) fn crossed_by(&self, start: &Vector3, direction: &Vector3) -> Option<[f64; 2]> {
        let (from, along) = (self.local(&(start - self.centre_m)), self.local(direction));
        let (mut enters_m, mut leaves_m) = (0.0_f64, f64::INFINITY);
        for axis in 0..3 {
            let half_m = self.size_m[axis] / 2.0;
            if along[axis].abs() < 1e-12 {
                if from[axis].abs() > half_m {
                    return None;
                }
                continue;
            }
            let a = (-half_m - from[axis]) / along[axis];
            let b = (half_m - from[axis]) / along[axis];
            enters_m = enters_m.max(a.min(b));
            leaves_m = leaves_m.min(a.max(b));
        }
        (enters_m < leaves_m).then_some([enters_m, leaves_m])
    }

    /// An offset in the frame of the box: along, across, up.
    fn local(&self, offset: &Vector3) -> [f64; 3] {
        in_heading(offset, self.yaw_rad.sin_cos())
    }

    /// Whether a place is inside, or outside by less than `margin_m` along each axis, metres.
    pub fn holds(&self, place: &Vector3, margin_m: f64) -> bool {
        self.holder(margin_m)(place)
    }

    /// [`Self::holds`] for many places: the sine and cosine of the heading are computed once.
    pub(crate) fn holder(&self, margin_m: f64) -> impl Fn(&Vector3) -> bool + use<> {
        let (centre_m, heading) = (self.centre_m, self.yaw_rad.sin_cos());
        let halves_m = self.size_m.map(|side_m| side_m / 2.0 + margin_m);
        move |place| {
            let local = in_heading(&(place - centre_m), heading);
            local.iter().zip(halves_m).all(|(at, half_m)| at.abs() <= half_m)
        }
    }
}

/// An offset along and across a heading, of which the sine and cosine are given, and up.
fn in_heading(offset: &Vector3, (sine, cosine): (f64, f64)) -> [f64; 3] {
    [cosine * offset.x + sine * offset.y, cosine * offset.y - sine * offset.x, offset.z]
}

/// Coordinates of points along and across a heading, from those along the axes.
pub(crate) fn turn([x, y]: &[Vec<f64>; 2], yaw_rad: f64, [along, across]: &mut [Vec<f64>; 2]) {
    let (sine, cosine) = yaw_rad.sin_cos();
    for (((along, across), x), y) in along.iter_mut().zip(across).zip(x).zip(y) {
        (*along, *across) = (cosine * x + sine * y, cosine * y - sine * x);
    }
}

/// Sum over points of the inverse of their distance from the nearest side of the box with a heading. `turned` has room for coordinates of as many points.
fn closeness(level: &[Vec<f64>; 2], yaw_rad: f64, on_side_m: f64, turned: &mut [Vec<f64>; 2]) -> f64 {
    turn(level, yaw_rad, turned);
    let [along, across] = turned.each_ref().map(|axis| axis.chunks(LANES));
    let [[left, right], [back, front]] = turned.each_ref().map(|axis| ends(axis));
    let mut sums = [0.0; LANES];
    for (along, across) in along.zip(across) {
        for (sum, (x, y)) in sums.iter_mut().zip(along.iter().zip(across)) {
            let nearest_m = least(least(x - left, right - x), least(y - back, front - y));
            *sum += 1.0 / if nearest_m > on_side_m { nearest_m } else { on_side_m };
        }
    }
    sums.iter().sum()
}

/// Values that are added and compared together: the processor does several at once.
const LANES: usize = 4;

fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Lowest and highest of finite values.
fn ends(values: &[f64]) -> [f64; 2] {
    let (mut low, mut high) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
    for values in values.chunks(LANES) {
        for (lane, at) in values.iter().enumerate() {
            (low[lane], high[lane]) = (least(low[lane], *at), -least(-high[lane], -at));
        }
    }
    [low.into_iter().fold(f64::INFINITY, least), -high.into_iter().map(|at| -at).fold(f64::INFINITY, least)]
}

/// Lowest and highest value without the outermost ones.
pub(crate) fn extent(mut values: Vec<f64>, trimmed_share: f64) -> Option<[f64; 2]> {
    values.sort_by(f64::total_cmp);
    let trimmed = (values.len() as f64 * trimmed_share) as usize;
    Some([*values.get(trimmed)?, *values.get(values.len().checked_sub(1 + trimmed)?)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points on the two sides of a box that a sensor at the origin sees.
    fn two_sides(centre: [f64; 2], [length, width, height]: [f64; 3], yaw_rad: f64) -> Vec<[f32; 3]> {
        let (sine, cosine) = yaw_rad.sin_cos();
        let at = |x: f64, y: f64, z: f64| {
            [centre[0] + cosine * x - sine * y, centre[1] + sine * x + cosine * y, z].map(|at| at as f32)
        };
        let steps = || (0..=20).map(|step| f64::from(step) / 20.0 - 0.5);
        let heights = || (0..=10).map(|step| f64::from(step) / 10.0 * height);
        let long = steps().flat_map(|x| heights().map(move |z| at(x * length, -width / 2.0, z)));
        let short = steps().flat_map(|y| heights().map(move |z| at(-length / 2.0, y * width, z)));
        long.chain(short).collect()
    }

    #[test]
    fn a_box_of_which_two_sides_are_seen_has_its_size_and_heading() {
        for yaw_deg in [0.0, 17.0, 45.0, 80.0, 130.0] {
            let yaw_rad = f64::to_radians(yaw_deg);
            let found = UprightBox::around(
                &two_sides([3.0, -2.0], [1.0, 0.5, 0.7], yaw_rad),
                &BoxFitConfig::default(),
            )
            .expect("points");
            let expected = [1.0, 0.5, 0.7];
            assert!(found.size_m.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.03), "{found:?}");
            assert!((found.centre_m - Vector3::new(3.0, -2.0, 0.35)).norm() < 0.03, "{found:?}");
            assert!((found.yaw_rad - yaw_rad).abs() < 0.03, "{found:?} {yaw_deg}");
            assert!(found.holds(&Vector3::new(3.0, -2.0, 0.1), 0.0));
            assert!(!found.holds(&Vector3::new(3.0, -2.0, 0.8), 0.05));
            assert!((found.down_to(-0.1).size_m[2] - 0.8).abs() < 0.03);
        }
        assert_eq!(UprightBox::around(&[], &BoxFitConfig::default()), None);
    }
}
