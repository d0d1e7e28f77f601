//! Thinning a cloud: one averaged point for each voxel.

use crate::hash::{CellKey, CellTable};

/// The average of the points that fell into one voxel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Centroid {
    /// Mean position, metres, in the frame of the input.
    pub xyz: [f32; 3],
    /// Mean of the attributes given with the points.
    pub attribute: f32,
    /// How many points were averaged.
    pub count: u32,
}

/// Averages points by voxel; keeps its memory from call to call.
#[derive(Clone, Debug, Default)]
pub struct Downsampler {
    table: CellTable,
    cells: Vec<Accumulator>,
}

/// Sums are kept relative to the first point, so that `f32` loses nothing far from the origin.
#[derive(Clone, Copy, Debug)]
struct Accumulator {
    first: [f32; 3],
    sum: [f32; 3],
    attribute_sum: f32,
    count: u32,
}

impl Downsampler {
    /// Appends to `out` one centroid for each voxel of edge `voxel` (metres) that holds a point, in the order in which
    /// the voxels were first met. `attributes` is a value for each point to average as well, or empty.
    pub fn downsample(&mut self, xyz: &[[f32; 3]], attributes: &[f32], voxel: f32, out: &mut Vec<Centroid>) {
        self.table.clear();
        self.cells.clear();
        let per_metre = 1.0 / voxel;
        let mut last = (CellKey::new([i64::MAX; 3]), 0_usize);
        for (index, &point) in xyz.iter().enumerate() {
            let key = CellKey::new(point.map(|c| i64::from(floor(c * per_metre))));
            // Neighbours in the sweep often share a voxel.
            let cell = if key == last.0 {
                last.1
            } else {
                let (cell, fresh) = self.table.get_or_insert(key, self.cells.len() as u32);
                if fresh {
                    self.cells.push(Accumulator {
                        first: point,
                        sum: [0.0; 3],
                        attribute_sum: 0.0,
                        count: 0,
                    });
                }
                cell as usize
            };
            last = (key, cell);
            let accumulator = &mut self.cells[cell];
            for axis in 0..3 {
                accumulator.sum[axis] += point[axis] - accumulator.first[axis];
            }
            accumulator.attribute_sum += attributes.get(index).copied().unwrap_or(0.0);
            accumulator.count += 1;
        }
        out.extend(self.cells.iter().map(Accumulator::centroid));
    }
}

impl Accumulator {
    fn centroid(&self) -> Centroid {
        let scale = 1.0 / self.count as f32;
        Centroid {
            xyz: std::array::from_fn(|axis| self.first[axis] + self.sum[axis] * scale),
            attribute: self.attribute_sum * scale,
            count: self.count,
        }
    }
}

/// `floor` to an integer without a library call.
#[inline]
fn floor(value: f32) -> i32 {
    let truncated = value as i32;
    truncated - i32::from((truncated as f32) > value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::RngTree;
    use std::collections::BTreeMap;

    #[test]
    fn agrees_with_sums_in_an_ordered_map() {
        let mut rng = RngTree::new(5).child("downsample").rng();
        let points: Vec<[f32; 3]> =
            (0..20_000).map(|_| std::array::from_fn(|_| (rng.normal() * 8.0) as f32)).collect();
        let attributes: Vec<f32> = (0..points.len()).map(|i| i as f32 * 1e-5).collect();
        let voxel = 0.4_f32;
        let mut out = Vec::new();
        Downsampler::default().downsample(&points, &attributes, voxel, &mut out);

        let mut twin: BTreeMap<[i64; 3], (Vec<usize>, f64)> = BTreeMap::new();
        for (i, p) in points.iter().enumerate() {
            let cell = p.map(|c| (c * (1.0 / voxel)).floor() as i64);
            let entry = twin.entry(cell).or_default();
            entry.0.push(i);
            entry.1 += f64::from(p[0]);
        }
        assert_eq!(out.len(), twin.len());
        for centroid in &out {
            let cell = centroid.xyz.map(|c| (c / voxel).floor() as i64);
            // A mean can round onto the border of its voxel; such cases are not looked up.
            let Some((members, sum)) = twin.get(&cell) else { continue };
            assert_eq!(members.len(), centroid.count as usize);
            assert!((sum / members.len() as f64 - f64::from(centroid.xyz[0])).abs() < 1e-5);
            let attribute =
                members.iter().map(|&i| f64::from(attributes[i])).sum::<f64>() / members.len() as f64;
            assert!((attribute - f64::from(centroid.attribute)).abs() < 1e-5);
        }
    }

    #[test]
    fn an_empty_cloud_has_no_centroids_and_memory_is_reused() {
        let mut downsampler = Downsampler::default();
        let mut out = Vec::new();
        downsampler.downsample(&[], &[], 1.0, &mut out);
        assert!(out.is_empty());
        downsampler.downsample(&[[0.1; 3], [0.2; 3], [-0.1; 3]], &[], 1.0, &mut out);
        assert_eq!(out.iter().map(|c| c.count).collect::<Vec<_>>(), [2, 1]);
    }
}
