//! KITTI's `.bin` scans: rows of x, y, z, intensity as little-endian f32, without a header.

use crate::{FormatError, PointField, PointTable, ScalarType, texts};

/// Reads a whole `.bin` file.
///
/// # Errors
/// When its length is not a whole number of points.
pub fn read(bytes: &[u8]) -> Result<PointTable<'_>, FormatError> {
    const STEP: usize = 16;
    if !bytes.len().is_multiple_of(STEP) {
        return Err(FormatError::Truncated {
            what: texts::KITTI_SCAN,
            at: (bytes.len() - bytes.len() % STEP) as u64,
            missing: (STEP - bytes.len() % STEP) as u64,
        });
    }
    let field = |(i, name): (usize, &&str)| PointField {
        name: (*name).into(),
        offset: 4 * i,
        scalar: ScalarType::F32,
        count: 1,
    };
    let fields = ["x", "y", "z", "intensity"].iter().enumerate().map(field).collect();
    PointTable::new(fields, STEP, bytes.len() / STEP, false, bytes.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_points_and_a_partial_row_is_an_error() {
        let bytes: Vec<u8> = [1.0f32, 2.0, 3.0, 0.5].iter().flat_map(|v| v.to_le_bytes()).collect();
        let (scan, _) = read(&bytes).unwrap().to_scan(None).unwrap();
        assert_eq!((scan.xyz, scan.intensity), (vec![[1.0, 2.0, 3.0]], vec![0.5]));
        assert!(read(&bytes[..15]).is_err());
    }
}
