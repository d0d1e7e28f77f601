//! Downsampling of scans for the pose tracker, to about the same number of points on every site.

use points::{AdaptiveVoxelConfig, Centroid, Downsampler};

/// Parameters of [`AdaptiveVoxelFilter`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveVoxelFilterConfig {
    /// Points that a filtered scan should have. Chosen: three quarters of what odometry registers (4,000); the time of a scan is in proportion.
    pub target_points: usize,
    /// How the voxel size adapts to that number.
    pub voxel: AdaptiveVoxelConfig,
}

impl Default for AdaptiveVoxelFilterConfig {
    fn default() -> Self {
        Self { target_points: 3_000, voxel: AdaptiveVoxelConfig::default() }
    }
}

/// A voxel filter that adapts its voxels from scan to scan (Cartographer's adaptive voxel filter, without its search within one scan).
#[derive(Debug)]
pub struct AdaptiveVoxelFilter {
    config: AdaptiveVoxelFilterConfig,
    downsampler: Downsampler,
    centroids: Vec<Centroid>,
    voxel_m: f32,
}

impl Default for AdaptiveVoxelFilter {
    fn default() -> Self {
        Self::new(AdaptiveVoxelFilterConfig::default())
    }
}

impl AdaptiveVoxelFilter {
    /// A filter that has seen no scan.
    pub fn new(config: AdaptiveVoxelFilterConfig) -> Self {
        let voxel_m = config.voxel.initial_m;
        Self { config, downsampler: Downsampler::default(), centroids: Vec::new(), voxel_m }
    }

    /// The mean of the points in each voxel, metres. Changes the size of the voxels for the next scan. Linear in the points.
    pub fn filter(&mut self, xyz: &[[f32; 3]]) -> Vec<[f32; 3]> {
        self.centroids.clear();
        self.downsampler.downsample(xyz, &[], self.voxel_m, &mut self.centroids);
        let filtered: Vec<[f32; 3]> = self.centroids.iter().map(|centroid| centroid.xyz).collect();
        let ratio = filtered.len().max(1) as f32 / self.config.target_points as f32;
        self.voxel_m = self.config.voxel.adapt(self.voxel_m, ratio);
        filtered
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::RngTree;

    #[test]
    fn the_number_of_points_approaches_the_target() {
        let mut rng = RngTree::new(1).child("floor").rng();
        let floor: Vec<[f32; 3]> = (0..60_000)
            .map(|_| [rng.range(-30.0, 30.0) as f32, rng.range(-30.0, 30.0) as f32, 0.0])
            .collect();
        let mut filter = AdaptiveVoxelFilter::default();
        let counts: Vec<usize> = (0..12).map(|_| filter.filter(&floor).len()).collect();
        assert!(counts[0] > 6_000 && counts[11].abs_diff(3_000) < 200, "{counts:?}");
    }

    #[test]
    fn the_voxels_stay_within_their_bounds() {
        let mut filter = AdaptiveVoxelFilter::default();
        for _ in 0..20 {
            assert_eq!(filter.filter(&[[1.0, 2.0, 3.0]]).len(), 1);
        }
        assert_eq!(filter.voxel_m, AdaptiveVoxelConfig::default().min_m);
    }
}
