//! What a map's keyframes leave behind for being found again (`places.bin`), so that a robot need not make it of all clouds whenever
//! it begins to use the map: 40 kB a keyframe instead of 1 MB.
//!
//! ```text
//! "AIPLACES", version u32, count u32, then for each keyframe in the graph's order
//!   lidar 3 f32 | points n u32, 3n i16 | ranges n u32, n u16 | six pictures, each n u32, n u8
//! ```
//!
//! All little-endian. Clouds are the truth: a file that is not there, of another version or broken is as if it had never been.

use crate::map_cloud::MapCloud;
use crate::map_clouds::map_clouds_and_sensors;
use crate::{StoreError, files};
use geometry::isometry_from_pose;
use mapping::{KEYFRAME_DESCRIPTOR_VERSION, KeyframeDescriptor, KeyframeDescriptorParts};
use messages::PriorKeyframe;
use std::fs;
use std::io::{self, ErrorKind, Write};
use std::path::Path;

const NAME: &str = "places.bin";
const MAGIC: &[u8; 8] = b"AIPLACES";

/// What each keyframe of the map in the folder `dir` saw, in the graph's order; `keyframes` of them, unless clouds are missing. Linear in
/// the keyframes: 20 us each, or some 10 ms where it has to be made of the clouds.
///
/// # Errors
/// When it has to be made of the clouds, and those cannot be read.
pub fn keyframe_descriptors(dir: &Path, keyframes: usize) -> Result<Vec<PriorKeyframe>, StoreError> {
    match read(&dir.join(NAME)) {
        Some(places) if places.len() == keyframes => Ok(places),
        _ => descriptors_from_clouds(dir),
    }
}

/// Makes the file of a map whose graph and clouds are written.
pub(crate) fn write_keyframe_descriptors(dir: &Path) -> Result<(), StoreError> {
    let places = descriptors_from_clouds(dir)?;
    files::write_durably(&dir.join(NAME), |out| write(out, &places))
}

fn descriptors_from_clouds(dir: &Path) -> Result<Vec<PriorKeyframe>, StoreError> {
    let mut places = Vec::new();
    for read in map_clouds_and_sensors(dir)? {
        let (cloud, lidar) = read?;
        places.extend(place_of(&cloud, lidar));
    }
    Ok(places)
}

fn place_of(cloud: &MapCloud, lidar: [f32; 3]) -> Option<PriorKeyframe> {
    let rotation = isometry_from_pose(&cloud.map_from_keyframe)?.rotation;
    let KeyframeDescriptorParts { points, ranges, views } =
        KeyframeDescriptor::of_cloud(&cloud.xyz, &rotation, lidar).parts();
    Some(PriorKeyframe { lidar, points, ranges, views })
}

fn write(out: &mut impl Write, places: &[PriorKeyframe]) -> io::Result<()> {
    let count = |len: usize| u32::try_from(len).map_err(|_| io::Error::from(ErrorKind::InvalidInput));
    out.write_all(MAGIC)?;
    out.write_all(&KEYFRAME_DESCRIPTOR_VERSION.to_le_bytes())?;
    out.write_all(&count(places.len())?.to_le_bytes())?;
    for PriorKeyframe { lidar, points, ranges, views } in places {
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

/// None for a file that cannot be used.
fn read(path: &Path) -> Option<Vec<PriorKeyframe>> {
    let bytes = match fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) => {
            if error.kind() != ErrorKind::NotFound {
                tracing::warn!("{} is made anew, because it cannot be read: {error}", path.display());
            }
            return None;
        }
    };
    let places = parse(&bytes);
    if places.is_none() {
        tracing::warn!("{} is made anew, because it is broken or of another version", path.display());
    }
    places
}

fn parse(bytes: &[u8]) -> Option<Vec<PriorKeyframe>> {
    let mut rest = Rest(bytes.strip_prefix(MAGIC)?);
    if rest.number()? != KEYFRAME_DESCRIPTOR_VERSION {
        return None;
    }
    let count = rest.number()?;
    let places = (0..count).map(|_| rest.place()).collect::<Option<Vec<_>>>()?;
    rest.0.is_empty().then_some(places)
}

/// What is still to be read.
struct Rest<'a>(&'a [u8]);

impl<'a> Rest<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn number(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(*self.take(4)?.first_chunk()?))
    }

    /// A count, and so many items of so many bytes.
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

    fn places() -> Vec<PriorKeyframe> {
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
        assert!(write(&mut bytes, &places()).is_ok());
        bytes
    }

    #[test]
    fn places_come_back() {
        assert_eq!(parse(&bytes()), Some(places()));
    }

    #[test]
    fn whatever_is_cut_off_or_too_long_is_not_used() {
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
