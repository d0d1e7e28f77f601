//! PNG files with one channel of 16 bits, which a browser's own decoder reduces to 8: the pixels, but for the decompression.

/// A picture as it is in the file.
pub(crate) struct Png16 {
    /// Columns and rows.
    pub(crate) size: [usize; 2],
    /// A zlib stream.
    pub(crate) compressed: Vec<u8>,
}

/// Parameters of pictures of 16 bits.
struct Png16Config {
    /// Greatest number of pixels, so that a picture takes at most 32 MB once it is unpacked. Chosen: more than any thermal camera has.
    max_pixels: usize,
}

const CONFIG: Png16Config = Png16Config { max_pixels: 16 << 20 };

const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";
/// Bytes of a pixel.
const PIXEL: usize = 2;

/// Reads the chunks. None unless the file is a grey PNG of 16 bits without interlacing.
pub(crate) fn parse(file: &[u8]) -> Option<Png16> {
    let mut rest = file.strip_prefix(SIGNATURE)?;
    let mut size = None;
    let mut compressed = Vec::new();
    while let Some((head, after)) = rest.split_at_checked(8) {
        let length = u32::from_be_bytes(head[..4].try_into().ok()?) as usize;
        let content = after.get(..length)?;
        match &head[4..] {
            b"IHDR" => {
                let (sides, form) = content.split_at_checked(8)?;
                // Bits a sample, colour type, compression, filter, interlacing.
                if form != [16, 0, 0, 0, 0] {
                    return None;
                }
                let side = |at: usize| Some(u32::from_be_bytes(sides[at..at + 4].try_into().ok()?) as usize);
                size = Some([side(0)?, side(4)?]);
            }
            b"IDAT" => compressed.extend_from_slice(content),
            _ => {}
        }
        // A checksum follows.
        rest = after.get(length + 4..)?;
    }
    let size = size?;
    let pixels = size[0].checked_mul(size[1])?;
    (0 < pixels && pixels <= CONFIG.max_pixels).then_some(Png16 { size, compressed })
}

/// The values of the pixels from the decompressed rows, each of which begins with the kind of its filter.
pub(crate) fn unfilter(picture: &Png16, rows: Vec<u8>) -> Option<Vec<u16>> {
    let [columns, row_count] = picture.size;
    let width = columns * PIXEL;
    let mut above = vec![0_u8; width];
    let mut values = Vec::with_capacity(columns * row_count);
    if rows.len() < row_count * (width + 1) {
        return None;
    }
    for row in rows.chunks_exact(width + 1).take(row_count) {
        let mut row_bytes = row[1..].to_vec();
        for at in 0..width {
            let left = if at >= PIXEL { row_bytes[at - PIXEL] } else { 0 };
            let up = above[at];
            let up_left = if at >= PIXEL { above[at - PIXEL] } else { 0 };
            let predicted = match row[0] {
                0 => 0,
                1 => left,
                2 => up,
                3 => ((u16::from(left) + u16::from(up)) / 2) as u8,
                4 => paeth(left, up, up_left),
                _ => return None,
            };
            row_bytes[at] = row_bytes[at].wrapping_add(predicted);
        }
        values.extend(row_bytes.chunks_exact(PIXEL).map(|pair| u16::from_be_bytes([pair[0], pair[1]])));
        above = row_bytes;
    }
    Some(values)
}

/// The neighbour that is nearest to `left + up - up_left`.
fn paeth(left: u8, up: u8, up_left: u8) -> u8 {
    let [a, b, c] = [left, up, up_left].map(i16::from);
    let estimate = a + b - c;
    let [to_a, to_b, to_c] = [a, b, c].map(|value| (estimate - value).abs());
    if to_a <= to_b && to_a <= to_c {
        left
    } else if to_b <= to_c {
        up
    } else {
        up_left
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(form: [u8; 5]) -> Vec<u8> {
        let mut file = SIGNATURE.to_vec();
        let mut chunk = |kind: &[u8], content: &[u8]| {
            file.extend((content.len() as u32).to_be_bytes());
            file.extend(kind);
            file.extend(content);
            file.extend([0; 4]);
        };
        chunk(b"IHDR", &[&[0, 0, 0, 2, 0, 0, 0, 5][..], &form].concat());
        chunk(b"IDAT", &[1, 2]);
        chunk(b"tEXt", &[9]);
        chunk(b"IDAT", &[3]);
        chunk(b"IEND", &[]);
        file
    }

    #[test]
    fn chunks_are_joined_and_other_forms_refused() {
        let picture = parse(&file([16, 0, 0, 0, 0])).unwrap();
        assert_eq!((picture.size, picture.compressed), ([2, 5], vec![1, 2, 3]));
        assert!(parse(&file([8, 0, 0, 0, 0])).is_none());
        assert!(parse(&file([16, 2, 0, 0, 0])).is_none());
        assert!(parse(&file([16, 0, 0, 0, 1])).is_none());
        assert!(parse(b"GIF89a").is_none());
        for length in 0..file([16, 0, 0, 0, 0]).len() {
            // Nothing panics, whatever is missing.
            let _ = parse(&file([16, 0, 0, 0, 0])[..length]);
        }
    }

    #[test]
    fn every_filter_is_taken_back() {
        let picture = Png16 { size: [2, 5], compressed: Vec::new() };
        #[rustfmt::skip]
        let rows = vec![
            0, 1, 0, 2, 5,
            1, 1, 1, 1, 1,
            2, 1, 1, 1, 1,
            3, 1, 1, 1, 1,
            4, 1, 1, 1, 1,
        ];
        let values = unfilter(&picture, rows.clone()).unwrap();
        // By the formulas of the standard: left, above, their mean, Paeth.
        let expected: [[u16; 2]; 5] =
            [[0x0100, 0x0205], [0x0101, 0x0202], [0x0202, 0x0303], [0x0202, 0x0303], [0x0303, 0x0404]];
        assert_eq!(values, expected.concat());
        assert!(unfilter(&picture, rows[..24].to_vec()).is_none());
        assert!(unfilter(&picture, vec![7; 25]).is_none());
    }
}
