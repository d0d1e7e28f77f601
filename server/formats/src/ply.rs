//! PLY point clouds: ascii and binary of both byte orders, any scalar properties; writing binary little-endian.
//!
//! Source: G. Turk, "The PLY Polygon File Format", 1994.

use crate::pcd::push_ascii;
use crate::{FormatError, PointField, PointTable, ScalarType, texts};
use std::io::{self, Write};

const WHAT: &str = "PLY file";
/// Bytes of rows that are collected before they are written.
const WRITE_BUFFER_BYTES: usize = 1 << 16;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Body {
    Ascii,
    LittleEndian,
    BigEndian,
}

struct Element {
    name: String,
    count: usize,
    fields: Vec<PointField>,
    step: usize,
    /// Lists have no fixed size.
    has_list: bool,
}

/// Whether a file that starts with these bytes is a PLY file.
pub fn is_ply(start: &[u8]) -> bool {
    start.starts_with(b"ply\n") || start.starts_with(b"ply\r\n")
}

/// Reads the vertices of a whole PLY file.
///
/// # Errors
/// When it is not a PLY file, contradicts itself, or holds fewer vertices than it states.
pub fn read(bytes: &[u8]) -> Result<PointTable<'_>, FormatError> {
    let (body, elements, end, lines) = read_header(bytes)?;
    let Some(position) = elements.iter().position(|element| element.name == "vertex") else {
        return Err(FormatError::at_line(WHAT, lines, texts::NO_VERTICES));
    };
    let (before, vertex) = (&elements[..position], &elements[position]);
    if vertex.has_list || before.iter().any(|element| element.has_list) {
        return Err(FormatError::Unsupported {
            what: texts::PLY_LIST_BEFORE_VERTICES.into(),
            remedy: texts::SAVE_VERTICES_FIRST,
        });
    }
    let fields = vertex.fields.clone();
    let data = &bytes[end..];
    if body == Body::Ascii {
        let skip = before.iter().fold(0usize, |sum, element| sum.saturating_add(element.count));
        let rows = read_ascii(data, vertex, skip, lines)?;
        return PointTable::new(fields, vertex.step, vertex.count, false, rows.into());
    }
    let skip = before.iter().fold(0usize, |sum, e| sum.saturating_add(e.count.saturating_mul(e.step)));
    let Some(data) = data.get(skip..) else {
        return Err(FormatError::Truncated { what: WHAT, at: bytes.len() as u64, missing: 1 });
    };
    PointTable::new(fields, vertex.step, vertex.count, body == Body::BigEndian, data.into())
}

fn read_header(bytes: &[u8]) -> Result<(Body, Vec<Element>, usize, usize), FormatError> {
    if !is_ply(bytes) {
        let found = texts::NO_PLY_HEADER.into();
        return Err(FormatError::WrongKind { expected: "a PLY file", found });
    }
    let (mut end, mut lines) = (0, 0);
    let mut body = None;
    let mut elements: Vec<Element> = Vec::new();
    loop {
        let Some(length) = bytes[end..].iter().position(|byte| *byte == b'\n') else {
            return Err(FormatError::Truncated { what: WHAT, at: end as u64, missing: 1 });
        };
        let line = String::from_utf8_lossy(&bytes[end..end + length]).into_owned();
        (end, lines) = (end + length + 1, lines + 1);
        let problem = |text: String| FormatError::at_line(WHAT, lines, text);
        match line.split_whitespace().collect::<Vec<_>>().as_slice() {
            ["format", kind, ..] => {
                body = Some(match *kind {
                    "ascii" => Body::Ascii,
                    "binary_little_endian" => Body::LittleEndian,
                    "binary_big_endian" => Body::BigEndian,
                    other => return Err(problem(texts::unknown_ply_format(other))),
                });
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_| problem(texts::not_a_count(count)))?;
                elements.push(Element {
                    name: (*name).into(),
                    count,
                    fields: vec![],
                    step: 0,
                    has_list: false,
                });
            }
            ["property", rest @ ..] => {
                let Some(element) = elements.last_mut() else {
                    return Err(problem(texts::PROPERTY_BEFORE_ELEMENT.into()));
                };
                match rest {
                    ["list", ..] => element.has_list = true,
                    [kind, name] => {
                        let Some(scalar) = scalar_type(kind) else {
                            return Err(problem(texts::unknown_ply_type(kind)));
                        };
                        let offset = element.step;
                        element.fields.push(PointField { name: (*name).into(), offset, scalar, count: 1 });
                        element.step += scalar.size();
                    }
                    _ => return Err(problem(texts::PROPERTY_INCOMPLETE.into())),
                }
            }
            ["end_header"] => {
                let Some(body) = body else { return Err(problem(texts::NO_PLY_FORMAT.into())) };
                return Ok((body, elements, end, lines));
            }
            // "ply", "comment", "obj_info" and blank lines.
            _ => {}
        }
    }
}

