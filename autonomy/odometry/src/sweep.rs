//! One LiDAR sweep: the points in range, kept until the other sensors cover it, and its motion correction (deskewing).

use crate::pose_table::PoseTable;
use geometry::{Base, Body, Isometry, Lidar, Transform, Vector3};
use points::filter;
use vocab::{Aabb, Span, Stamp};

/// A scan as it comes from the sensor: parallel columns in the LiDAR frame, metres. An optional column is empty or of full length.
#[derive(Clone, Copy, Debug)]
pub struct ScanView<'a> {
    /// The instant of offset 0, usually the start of the sweep.
    pub stamp: Stamp,
    /// Positions.
    pub xyz: &'a [[f32; 3]],
    /// Return strengths, or empty.
    pub intensity: &'a [f32],
    /// Time of measurement of each point, nanoseconds after `stamp`, or empty.
    pub offset_ns: &'a [i32],
}

/// Parameters of the motion correction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SweepConfig {
    /// Number of time slices of a sweep, at most 65,536. The points of a slice share one correction. Half a slice is 50 µs of a 10 Hz sweep, in
    /// which a robot that turns at 1 rad/s moves a point at 20 m by 1 mm. Chosen: more gain nothing above the noise of a range.
    pub slices: u32,
}

impl Default for SweepConfig {
    fn default() -> Self {
        Self { slices: 1024 }
    }
}

/// A waiting scan, without the points out of range and on the robot itself.
#[derive(Clone, Debug, Default)]
pub struct Sweep {
    config: SweepConfig,
    /// The scan's own stamp.
    pub stamp: Stamp,
    /// When its first point was measured.
    pub start: Stamp,
    /// When its last point was measured.
    pub end: Stamp,
    /// Whether its points have times.
    pub has_times: bool,
    /// Points, LiDAR frame, metres.
    xyz: Vec<[f32; 3]>,
    /// Return strength of each point, or empty.
    intensity: Vec<f32>,
    /// Slice of each point, or empty.
    slice: Vec<u16>,
}

impl Sweep {
    /// Copies the points that are between two ranges (metres) and outside the `self_filter` (box in the base frame).
    /// `kept_indices` is working memory.
    pub fn from_scan(
        config: SweepConfig,
        scan: &ScanView<'_>,
        (min_range_m, max_range_m): (f32, f32),
        self_filter: Option<&Aabb>,
        base_from_lidar: &Transform<Base, Lidar>,
        kept_indices: &mut Vec<u32>,
    ) -> Self {
        let kept = kept_indices;
        kept.clear();
        filter::select_in_range(scan.xyz, min_range_m, max_range_m, kept);
        if let Some(aabb) = self_filter {
            let matrix = matrix_of(base_from_lidar.isometry());
            kept.retain(|&index| !filter::contains(aabb, &apply(&matrix, &scan.xyz[index as usize])));
        }
        let full = scan.xyz.len();
        let has_offsets = full > 0 && scan.offset_ns.len() == full;
        let (mut first, mut last) = (0, 0);
        if has_offsets {
            first = scan.offset_ns.iter().copied().min().unwrap_or(0);
            last = scan.offset_ns.iter().copied().max().unwrap_or(0);
        }
        // A sweep whose points all have the same time contains no information about motion.
        let has_times = has_offsets && last > first;
        let whole = (i64::from(last) - i64::from(first)).max(1);
        let last_slice = i64::from(config.slices) - 1;
        let slice_of = |offset: i32| ((i64::from(offset) - i64::from(first)) * last_slice / whole) as u16;
        Self {
            config,
            stamp: scan.stamp,
            start: scan.stamp + Span::from_nanos(i64::from(first)),
            end: scan.stamp + Span::from_nanos(i64::from(last)),
            has_times,
            xyz: kept.iter().map(|&index| scan.xyz[index as usize]).collect(),
            intensity: if scan.intensity.len() == full {
                kept.iter().map(|&index| scan.intensity[index as usize]).collect()
            } else {
                Vec::new()
            },
            slice: if has_times {
                kept.iter().map(|&index| slice_of(scan.offset_ns[index as usize])).collect()
            } else {
                Vec::new()
            },
        }
    }

