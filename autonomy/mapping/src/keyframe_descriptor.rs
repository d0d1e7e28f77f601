//! Descriptor of a keyframe for place recognition. It is stored with a saved map, so that it does not have to be computed again from the full
//! cloud wherever that map is used.

use crate::range_image::RangeImage;
use crate::scan_context::{ScanContext, level_from_base};
use crate::submap::KeyframeCloud;
use geometry::Rotation;
use points::Downsampler;
use std::sync::Arc;

/// Lateral offset of the two virtual views besides the one from the base, metres. Part of the stored format.
pub(crate) const VIEW_OFFSET_M: f32 = 1.5;
/// Origins of the views of which scan contexts are computed: metres ahead of the base and to its left.
pub const VIEW_ORIGINS: [[f32; 2]; 3] = [[0.0, 0.0], [0.0, VIEW_OFFSET_M], [0.0, -VIEW_OFFSET_M]];

/// Version of the stored descriptors. It is increased whenever their computation changes, so that older ones are computed again.
pub const KEYFRAME_DESCRIPTOR_VERSION: u32 = 1;

/// A keyframe's thinned cloud, its range image and the scan contexts of three views: some 40 kB, shared by clones.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyframeDescriptor {
    pub(crate) cloud: Arc<KeyframeCloud>,
    pub(crate) views: [Arc<ScanContext>; 3],
}

/// A [`KeyframeDescriptor`] as plain data. The two large lists are shared with it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyframeDescriptorParts {
    /// As [`KeyframeCloud::lattice`].
    pub points: Arc<[[i16; 3]]>,
    /// As [`crate::range_image::RangeImage::cells`].
    pub ranges: Arc<[u16]>,
    /// As [`ScanContext::images`], of each view.
    pub views: [[Vec<u8>; 2]; 3],
}

impl KeyframeDescriptor {
    /// Computes the descriptor of a motion-corrected cloud (base frame, metres) measured from `sensor` (base frame, metres). `rotation` is
    /// the attitude of the base in a frame whose z axis points up. Linear in the points; docs/maths/loops.md has the times.
    pub fn new(
        xyz: &[[f32; 3]],
        rotation: &Rotation,
        sensor: [f32; 3],
        downsampler: &mut Downsampler,
    ) -> Self {
        let level = level_from_base(rotation);
        let views = VIEW_ORIGINS.map(|origin| Arc::new(ScanContext::new(xyz, &level, origin)));
        Self { cloud: Arc::new(KeyframeCloud::new(xyz, sensor, downsampler)), views }
    }

    /// As [`Self::new`], with its own downsampler.
    pub fn of_cloud(xyz: &[[f32; 3]], rotation: &Rotation, sensor: [f32; 3]) -> Self {
        Self::new(xyz, rotation, sensor, &mut Downsampler::default())
    }

    /// As plain data.
    pub fn parts(&self) -> KeyframeDescriptorParts {
        KeyframeDescriptorParts {
            points: Arc::clone(self.cloud.lattice()),
            ranges: Arc::clone(self.cloud.view().cells()),
            views: std::array::from_fn(|view| self.views[view].images()),
        }
    }

    /// From plain data, measured from `sensor` (base frame, metres). `None` if a list does not have the right length.
    pub fn from_parts(parts: KeyframeDescriptorParts, sensor: [f32; 3]) -> Option<Self> {
        let cloud = KeyframeCloud::from_parts(parts.points, sensor, parts.ranges)?;
        let [a, b, c] = parts.views.map(|[heights, slices]| ScanContext::from_images(&heights, &slices));
        Some(Self { cloud: Arc::new(cloud), views: [a?, b?, c?].map(Arc::new) })
    }

    /// The scan contexts as seen from each of [`VIEW_ORIGINS`].
    pub fn views(&self) -> &[Arc<ScanContext>; 3] {
        &self.views
    }

    /// The thinned cloud, base frame, metres.
    pub fn points(&self) -> impl ExactSizeIterator<Item = [f32; 3]> {
        self.cloud.points()
    }

    /// Corners of the bounding box of the thinned cloud, base frame, metres. `None` if the cloud is empty.
    pub fn extent(&self) -> Option<[[f32; 3]; 2]> {
        let first = self.points().next()?;
        Some(self.points().fold([first; 2], |[least, most], point| {
            let each = |pick: fn(f32, f32) -> f32, of: [f32; 3]| {
                std::array::from_fn(|axis| pick(of[axis], point[axis]))
            };
            [each(f32::min, least), each(f32::max, most)]
        }))
    }

    /// The range image of the scan: what the sensor looked through.
    pub fn view(&self) -> &RangeImage {
        self.cloud.view()
    }

    /// Position of the LiDAR, base frame, metres.
    pub fn sensor(&self) -> [f32; 3] {
        self.cloud.view().sensor()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{SENSOR, at, furnished, scan};

    #[test]
    fn a_descriptor_is_restored_from_its_parts() {
        let xyz = scan(&furnished(), &at(1.0, 0.5, 0.4), 7);
        let descriptor =
            KeyframeDescriptor::new(&xyz, &Rotation::identity(), SENSOR, &mut Downsampler::default());
        assert_eq!(
            KeyframeDescriptor::from_parts(descriptor.parts(), descriptor.sensor()).as_ref(),
            Some(&descriptor)
        );
        let broken = |change: fn(&mut KeyframeDescriptorParts)| {
            let mut parts = descriptor.parts();
            change(&mut parts);
            KeyframeDescriptor::from_parts(parts, SENSOR)
        };
        assert_eq!(broken(|parts| parts.ranges = parts.ranges[..9].into()), None);
        assert_eq!(broken(|parts| parts.views[1][0].push(0)), None);
        assert_eq!(broken(|parts| parts.views[2][1].clear()), None);
    }
}