fn scalar_type(name: &str) -> Option<ScalarType> {
    Some(match name {
        "char" | "int8" => ScalarType::I8,
        "uchar" | "uint8" => ScalarType::U8,
        "short" | "int16" => ScalarType::I16,
        "ushort" | "uint16" => ScalarType::U16,
        "int" | "int32" => ScalarType::I32,
        "uint" | "uint32" => ScalarType::U32,
        "float" | "float32" => ScalarType::F32,
        "double" | "float64" => ScalarType::F64,
        _ => return None,
    })
}

fn read_ascii(data: &[u8], vertex: &Element, skip: usize, header: usize) -> Result<Vec<u8>, FormatError> {
    let text = String::from_utf8_lossy(data);
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()).skip(skip);
    let mut rows = Vec::new();
    for done in 0..vertex.count {
        let Some((index, line)) = lines.next() else {
            let problem = texts::too_few_vertices(vertex.count, done);
            return Err(FormatError::at_line(WHAT, header + text.lines().count(), problem));
        };
        let mut words = line.split_whitespace();
        for field in &vertex.fields {
            words.next().and_then(|word| push_ascii(&mut rows, field.scalar, word)).ok_or_else(|| {
                let problem = texts::value_missing_or_no_number(&field.name);
                FormatError::at_line(WHAT, header + index + 1, problem)
            })?;
        }
    }
    Ok(rows)
}

/// Writes points (metres) as binary PLY with `x y z` and, if given for every point, `intensity`.
///
/// # Errors
/// When `out` fails.
pub fn write(out: &mut impl Write, xyz: &[[f32; 3]], intensity: &[f32]) -> io::Result<()> {
    let with_intensity = intensity.len() == xyz.len() && !xyz.is_empty();
    write_header(out, xyz.len(), with_intensity)?;
    let mut rows = Vec::with_capacity(WRITE_BUFFER_BYTES);
    for (i, point) in xyz.iter().enumerate() {
        rows.extend(point.iter().flat_map(|c| c.to_le_bytes()));
        if with_intensity {
            rows.extend(intensity[i].to_le_bytes());
        }
        // A map has many points; they must not be in memory twice.
        if rows.len() > WRITE_BUFFER_BYTES {
            out.write_all(&rows)?;
            rows.clear();
        }
    }
    out.write_all(&rows)
}

/// Writes the header of a binary PLY. `count` rows of little-endian f32 must follow: `x y z`, and `intensity` if `with_intensity`. For clouds
/// that are too large for the memory.
///
/// # Errors
/// When `out` fails.
pub fn write_header(out: &mut impl Write, count: usize, with_intensity: bool) -> io::Result<()> {
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {count}\nproperty float x\nproperty float y\n\
         property float z\n{}end_header\n",
        if with_intensity { "property float intensity\n" } else { "" }
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "element other 1\nproperty uchar a\nelement vertex 2\nproperty double x\n\
                          property float y\nproperty float z\nproperty ushort ring\nelement face 0\n\
                          property list uchar int vertex_indices\nend_header\n";

    #[test]
    fn ascii_and_both_byte_orders_agree() {
        let points = [(1.0f64, 2.0f32, 3.0f32, 4u16), (-1.5, 0.25, 9.0, 31)];
        let ascii = format!("ply\nformat ascii 1.0\n{HEADER}7\n1 2 3 4\n-1.5 0.25 9 31\n").into_bytes();
        let mut little = format!("ply\nformat binary_little_endian 1.0\n{HEADER}").into_bytes();
        let mut big = format!("ply\nformat binary_big_endian 1.0\n{HEADER}").into_bytes();
        little.push(7);
        big.push(7);
        for (x, y, z, ring) in points {
            little.extend(
                [&x.to_le_bytes()[..], &y.to_le_bytes(), &z.to_le_bytes(), &ring.to_le_bytes()].concat(),
            );
            big.extend(
                [&x.to_be_bytes()[..], &y.to_be_bytes(), &z.to_be_bytes(), &ring.to_be_bytes()].concat(),
            );
        }
        for file in [ascii, little, big] {
            let (scan, _) = read(&file).unwrap().to_scan(None).unwrap();
            assert_eq!(scan.xyz, [[1.0, 2.0, 3.0], [-1.5, 0.25, 9.0]]);
            assert_eq!(scan.ring, [4, 31]);
            for cut in 0..file.len() {
                let _ = read(&file[..cut]);
            }
        }
    }

    #[test]
    fn what_is_written_is_read() {
        let mut file = Vec::new();
        write(&mut file, &[[1.0, 2.0, 3.0]], &[0.5]).unwrap();
        let (scan, _) = read(&file).unwrap().to_scan(None).unwrap();
        assert_eq!((scan.xyz, scan.intensity), (vec![[1.0, 2.0, 3.0]], vec![0.5]));
    }

    #[test]
    fn absurd_headers_are_refused_without_allocating() {
        for count in ["18446744073709551615", "99999999999999999999", "4000000000", "-1"] {
            for format in ["ascii", "binary_little_endian"] {
                let file = format!(
                    "ply\nformat {format} 1.0\nelement vertex {count}\nproperty float x\nend_header\n"
                );
                assert!(read(file.as_bytes()).is_err(), "{count} {format}");
            }
        }
        assert!(read(b"ply\nformat ascii 1.0\nelement vertex 9\nend_header\n").is_err(), "no properties");
    }
}
