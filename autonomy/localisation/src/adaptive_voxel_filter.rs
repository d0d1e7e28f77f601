//! Scans as they are tracked: some thousands of points, spread evenly.

use points::{Centroid, Downsampler};

/// Points wanted.
const WANTED: usize = 3_000;
/// Edge of the voxels at first, and its bounds, metres.
const FIRST: f32 = 0.3;
const BOUNDS: (f32, f32) = (0.05, 2.0);
/// How far the edge follows the number of points: halving it quadruples them, less where they are sparse.
const FOLLOWS: f32 = 0.3;

/// Thins scan after scan to about as many points.
#[derive(Debug)]
pub struct AdaptiveVoxelFilter {
    downsampler: Downsampler,
    centroids: Vec<Centroid>,
    voxel: f32,
}

impl Default for AdaptiveVoxelFilter {
    fn default() -> Self {
        Self { downsampler: Downsampler::default(), centroids: Vec::new(), voxel: FIRST }
    }
}

impl AdaptiveVoxelFilter {
    /// Means of voxels, which are larger or smaller the next time. Linear in the points.
    pub fn thin(&mut self, xyz: &[[f32; 3]]) -> Vec<[f32; 3]> {
        self.centroids.clear();
        self.downsampler.downsample(xyz, &[], self.voxel, &mut self.centroids);
        let thinned: Vec<[f32; 3]> = self.centroids.iter().map(|centroid| centroid.xyz).collect();
        let ratio = thinned.len().max(1) as f32 / WANTED as f32;
        self.voxel = (self.voxel * ratio.powf(FOLLOWS)).clamp(BOUNDS.0, BOUNDS.1);
        thinned
    }
}
