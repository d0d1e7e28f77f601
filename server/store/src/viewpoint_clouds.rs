//! Clouds of the virtual viewpoints of an imported map (`clouds/viewpoints_NNNNNN.bin`).
//!
//! An imported cloud has no keyframes that a robot walked. Virtual viewpoints take their place, and neighbouring viewpoints see mostly the same points.
//! One file therefore holds the points once, and for each viewpoint the indices of the points that are visible from it. A survey of 2.8 million points
//! with 438 viewpoints takes a twentieth of the bytes of one PCD file for each viewpoint.
//!
//! ```text
//! "AIVIEWPT", version u32, points u32, packed bytes u32, packed planes, viewpoints u32, then for each viewpoint
//!   cloud_from_base 3 f64 position, 4 f64 quaternion (w, x, y, z) | lidar 3 f32 | visible points u32, packed bytes u32, packed gaps
//! ```
//!
//! All numbers are little-endian. The planes are 16 times `points` bytes: the first bytes of all x, the second bytes of all x, and so on for y, z and
//! intensity (f32). Gaps are the differences of ascending indices as LEB128. Planes and gaps are packed as one zstd frame each. NNNNNN is the number of
//! the keyframe that the first viewpoint stands for; the others follow it. The file has a frame of its own, so it stays valid wherever the map's
//! graph moves the keyframes.

use crate::{MapPoints, StoreError, files, texts};
use geometry::{Isometry, isometry_from_pose, pose_from_isometry};
use std::fs;
use std::io::{self, Read, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use vocab::{KeyframeId, Pose, Quat, Vec3};

const MAGIC: &[u8; 8] = b"AIVIEWPT";
const VERSION: u32 = 1;
const NAME_PREFIX: &str = "viewpoints_";
const NAME_SUFFIX: &str = ".bin";
/// Planes of one byte a point: three coordinates and the intensity, four bytes each.
const PLANES: usize = 16;
/// Longest LEB128 of a u32, bytes.
const MAX_GAP_BYTES: usize = 5;

/// Parameters of files of viewpoints.
#[derive(Clone, Copy, Debug)]
struct ViewpointCloudsConfig {
    /// Level of zstd. Higher levels gain little on gaps and on the bytes of coordinates. Chosen: twice the default of zstd, 3.
    zstd_level: i32,
    /// Most points that a file may announce, so that a broken one cannot ask for all memory: 1 GB unpacked. Chosen: 67 million, more than an import may have in its
    /// memory.
    max_points: usize,
}

const CONFIG: ViewpointCloudsConfig = ViewpointCloudsConfig { zstd_level: 6, max_points: 1 << 26 };

/// A place in a cloud without a robot, and what is visible from it.
#[derive(Clone, Debug, PartialEq)]
pub struct CloudViewpoint {
    /// Pose of the base in the cloud's frame.
    pub cloud_from_base: Isometry,
    /// Position of the LiDAR in the base frame, metres.
    pub lidar: [f32; 3],
    /// Indices of the visible points, ascending.
    pub visible: Vec<u32>,
}

/// What one viewpoint sees.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct VisibleCloud {
    /// Metres, base frame.
    pub(crate) xyz: Vec<[f32; 3]>,
    /// Sensor units, one for each point.
    pub(crate) intensity: Vec<f32>,
    /// Position of the LiDAR in the base frame, metres.
    pub(crate) lidar: [f32; 3],
}

/// Name of the file whose first viewpoint stands for this keyframe.
pub(crate) fn file_name(first: KeyframeId) -> String {
    format!("{NAME_PREFIX}{:06}{NAME_SUFFIX}", first.0)
}

/// Whether a file is one of viewpoints, by its name.
pub(crate) fn is_viewpoint_file(path: &Path) -> bool {
    first_keyframe(path).is_some()
}

/// The keyframe that the first viewpoint of a file stands for, by the file's name.
fn first_keyframe(path: &Path) -> Option<KeyframeId> {
    let number = path.file_name()?.to_str()?.strip_prefix(NAME_PREFIX)?.strip_suffix(NAME_SUFFIX)?;
    number.parse().ok().map(KeyframeId)
}

/// Files of viewpoints in a folder of clouds, each with the keyframe that its first viewpoint stands for.
pub(crate) fn list(directory: &Path) -> Result<Vec<(KeyframeId, PathBuf)>, StoreError> {
    let paths = files::entries(directory)?;
    Ok(paths.into_iter().filter_map(|path| Some((first_keyframe(&path)?, path))).collect())
}

