//! One LiDAR sweep: kept while it waits, thinned to what is in range, and freed of the motion during it.

use crate::pose_table::PoseTable;
use geometry::{Isometry, Vector3};
use points::filter;
use vocab::{Aabb, Span, Stamp};

/// A scan as it comes from the sensor: parallel columns in the LiDAR frame, metres. Optional columns are empty or of full
/// length.
#[derive(Clone, Copy, Debug)]
pub struct ScanView<'a> {
    /// The instant to which offset 0 refers; usually the start of the sweep.
    pub stamp: Stamp,
    /// Positions.
    pub xyz: &'a [[f32; 3]],
    /// Return strengths, or empty.
    pub intensity: &'a [f32],
    /// Nanoseconds after `stamp` at which each point was measured, or empty.
    pub offset_ns: &'a [i32],
}

/// Slices of a sweep whose points share one correction: half of one is 50 µs of a 10 Hz sweep, in which a robot that turns at
/// 1 rad/s moves a point at 20 m by 1 mm.
const SLICES: usize = 1024;

/// A scan that waits, without the points that nobody wants.
#[derive(Clone, Debug, Default)]
pub struct Sweep {
    /// Of the scan.
    pub stamp: Stamp,
    /// When its first point was measured.
    pub start: Stamp,
    /// When its last point was measured.
    pub end: Stamp,
    /// Whether its points have times.
    pub timed: bool,
    /// LiDAR frame, metres.
    xyz: Vec<[f32; 3]>,
    /// Or empty.
    intensity: Vec<f32>,
    /// Slice of each point, or empty.
    slice: Vec<u16>,
}

impl Sweep {
    /// Copies what is in range and outside the robot's body.
    pub fn take(
        scan: &ScanView<'_>,
        range: (f32, f32),
        hidden: Option<&Aabb>,
        base_from_lidar: &Isometry,
        kept: &mut Vec<u32>,
    ) -> Self {
        kept.clear();
        filter::select_in_range(scan.xyz, range.0, range.1, kept);
        if let Some(hidden) = hidden {
            let matrix = matrix_of(base_from_lidar);
            kept.retain(|&index| !filter::contains(hidden, &apply(&matrix, &scan.xyz[index as usize])));
        }
        let full = scan.xyz.len();
        let timed = full > 0 && scan.offset_ns.len() == full;
        let (mut first, mut last) = (0, 0);
        if timed {
            first = scan.offset_ns.iter().copied().min().unwrap_or(0);
            last = scan.offset_ns.iter().copied().max().unwrap_or(0);
        }
        let whole = (i64::from(last) - i64::from(first)).max(1);
        let slice_of =
            |offset: i32| ((i64::from(offset) - i64::from(first)) * (SLICES as i64 - 1) / whole) as u16;
        Self {
            stamp: scan.stamp,
            start: scan.stamp + Span::from_nanos(i64::from(first)),
            end: scan.stamp + Span::from_nanos(i64::from(last)),
            // All at one instant says nothing about motion.
            timed: timed && last > first,
            xyz: kept.iter().map(|&index| scan.xyz[index as usize]).collect(),
            intensity: if scan.intensity.len() == full {
                kept.iter().map(|&index| scan.intensity[index as usize]).collect()
            } else {
                Vec::new()
            },
            slice: if timed && last > first {
                kept.iter().map(|&index| slice_of(scan.offset_ns[index as usize])).collect()
            } else {
                Vec::new()
            },
        }
    }

    /// Part `index` of `parts` by time, a small sweep of its own. Needs times.
    pub fn part(&self, index: usize, parts: usize) -> Self {
        let size = SLICES / parts;
        let (first, end) = (index * size, if index + 1 == parts { SLICES } else { (index + 1) * size });
        let whole = (self.end - self.start).nanos();
        let at = |slice: usize| self.start + Span::from_nanos(whole * slice as i64 / (SLICES as i64 - 1));
        let mut part =
            Self { stamp: at(first), start: at(first), end: at(end).min(self.end), ..Self::default() };
        for (point, &slice) in self.xyz.iter().zip(&self.slice) {
            let slice = usize::from(slice);
            if (first..end).contains(&slice) {
                part.xyz.push(*point);
                part.slice.push(((slice - first) * SLICES / (end - first)) as u16);
            }
        }
        part.timed = self.timed;
        part
    }

    /// Number of points kept.
    #[cfg(test)]
    pub fn len(&self) -> usize {
        self.xyz.len()
    }

    /// Gives the return strengths away.
    pub fn take_intensity(&mut self) -> Vec<f32> {
        std::mem::take(&mut self.intensity)
    }

