//! Points as rows of named binary fields, the common form of PointCloud2, PCD, PLY and KITTI files.
//!
//! Only [`PointTable::to_scan`] knows which names mean intensity, channel and time, and in which units the makers of sensors write the time of
//! a point.

use crate::{FormatError, texts};
use messages::Scan;
use std::borrow::Cow;
use vocab::Stamp;

/// Type of one number of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the types")]
pub enum ScalarType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl ScalarType {
    /// Bytes it takes.
    pub const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// Whether it is a floating-point type.
    pub const fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }
}

/// One named column of a point table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PointField {
    /// As written in the file, e.g. `x`, `intensity`, `t`.
    pub name: String,
    /// Byte offset within a point.
    pub offset: usize,
    /// Type of each number.
    pub scalar: ScalarType,
    /// Number of numbers in it.
    pub count: usize,
}

/// Points as rows of bytes. Invariant: every field lies within a row and every row within the data.
#[derive(Clone, Debug, PartialEq)]
pub struct PointTable<'a> {
    fields: Vec<PointField>,
    point_step: usize,
    row_step: usize,
    width: usize,
    height: usize,
    big_endian: bool,
    data: Cow<'a, [u8]>,
}

/// Points left out of a scan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    /// A coordinate was NaN or infinite.
    pub non_finite: usize,
    /// The sensor reported no return: all coordinates zero.
    pub zero_range: usize,
}

impl Dropped {
    /// Sum of both.
    pub fn total(self) -> usize {
        self.non_finite + self.zero_range
    }
}

/// Report of turning a table into a scan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ScanReport {
    /// Points left out.
    pub dropped: Dropped,
    /// The point times were absolute but more than 2 s from the message's stamp, so they were counted from the
    /// earliest one instead: the sensor's clock and the recorder's disagree.
    pub clock_mismatch: bool,
}

/// Which times of points are of a scan.
#[derive(Clone, Copy, Debug)]
struct PointTimesConfig {
    /// Greatest difference between a point's time and its scan's stamp, ns: two seconds, more than any LiDAR's sweep. Chosen: times of another clock differ by far more.
    max_difference_ns: i64,
}

const TIMES: PointTimesConfig = PointTimesConfig { max_difference_ns: 2_000_000_000 };
const TIME_NAMES: [&str; 7] =
    ["t", "time", "timestamp", "offset_time", "time_offset", "timeoffset", "time_stamp"];
const INTENSITY_NAMES: [&str; 4] = ["intensity", "scalar_intensity", "i", "reflectivity"];
const COLOUR_NAMES: [&str; 2] = ["rgba", "rgb"];
const RING_NAMES: [&str; 4] = ["ring", "channel", "line", "laser_id"];

impl<'a> PointTable<'a> {
    /// A dense table of one row.
    ///
    /// # Errors
    /// As [`PointTable::organised`].
    pub fn new(
        fields: Vec<PointField>,
        point_step: usize,
        count: usize,
        big_endian: bool,
        data: Cow<'a, [u8]>,
    ) -> Result<Self, FormatError> {
        Self::organised(fields, point_step, point_step.saturating_mul(count), count, 1, big_endian, data)
    }

    /// A table of `height` rows that start `row_step` bytes apart.
    ///
    /// # Errors
    /// When a field reaches beyond its point, or the points beyond the data.
    pub fn organised(
        fields: Vec<PointField>,
        point_step: usize,
        row_step: usize,
        width: usize,
        height: usize,
        big_endian: bool,
        data: Cow<'a, [u8]>,
    ) -> Result<Self, FormatError> {
        for field in &fields {
            let end = field.scalar.size().saturating_mul(field.count).saturating_add(field.offset);
            if end > point_step {
                return Err(FormatError::Malformed {
                    what: texts::POINT_CLOUD,
                    place: format!("field '{}'", texts::shown(&field.name)),
                    problem: texts::field_beyond_point(end, point_step),
                });
            }
        }
        let row = point_step.saturating_mul(width);
        if height > 1 && row_step < row {
            return Err(FormatError::Malformed {
                what: texts::POINT_CLOUD,
                place: "row_step".into(),
                problem: texts::row_too_short(row_step, width, point_step),
            });
        }
        let needed = match (width, height) {
            (0, _) | (_, 0) => 0,
            _ => row_step.saturating_mul(height - 1).saturating_add(row),
        };
        if needed > data.len() || (needed == 0 && point_step == 0 && width > 0 && height > 0) {
            return Err(FormatError::Truncated {
                what: texts::POINT_CLOUD,
                at: data.len() as u64,
                missing: (needed - data.len().min(needed)) as u64,
            });
        }
        // Without a point there is no row either: a header may state billions of rows of no points.
        let (width, height) = if needed == 0 { (0, 0) } else { (width, height) };
        Ok(Self { fields, point_step, row_step, width, height, big_endian, data })
    }