/// The transform of a viewpoint's points into its base frame: linear in the visible points.
pub fn visible_points(viewpoint: &CloudViewpoint, cloud: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let base_from_cloud = viewpoint.cloud_from_base.inverse();
    let in_base = |index: &u32| transform(&base_from_cloud, &cloud[*index as usize]);
    viewpoint.visible.iter().map(in_base).collect()
}

fn transform(base_from_cloud: &Isometry, point: &[f32; 3]) -> [f32; 3] {
    let point = geometry::Vector3::from(point.map(f64::from));
    let in_base = base_from_cloud.rotation * point + base_from_cloud.translation.vector;
    in_base.map(|coordinate| coordinate as f32).into()
}

/// Writes the clouds of viewpoints that stand for the keyframes from `first` on. `cloud` has the points of all of them, in a frame of its own. One viewpoint at
/// a time is in memory.
///
/// # Errors
/// When the disk fails, or indices do not ascend or exceed the cloud.
pub fn write_viewpoint_clouds(
    directory: &Path,
    first: KeyframeId,
    cloud: &MapPoints,
    viewpoints: impl ExactSizeIterator<Item = CloudViewpoint>,
) -> Result<(), StoreError> {
    let path = directory.join(file_name(first));
    let mut fits = true;
    files::write_durably(&path, |out| {
        fits = write(out, cloud, viewpoints)?;
        Ok(())
    })?;
    if !fits {
        files::remove_file(&path)?;
        return Err(StoreError::Broken { path, what: texts::VIEWPOINTS_DO_NOT_FIT });
    }
    Ok(())
}

