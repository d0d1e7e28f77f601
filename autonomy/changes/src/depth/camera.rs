//! The rays of the pixels of a depth camera.

/// A pinhole camera without distortion. Source: Hartley and Zisserman, *Multiple View Geometry in Computer Vision*, 2004, section 6.1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Camera {
    /// Focal length along the rows and along the columns, pixels.
    pub(crate) focal_px: [f64; 2],
    /// Where the axis meets the image, pixels.
    pub(crate) centre_px: [f64; 2],
}

/// Sums for a straight line `y = a + b x` through points.
#[derive(Default)]
struct LineSums {
    count: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl LineSums {
    fn add(&mut self, x: f64, y: f64) {
        self.count += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
        self.yy += y * y;
    }

    /// `a`, `b` and the root mean square of what is left; `None` if all `x` are the same.
    fn line(&self) -> Option<[f64; 3]> {
        let [mean_x, mean_y] = [self.x / self.count, self.y / self.count];
        let spread = self.xx / self.count - mean_x * mean_x;
        if spread.is_nan() || spread < 1e-9 {
            return None;
        }
        let slope = (self.xy / self.count - mean_x * mean_y) / spread;
        let rest = self.yy / self.count - mean_y * mean_y - slope * slope * spread;
        Some([mean_y - slope * mean_x, slope, rest.max(0.0).sqrt()])
    }
}

impl Camera {
    /// The camera whose pixels see these points: column, row and point (metres, third axis forward). The second value is the root mean square distance of the points from the
    /// rays of their pixels, pixels. None if they do not say, such as points of one row.
    pub(crate) fn fit(points: impl Iterator<Item = (usize, usize, [f32; 3])>) -> Option<(Self, f64)> {
        let mut sums = [LineSums::default(), LineSums::default()];
        for (column, row, [x, y, z]) in points {
            let [x, y, z] = [x, y, z].map(f64::from);
            sums[0].add(x / z, column as f64);
            sums[1].add(y / z, row as f64);
        }
        let [[centre_x, focal_x, rest_x], [centre_y, focal_y, rest_y]] = [sums[0].line()?, sums[1].line()?];
        let camera = Self { focal_px: [focal_x, focal_y], centre_px: [centre_x, centre_y] };
        (focal_x > 0.0 && focal_y > 0.0).then_some((camera, rest_x.hypot(rest_y)))
    }

    /// Area that a pixel sees at a depth, across its ray, square metres.
    pub(crate) fn pixel_area_m2(&self, depth_m: f64) -> f64 {
        depth_m * depth_m / (self.focal_px[0] * self.focal_px[1])
    }

    /// Largest distance between where two cameras see the same direction, in an image of this size, pixels.
    pub(crate) fn distance_px(&self, other: &Self, size_px: [usize; 2]) -> f64 {
        let along = |axis: usize, at: f64| {
            let slope = (at - self.centre_px[axis]) / self.focal_px[axis];
            (other.centre_px[axis] + slope * other.focal_px[axis] - at).abs()
        };
        (0..2).flat_map(|axis| [along(axis, 0.0), along(axis, size_px[axis] as f64)]).fold(0.0, f64::max)
    }
}
