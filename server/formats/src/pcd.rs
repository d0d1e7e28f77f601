//! PCD files of the Point Cloud Library: ascii, binary and binary_compressed, any fields; writing binary.
//!
//! Source: "The PCD (Point Cloud Data) file format", version 0.7, Point Cloud Library documentation.

use crate::limits::MAX_UNPACKED_BYTES;
use crate::{FormatError, PointField, PointTable, ScalarType, lzf, texts};
use std::borrow::Cow;
use std::io::{self, Write};

const WHAT: &str = "PCD file";
/// Longest point that is read, bytes. A larger size in the header is damage.
const MAX_POINT_BYTES: usize = 1 << 20;
/// Bytes at the start of a file that are searched for the first lines of the header.
const MAGIC_BYTES: usize = 256;

/// The header of a PCD file.
struct Header {
    fields: Vec<PointField>,
    point_step: usize,
    points: usize,
    /// Columns and rows, if their product is the number of points; else one row.
    grid: [usize; 2],
    data: DataKind,
    /// Byte offset of the first byte after the header.
    end: usize,
    /// Number of lines in the header.
    lines: usize,
}

enum DataKind {
    Ascii,
    Binary,
    Compressed,
}

/// Reads a whole PCD file.
///
/// # Errors
/// When it is not a PCD file, contradicts itself, or holds fewer points than it states.
pub fn read(bytes: &[u8]) -> Result<PointTable<'_>, FormatError> {
    let header = read_header(bytes)?;
    let body = &bytes[header.end..];
    match header.data {
        DataKind::Binary => table(header, body.into()),
        DataKind::Compressed => read_compressed(header, body),
        DataKind::Ascii => read_ascii(header, body),
    }
}

/// Whether a file that starts with these bytes is a PCD file.
pub fn is_pcd(start: &[u8]) -> bool {
    let text = start.get(..start.len().min(MAGIC_BYTES)).unwrap_or_default();
    let text = String::from_utf8_lossy(text);
    text.starts_with("# .PCD") || text.lines().take(3).any(|line| line.starts_with("VERSION"))
}

fn read_header(bytes: &[u8]) -> Result<Header, FormatError> {
    if !is_pcd(bytes) {
        return Err(FormatError::WrongKind { expected: "a PCD file", found: texts::NO_PCD_HEADER.into() });
    }
    let (mut names, mut sizes, mut kinds, mut counts) = (vec![], vec![], vec![], vec![]);
    let (mut width, mut height, mut points) = (None, None, None);
    let (mut end, mut lines) = (0, 0);
    loop {
        let Some(length) = bytes[end..].iter().position(|byte| *byte == b'\n') else {
            return Err(FormatError::Truncated { what: WHAT, at: end as u64, missing: 1 });
        };
        let line = String::from_utf8_lossy(&bytes[end..end + length]).into_owned();
        (end, lines) = (end + length + 1, lines + 1);
        let mut words = line.split_whitespace();
        let Some(key) = words.next() else { continue };
        let words: Vec<&str> = words.collect();
        let number = |word: &str| {
            word.parse::<usize>().map_err(|_| FormatError::at_line(WHAT, lines, texts::not_a_count(word)))
        };
        let numbers = || words.iter().map(|word| number(word)).collect::<Result<Vec<_>, _>>();
        let single = || number(words.first().copied().unwrap_or_default());
        match key {
            "FIELDS" | "COLUMNS" => names = words.iter().map(|word| (*word).to_owned()).collect(),
            "SIZE" => sizes = numbers()?,
            "TYPE" => kinds = words.iter().map(|word| (*word).to_owned()).collect(),
            "COUNT" => counts = numbers()?,
            "WIDTH" => width = Some(single()?),
            "HEIGHT" => height = Some(single()?),
            "POINTS" => points = Some(single()?),
            "DATA" => {
                let data = match words.first().copied() {
                    Some("ascii") => DataKind::Ascii,
                    Some("binary") => DataKind::Binary,
                    Some("binary_compressed") => DataKind::Compressed,
                    other => {
                        let problem = texts::unknown_data_kind(other.unwrap_or_default());
                        return Err(FormatError::at_line(WHAT, lines, problem));
                    }
                };
                let (fields, point_step) = lay_out(names, &sizes, &kinds, &counts, lines)?;
                let grid = width.map(|width| width.saturating_mul(height.unwrap_or(1)));
                let Some(points) = points.or(grid) else {
                    return Err(FormatError::at_line(WHAT, lines, texts::NO_PCD_SIZE));
                };
                let grid = [width.unwrap_or(points), height.unwrap_or(1)];
                let is_whole = grid[0].checked_mul(grid[1]) == Some(points);
                let grid = if is_whole { grid } else { [points, 1] };
                return Ok(Header { fields, point_step, points, grid, data, end, lines });
            }
            // Comments, VERSION and VIEWPOINT.
            _ => {}
        }
    }
}