/// Returns false if the viewpoints do not fit the cloud, or there are too many points.
fn write(
    out: &mut impl Write,
    cloud: &MapPoints,
    viewpoints: impl ExactSizeIterator<Item = CloudViewpoint>,
) -> io::Result<bool> {
    if !write_head(out, cloud, viewpoints.len())? {
        return Ok(false);
    }
    for viewpoint in viewpoints {
        if !write_viewpoint(out, cloud.xyz.len(), &viewpoint)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Returns false if there are too many points or viewpoints.
fn write_head(out: &mut impl Write, cloud: &MapPoints, viewpoints: usize) -> io::Result<bool> {
    let head = || {
        let mut bytes = MAGIC.to_vec();
        put(&mut bytes, VERSION as usize)?;
        put(&mut bytes, Some(cloud.xyz.len()).filter(|points| *points <= CONFIG.max_points)?)?;
        let packed = pack(&planes(cloud))?;
        put(&mut bytes, packed.len())?;
        bytes.extend(packed);
        put(&mut bytes, viewpoints)?;
        Some(bytes)
    };
    write_if_some(out, head())
}

/// Returns false if its indices do not ascend or exceed the points of the cloud.
fn write_viewpoint(out: &mut impl Write, points: usize, viewpoint: &CloudViewpoint) -> io::Result<bool> {
    let encode = || {
        let Pose { position, orientation: Quat { w, x, y, z } } =
            pose_from_isometry(&viewpoint.cloud_from_base);
        let pose = position.to_array().into_iter().chain([w, x, y, z]);
        let mut bytes: Vec<u8> = pose.flat_map(f64::to_le_bytes).collect();
        bytes.extend(viewpoint.lidar.iter().flat_map(|c| c.to_le_bytes()));
        put(&mut bytes, viewpoint.visible.len())?;
        let packed = pack(&gaps(&viewpoint.visible, points)?)?;
        put(&mut bytes, packed.len())?;
        bytes.extend(packed);
        Some(bytes)
    };
    write_if_some(out, encode())
}

fn write_if_some(out: &mut impl Write, bytes: Option<Vec<u8>>) -> io::Result<bool> {
    match bytes {
        Some(bytes) => out.write_all(&bytes).map(|()| true),
        None => Ok(false),
    }
}

/// None for a number that a u32 cannot hold.
fn put(bytes: &mut Vec<u8>, number: usize) -> Option<()> {
    bytes.extend(u32::try_from(number).ok()?.to_le_bytes());
    Some(())
}

fn pack(bytes: &[u8]) -> Option<Vec<u8>> {
    zstd::bulk::compress(bytes, CONFIG.zstd_level).ok()
}

fn planes(cloud: &MapPoints) -> Vec<u8> {
    let count = cloud.xyz.len();
    let mut planes = vec![0; PLANES * count];
    for (index, [x, y, z]) in cloud.xyz.iter().enumerate() {
        let intensity = cloud.intensity.get(index).copied().unwrap_or(0.0);
        let bytes = [*x, *y, *z, intensity].map(f32::to_le_bytes);
        for (plane, byte) in bytes.as_flattened().iter().enumerate() {
            planes[plane * count + index] = *byte;
        }
    }
    planes
}

/// None if indices do not ascend or exceed the cloud.
fn gaps(indices: &[u32], points: usize) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(indices.len() + 16);
    let mut next = 0;
    for &index in indices {
        let mut gap = index.checked_sub(next).filter(|_| (index as usize) < points)?;
        next = index + 1;
        while gap >= 0x80 {
            bytes.push(gap as u8 | 0x80);
            gap >>= 7;
        }
        bytes.push(gap as u8);
    }
    Some(bytes)
}

/// One file in memory: its points unpacked, its viewpoints as they lie on disk.
#[derive(Debug)]
pub(crate) struct ViewpointClouds {
    path: PathBuf,
    first: KeyframeId,
    cloud: MapPoints,
    viewpoints: Vec<PackedViewpoint>,
    bytes: Vec<u8>,
}

#[derive(Debug)]
struct PackedViewpoint {
    base_from_cloud: Isometry,
    lidar: [f32; 3],
    visible: usize,
    /// Of the packed gaps in the file.
    gaps: Range<usize>,
}

impl ViewpointClouds {
    /// Reads a file; `first` is the keyframe that its first viewpoint stands for.
    pub(crate) fn read(path: &Path, first: KeyframeId) -> Result<Self, StoreError> {
        let bytes = fs::read(path).map_err(|source| StoreError::io("read", path, source))?;
        Self::parse(path, first, bytes)
    }

    pub(crate) fn parse(path: &Path, first: KeyframeId, bytes: Vec<u8>) -> Result<Self, StoreError> {
        let version = bytes.strip_prefix(MAGIC).and_then(|rest| rest.first_chunk());
        let version = version.map_or(VERSION, |version| u32::from_le_bytes(*version));
        files::check_version(path, version, VERSION)?;
        let broken = || StoreError::Broken { path: path.to_owned(), what: texts::NO_VIEWPOINT_FILE };
        let (cloud, viewpoints) = parse(&bytes).ok_or_else(broken)?;
        Ok(Self { path: path.to_owned(), first, cloud, viewpoints, bytes })
    }

    /// Number of viewpoints.
    pub(crate) fn len(&self) -> u32 {
        self.viewpoints.len() as u32
    }

    /// Whether a viewpoint of this file stands for the keyframe.
    pub(crate) fn contains(&self, keyframe: KeyframeId) -> bool {
        self.index_of(keyframe).is_some()
    }

    fn index_of(&self, keyframe: KeyframeId) -> Option<usize> {
        let index = keyframe.0.checked_sub(self.first.0)? as usize;
        Some(index).filter(|index| *index < self.viewpoints.len())
    }

    /// What the keyframe's viewpoint sees; none if no viewpoint of this file stands for it. Linear in its points.
    pub(crate) fn cloud_of(&self, keyframe: KeyframeId) -> Result<Option<VisibleCloud>, StoreError> {
        let Some(index) = self.index_of(keyframe) else { return Ok(None) };
        let PackedViewpoint { base_from_cloud, lidar, visible, gaps } = &self.viewpoints[index];
        let indices = indices(&self.bytes[gaps.clone()], *visible, self.cloud.xyz.len());
        let indices = indices
            .ok_or_else(|| StoreError::Broken { path: self.path.clone(), what: texts::BROKEN_VIEWPOINT })?;
        let xyz = indices.iter().map(|index| transform(base_from_cloud, &self.cloud.xyz[*index as usize]));
        let intensity = indices.iter().map(|index| self.cloud.intensity[*index as usize]);
        Ok(Some(VisibleCloud { xyz: xyz.collect(), intensity: intensity.collect(), lidar: *lidar }))
    }
}

fn parse(bytes: &[u8]) -> Option<(MapPoints, Vec<PackedViewpoint>)> {
    let mut cursor = Cursor { bytes, at: 0 };
    let version = (cursor.take(MAGIC.len())? == MAGIC).then(|| cursor.number())??;
    if version != VERSION as usize {
        return None;
    }
    let points = cursor.number().filter(|points| *points <= CONFIG.max_points)?;
    let packed = cursor.number()?;
    let planes = unpack(cursor.take(packed)?, PLANES * points)?;
    let float = |plane: usize, index: usize| {
        f32::from_le_bytes([0, 1, 2, 3].map(|byte| planes[(4 * plane + byte) * points + index]))
    };
    let cloud = MapPoints {
        xyz: (0..points).map(|index| [0, 1, 2].map(|axis| float(axis, index))).collect(),
        intensity: (0..points).map(|index| float(3, index)).collect(),
    };
    let count = cursor.number()?;
    let viewpoints = (0..count).map(|_| cursor.viewpoint()).collect::<Option<Vec<_>>>()?;
    (cursor.at == bytes.len()).then_some((cloud, viewpoints))
}

/// None unless exactly the expected number of bytes comes out.
fn unpack(packed: &[u8], length: usize) -> Option<Vec<u8>> {
    unpack_at_most(packed, length).filter(|bytes| bytes.len() == length)
}

/// Memory grows with what comes out, not with what a header announces. None if more than `limit` bytes come out.
fn unpack_at_most(packed: &[u8], limit: usize) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let decoder = zstd::stream::read::Decoder::with_buffer(packed).ok()?;
    decoder.take(limit as u64 + 1).read_to_end(&mut bytes).ok()?;
    (bytes.len() <= limit).then_some(bytes)
}

