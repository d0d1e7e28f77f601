//! `sensor_msgs/PointCloud2`: reading any layout, writing the platform's own.

use super::standard::Header;
use crate::cdr::{CdrReader, Encoding, Writer};
use crate::{FormatError, PointField, PointTable, ScalarType, texts};
use messages::Scan;
use std::borrow::Cow;

/// Least bytes of a `sensor_msgs/PointField`: length of the name, offset, data type and count.
const MIN_FIELD_BYTES: usize = 4 + 4 + 1 + 4;

/// A point cloud message; the points stay where they are in the message's bytes.
#[derive(Clone, Debug, PartialEq)]
pub struct PointCloud2<'a> {
    /// When (usually the start of the sweep), and in which frame.
    pub header: Header,
    /// The points.
    pub table: PointTable<'a>,
}

impl<'a> PointCloud2<'a> {
    /// Package and name of the ROS type.
    pub const TYPE: &'static str = "sensor_msgs/PointCloud2";

    /// Reads a whole message.
    ///
    /// # Errors
    /// When it ends early, a field has an unknown type, or the sizes contradict each other.
    pub fn from_bytes(encoding: Encoding, bytes: &'a [u8]) -> Result<Self, FormatError> {
        let mut reader = CdrReader::new(encoding, bytes, Self::TYPE)?;
        let header = Header::read(&mut reader, encoding)?;
        let height = reader.u32()? as usize;
        let width = reader.u32()? as usize;
        let fields = reader.sequence(MIN_FIELD_BYTES, read_field)?;
        let big_endian = reader.bool()?;
        let point_step = reader.u32()? as usize;
        let row_step = reader.u32()? as usize;
        let data = Cow::Borrowed(reader.byte_sequence()?);
        let table = PointTable::organised(fields, point_step, row_step, width, height, big_endian, data)?;
        Ok(Self { header, table })
    }
}

fn read_field(reader: &mut CdrReader<'_>) -> Result<PointField, FormatError> {
    let name = reader.string()?;
    let offset = reader.u32()? as usize;
    let datatype = reader.u8()?;
    let count = reader.u32()? as usize;
    let Some(scalar) = scalar_type(datatype) else {
        return Err(reader.malformed(texts::unknown_ros_field_type(&name, datatype)));
    };
    // Some drivers write 0 instead of 1.
    Ok(PointField { name, offset, scalar, count: count.max(1) })
}

fn scalar_type(datatype: u8) -> Option<ScalarType> {
    const TYPES: [ScalarType; 8] = [
        ScalarType::I8,
        ScalarType::U8,
        ScalarType::I16,
        ScalarType::U16,
        ScalarType::I32,
        ScalarType::U32,
        ScalarType::F32,
        ScalarType::F64,
    ];
    TYPES.get(usize::from(datatype).checked_sub(1)?).copied()
}

// Data types of `sensor_msgs/PointField`.
const INT32: u8 = 5;
const UINT32: u8 = 6;
const UINT16: u8 = 4;
const FLOAT32: u8 = 7;

/// Appends a scan as PointCloud2: `x y z` (f32, m) and, where the scan has them, `intensity` (f32), `t` (ns after
/// the stamp; u32, or i32 where one is negative) and `ring` (u16). Columns of another length are left out.
pub fn write_scan(scan: &Scan, frame_id: &str, encoding: Encoding, out: &mut Vec<u8>) {
    let count = scan.xyz.len();
    let has = |length: usize| length == count && count > 0;
    let (intensity, offset, ring) =
        (has(scan.intensity.len()), has(scan.offset_ns.len()), has(scan.ring.len()));
    let time_type = if scan.offset_ns.iter().any(|t| *t < 0) { INT32 } else { UINT32 };
    let mut fields = vec![("x", FLOAT32, 4), ("y", FLOAT32, 4), ("z", FLOAT32, 4)];
    fields.extend(intensity.then_some(("intensity", FLOAT32, 4)));
    fields.extend(offset.then_some(("t", time_type, 4)));
    fields.extend(ring.then_some(("ring", UINT16, 2)));
    let step: usize = fields.iter().map(|(_, _, size)| size).sum();

    let mut writer = Writer::new(encoding, out);
    Header::write(scan.stamp, frame_id, &mut writer);
    writer.u32(1);
    writer.u32(count as u32);
    writer.u32(fields.len() as u32);
    let mut at = 0;
    for (name, datatype, size) in &fields {
        writer.string(name);
        writer.u32(at);
        writer.u8(*datatype);
        writer.u32(1);
        at += *size as u32;
    }
    writer.u8(0);
    writer.u32(step as u32);
    writer.u32((step * count) as u32);
    writer.byte_sequence(step * count, |out| {
        let start = out.len();
        out.resize(start + step * count, 0);
        let rows = &mut out[start..];
        put_column(rows, step, 0, &scan.xyz, |[x, y, z]| {
            let (x, y, z) = (x.to_le_bytes(), y.to_le_bytes(), z.to_le_bytes());
            [x[0], x[1], x[2], x[3], y[0], y[1], y[2], y[3], z[0], z[1], z[2], z[3]]
        });
        let mut at = 12;
        if intensity {
            put_column(rows, step, at, &scan.intensity, f32::to_le_bytes);
            at += 4;
        }
        if offset {
            put_column(rows, step, at, &scan.offset_ns, i32::to_le_bytes);
            at += 4;
        }
        if ring {
            put_column(rows, step, at, &scan.ring, u16::to_le_bytes);
        }
    });
    writer.u8(1);
}

fn put_column<T: Copy, const N: usize>(
    rows: &mut [u8],
    step: usize,
    at: usize,
    values: &[T],
    bytes: impl Fn(T) -> [u8; N],
) {
    for (row, value) in rows.chunks_exact_mut(step).zip(values) {
        row[at..at + N].copy_from_slice(&bytes(*value));
    }
}
