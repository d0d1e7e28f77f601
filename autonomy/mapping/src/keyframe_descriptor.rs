//! What a keyframe leaves behind for being found again: kept with a saved map, so that it need not be made anew from the full cloud
//! wherever that map is used.

use crate::range_image::RangeImage;
use crate::scan_context::{ScanContext, level_from_base};
use crate::submap::KeyframeCloud;
use geometry::Rotation;
use points::Downsampler;
use std::sync::Arc;

/// Besides from the base, a place is looked up as it would look from so far to the left and right, metres.
pub(crate) const ASIDE: f32 = 1.5;
/// From where a place is looked at: metres ahead of and left of the base.
pub const VIEW_ORIGINS: [[f32; 2]; 3] = [[0.0, 0.0], [0.0, ASIDE], [0.0, -ASIDE]];

/// Which rules places are made by. It goes up whenever those change, so that what was kept of others is not used.
pub const KEYFRAME_DESCRIPTOR_VERSION: u32 = 1;

/// A keyframe's small cloud and its looks from the base and from both sides: some 40 kB, shared by clones.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyframeDescriptor {
    pub(crate) cloud: Arc<KeyframeCloud>,
    pub(crate) views: [Arc<ScanContext>; 3],
}

/// A [`KeyframeDescriptor`] as plain data; the two large lists are shared with it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyframeDescriptorParts {
    /// As [`KeyframeCloud::lattice`].
    pub points: Arc<[[i16; 3]]>,
    /// As [`crate::range_image::RangeImage::cells`].
    pub ranges: Arc<[u16]>,
    /// As [`ScanContext::pictures`], of each view.
    pub views: [[Vec<u8>; 2]; 3],
}

impl KeyframeDescriptor {
    /// Of a motion-corrected cloud (base frame, metres) seen from `sensor` (base frame), the base being turned like that in a frame
    /// whose z axis points up. Linear in the points: the cloud and three descriptors, as `docs/maths/loops.md` has them measured.
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

    /// As [`Self::new`], with a downsampler of its own.
    pub fn of_cloud(xyz: &[[f32; 3]], rotation: &Rotation, sensor: [f32; 3]) -> Self {
        Self::new(xyz, rotation, sensor, &mut Downsampler::default())
    }

    /// Its data.
    pub fn parts(&self) -> KeyframeDescriptorParts {
        KeyframeDescriptorParts {
            points: Arc::clone(self.cloud.lattice()),
            ranges: Arc::clone(self.cloud.view().cells()),
            views: std::array::from_fn(|view| self.views[view].pictures()),
        }
    }

    /// From its data, seen from `sensor`; none if they are not of the right size.
    pub fn from_parts(parts: KeyframeDescriptorParts, sensor: [f32; 3]) -> Option<Self> {
        let cloud = KeyframeCloud::from_parts(parts.points, sensor, parts.ranges)?;
        let [a, b, c] = parts.views.map(|[heights, slices]| ScanContext::from_pictures(&heights, &slices));
        Some(Self { cloud: Arc::new(cloud), views: [a?, b?, c?].map(Arc::new) })
    }

    /// How it looks from each of [`VIEW_ORIGINS`].
    pub fn views(&self) -> &[Arc<ScanContext>; 3] {
        &self.views
    }

    /// Its small cloud, base frame, metres.
    pub fn points(&self) -> impl ExactSizeIterator<Item = [f32; 3]> {
        self.cloud.points()
    }

    /// Corners of a box about its small cloud, base frame, metres; none if there is nothing in it.
    pub fn extent(&self) -> Option<[[f32; 3]; 2]> {
        let first = self.points().next()?;
        Some(self.points().fold([first; 2], |[least, most], point| {
            let each = |pick: fn(f32, f32) -> f32, of: [f32; 3]| {
                std::array::from_fn(|axis| pick(of[axis], point[axis]))
            };
            [each(f32::min, least), each(f32::max, most)]
        }))
    }

    /// What the sensor saw through.
    pub fn view(&self) -> &RangeImage {
        self.cloud.view()
    }

    /// Where the LiDAR was, base frame, metres.
    pub fn sensor(&self) -> [f32; 3] {
        self.cloud.view().sensor()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{SENSOR, at, furnished, scan};

    #[test]
    fn a_place_comes_back_from_its_parts() {
        let xyz = scan(&furnished(), &at(1.0, 0.5, 0.4), 7);
        let place = KeyframeDescriptor::new(&xyz, &Rotation::identity(), SENSOR, &mut Downsampler::default());
        assert_eq!(KeyframeDescriptor::from_parts(place.parts(), place.sensor()).as_ref(), Some(&place));
        let broken = |change: fn(&mut KeyframeDescriptorParts)| {
            let mut parts = place.parts();
            change(&mut parts);
            KeyframeDescriptor::from_parts(parts, SENSOR)
        };
        assert_eq!(broken(|parts| parts.ranges = parts.ranges[..9].into()), None);
        assert_eq!(broken(|parts| parts.views[1][0].push(0)), None);
        assert_eq!(broken(|parts| parts.views[2][1].clear()), None);
    }
}
