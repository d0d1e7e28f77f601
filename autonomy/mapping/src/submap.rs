//! The thinned cloud of a keyframe, and the submap made of a keyframe and its neighbours.

use crate::UncertainPose;
use crate::range_image::RangeImage;
use geometry::{Isometry, Matrix6, Vector3};
use nalgebra::Point3;
use points::{Centroid, Downsampler, GaussianMap, GaussianMapConfig};
use std::sync::{Arc, OnceLock};

/// Greatest number of points kept of a keyframe. Part of the stored format.
pub const MAX_POINTS: usize = 3_000;
/// Resolution of the stored points, metres: ±65.5 m in 16 bits, an error of at most a millimetre. Part of the stored format.
const RESOLUTION_M: f32 = 0.002;

/// Parameters of the thinning of a keyframe's cloud.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinningConfig {
    /// Edge of the voxels in which a cloud is averaged first, metres. Chosen: fine enough for the surfaces that a comparison needs; larger clouds are thinned further by
    /// [`Self::voxel_growth`].
    pub voxel_m: f32,
    /// Factor, greater than 1, by which the voxels grow until at most [`MAX_POINTS`] points remain. Chosen: each step leaves about two thirds of the points of a surface;
    /// a larger factor leaves fewer than needed.
    pub voxel_growth: f32,
}

impl Default for ThinningConfig {
    fn default() -> Self {
        Self { voxel_m: 0.12, voxel_growth: 1.25 }
    }
}

/// Parameters of a submap: a keyframe with its neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SubmapConfig {
    /// Neighbours are taken within this distance of the keyframe, metres. Along the walk for loops of a session, straight for finished maps. Chosen: far enough for two
    /// walks through a room to overlap, and near enough for odometry to keep its shape.
    pub radius_m: f64,
    /// Greatest number of keyframes in a submap, its own included. Chosen: the keyframe and eight before and after it, one a metre ([`Self::radius_m`]).
    pub max_keyframes: usize,
    /// If the walk alone gives fewer keyframes than this, the nearest ones over loops are added. Chosen: the keyframe and those of one side.
    pub min_keyframes: usize,
    /// Keyframes over loops are added only if their pose is known to this standard deviation, metres. Chosen: less than the gate of the fine registration, so that its
    /// surfaces are not doubled.
    pub max_std_m: f64,
    /// Greatest height difference of neighbours in a finished map, metres. Chosen: half a storey.
    pub max_height_m: f64,
}

impl Default for SubmapConfig {
    fn default() -> Self {
        Self { radius_m: 8.0, max_keyframes: 17, min_keyframes: 9, max_std_m: 0.1, max_height_m: 1.5 }
    }
}

/// A keyframe's thinned cloud and its range image: at most 18 kB and 11.5 kB.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyframeCloud {
    points: Arc<[[i16; 3]]>,
    view: RangeImage,
}

impl KeyframeCloud {
    /// Thins a motion-corrected cloud (base frame, metres) measured from `sensor` (base frame, metres), with the default parameters. Linear in
    /// the points. Points that are not finite or farther away than 65 m are dropped.
    pub fn new(xyz: &[[f32; 3]], sensor: [f32; 3], downsampler: &mut Downsampler) -> Self {
        let config = ThinningConfig::default();
        let limit = RESOLUTION_M * f32::from(i16::MAX);
        let mut kept: Vec<[f32; 3]> =
            xyz.iter().filter(|p| p.iter().all(|c| c.abs() < limit)).copied().collect();
        let (mut voxel, mut centroids) = (config.voxel_m, Vec::<Centroid>::new());
        loop {
            centroids.clear();
            downsampler.downsample(&kept, &[], voxel, &mut centroids);
            kept.clear();
            kept.extend(centroids.iter().map(|centroid| centroid.xyz));
            if kept.len() <= MAX_POINTS {
                break;
            }
            voxel *= config.voxel_growth;
        }
        let points = kept.iter().map(|p| p.map(|c| (c / RESOLUTION_M).round() as i16)).collect();
        Self { points, view: RangeImage::new(xyz, sensor) }
    }