fn lay_out(
    names: Vec<String>,
    sizes: &[usize],
    kinds: &[String],
    counts: &[usize],
    line: usize,
) -> Result<(Vec<PointField>, usize), FormatError> {
    let same_length = sizes.len() == names.len()
        && kinds.len() == names.len()
        && (counts.is_empty() || counts.len() == names.len());
    if names.is_empty() || !same_length {
        return Err(FormatError::at_line(WHAT, line, texts::PCD_COLUMNS_DIFFER));
    }
    let mut offset = 0usize;
    let mut fields = Vec::with_capacity(names.len());
    for (i, name) in names.into_iter().enumerate() {
        let Some(scalar) = scalar_type(&kinds[i], sizes[i]) else {
            let problem = texts::unknown_field_type(&name, &kinds[i], sizes[i]);
            return Err(FormatError::at_line(WHAT, line, problem));
        };
        let count = counts.get(i).copied().unwrap_or(1);
        if count == 0 {
            return Err(FormatError::at_line(WHAT, line, texts::field_without_values(&name)));
        }
        let end = scalar.size().checked_mul(count).and_then(|size| size.checked_add(offset));
        let Some(end) = end.filter(|end| *end <= MAX_POINT_BYTES) else {
            let problem = texts::absurd_field_count(&name, count);
            return Err(FormatError::at_line(WHAT, line, problem));
        };
        fields.push(PointField { name, offset, scalar, count });
        offset = end;
    }
    Ok((fields, offset))
}

fn scalar_type(kind: &str, size: usize) -> Option<ScalarType> {
    Some(match (kind, size) {
        ("I", 1) => ScalarType::I8,
        ("I", 2) => ScalarType::I16,
        ("I", 4) => ScalarType::I32,
        ("I", 8) => ScalarType::I64,
        ("U", 1) => ScalarType::U8,
        ("U", 2) => ScalarType::U16,
        ("U", 4) => ScalarType::U32,
        ("U", 8) => ScalarType::U64,
        ("F", 4) => ScalarType::F32,
        ("F", 8) => ScalarType::F64,
        _ => return None,
    })
}

/// Compressed data holds whole columns one after the other; rows are made of them.
fn read_compressed<'a>(header: Header, body: &[u8]) -> Result<PointTable<'a>, FormatError> {
    let Some((sizes, rest)) = body.split_first_chunk::<8>() else {
        return Err(FormatError::Truncated { what: WHAT, at: header.end as u64, missing: 8 });
    };
    let [c0, c1, c2, c3, u0, u1, u2, u3] = *sizes;
    let compressed = u32::from_le_bytes([c0, c1, c2, c3]) as usize;
    let unpacked = u32::from_le_bytes([u0, u1, u2, u3]) as usize;
    let Some(packed) = rest.get(..compressed) else {
        let missing = (compressed - rest.len()) as u64;
        return Err(FormatError::Truncated { what: WHAT, at: header.end as u64 + 8, missing });
    };
    if unpacked > MAX_UNPACKED_BYTES {
        let problem = texts::unpacks_to_too_much(unpacked, MAX_UNPACKED_BYTES);
        return Err(FormatError::at_byte(WHAT, header.end as u64, problem));
    }
    let columns = if unpacked == 0 { Vec::new() } else { lzf::decompress(packed, unpacked)? };
    if columns.len() < header.points.saturating_mul(header.point_step) {
        let problem = texts::data_ends_early(header.points);
        return Err(FormatError::at_byte(WHAT, header.end as u64, problem));
    }
    let mut rows = vec![0; header.points * header.point_step];
    let mut column_start = 0;
    for field in &header.fields {
        let size = field.scalar.size() * field.count;
        for (i, row) in rows.chunks_exact_mut(header.point_step).enumerate() {
            let from = column_start + i * size;
            row[field.offset..field.offset + size].copy_from_slice(&columns[from..from + size]);
        }
        column_start += size * header.points;
    }
    table(header, rows.into())
}