/// None unless the gaps give exactly `count` ascending indices below `points`.
fn indices(packed: &[u8], count: usize, points: usize) -> Option<Vec<u32>> {
    if count > points {
        return None;
    }
    let gaps = unpack_at_most(packed, count * MAX_GAP_BYTES)?;
    let mut bytes = gaps.iter();
    let mut next = 0_u32;
    let mut indices = Vec::with_capacity(count);
    for _ in 0..count {
        let (mut gap, mut shift) = (0_u32, 0);
        loop {
            let byte = *bytes.next()?;
            gap |= u32::from(byte & 0x7f).checked_shl(shift)?;
            shift += 7;
            if byte & 0x80 == 0 {
                break;
            }
        }
        let index = next.checked_add(gap).filter(|index| (*index as usize) < points)?;
        indices.push(index);
        next = index + 1;
    }
    bytes.next().is_none().then_some(indices)
}

/// A position in the bytes of a file.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let taken = self.bytes.get(self.at..self.at.checked_add(count)?)?;
        self.at += count;
        Some(taken)
    }

    fn number(&mut self) -> Option<usize> {
        Some(u32::from_le_bytes(*self.take(4)?.first_chunk()?) as usize)
    }

    fn floats<const COUNT: usize>(&mut self) -> Option<[f64; COUNT]> {
        let (chunks, _) = self.take(8 * COUNT)?.as_chunks::<8>();
        Some(std::array::from_fn(|index| f64::from_le_bytes(chunks[index])))
    }

    fn viewpoint(&mut self) -> Option<PackedViewpoint> {
        let [px, py, pz, w, x, y, z] = self.floats::<7>()?;
        let pose = Pose { position: Vec3::new(px, py, pz), orientation: Quat { w, x, y, z } };
        let (lidar, _) = self.take(12)?.as_chunks::<4>();
        let lidar = [0, 1, 2].map(|axis| f32::from_le_bytes(lidar[axis]));
        let visible = self.number()?;
        let packed = self.number()?;
        let gaps = self.at..self.at.checked_add(packed)?;
        self.take(packed)?;
        Some(PackedViewpoint { base_from_cloud: isometry_from_pose(&pose)?.inverse(), lidar, visible, gaps })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Rotation, Vector3};

    fn cloud(points: u32) -> MapPoints {
        let coordinate = |seed: u32| (seed.wrapping_mul(2_654_435_761) >> 8) as f32 * 1e-5 - 80.0;
        MapPoints {
            xyz: (0..points).map(|i| [i, i + 7_000, i + 90_000].map(coordinate)).collect(),
            intensity: (0..points).map(|i| i as f32 * 0.25).collect(),
        }
    }

    fn pose(step: f64) -> Isometry {
        let turn = Rotation::from_euler_angles(0.01 * step, -0.02, 0.3 * step);
        Isometry::from_parts(Vector3::new(step, -2.0 * step, 0.5).into(), turn)
    }

    /// Every other point, every 200th, all, none, and the first and last.
    fn lists(points: u32) -> Vec<Vec<u32>> {
        let every = |step: usize| (0..points).step_by(step).collect();
        vec![every(2), every(200), every(1), Vec::new(), vec![0, points - 1]]
    }

    fn viewpoints(lists: &[Vec<u32>]) -> Vec<CloudViewpoint> {
        let make = |(step, visible): (usize, &Vec<u32>)| CloudViewpoint {
            cloud_from_base: pose(step as f64),
            lidar: [0.1, 0.0, 0.3],
            visible: visible.clone(),
        };
        lists.iter().enumerate().map(make).collect()
    }

    /// None if the viewpoints do not fit the cloud.
    fn encode(cloud: &MapPoints, viewpoints: &[CloudViewpoint]) -> Option<Vec<u8>> {
        let mut bytes = Vec::new();
        write(&mut bytes, cloud, viewpoints.iter().cloned()).expect("memory").then_some(bytes)
    }

    fn read(bytes: Vec<u8>) -> Result<ViewpointClouds, StoreError> {
        ViewpointClouds::parse(Path::new("viewpoints_000005.bin"), KeyframeId(5), bytes)
    }

    #[test]
    fn every_viewpoint_comes_back_bit_for_bit() {
        let (cloud, lists) = (cloud(3_000), lists(3_000));
        let viewpoints = viewpoints(&lists);
        let file = read(encode(&cloud, &viewpoints).expect("fits")).expect("read");
        for (viewpoint, number) in viewpoints.iter().zip(5..) {
            let seen = file.cloud_of(KeyframeId(number)).expect("understood").expect("there");
            assert_eq!(seen.xyz, visible_points(viewpoint, &cloud.xyz));
            let intensity: Vec<f32> =
                viewpoint.visible.iter().map(|i| cloud.intensity[*i as usize]).collect();
            assert_eq!((seen.intensity, seen.lidar), (intensity, [0.1, 0.0, 0.3]));
        }
        for absent in [0, 4, 10] {
            assert!(!file.contains(KeyframeId(absent)));
            assert_eq!(file.cloud_of(KeyframeId(absent)).expect("no error"), None);
        }
    }

    /// Files as they were written, by version. They can be read for good. If the test below fails, the layout has changed: raise the version, keep the old one
    /// readable, and add a line. The bytes of a later zstd may differ with the same layout.
    const STORED: [(u8, &str); 1] = [(1, include_str!("../layouts/viewpoints_v1.txt"))];

    #[test]
    fn files_of_every_version_are_read() {
        let (cloud, lists) = (cloud(40), lists(40));
        let viewpoints = viewpoints(&lists);
        let hex = |bytes: &[u8]| bytes.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
        let written = encode(&cloud, &viewpoints).expect("fits");
        assert_eq!(u32::from(STORED[STORED.len() - 1].0), VERSION);
        for (version, line) in STORED {
            let digits = line.trim();
            let byte = |at: usize| u8::from_str_radix(&digits[at..at + 2], 16).expect("hexadecimal");
            let bytes: Vec<u8> = (0..digits.len()).step_by(2).map(byte).collect();
            assert_eq!(bytes.get(MAGIC.len()), Some(&version), "now {}", hex(&written));
            let file = read(bytes).expect("read");
            for (viewpoint, number) in viewpoints.iter().zip(5..) {
                let seen = file.cloud_of(KeyframeId(number)).expect("understood").expect("there");
                assert_eq!(seen.xyz, visible_points(viewpoint, &cloud.xyz), "version {version}");
            }
        }
    }

    #[test]
    fn indices_that_do_not_fit_are_refused() {
        let cloud = cloud(10);
        for list in [vec![3, 3], vec![4, 2], vec![10]] {
            assert_eq!(encode(&cloud, &viewpoints(&[list])), None);
        }
    }

    #[test]
    fn a_truncated_file_gives_an_error_at_every_length() {
        let lists = lists(40);
        let whole = encode(&cloud(40), &viewpoints(&lists)).expect("fits");
        for length in 0..whole.len() {
            assert!(matches!(read(whole[..length].to_vec()), Err(StoreError::Broken { .. })), "{length}");
        }
        assert!(read([whole.as_slice(), &[0]].concat()).is_err());
    }

    #[test]
    fn a_changed_byte_gives_an_error_or_other_points_but_no_panic() {
        let lists = lists(40);
        let whole = encode(&cloud(40), &viewpoints(&lists)).expect("fits");
        for at in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] ^= 0x55;
            if let Ok(file) = read(bytes) {
                (5..10).for_each(|number| drop(file.cloud_of(KeyframeId(number))));
            }
        }
    }
}
