//! LAS and LAZ (ASPRS LAS 1.2, point format 0; LASzip compression), which survey programs read.
//!
//! Coordinates are whole millimetres from the middle of the cloud. The range of intensities differs between sensors; it is scaled to 16 bits,
//! as the standard requires.

use crate::texts;
use las::{Builder, Header, Point, Transform, Vector, Writer, point::Format};
use std::io::{self, Seek, SeekFrom, Write};

/// Step to which coordinates are rounded, metres.
const STEP: f64 = 0.001;

/// Writes points (metres) with their intensity (sensor units; missing ones are 0), compressed or not.
///
/// # Errors
/// When `out` fails, or a coordinate is not finite or farther than 2,147 km from the middle.
pub fn write(
    out: impl Write + Seek + Send + Sync + 'static,
    xyz: &[[f32; 3]],
    intensity: &[f32],
    compressed: bool,
) -> io::Result<()> {
    let header = header(xyz, compressed)?;
    let mut writer = Writer::new(FailureKeeper::new(out), header).map_err(io::Error::other)?;
    let scale = intensity_scale(intensity);
    let intensities = intensity.iter().copied().chain(std::iter::repeat(0.0));
    for ([x, y, z], intensity) in xyz.iter().map(|point| point.map(f64::from)).zip(intensities) {
        let point = Point { x, y, z, intensity: (intensity * scale).round() as u16, ..Point::default() };
        writer.write_point(point).map_err(io::Error::other)?;
    }
    let mut output = writer.into_inner().map_err(io::Error::other)?;
    output.failed.take().map_or(Ok(()), Err)?;
    output.out.flush()
}

/// Output of the library's writer. After the first failure it discards all further bytes and reports success, because the library's writer
/// completes its file when it is dropped and panics if that fails. The failure is reported at the end.
struct FailureKeeper<W> {
    out: W,
    /// Position and end of the file as the writer believes them to be, bytes.
    position: u64,
    end: u64,
    /// The first failure.
    failed: Option<io::Error>,
}

impl<W> FailureKeeper<W> {
    fn new(out: W) -> Self {
        Self { out, position: 0, end: 0, failed: None }
    }

    fn attempt(&mut self, act: impl FnOnce(&mut W) -> io::Result<()>) {
        if self.failed.is_none() {
            self.failed = act(&mut self.out).err();
        }
    }
}

impl<W: Write> Write for FailureKeeper<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.attempt(|out| out.write_all(bytes));
        self.position += bytes.len() as u64;
        self.end = self.end.max(self.position);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.attempt(Write::flush);
        Ok(())
    }
}

impl<W: Seek> Seek for FailureKeeper<W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let before_start = || io::Error::new(io::ErrorKind::InvalidInput, texts::SEEK_BEFORE_START);
        self.position = match to {
            SeekFrom::Start(place) => Some(place),
            SeekFrom::Current(offset) => self.position.checked_add_signed(offset),
            SeekFrom::End(offset) => self.end.checked_add_signed(offset),
        }
        .ok_or_else(before_start)?;
        let place = self.position;
        self.attempt(|out| out.seek(SeekFrom::Start(place)).map(drop));
        Ok(place)
    }
}

/// Refuses points that cannot be written: once the writer has begun, it must not fail.
fn header(xyz: &[[f32; 3]], compressed: bool) -> io::Result<Header> {
    let offsets = std::array::from_fn(|axis| middle(xyz, axis));
    let fits = |point: &[f32; 3]| {
        point
            .iter()
            .zip(offsets)
            .all(|(c, offset)| (f64::from(*c) - offset).abs() / STEP < f64::from(i32::MAX))
    };
    if !xyz.iter().all(fits) {
        let problem = texts::LAS_POINT_UNWRITABLE;
        return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
    }
    let mut builder = Builder::from((1, 2));
    builder.point_format = Format::new(0).map_err(io::Error::other)?;
    builder.point_format.is_compressed = compressed;
    builder.system_identifier = "AutoInspect".to_owned();
    builder.generating_software = concat!("AutoInspect ", env!("CARGO_PKG_VERSION")).to_owned();
    let [x, y, z] = offsets.map(|offset| Transform { scale: STEP, offset });
    builder.transforms = Vector { x, y, z };
    builder.into_header().map_err(io::Error::other)
}