/// The points of a file, in its grid.
fn table(header: Header, data: Cow<'_, [u8]>) -> Result<PointTable<'_>, FormatError> {
    let [width, height] = header.grid;
    let row_step = header.point_step.saturating_mul(width);
    PointTable::organised(header.fields, header.point_step, row_step, width, height, false, data)
}

fn read_ascii<'a>(header: Header, body: &[u8]) -> Result<PointTable<'a>, FormatError> {
    let text = String::from_utf8_lossy(body);
    let mut rows = Vec::new();
    let mut count = 0;
    for (i, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        if count == header.points {
            break;
        }
        let number = header.lines + i + 1;
        let mut words = line.split_whitespace();
        for field in &header.fields {
            for _ in 0..field.count {
                let word = words
                    .next()
                    .ok_or_else(|| FormatError::at_line(WHAT, number, texts::value_missing(&field.name)))?;
                push_ascii(&mut rows, field.scalar, word).ok_or_else(|| {
                    let problem = texts::not_a_value(word, &field.name);
                    FormatError::at_line(WHAT, number, problem)
                })?;
            }
        }
        count += 1;
    }
    if count < header.points {
        let problem = texts::too_few_points(header.points, count);
        return Err(FormatError::at_line(WHAT, header.lines + count, problem));
    }
    table(header, rows.into())
}

/// Appends the little-endian bytes of a number in text. Integers may be written as floats.
pub(crate) fn push_ascii(out: &mut Vec<u8>, scalar: ScalarType, word: &str) -> Option<()> {
    macro_rules! integer {
        ($type:ty) => {
            out.extend(
                word.parse::<$type>()
                    .ok()
                    .or_else(|| word.parse::<f64>().ok().map(|v| v as $type))?
                    .to_le_bytes(),
            )
        };
    }
    match scalar {
        ScalarType::I8 => integer!(i8),
        ScalarType::U8 => integer!(u8),
        ScalarType::I16 => integer!(i16),
        ScalarType::U16 => integer!(u16),
        ScalarType::I32 => integer!(i32),
        ScalarType::U32 => integer!(u32),
        ScalarType::I64 => integer!(i64),
        ScalarType::U64 => integer!(u64),
        ScalarType::F32 => out.extend(word.parse::<f32>().ok()?.to_le_bytes()),
        ScalarType::F64 => out.extend(word.parse::<f64>().ok()?.to_le_bytes()),
    }
    Some(())
}

/// Position of the sensor in the frame of the points, metres; none if the file does not have it.
pub fn viewpoint(bytes: &[u8]) -> Option<[f32; 3]> {
    let header = &bytes[..read_header(bytes).ok()?.end];
    let text = String::from_utf8_lossy(header);
    let mut words = text.lines().find_map(|line| line.strip_prefix("VIEWPOINT"))?.split_whitespace();
    let mut coordinate = || words.next()?.parse().ok().filter(|c: &f32| c.is_finite());
    Some([coordinate()?, coordinate()?, coordinate()?])
}

/// Writes points (metres) seen from `viewpoint` as binary PCD with `x y z` and, if given for every point, `intensity`.
///
/// # Errors
/// When `out` fails.
pub fn write(
    out: &mut impl Write,
    viewpoint: [f32; 3],
    xyz: &[[f32; 3]],
    intensity: &[f32],
) -> io::Result<()> {
    let with_intensity = intensity.len() == xyz.len() && !xyz.is_empty();
    let (names, columns) = if with_intensity { ("x y z intensity", 4) } else { ("x y z", 3) };
    let repeat = |word: &str| vec![word; columns].join(" ");
    let [x, y, z] = viewpoint;
    write!(
        out,
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS {names}\nSIZE {}\nTYPE {}\nCOUNT {}\n\
         WIDTH {count}\nHEIGHT 1\nVIEWPOINT {x} {y} {z} 1 0 0 0\nPOINTS {count}\nDATA binary\n",
        repeat("4"),
        repeat("F"),
        repeat("1"),
        count = xyz.len(),
    )?;
    let mut rows = Vec::with_capacity(xyz.len() * columns * 4);
    for (i, point) in xyz.iter().enumerate() {
        rows.extend(point.iter().flat_map(|c| c.to_le_bytes()));
        if with_intensity {
            rows.extend(intensity[i].to_le_bytes());
        }
    }
    out.write_all(&rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(points: &str, data: &str) -> String {
        format!(
            "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z ring\nSIZE 4 4 4 2\nTYPE F F F U\nCOUNT 1 1 1 1\n\
             WIDTH {points}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {points}\nDATA {data}\n"
        )
    }

    #[test]
    fn ascii_binary_and_compressed_agree() {
        let points = [([1.0f32, 2.0, 3.0], 4u16), ([-1.5, 0.25, 9.0], 31)];
        let ascii = header("2", "ascii") + "1 2 3 4\n-1.5 0.25 9 31\n";
        let mut binary = header("2", "binary").into_bytes();
        let mut columns = Vec::new();
        for axis in 0..3 {
            columns.extend(points.iter().flat_map(|(xyz, _)| xyz[axis].to_le_bytes()));
        }
        columns.extend(points.iter().flat_map(|(_, ring)| ring.to_le_bytes()));
        for (xyz, ring) in points {
            binary.extend(xyz.iter().flat_map(|c| c.to_le_bytes()));
            binary.extend(ring.to_le_bytes());
        }
        // One literal run: LZF needs no references to be valid.
        let mut packed = vec![columns.len() as u8 - 1];
        packed.extend(&columns);
        let mut compressed = header("2", "binary_compressed").into_bytes();
        compressed.extend((packed.len() as u32).to_le_bytes());
        compressed.extend((columns.len() as u32).to_le_bytes());
        compressed.extend(packed);
        for file in [ascii.as_bytes(), &binary, &compressed] {
            let (scan, _) = read(file).unwrap().to_scan(None).unwrap();
            assert_eq!(scan.xyz, points.map(|(xyz, _)| xyz));
            assert_eq!(scan.ring, [4, 31]);
            for cut in 0..file.len() {
                // A cut ascii number may still be a number; anything else is an error. Nothing panics.
                let _ = read(&file[..cut]);
            }
        }
    }

    #[test]
    fn what_is_written_is_read() {
        let mut file = Vec::new();
        write(&mut file, [0.1, -0.2, 0.3], &[[1.0, 2.0, 3.0]], &[0.5]).unwrap();
        assert_eq!(viewpoint(&file), Some([0.1, -0.2, 0.3]));
        assert_eq!(
            viewpoint(header("1", "ascii").replace("VIEWPOINT 0 0 0", "VIEWPOINT 0 nan").as_bytes()),
            None
        );
        let (scan, _) = read(&file).unwrap().to_scan(None).unwrap();
        assert_eq!((scan.xyz, scan.intensity), (vec![[1.0, 2.0, 3.0]], vec![0.5]));
    }

    #[test]
    fn absurd_headers_are_refused_without_allocating() {
        for points in ["99999999999999999999", "18446744073709551615", "4000000000", "-1"] {
            for data in ["ascii", "binary", "binary_compressed"] {
                assert!(read(header(points, data).as_bytes()).is_err(), "{points} {data}");
            }
        }
        assert!(read(b"").is_err());
        for data in ["ascii", "binary", "binary_compressed"] {
            let file = header("1", data).replace("COUNT 1 1 1 1", "COUNT 0 0 0 0") + "\0\0\0\0\0\0\0\0";
            assert!(read(file.as_bytes()).is_err(), "fields without values, {data}");
        }
        assert!(read(header("1", "binary_xz").as_bytes()).is_err());
    }
}