    /// Restores a cloud from [`Self::lattice`] and [`RangeImage::cells`]. `None` if they do not have the right size.
    pub fn from_parts(points: Arc<[[i16; 3]]>, sensor: [f32; 3], cells: Arc<[u16]>) -> Option<Self> {
        let view = RangeImage::from_cells(cells, sensor)?;
        (points.len() <= MAX_POINTS).then_some(Self { points, view })
    }

    /// The points as stored: base frame, in steps of 2 mm.
    pub fn lattice(&self) -> &Arc<[[i16; 3]]> {
        &self.points
    }

    /// The points, base frame, metres.
    pub fn points(&self) -> impl ExactSizeIterator<Item = [f32; 3]> {
        self.points.iter().map(|point| point.map(|c| f32::from(c) * RESOLUTION_M))
    }

    /// One of the points, base frame, metres.
    pub fn point(&self, index: usize) -> [f32; 3] {
        self.points[index].map(|c| f32::from(c) * RESOLUTION_M)
    }

    /// The range image of the scan: what the sensor looked through.
    pub fn view(&self) -> &RangeImage {
        &self.view
    }

    /// The position of the LiDAR, base frame, metres.
    pub fn viewpoint(&self) -> Vector3 {
        Vector3::from(self.view.sensor().map(f64::from))
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.points.len() * size_of::<[i16; 3]>() + RangeImage::BYTES
    }
}

/// A keyframe with its neighbours, in the keyframe's frame, ready for registration.
#[derive(Clone, Debug)]
pub struct Submap {
    /// The keyframe's own points.
    pub points: Vec<[f32; 3]>,
    /// The position of the LiDAR from which the keyframe saw them.
    pub viewpoint: Vector3,
    /// Surfaces of all members. They have sides: a plane faces the position from which it was seen.
    pub map: GaussianMap,
    /// The keyframe and its neighbours, with their poses in the keyframe.
    pub members: Vec<(Isometry, Arc<KeyframeCloud>)>,
    /// Mean covariance of the members' poses: how far the submap may be deformed.
    pub mean_covariance: Matrix6,
}

impl Submap {
    /// Builds the submap of `members` with their poses in the keyframe, which is the member at the index `own`. Linear in their points:
    /// about 10 ms for 20 members.
    pub fn new(members: Vec<(UncertainPose, Arc<KeyframeCloud>)>, own: usize) -> Self {
        let mut map = GaussianMap::new(GaussianMapConfig::for_thinned_clouds());
        let mut mean_covariance = Matrix6::zeros();
        for (UncertainPose { pose: anchor_from_member, covariance }, cloud) in &members {
            mean_covariance += covariance / members.len() as f64;
            let rotation = anchor_from_member.rotation.to_rotation_matrix();
            let viewpoint = (anchor_from_member * Point3::from(cloud.viewpoint())).coords;
            for point in cloud.points() {
                let moved =
                    rotation * Vector3::from(point.map(f64::from)) + anchor_from_member.translation.vector;
                map.insert_from_viewpoint(moved.as_ref(), viewpoint.as_ref());
            }
        }
        let (points, viewpoint) = members
            .get(own)
            .map_or_else(Default::default, |(_, cloud)| (cloud.points().collect(), cloud.viewpoint()));
        let members = members.into_iter().map(|(relative, cloud)| (relative.pose, cloud)).collect();
        Self { points, viewpoint, map, members, mean_covariance }
    }

    /// Bytes held, without the members, which are shared.
    pub fn bytes(&self) -> usize {
        self.map.bytes() + self.points.len() * size_of::<[f32; 3]>()
    }
}

/// A submap that is built on first use. Proposing a pair takes microseconds; the job that verifies it builds the submap. The result depends
/// on the members alone.
#[derive(Clone, Debug)]
pub struct LazySubmap {
    members: Vec<(UncertainPose, Arc<KeyframeCloud>)>,
    own: usize,
    made: OnceLock<Submap>,
}