    /// Number of points, the unusable ones included.
    pub fn len(&self) -> usize {
        self.width * self.height
    }

    /// Whether there is no point at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Columns and rows of the grid in which the points stand; an unorganised table has one row.
    pub fn grid(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// The columns.
    pub fn fields(&self) -> &[PointField] {
        &self.fields
    }

    /// The column of this name, in any case; if there are several, one in the exact case first.
    pub fn field(&self, name: &str) -> Option<&PointField> {
        let exact = self.fields.iter().find(|field| field.name == name);
        exact.or_else(|| self.fields.iter().find(|field| field.name.eq_ignore_ascii_case(name)))
    }

    /// Whether points have a time of their own.
    pub fn has_times(&self) -> bool {
        self.first_field(&TIME_NAMES).is_some()
    }

    /// Whether points name their channel.
    pub fn has_rings(&self) -> bool {
        self.first_field(&RING_NAMES).is_some()
    }

    /// Turns rows into a scan, leaving out points without a return. `stamp` is the message's; without one the
    /// earliest absolute point time is taken, or the epoch.
    ///
    /// # Errors
    /// When x, y or z is missing.
    pub fn to_scan(&self, stamp: Option<Stamp>) -> Result<(Scan, ScanReport), FormatError> {
        let mut xyz = self.positions()?;
        let (keep, dropped) = usable(&xyz);
        let mut intensity = self.intensity();
        let mut ring = self.first_field(&RING_NAMES).map_or(Vec::new(), |field| self.column::<u16>(field));
        let mut report = ScanReport { dropped, clock_mismatch: false };
        let mut times = self.first_field(&TIME_NAMES).map(|field| self.times(field));
        if let Some(keep) = keep {
            retain(&mut xyz, &keep);
            retain(&mut intensity, &keep);
            retain(&mut ring, &keep);
            match &mut times {
                Some(PointTimes::Offsets(offsets)) => retain(offsets, &keep),
                Some(PointTimes::Absolute(stamps)) => retain(stamps, &keep),
                None => {}
            }
        }
        let (stamp, offset_ns) = match times {
            None => (stamp.unwrap_or_default(), Vec::new()),
            Some(PointTimes::Offsets(offsets)) => (stamp.unwrap_or_default(), offsets),
            Some(PointTimes::Absolute(stamps)) => {
                let (base, mismatch) = reference_time(&stamps, stamp);
                report.clock_mismatch = mismatch;
                let offsets = stamps.iter().map(|at| saturate(at.saturating_sub(base))).collect();
                (stamp.unwrap_or(Stamp::from_nanos(base)), offsets)
            }
        };
        Ok((Scan { stamp, xyz, intensity, offset_ns, ring }, report))
    }

    /// Positions of all points, the unusable ones included.
    ///
    /// # Errors
    /// When x, y or z is missing.
    pub fn positions(&self) -> Result<Vec<[f32; 3]>, FormatError> {
        let (x, y, z) = (self.coordinate("x")?, self.coordinate("y")?, self.coordinate("z")?);
        let packed_f32 = !self.big_endian
            && [x, y, z].iter().all(|field| field.scalar == ScalarType::F32)
            && y.offset == x.offset + 4
            && z.offset == x.offset + 8;
        if packed_f32 {
            // The layout of nearly every sensor: one pass instead of three.
            return Ok(self
                .points()
                .map(|point| {
                    let at =
                        |o: usize| f32::from_le_bytes([point[o], point[o + 1], point[o + 2], point[o + 3]]);
                    [at(x.offset), at(x.offset + 4), at(x.offset + 8)]
                })
                .collect());
        }
        let (x, y, z) = (self.column::<f32>(x), self.column::<f32>(y), self.column::<f32>(z));
        Ok(x.into_iter().zip(y).zip(z).map(|((x, y), z)| [x, y, z]).collect())
    }

    /// Positions of all points in double precision, the unusable ones included.
    ///
    /// # Errors
    /// When x, y or z is missing.
    pub fn coordinates(&self) -> Result<impl Iterator<Item = [f64; 3]> + '_, FormatError> {
        let fields = [self.coordinate("x")?, self.coordinate("y")?, self.coordinate("z")?];
        Ok(self.points().map(move |point| fields.map(|field| self.number(point, field))))
    }