    /// Part `index` of `parts` equal intervals of time, as a sweep of its own. Needs times of the points.
    pub fn part(&self, index: usize, parts: usize) -> Self {
        let slices = self.config.slices as usize;
        let size = slices / parts;
        let (first, end) = (index * size, if index + 1 == parts { slices } else { (index + 1) * size });
        let whole = (self.end - self.start).nanos();
        let at = |slice: usize| self.start + Span::from_nanos(whole * slice as i64 / (slices as i64 - 1));
        let (config, start) = (self.config, at(first));
        let mut part = Self { config, stamp: start, start, end: at(end).min(self.end), ..Self::default() };
        for (point, &slice) in self.xyz.iter().zip(&self.slice) {
            let slice = usize::from(slice);
            if (first..end).contains(&slice) {
                part.xyz.push(*point);
                part.slice.push(((slice - first) * slices / (end - first)) as u16);
            }
        }
        part.has_times = self.has_times;
        part
    }

    /// Number of points kept.
    #[cfg(test)]
    pub fn len(&self) -> usize {
        self.xyz.len()
    }

    /// Moves the return strengths out.
    pub fn take_intensity(&mut self) -> Vec<f32> {
        std::mem::take(&mut self.intensity)
    }

    /// Moves every point to the base frame at the end of the sweep (docs/maths/odometry.md, equation 22). `table` holds the poses of
    /// the body during the sweep.
    pub fn deskew(
        &self,
        table: &PoseTable,
        base_from_lidar: &Transform<Base, Lidar>,
        body_from_base: &Transform<Body, Base>,
        xyz: &mut Vec<[f32; 3]>,
    ) {
        xyz.clear();
        if self.slice.is_empty() {
            let matrix = matrix_of(base_from_lidar.isometry());
            xyz.extend(self.xyz.iter().map(|point| apply(&matrix, point)));
            return;
        }
        let matrices = self.slice_matrices(table, base_from_lidar, body_from_base);
        xyz.extend(
            self.xyz
                .iter()
                .zip(&self.slice)
                .map(|(point, &slice)| apply(&matrices[usize::from(slice)], point)),
        );
    }

    /// For each slice, the pose of the LiDAR at its time in the base at the end of the sweep.
    fn slice_matrices(
        &self,
        table: &PoseTable,
        base_from_lidar: &Transform<Base, Lidar>,
        body_from_base: &Transform<Body, Base>,
    ) -> Vec<[[f32; 4]; 3]> {
        let whole = (self.end - self.start).nanos();
        let body_from_lidar: Transform<Body, Lidar> = *body_from_base * *base_from_lidar;
        let end_from_odom = table.at(self.end).map(|pose| (pose * body_from_base.isometry()).inverse());
        let mut cursor = 0;
        let slices = i64::from(self.config.slices);
        (0..slices)
            .map(|slice| {
                // The middle of the slice. The last slice holds the last instant only.
                let nanos = (whole * (2 * slice + 1) / (2 * (slices - 1))).min(whole);
                let at = table.at_from(self.start + Span::from_nanos(nanos), &mut cursor);
                match (&end_from_odom, at) {
                    (Some(end_from_odom), Some(odom_from_body)) => {
                        matrix_of(&(end_from_odom * odom_from_body * body_from_lidar.isometry()))
                    }
                    _ => matrix_of(base_from_lidar.isometry()),
                }
            })
            .collect()
    }
}

/// Corrects a scan for a known motion: moves every finite point to the body frame at the end of the sweep. `poses` are stamped poses
/// of the body in any fixed frame, ascending; between them the motion is uniform. Also returns the pose of the body at the end.
pub fn deskew(
    scan: &ScanView<'_>,
    poses: &[(Stamp, Isometry)],
    body_from_lidar: &Isometry,
) -> (Vec<[f32; 3]>, Isometry) {
    let mut table = PoseTable::default();
    for (stamp, pose) in poses {
        table.push(*stamp, *pose);
    }
    let base_from_lidar = Transform::new(*body_from_lidar);
    let (config, range_m) = (SweepConfig::default(), (0.0, f32::INFINITY));
    let sweep = Sweep::from_scan(config, scan, range_m, None, &base_from_lidar, &mut Vec::new());
    let mut xyz = Vec::new();
    sweep.deskew(&table, &base_from_lidar, &Transform::identity(), &mut xyz);
    (xyz, table.at(sweep.end).unwrap_or_default())
}

