//! A voxel size that adapts from scan to scan, so that downsampled scans have about the same number of points whatever the site.

/// Parameters of the adaptation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveVoxelConfig {
    /// Voxel size of the first scan, metres. Chosen as a round number: the next scans adapt it.
    pub initial_m: f32,
    /// Smallest voxel size, metres. Chosen: several times the noise of a LiDAR.
    pub min_m: f32,
    /// Largest voxel size, metres. Chosen: the edge of a root cube of the local map.
    pub max_m: f32,
    /// The size is multiplied by the ratio of found to wanted points, to this power. Halving the voxels of a dense surface quadruples its
    /// points, which would be 0.5; sparse scans give fewer, so that 0.5 would overshoot. Chosen: below that, at the price of some scans more.
    pub exponent: f32,
}

impl Default for AdaptiveVoxelConfig {
    fn default() -> Self {
        Self { initial_m: 0.3, min_m: 0.05, max_m: 2.0, exponent: 0.3 }
    }
}

impl AdaptiveVoxelConfig {
    /// The voxel size of the next scan after one that gave `ratio` times the wanted number of points with `voxel_m`.
    pub fn adapt(&self, voxel_m: f32, ratio: f32) -> f32 {
        (voxel_m * ratio.powf(self.exponent)).clamp(self.min_m, self.max_m)
    }
}