    /// Intensities of all points in sensor units; zeros if there are none.
    pub fn intensities(&self) -> impl Iterator<Item = f32> + '_ {
        let field = self.first_field(&INTENSITY_NAMES);
        self.points().map(move |point| field.map_or(0.0, |field| self.number(point, field)))
    }

    /// Intensities in sensor units; empty if there are none.
    fn intensity(&self) -> Vec<f32> {
        self.first_field(&INTENSITY_NAMES).map_or(Vec::new(), |field| self.column::<f32>(field))
    }

    /// Red, green and blue of all points, packed as the Point Cloud Library does in a field `rgb` or `rgba` of four bytes; empty if there is none.
    pub fn colours(&self) -> Vec<[u8; 3]> {
        let field = COLOUR_NAMES.iter().find_map(|name| self.field(name));
        let Some(field) = field.filter(|field| field.count > 0 && field.scalar.size() == 4) else {
            return Vec::new();
        };
        let packed = |point: &[u8]| {
            let bytes = [0, 1, 2, 3].map(|byte| point[field.offset + byte]);
            let number = if self.big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) };
            [16, 8, 0].map(|shift| (number >> shift) as u8)
        };
        self.points().map(packed).collect()
    }

    fn coordinate(&self, name: &'static str) -> Result<&PointField, FormatError> {
        self.field(name).filter(|field| field.count > 0).ok_or_else(|| FormatError::Malformed {
            what: texts::POINT_CLOUD,
            place: format!("field '{name}'"),
            problem: texts::coordinate_missing(&self.field_names()),
        })
    }

    /// The first number of a column of this table for every point, converted.
    fn column<T: FromNumber>(&self, field: &PointField) -> Vec<T> {
        if field.count == 0 {
            return vec![T::from_i64(0); self.len()];
        }
        self.points().map(|point| self.number(point, field)).collect()
    }

    /// The first number of a field of a point. The field must not be empty.
    fn number<T: FromNumber>(&self, point: &[u8], field: &PointField) -> T {
        macro_rules! read {
            ($type:ty, $from:ident as $wide:ty) => {{
                let mut bytes = [0; size_of::<$type>()];
                bytes.copy_from_slice(&point[field.offset..field.offset + size_of::<$type>()]);
                let value = match self.big_endian {
                    true => <$type>::from_be_bytes(bytes),
                    false => <$type>::from_le_bytes(bytes),
                };
                T::$from(value as $wide)
            }};
        }
        match field.scalar {
            ScalarType::I8 => read!(i8, from_i64 as i64),
            ScalarType::U8 => read!(u8, from_i64 as i64),
            ScalarType::I16 => read!(i16, from_i64 as i64),
            ScalarType::U16 => read!(u16, from_i64 as i64),
            ScalarType::I32 => read!(i32, from_i64 as i64),
            ScalarType::U32 => read!(u32, from_i64 as i64),
            ScalarType::I64 => read!(i64, from_i64 as i64),
            // Sensor clocks end long before 2^63 ns.
            ScalarType::U64 => read!(u64, from_i64 as i64),
            ScalarType::F32 => read!(f32, from_f32 as f32),
            ScalarType::F64 => read!(f64, from_f64 as f64),
        }
    }

    fn points(&self) -> impl Iterator<Item = &[u8]> {
        let row_len = self.width * self.point_step;
        (0..self.height).flat_map(move |row| {
            let start = if self.width == 0 { 0 } else { row * self.row_step };
            // `max(1)`: a table without fields has no bytes and therefore, by the invariant, no points.
            self.data[start..start + row_len].chunks_exact(self.point_step.max(1))
        })
    }

    fn times(&self, field: &PointField) -> PointTimes {
        if field.scalar.is_float() {
            float_times(&self.column::<f64>(field))
        } else {
            integer_times(self.column::<i64>(field))
        }
    }

    fn first_field(&self, names: &[&str]) -> Option<&PointField> {
        names.iter().find_map(|name| self.field(name)).filter(|field| field.count > 0)
    }

    fn field_names(&self) -> String {
        self.fields.iter().map(|field| field.name.as_str()).collect::<Vec<_>>().join(", ")
    }
}

/// Times of points, normalised to nanoseconds.
enum PointTimes {
    /// After (or before) the scan's stamp.
    Offsets(Vec<i32>),
    /// Since the Unix epoch or another origin of the sensor's clock.
    Absolute(Vec<i64>),
}

