//! Points of the PLY files that the platform writes of objects.

/// Points, m, in the frame of the file.
pub(crate) type Points = Vec<[f32; 3]>;

/// The points of a binary PLY file, as the platform writes it: after the header, x, y and z of each point as little-endian floats. None for other files.
pub(crate) fn parse_ply(bytes: &[u8]) -> Option<Points> {
    const END: &[u8] = b"end_header\n";
    let header_bytes = bytes.windows(END.len()).position(|part| part == END)? + END.len();
    let header = std::str::from_utf8(&bytes[..header_bytes]).ok()?;
    if !header.contains("format binary_little_endian") {
        return None;
    }
    let properties: Vec<&str> = header.lines().filter_map(|line| line.strip_prefix("property ")).collect();
    let are_floats = properties.iter().all(|property| property.starts_with("float "));
    if !are_floats || properties.len() < 3 {
        return None;
    }
    let row_bytes = 4 * properties.len();
    let rows = bytes[header_bytes..].chunks_exact(row_bytes);
    let point = |row: &[u8]| -> Option<[f32; 3]> {
        let value = |axis: usize| Some(f32::from_le_bytes(row.get(4 * axis..4 * axis + 4)?.try_into().ok()?));
        Some([value(0)?, value(1)?, value(2)?]).filter(|point| point.iter().all(|at| at.is_finite()))
    };
    Some(rows.filter_map(point).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(header: &str, values: &[f32]) -> Vec<u8> {
        let bytes = values.iter().flat_map(|value| value.to_le_bytes());
        header.bytes().chain(bytes).collect()
    }

    #[test]
    fn points_are_read_with_and_without_intensity_and_other_files_are_not() {
        let start = "ply\nformat binary_little_endian 1.0\nelement vertex 2\n";
        let xyz = "property float x\nproperty float y\nproperty float z\n";
        let plain = file(&format!("{start}{xyz}end_header\n"), &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(parse_ply(&plain), Some(vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]));
        let with_intensity = format!("{start}{xyz}property float intensity\nend_header\n");
        let bytes = file(&with_intensity, &[1.0, 2.0, 3.0, 0.5, f32::NAN, 5.0, 6.0, 0.5, 7.0]);
        assert_eq!(parse_ply(&bytes), Some(vec![[1.0, 2.0, 3.0]]));
        for header in [
            "ply\nformat ascii 1.0\nproperty float x\nproperty float y\nproperty float z\nend_header\n",
            "ply\nformat binary_little_endian 1.0\nproperty double x\nend_header\n",
            "no header",
        ] {
            assert_eq!(parse_ply(&file(header, &[1.0; 6])), None, "{header}");
        }
    }
}
