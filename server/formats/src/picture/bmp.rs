//! Reads BMP files without compression, as some cameras write them.
//!
//! Source: "Bitmap Storage" and `BITMAPINFOHEADER`, Windows GDI documentation. Rows begin at multiples of four bytes, the lowest row first unless the height is negative; a pixel is
//! blue, green, red.

/// Why a BMP file is not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BmpError {
    /// The file ends before its last row.
    CutShort,
    /// It has colours of another kind than 24 or 32 bits without compression, or no size.
    OtherKind,
}

/// Width, height, and the pixels row by row from the top left.
pub type Pixels = ([usize; 2], Vec<[u8; 3]>);

/// Reads a whole BMP file whose sides are at most this long, pixels.
///
/// # Errors
/// When the file is cut short or of another kind.
pub fn read(bytes: &[u8], max_side_px: u32) -> Result<Pixels, BmpError> {
    let number = |at: usize| {
        let field = bytes.get(at..at + 4).and_then(|field| field.try_into().ok());
        field.map(u32::from_le_bytes).ok_or(BmpError::CutShort)
    };
    let [start, width, height] = [number(10)?, number(18)?, number(22)?];
    let [planes_and_bits, compression] = [number(26)?, number(30)?];
    let rows = height.cast_signed();
    let bits = planes_and_bits >> 16;
    let is_known = (bits == 24 || bits == 32) && compression == 0;
    let has_size = [width, rows.unsigned_abs()].iter().all(|side| (1..=max_side_px).contains(side));
    if !is_known || !has_size {
        return Err(BmpError::OtherKind);
    }
    let (width, height) = (width as usize, rows.unsigned_abs() as usize);
    let pixel_bytes = bits as usize / 8;
    let row_bytes = (width * pixel_bytes).next_multiple_of(4);
    let data = bytes.get(start as usize..).ok_or(BmpError::CutShort)?;
    // The last row may lack its padding.
    if data.len() < row_bytes * (height - 1) + width * pixel_bytes {
        return Err(BmpError::CutShort);
    }
    let pixel = |row: usize, column: usize| {
        let stored = if rows < 0 { row } else { height - 1 - row };
        let at = stored * row_bytes + column * pixel_bytes;
        [data[at + 2], data[at + 1], data[at]]
    };
    let pixels = (0..height).flat_map(|row| (0..width).map(move |column| (row, column)));
    Ok(([width, height], pixels.map(|(row, column)| pixel(row, column)).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two columns and two rows: red, green above blue, white.
    fn file(height: i32) -> Vec<u8> {
        let mut bytes = b"BM".to_vec();
        for field in [70_u32, 0, 54, 40, 2] {
            bytes.extend(field.to_le_bytes());
        }
        bytes.extend(height.to_le_bytes());
        bytes.extend(1_u16.to_le_bytes());
        bytes.extend(24_u16.to_le_bytes());
        bytes.extend([0; 24]);
        let upper = [0, 0, 255, 0, 255, 0, 0, 0];
        let lower = [255, 0, 0, 255, 255, 255, 0, 0];
        bytes.extend(if height < 0 { [upper, lower] } else { [lower, upper] }.concat());
        bytes
    }

    #[test]
    fn pixels_come_from_the_top_left_whichever_row_is_first() {
        let expected = vec![[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255]];
        assert_eq!(read(&file(2), 100), Ok(([2, 2], expected.clone())));
        assert_eq!(read(&file(-2), 100), Ok(([2, 2], expected)));
    }

    #[test]
    fn what_is_cut_short_or_of_another_kind_is_refused() {
        let whole = file(2);
        for cut in 0..whole.len() - 2 {
            assert_eq!(read(&whole[..cut], 100), Err(BmpError::CutShort), "{cut}");
        }
        let mut other = whole.clone();
        other[28] = 8;
        assert_eq!(read(&other, 100), Err(BmpError::OtherKind));
        assert_eq!(read(&file(0), 100), Err(BmpError::OtherKind));
        assert_eq!(read(&file(i32::MIN), 100), Err(BmpError::OtherKind));
    }
}