/// Integers are nanoseconds (Ouster `t`, Livox `offset_time`) unless they are too large for a sweep: then
/// absolute nanoseconds or microseconds.
fn integer_times(values: Vec<i64>) -> PointTimes {
    let least = values.iter().copied().filter(|value| *value != 0).min().unwrap_or(0);
    if least >= 100_000_000_000_000_000 {
        PointTimes::Absolute(values)
    } else if least >= 100_000_000_000_000 {
        PointTimes::Absolute(values.into_iter().map(|micros| micros.saturating_mul(1000)).collect())
    } else {
        PointTimes::Offsets(values.into_iter().map(saturate).collect())
    }
}

/// Floats are seconds (Velodyne `time`, Hesai `timestamp`), but milli-, micro- and nanoseconds are met too. A
/// sweep lasts a fraction of a second and today's date is 1.7e9 s, so the magnitude determines the unit.
fn float_times(values: &[f64]) -> PointTimes {
    let finite = || values.iter().copied().filter(|value| value.is_finite());
    let least = finite().filter(|value| *value != 0.0).fold(f64::INFINITY, f64::min);
    let largest = finite().map(f64::abs).fold(0.0, f64::max);
    if least.is_finite() && least >= 1e8 {
        let per_second = [1.0, 1e3, 1e6, 1e9].into_iter().find(|unit| least < 1e11 * unit).unwrap_or(1e9);
        let stamp = |value: f64| match per_second {
            1e9 => value as i64,
            _ => Stamp::from_secs_f64(value / per_second).nanos(),
        };
        return PointTimes::Absolute(values.iter().map(|value| stamp(*value)).collect());
    }
    let per_second = [1.0, 1e3, 1e6, 1e9].into_iter().find(|unit| largest <= 2.0 * unit).unwrap_or(1e9);
    let offset = |value: f64| (value * (1e9 / per_second)).round() as i32;
    PointTimes::Offsets(values.iter().map(|value| offset(*value)).collect())
}

/// The instant that absolute times count from, and whether the message's stamp had to be ignored for it.
fn reference_time(stamps: &[i64], message: Option<Stamp>) -> (i64, bool) {
    let earliest = stamps.iter().copied().min().unwrap_or(0);
    match message {
        None => (earliest, false),
        Some(stamp) if stamps.is_empty() => (stamp.nanos(), false),
        Some(stamp) => {
            let far = earliest.saturating_sub(stamp.nanos()).saturating_abs() > TIMES.max_difference_ns;
            (if far { earliest } else { stamp.nanos() }, far)
        }
    }
}

fn saturate(nanos: i64) -> i32 {
    nanos.clamp(i32::MIN.into(), i32::MAX.into()) as i32
}

/// Which points are usable; `None` if all are, the common case.
fn usable(xyz: &[[f32; 3]]) -> (Option<Vec<bool>>, Dropped) {
    let mut dropped = Dropped::default();
    for point in xyz {
        if !point.iter().all(|c| c.is_finite()) {
            dropped.non_finite += 1;
        } else if *point == [0.0; 3] {
            dropped.zero_range += 1;
        }
    }
    if dropped.total() == 0 {
        return (None, dropped);
    }
    let keep = xyz.iter().map(|point| point.iter().all(|c| c.is_finite()) && *point != [0.0; 3]).collect();
    (Some(keep), dropped)
}

fn retain<T>(values: &mut Vec<T>, keep: &[bool]) {
    let mut flags = keep.iter();
    values.retain(|_| flags.next().copied().unwrap_or(false));
}

/// Type as which a column can be read; floats round towards zero, integers saturate.
pub(crate) trait FromNumber: Clone {
    fn from_i64(value: i64) -> Self;
    fn from_f64(value: f64) -> Self;
    /// Apart from `from_f64` so that f32 keeps its very bits, NaN included.
    fn from_f32(value: f32) -> Self;
}

macro_rules! from_number {
    ($($type:ty: $i:ident => $from_int:expr),*) => {$(
        impl FromNumber for $type {
            fn from_i64($i: i64) -> Self {
                $from_int
            }
            fn from_f64(value: f64) -> Self {
                value as $type
            }
            fn from_f32(value: f32) -> Self {
                value as $type
            }
        }
    )*};
}

from_number!(
    f32: v => v as f32,
    f64: v => v as f64,
    i64: v => v,
    u16: v => v.clamp(0, u16::MAX.into()) as u16
);

#[cfg(test)]
#[path = "point_table_tests.rs"]
mod tests;