/// A whole number of metres near the middle of the cloud.
fn middle(xyz: &[[f32; 3]], axis: usize) -> f64 {
    let of = |pick: fn(f32, f32) -> f32| xyz.iter().map(|point| point[axis]).reduce(pick).unwrap_or(0.0);
    let middle = 0.5 * (f64::from(of(f32::min)) + f64::from(of(f32::max)));
    if middle.is_finite() { middle.round() } else { 0.0 }
}

/// Factor that spreads an intensity over 16 bits: sensors count to 1, to 255, or to 65,535.
fn intensity_scale(intensity: &[f32]) -> f32 {
    let most = intensity.iter().copied().fold(0.0, f32::max);
    let range = [1.0, 255.0].into_iter().find(|range| most <= *range).unwrap_or(65_535.0);
    65_535.0 / range
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;

    fn cloud(count: usize) -> (Vec<[f32; 3]>, Vec<f32>) {
        let xyz = (0..count).map(|i| [100.0 + i as f32 * 0.25, -(i as f32) * 0.01, (i % 7) as f32 * 0.5]);
        (xyz.collect(), (0..count).map(|i| (i % 256) as f32).collect())
    }

    #[test]
    fn both_kinds_read_back_within_half_a_step() {
        let (xyz, intensity) = cloud(1000);
        let dir = tempfile::tempdir().unwrap();
        let sizes = [("a.las", false), ("a.laz", true)].map(|(name, compressed)| {
            let path = dir.path().join(name);
            write(File::create(&path).unwrap(), &xyz, &intensity, compressed).unwrap();
            let mut reader = las::Reader::from_path(&path).unwrap();
            let points: Vec<Point> = reader.read_all().unwrap().points().map(Result::unwrap).collect();
            assert_eq!(points.len(), 1000);
            for ((point, truth), intensity) in points.iter().zip(&xyz).zip(&intensity) {
                for (read, truth) in [point.x, point.y, point.z].into_iter().zip(truth) {
                    assert!((read - f64::from(*truth)).abs() <= 0.51 * STEP);
                }
                assert_eq!(point.intensity, (*intensity * 257.0) as u16);
            }
            std::fs::metadata(&path).unwrap().len()
        });
        assert!(sizes[1] < sizes[0] / 2, "{sizes:?}");
    }

    #[test]
    fn no_points_and_impossible_points() {
        let written = |xyz: &[[f32; 3]]| write(io::Cursor::new(Vec::new()), xyz, &[], true);
        written(&[]).unwrap();
        assert!(written(&[[f32::NAN, 0.0, 0.0]]).is_err());
        assert!(written(&[[1.0, f32::INFINITY, 0.0], [0.0; 3]]).is_err());
        assert!(written(&[[3e9, 0.0, 0.0], [0.0; 3]]).is_err());
    }

    /// A disk with room for some bytes.
    struct Full {
        place: io::Cursor<Vec<u8>>,
        room: usize,
    }

    impl Write for Full {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.room = self.room.checked_sub(bytes.len()).ok_or(io::ErrorKind::StorageFull)?;
            self.place.write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    impl Seek for Full {
        fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
            self.place.seek(to)
        }
    }

    #[test]
    fn a_full_disk_is_an_error_and_no_panic() {
        let (xyz, intensity) = cloud(1000);
        for compressed in [false, true] {
            for room in [0, 100, 300, 1000] {
                let disk = Full { place: io::Cursor::new(Vec::new()), room };
                let error = write(disk, &xyz, &intensity, compressed).unwrap_err();
                assert_eq!(error.kind(), io::ErrorKind::StorageFull, "{room} {compressed}: {error}");
            }
        }
    }
}