impl LazySubmap {
    /// As [`Submap::new`], built on first use.
    pub fn new(members: Vec<(UncertainPose, Arc<KeyframeCloud>)>, own: usize) -> Self {
        Self { members, own, made: OnceLock::new() }
    }

    /// The submap. The first call builds it, also with several threads.
    pub fn get(&self) -> &Submap {
        self.made.get_or_init(|| Submap::new(self.members.clone(), self.own))
    }

    /// Bytes held, without the members' clouds, which are shared.
    pub fn bytes(&self) -> usize {
        self.made.get().map_or(0, Submap::bytes) + size_of_val(self.members.as_slice())
    }
}

impl From<Submap> for LazySubmap {
    /// A submap that is built already.
    fn from(submap: Submap) -> Self {
        Self { members: Vec::new(), own: 0, made: OnceLock::from(submap) }
    }
}

/// Cache of the submaps used last, so that neighbouring revisits do not build the same one again.
#[derive(Clone, Debug)]
pub struct SubmapCache {
    /// In the order of use, the last one used last.
    held: Vec<(usize, Arc<LazySubmap>)>,
    capacity: usize,
}

impl SubmapCache {
    /// Holds at most `capacity` submaps.
    pub fn new(capacity: usize) -> Self {
        Self { held: Vec::new(), capacity }
    }

    /// The submap of a keyframe; `make` describes it if it is not in the cache.
    pub fn get(&mut self, keyframe: usize, make: impl FnOnce() -> LazySubmap) -> Arc<LazySubmap> {
        if let Some(index) = self.held.iter().position(|(held, _)| *held == keyframe) {
            let entry = self.held.remove(index);
            let submap = entry.1.clone();
            self.held.push(entry);
            return submap;
        }
        let submap = Arc::new(make());
        if self.held.len() >= self.capacity.max(1) {
            self.held.remove(0);
        }
        self.held.push((keyframe, submap.clone()));
        submap
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.held.iter().map(|(_, submap)| submap.bytes()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::RngTree;

    fn cloud(points: usize, reach: f64) -> KeyframeCloud {
        let mut rng = RngTree::new(1).child("cloud").rng();
        let xyz: Vec<[f32; 3]> =
            (0..points).map(|_| std::array::from_fn(|_| rng.range(-reach, reach) as f32)).collect();
        KeyframeCloud::new(&xyz, [0.0, 0.0, 0.3], &mut Downsampler::default())
    }

    #[test]
    fn clouds_are_bounded_and_exact_to_a_millimetre() {
        for (points, reach) in [(0, 1.0), (50, 40.0), (60_000, 30.0), (60_000, 500.0)] {
            let cloud = cloud(points, reach);
            assert!(
                cloud.points().len() <= MAX_POINTS && cloud.bytes() <= 29_600,
                "{}",
                cloud.points().len()
            );
        }
        let one =
            KeyframeCloud::new(&[[1.2345, -50.0, 0.5], [f32::NAN; 3]], [0.0; 3], &mut Downsampler::default());
        let kept: Vec<[f32; 3]> = one.points().collect();
        assert_eq!(kept.len(), 1);
        assert!((kept[0][0] - 1.2345).abs() <= 0.0011 && (kept[0][1] + 50.0).abs() <= 0.0011, "{kept:?}");
    }

    #[test]
    fn the_cache_drops_the_least_recently_used_submap() {
        let mut cache = SubmapCache::new(2);
        let member = || (UncertainPose::identity(), Arc::new(cloud(100, 5.0)));
        let mut made = Vec::new();
        for keyframe in [1, 2, 1, 3, 1, 2] {
            cache.get(keyframe, || {
                made.push(keyframe);
                LazySubmap::new(vec![member()], 0)
            });
        }
        assert_eq!(made, [1, 2, 3, 2]);
        let unmade = cache.bytes();
        cache.get(2, || LazySubmap::new(Vec::new(), 0)).get();
        assert!(cache.bytes() > unmade, "built on first use");
    }
}
