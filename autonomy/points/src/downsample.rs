//! Voxel grid downsampling: one averaged point for each occupied voxel.

use crate::hash::{CellKey, CellTable};

/// Number of points whose voxels are looked up together.
const LOOKUP_BLOCK: usize = 16;

/// The average of the points in one voxel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Centroid {
    /// Mean position, metres, in the frame of the input.
    pub xyz: [f32; 3],
    /// Mean of the attribute that was given with each point (intensity, time), in its unit.
    pub attribute: f32,
    /// Number of points averaged.
    pub count: u32,
}

/// Averages points by voxel. Reuses its memory from call to call.
#[derive(Clone, Debug, Default)]
pub struct Downsampler {
    table: CellTable,
    voxels: Vec<Accumulator>,
}

/// Sums of one voxel. Positions are relative to its first point, so that `f32` stays precise far from the origin.
#[derive(Clone, Copy, Debug)]
struct Accumulator {
    first: [f32; 3],
    sum: [f32; 3],
    attribute_sum: f32,
    count: u32,
}

impl Downsampler {
    /// Appends to `out` one centroid for each occupied voxel of edge `voxel_m` (metres), in the order in which the voxels first
    /// occur in `xyz`. `attributes` holds one value for each point to be averaged as well, or is empty.
    pub fn downsample(
        &mut self,
        xyz: &[[f32; 3]],
        attributes: &[f32],
        voxel_m: f32,
        out: &mut Vec<Centroid>,
    ) {
        self.table.clear();
        self.voxels.clear();
        let voxels_per_metre = 1.0 / voxel_m;
        for (block, points) in xyz.chunks(LOOKUP_BLOCK).enumerate() {
            let mut keys = [CellKey::default(); LOOKUP_BLOCK];
            for (key, point) in keys.iter_mut().zip(points) {
                *key = CellKey::of_point(point, voxels_per_metre);
            }
            // The table does not fit into the nearest cache. Reads that do not wait for one another hide its delay.
            let found = self.table.peek(&keys);
            for (index, (point, &key)) in points.iter().zip(&keys).enumerate() {
                let voxel = match found[index] {
                    Some(voxel) => voxel,
                    None => {
                        let (voxel, is_new) = self.table.get_or_insert(key, self.voxels.len() as u32);
                        if is_new {
                            self.voxels.push(Accumulator::begin(point));
                        }
                        voxel
                    }
                };
                let attribute = attributes.get(block * LOOKUP_BLOCK + index).copied().unwrap_or(0.0);
                self.voxels[voxel as usize].add(point, attribute);
            }
        }
        out.extend(self.voxels.iter().map(Accumulator::centroid));
    }
}

impl Accumulator {
    fn begin(first: &[f32; 3]) -> Self {
        Self { first: *first, sum: [0.0; 3], attribute_sum: 0.0, count: 0 }
    }

    #[inline]
    fn add(&mut self, point: &[f32; 3], attribute: f32) {
        for axis in 0..3 {
            self.sum[axis] += point[axis] - self.first[axis];
        }
        self.attribute_sum += attribute;
        self.count += 1;
    }

    fn centroid(&self) -> Centroid {
        let scale = 1.0 / self.count as f32;
        Centroid {
            xyz: std::array::from_fn(|axis| self.first[axis] + self.sum[axis] * scale),
            attribute: self.attribute_sum * scale,
            count: self.count,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_cloud_has_no_centroids_and_a_downsampler_can_be_used_again() {
        let mut downsampler = Downsampler::default();
        let mut out = Vec::new();
        downsampler.downsample(&[], &[], 1.0, &mut out);
        assert!(out.is_empty());
        downsampler.downsample(&[[0.1; 3], [0.2; 3], [-0.1; 3]], &[], 1.0, &mut out);
        assert_eq!(out.iter().map(|c| c.count).collect::<Vec<_>>(), [2, 1]);
    }

    #[test]
    fn points_that_are_not_finite_do_no_harm() {
        let mut out = Vec::new();
        Downsampler::default().downsample(&[[f32::INFINITY; 3], [f32::NAN; 3], [0.0; 3]], &[], 1.0, &mut out);
        assert_eq!(out.iter().map(|c| c.count).sum::<u32>(), 3);
    }
}