    /// Moves every point to the base frame at the end of the sweep.
    pub fn deskew(
        &self,
        table: &PoseTable,
        base_from_lidar: &Isometry,
        body_from_base: &Isometry,
        xyz: &mut Vec<[f32; 3]>,
    ) {
        xyz.clear();
        if self.slice.is_empty() {
            let matrix = matrix_of(base_from_lidar);
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

    /// For each slice, base at the end from LiDAR at that time.
    fn slice_matrices(
        &self,
        table: &PoseTable,
        base_from_lidar: &Isometry,
        body_from_base: &Isometry,
    ) -> Vec<[[f32; 4]; 3]> {
        let whole = (self.end - self.start).nanos();
        let body_from_lidar = body_from_base * base_from_lidar;
        let end_from_odom = table.at(self.end).map(|pose| (pose * body_from_base).inverse());
        let mut cursor = 0;
        (0..SLICES as i64)
            .map(|slice| {
                // The middle of the slice; the last one holds the last instant only.
                let nanos = (whole * (2 * slice + 1) / (2 * (SLICES as i64 - 1))).min(whole);
                let at = table.at_from(self.start + Span::from_nanos(nanos), &mut cursor);
                match (&end_from_odom, at) {
                    (Some(end_from_odom), Some(odom_from_body)) => {
                        matrix_of(&(end_from_odom * odom_from_body * body_from_lidar))
                    }
                    _ => matrix_of(base_from_lidar),
                }
            })
            .collect()
    }
}

/// Takes known motion out of a scan: moves every finite point to the body frame at the end of the sweep. `poses` are the
/// body's, in any fixed frame, ascending; between them it moves uniformly. Also returns the body's pose at the end.
pub fn deskew(
    scan: &ScanView<'_>,
    poses: &[(Stamp, Isometry)],
    body_from_lidar: &Isometry,
) -> (Vec<[f32; 3]>, Isometry) {
    let mut table = PoseTable::default();
    for (stamp, pose) in poses {
        table.push(*stamp, *pose);
    }
    let sweep = Sweep::take(scan, (0.0, f32::INFINITY), None, body_from_lidar, &mut Vec::new());
    let mut xyz = Vec::new();
    sweep.deskew(&table, body_from_lidar, &Isometry::identity(), &mut xyz);
    (xyz, table.at(sweep.end).unwrap_or_default())
}

/// Rows of a 3x4 matrix, `f32`.
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

    /// A sensor that turns and moves uniformly sees one fixed point all the time: corrected, it is one point.
    #[test]
    fn a_fixed_point_seen_throughout_a_sweep_stays_one_point() {
        let base_from_lidar = Isometry::new(Vector3::new(0.2, 0.0, 0.4), Vector3::new(0.0, 0.1, 1.0));
        let body_from_base = Isometry::new(Vector3::new(-0.1, 0.05, 0.0), Vector3::new(3.0, 0.0, 0.2));
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
            let odom_from_lidar = odom_from_body * body_from_base * base_from_lidar;
            let point = odom_from_lidar.inverse_transform_point(&fixed.into());
            xyz.push([point.x as f32, point.y as f32, point.z as f32]);
        }
        let view = ScanView { stamp, xyz: &xyz, intensity: &[], offset_ns: &offset_ns };
        let sweep = Sweep::take(&view, (0.1, 100.0), None, &base_from_lidar, &mut Vec::new());
        let mut deskewed = Vec::new();
        sweep.deskew(&table, &base_from_lidar, &body_from_base, &mut deskewed);
        let expected = (end * body_from_base).inverse_transform_point(&fixed.into());
        for point in &deskewed {
            let error =
                Vector3::new(f64::from(point[0]), f64::from(point[1]), f64::from(point[2])) - expected.coords;
            assert!(error.norm() < 2e-3, "{error}");
        }
    }

    #[test]
    fn the_robots_own_body_is_dropped() {
        let base_from_lidar = Isometry::translation(0.0, 0.0, 0.5);
        let hidden = Aabb { min: [-0.4, -0.3, -0.5], max: [0.4, 0.3, 0.3] };
        let view = ScanView {
            stamp: Stamp::EPOCH,
            xyz: &[[0.3, 0.0, -0.4], [0.0, 0.0, 1.0], [5.0, 0.0, 0.0]],
            intensity: &[1.0, 2.0, 3.0],
            offset_ns: &[],
        };
        let mut sweep = Sweep::take(&view, (0.1, 100.0), Some(&hidden), &base_from_lidar, &mut Vec::new());
        assert_eq!((sweep.len(), sweep.timed, sweep.take_intensity()), (2, false, vec![2.0, 3.0]));
    }
}
