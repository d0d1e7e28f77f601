//! What a keyframe leaves behind for loop closure, and the small map made of it and its neighbours.

use crate::UncertainPose;
use crate::range_image::RangeImage;
use geometry::{Isometry, Matrix6};
use points::{Centroid, Downsampler, GaussianMap, GaussianMapConfig};
use std::sync::{Arc, OnceLock};

/// Points kept of a keyframe at most.
pub const POINTS: usize = 3_000;
/// Edge of the voxels in which a cloud is averaged at first, metres; grown by a quarter until few enough remain.
const VOXEL: f32 = 0.12;
/// Points are kept as multiples of this, metres: ±65.5 m in 16 bits, an error of a millimetre.
const STEP: f32 = 0.002;

/// A keyframe's own small cloud and what its sensor saw through: at most 18 kB and 11.5 kB.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyframeCloud {
    points: Arc<[[i16; 3]]>,
    view: RangeImage,
}

impl KeyframeCloud {
    /// Of a motion-corrected cloud (base frame, metres) measured from `sensor` (base frame). Linear in the points; those
    /// that are not finite or farther than 65 m are dropped.
    pub fn new(xyz: &[[f32; 3]], sensor: [f32; 3], downsampler: &mut Downsampler) -> Self {
        let limit = STEP * f32::from(i16::MAX);
        let mut kept: Vec<[f32; 3]> =
            xyz.iter().filter(|p| p.iter().all(|c| c.abs() < limit)).copied().collect();
        let (mut voxel, mut centroids) = (VOXEL, Vec::<Centroid>::new());
        loop {
            centroids.clear();
            downsampler.downsample(&kept, &[], voxel, &mut centroids);
            kept.clear();
            kept.extend(centroids.iter().map(|centroid| centroid.xyz));
            if kept.len() <= POINTS {
                break;
            }
            voxel *= 1.25;
        }
        let points = kept.iter().map(|p| p.map(|c| (c / STEP).round() as i16)).collect();
        Self { points, view: RangeImage::new(xyz, sensor) }
    }

    /// From what [`Self::lattice`] and [`RangeImage::cells`] gave; none if that is not of the right size.
    pub fn from_parts(points: Arc<[[i16; 3]]>, sensor: [f32; 3], cells: Arc<[u16]>) -> Option<Self> {
        let view = RangeImage::from_cells(cells, sensor)?;
        (points.len() <= POINTS).then_some(Self { points, view })
    }

    /// The points as they are kept, base frame, in steps of 2 mm.
    pub fn lattice(&self) -> &Arc<[[i16; 3]]> {
        &self.points
    }

    /// The points, base frame, metres.
    pub fn points(&self) -> impl ExactSizeIterator<Item = [f32; 3]> {
        self.points.iter().map(|point| point.map(|c| f32::from(c) * STEP))
    }

    /// What the sensor saw through.
    pub fn view(&self) -> &RangeImage {
        &self.view
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.points.len() * size_of::<[i16; 3]>() + 2 * 180 * 32
    }
}

/// A keyframe with its neighbours along the walk, in its own frame, ready to be registered against and with.
#[derive(Clone, Debug)]
pub struct Submap {
    /// The keyframe's own points.
    pub points: Vec<[f32; 3]>,
    /// Surfaces of all of them.
    pub map: GaussianMap,
    /// The keyframe and its neighbours in the keyframe's frame.
    pub members: Vec<(Isometry, Arc<KeyframeCloud>)>,
    /// Mean covariance of the members' poses: how far the submap may be bent in itself.
    pub slack: Matrix6,
}