/// A rigid transform as the rows of a 3x4 matrix.
pub(crate) fn matrix_of(iso: &Isometry) -> [[f32; 4]; 3] {
    let rotation = iso.rotation.to_rotation_matrix();
    let translation: &Vector3 = &iso.translation.vector;
    std::array::from_fn(|row| {
        std::array::from_fn(
            |column| {
                if column < 3 { rotation[(row, column)] as f32 } else { translation[row] as f32 }
            },
        )
    })
}

/// Transforms a point.
#[inline]
pub(crate) fn apply(matrix: &[[f32; 4]; 3], point: &[f32; 3]) -> [f32; 3] {
    std::array::from_fn(|row| {
        let m = &matrix[row];
        m[0] * point[0] + m[1] * point[1] + m[2] * point[2] + m[3]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::se3;

    /// A sensor that turns and moves uniformly measures one fixed point all the time. After the correction it is one point.
    #[test]
    fn a_fixed_point_seen_throughout_a_sweep_stays_one_point() {
        let base_from_lidar = Transform::<Base, Lidar>::new(Isometry::new(
            Vector3::new(0.2, 0.0, 0.4),
            Vector3::new(0.0, 0.1, 1.0),
        ));
        let body_from_base = Transform::<Body, Base>::new(Isometry::new(
            Vector3::new(-0.1, 0.05, 0.0),
            Vector3::new(3.0, 0.0, 0.2),
        ));
        let (start, end) = (
            Isometry::new(Vector3::new(1.0, 2.0, 0.5), Vector3::new(0.0, 0.0, 0.3)),
            Isometry::new(Vector3::new(1.1, 2.05, 0.52), Vector3::new(0.02, -0.03, 0.45)),
        );
        let mut table = PoseTable::default();
        let stamp = Stamp::from_nanos(1_000_000_000);
        table.push(stamp, start);
        table.push(stamp + Span::from_millis(100), end);
        let fixed = Vector3::new(8.0, -3.0, 1.0);
        let (mut xyz, mut offset_ns) = (Vec::new(), Vec::new());
        for index in 0..=2_000_i32 {
            offset_ns.push(index * 50_000);
            let odom_from_body = se3::interpolate(&start, &end, f64::from(index) / 2_000.0);
            let odom_from_lidar = odom_from_body * (body_from_base * base_from_lidar).isometry();
            let point = odom_from_lidar.inverse_transform_point(&fixed.into());
            xyz.push([point.x as f32, point.y as f32, point.z as f32]);
        }
        let view = ScanView { stamp, xyz: &xyz, intensity: &[], offset_ns: &offset_ns };
        let (config, range_m) = (SweepConfig::default(), (0.1, 100.0));
        let sweep = Sweep::from_scan(config, &view, range_m, None, &base_from_lidar, &mut Vec::new());
        let mut deskewed = Vec::new();
        sweep.deskew(&table, &base_from_lidar, &body_from_base, &mut deskewed);
        let expected = (end * body_from_base.isometry()).inverse_transform_point(&fixed.into());
        for point in &deskewed {
            let error =
                Vector3::new(f64::from(point[0]), f64::from(point[1]), f64::from(point[2])) - expected.coords;
            assert!(error.norm() < 2e-3, "{error}");
        }
    }

    #[test]
    fn the_robots_own_body_is_dropped() {
        let base_from_lidar = Transform::new(Isometry::translation(0.0, 0.0, 0.5));
        let robot = Aabb { min: [-0.4, -0.3, -0.5], max: [0.4, 0.3, 0.3] };
        let view = ScanView {
            stamp: Stamp::EPOCH,
            xyz: &[[0.3, 0.0, -0.4], [0.0, 0.0, 1.0], [5.0, 0.0, 0.0]],
            intensity: &[1.0, 2.0, 3.0],
            offset_ns: &[],
        };
        let (config, range_m) = (SweepConfig::default(), (0.1, 100.0));
        let mut sweep =
            Sweep::from_scan(config, &view, range_m, Some(&robot), &base_from_lidar, &mut Vec::new());
        assert_eq!((sweep.len(), sweep.has_times, sweep.take_intensity()), (2, false, vec![2.0, 3.0]));
    }
}
