//! Descriptors of a map's keyframes (`places.bin`), so that localisation need not compute them from all clouds at every start: 40 kB a keyframe instead of
//! 1 MB.
//!
//! ```text
//! "AIPLACES", version u32, count u32, then for each keyframe in the graph's order
//!   lidar 3 f32 | points n u32, 3n i16 | ranges n u32, n u16 | six pictures, each n u32, n u8
//! ```
//!
//! All numbers are little-endian. The file can be computed again from the clouds, so a file that is absent, broken or of another version is ignored.

use crate::map_clouds::keyframes_and_clouds;
use crate::{StoreError, files};
use geometry::isometry_from_pose;
use mapping::{KEYFRAME_DESCRIPTOR_VERSION, KeyframeDescriptor, KeyframeDescriptorParts};
use messages::PriorKeyframe;
use std::fs;
use std::io::{self, ErrorKind, Write};
use std::path::Path;
use vocab::Pose;

const NAME: &str = "places.bin";
const MAGIC: &[u8; 8] = b"AIPLACES";

/// Descriptors of the keyframes of the map in the folder `dir`, in the graph's order: `keyframes` of them, unless all clouds are missing. Cost: 20 us a keyframe, or
/// some 10 ms if they have to be computed from the clouds.
///
/// # Errors
/// When they have to be computed from the clouds, and those cannot be read.
pub fn keyframe_descriptors(dir: &Path, keyframes: usize) -> Result<Vec<PriorKeyframe>, StoreError> {
    match read(&dir.join(NAME)) {
        Some(descriptors) if descriptors.len() == keyframes => Ok(descriptors),
        _ => descriptors_from_clouds(dir),
    }
}

/// Writes the file of a map whose graph and clouds exist.
pub(crate) fn write_keyframe_descriptors(dir: &Path) -> Result<(), StoreError> {
    let descriptors = descriptors_from_clouds(dir)?;
    files::write_durably(&dir.join(NAME), |out| write(out, &descriptors))
}

/// A keyframe without a cloud gets the descriptor of an empty one, so that the others of the map can be used. None at all if no keyframe has a cloud.
fn descriptors_from_clouds(dir: &Path) -> Result<Vec<PriorKeyframe>, StoreError> {
    let (mut descriptors, mut has_clouds) = (Vec::new(), false);
    for read in keyframes_and_clouds(dir)? {
        let (keyframe, cloud) = read?;
        has_clouds |= cloud.is_some();
        let (xyz, lidar) = cloud.map(|(cloud, lidar)| (cloud.xyz, lidar)).unwrap_or_default();
        descriptors.extend(descriptor_of(&keyframe.map_from_keyframe, &xyz, lidar));
    }
    Ok(if has_clouds { descriptors } else { Vec::new() })
}

fn descriptor_of(map_from_keyframe: &Pose, xyz: &[[f32; 3]], lidar: [f32; 3]) -> Option<PriorKeyframe> {
    let rotation = isometry_from_pose(map_from_keyframe)?.rotation;
    let KeyframeDescriptorParts { points, ranges, views } =
        KeyframeDescriptor::of_cloud(xyz, &rotation, lidar).parts();
    Some(PriorKeyframe { lidar, points, ranges, views })
}

fn write(out: &mut impl Write, descriptors: &[PriorKeyframe]) -> io::Result<()> {
    let count = |len: usize| u32::try_from(len).map_err(|_| io::Error::from(ErrorKind::InvalidInput));
    out.write_all(MAGIC)?;
    out.write_all(&KEYFRAME_DESCRIPTOR_VERSION.to_le_bytes())?;
    out.write_all(&count(descriptors.len())?.to_le_bytes())?;
    for PriorKeyframe { lidar, points, ranges, views } in descriptors {
        out.write_all(&lidar.map(f32::to_le_bytes).concat())?;
        out.write_all(&count(points.len())?.to_le_bytes())?;
        let points: Vec<u8> = points.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
        out.write_all(&points)?;
        out.write_all(&count(ranges.len())?.to_le_bytes())?;
        let ranges: Vec<u8> = ranges.iter().flat_map(|range| range.to_le_bytes()).collect();
        out.write_all(&ranges)?;
        for picture in views.as_flattened() {
            out.write_all(&count(picture.len())?.to_le_bytes())?;
            out.write_all(picture)?;
        }
    }
    Ok(())
}