impl Submap {
    /// Of `members`, the keyframe itself at `own`, each with its pose in the keyframe's frame. Linear in their points:
    /// about 10 ms for 20.
    pub fn new(members: Vec<(UncertainPose, Arc<KeyframeCloud>)>, own: usize) -> Self {
        let mut map = GaussianMap::new(GaussianMapConfig { min_points: 6, ..GaussianMapConfig::default() });
        let mut slack = Matrix6::zeros();
        for (UncertainPose { pose: anchor_from_member, covariance }, cloud) in &members {
            slack += covariance / members.len() as f64;
            let rotation = anchor_from_member.rotation.to_rotation_matrix();
            for point in cloud.points() {
                let moved = rotation * geometry::Vector3::from(point.map(f64::from))
                    + anchor_from_member.translation.vector;
                map.insert(&[moved.x, moved.y, moved.z]);
            }
        }
        let points = members.get(own).map(|(_, cloud)| cloud.points().collect()).unwrap_or_default();
        let members = members.into_iter().map(|(way, cloud)| (way.pose, cloud)).collect();
        Self { points, map, members, slack }
    }

    /// Bytes held, without the members, which others hold too.
    pub fn bytes(&self) -> usize {
        self.map.bytes() + self.points.len() * size_of::<[f32; 3]>()
    }
}

/// A submap that is made when it is first looked at: whoever proposes a pair only says of what, in microseconds, and the
/// one who verifies it pays, wherever that is. What comes out depends on the members alone.
#[derive(Clone, Debug)]
pub struct LazySubmap {
    members: Vec<(UncertainPose, Arc<KeyframeCloud>)>,
    own: usize,
    made: OnceLock<Submap>,
}

impl LazySubmap {
    /// As [`Submap::new`], later.
    pub fn new(members: Vec<(UncertainPose, Arc<KeyframeCloud>)>, own: usize) -> Self {
        Self { members, own, made: OnceLock::new() }
    }

    /// The submap; the first call makes it. Calls from several threads make it once.
    pub fn get(&self) -> &Submap {
        self.made.get_or_init(|| Submap::new(self.members.clone(), self.own))
    }

    /// Bytes held, without the members' clouds, which others hold too.
    pub fn bytes(&self) -> usize {
        self.made.get().map_or(0, Submap::bytes) + size_of_val(self.members.as_slice())
    }
}

impl From<Submap> for LazySubmap {
    /// One that is made already.
    fn from(submap: Submap) -> Self {
        Self { members: Vec::new(), own: 0, made: OnceLock::from(submap) }
    }
}

/// The last few submaps, so that neighbouring revisits do not make the same one again.
#[derive(Clone, Debug)]
pub struct SubmapCache {
    /// Last used last.
    held: Vec<(usize, Arc<LazySubmap>)>,
    room: usize,
}

impl SubmapCache {
    /// Holds at most `room` submaps.
    pub fn new(room: usize) -> Self {
        Self { held: Vec::new(), room }
    }

    /// The submap of a keyframe, described by `make` if it is not held.
    pub fn get(&mut self, keyframe: usize, make: impl FnOnce() -> LazySubmap) -> Arc<LazySubmap> {
        if let Some(index) = self.held.iter().position(|(held, _)| *held == keyframe) {
            let entry = self.held.remove(index);
            let submap = entry.1.clone();
            self.held.push(entry);
            return submap;
        }
        let submap = Arc::new(make());
        if self.held.len() >= self.room.max(1) {
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
    fn clouds_are_bounded_and_true_to_a_millimetre() {
        for (points, reach) in [(0, 1.0), (50, 40.0), (60_000, 30.0), (60_000, 500.0)] {
            let cloud = cloud(points, reach);
            assert!(cloud.points().len() <= POINTS && cloud.bytes() <= 29_600, "{}", cloud.points().len());
        }
        let one =
            KeyframeCloud::new(&[[1.2345, -50.0, 0.5], [f32::NAN; 3]], [0.0; 3], &mut Downsampler::default());
        let kept: Vec<[f32; 3]> = one.points().collect();
        assert_eq!(kept.len(), 1);
        assert!((kept[0][0] - 1.2345).abs() <= 0.0011 && (kept[0][1] + 50.0).abs() <= 0.0011, "{kept:?}");
    }

    #[test]
    fn the_cache_forgets_what_was_used_longest_ago() {
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
        assert!(cache.bytes() > unmade, "made when it was looked at");
    }
}