/// None for a file that is absent or cannot be used.
fn read(path: &Path) -> Option<Vec<PriorKeyframe>> {
    let bytes = match fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) => {
            if error.kind() != ErrorKind::NotFound {
                tracing::warn!("{} is computed again, because it cannot be read: {error}", path.display());
            }
            return None;
        }
    };
    let descriptors = parse(&bytes);
    if descriptors.is_none() {
        tracing::warn!("{} is computed again, because it is broken or of another version", path.display());
    }
    descriptors
}

pub(crate) fn parse(bytes: &[u8]) -> Option<Vec<PriorKeyframe>> {
    let mut cursor = Cursor(bytes.strip_prefix(MAGIC)?);
    if cursor.number()? != KEYFRAME_DESCRIPTOR_VERSION {
        return None;
    }
    let count = cursor.number()?;
    let descriptors = (0..count).map(|_| cursor.place()).collect::<Option<Vec<_>>>()?;
    cursor.0.is_empty().then_some(descriptors)
}

/// The bytes that are still to be read.
struct Cursor<'a>(&'a [u8]);

impl<'a> Cursor<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn number(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(*self.take(4)?.first_chunk()?))
    }

    /// A count, and as many items of `size` bytes each.
    fn list(&mut self, size: usize) -> Option<&'a [u8]> {
        let count = self.number()? as usize;
        self.take(count.checked_mul(size)?)
    }

    fn place(&mut self) -> Option<PriorKeyframe> {
        let (lidar, _) = self.take(12)?.as_chunks::<4>();
        let lidar = [lidar[0], lidar[1], lidar[2]].map(f32::from_le_bytes);
        let (points, _) = self.list(6)?.as_chunks::<6>();
        let axis = |point: &[u8; 6], axis: usize| i16::from_le_bytes([point[2 * axis], point[2 * axis + 1]]);
        let points = points.iter().map(|point| [axis(point, 0), axis(point, 1), axis(point, 2)]).collect();
        let (ranges, _) = self.list(2)?.as_chunks::<2>();
        let ranges = ranges.iter().map(|range| u16::from_le_bytes(*range)).collect();
        let mut views: [[Vec<u8>; 2]; 3] = Default::default();
        for picture in views.as_flattened_mut() {
            *picture = self.list(1)?.to_vec();
        }
        Some(PriorKeyframe { lidar, points, ranges, views })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect_file;

    fn descriptors() -> Vec<PriorKeyframe> {
        let place = |number: i16| PriorKeyframe {
            lidar: [0.1, f32::from(number), -0.3],
            points: (0..number).map(|i| [i, -i, i16::MIN + i]).collect(),
            ranges: vec![u16::MAX, 7, number.unsigned_abs()].into(),
            views: std::array::from_fn(|view| [vec![view as u8; 5], vec![9; view]]),
        };
        vec![place(0), place(3), place(500)]
    }

    fn bytes() -> Vec<u8> {
        let mut bytes = Vec::new();
        assert!(write(&mut bytes, &descriptors()).is_ok());
        bytes
    }

    #[test]
    fn descriptors_come_back() {
        assert_eq!(parse(&bytes()), Some(descriptors()));
    }

    /// If this fails, the layout has changed: raise the version, and write the new bytes with `UPDATE_EXPECT=1`.
    #[test]
    fn the_bytes_are_unchanged() {
        let mut bytes = Vec::new();
        let few: Vec<_> = descriptors().into_iter().take(2).collect();
        assert!(write(&mut bytes, &few).is_ok());
        let text: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        let golden = format!("../layouts/places_v{KEYFRAME_DESCRIPTOR_VERSION}.txt");
        expect_file![golden].assert_eq(&format!("{text}\n"));
    }

    #[test]
    fn a_truncated_or_longer_file_is_not_used() {
        let whole = bytes();
        for length in 0..whole.len() {
            assert_eq!(parse(&whole[..length]), None, "{length}");
        }
        assert_eq!(parse(&[whole.as_slice(), &[0]].concat()), None);
        let mut older = whole;
        older[8] = older[8].wrapping_add(1);
        assert_eq!(parse(&older), None);
    }
}
