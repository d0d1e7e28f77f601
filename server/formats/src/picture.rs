//! Pictures in JPEG, PNG and BMP files. The content says which of them a file is, because names are often wrong.

mod bmp;
mod jpeg_sampling;

use crate::texts;
use bmp::{BmpError, Pixels};
use std::fmt::Display;
use std::io::Cursor;
use vocab::legible;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// Which pictures are read.
#[derive(Clone, Copy, Debug)]
struct PictureConfig {
    /// Largest width and height, pixels. Chosen: more than any camera, and less than what fills the memory.
    max_side_px: usize,
    /// Pixels of a JPEG file for each of its bytes, at most. Source: a block of 64 pixels takes a bit or more (ITU-T T.81). What a header promises beyond that is not reserved.
    max_jpeg_pixels_per_byte: usize,
    /// Bytes that each byte of a PNG file unpacks to, at most. Source: Deflate (RFC 1951) has a limit of 1,032; chosen: a little more.
    max_png_expansion: usize,
    /// Bytes that a PNG file of any length may unpack to, and that its decoder may take. Chosen: what a decoder needs for itself, 32 kB for the window of Deflate, twice.
    max_png_start_bytes: usize,
    /// Longest reason of a decoder in a sentence, characters. Chosen: a line.
    max_reason_chars: usize,
}

const CONFIG: PictureConfig = PictureConfig {
    max_side_px: 16_384,
    max_jpeg_pixels_per_byte: 512,
    max_png_expansion: 1_100,
    max_png_start_bytes: 1 << 16,
    max_reason_chars: 160,
};

/// A picture: red, green and blue of each pixel, row by row from the top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DecodedPicture {
    /// Width and height, pixels; as many pixels as both say.
    pub size_px: [usize; 2],
    /// The pixels.
    pub pixels: Vec<[u8; 3]>,
}

/// Why a file is no picture.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PictureFileError {
    /// It is of another format.
    #[error("{}", texts::NO_PICTURE)]
    OtherFormat,
    /// It ends before the picture does.
    #[error("{}", texts::PICTURE_CUT_SHORT)]
    CutShort,
    /// A BMP file of a kind that is not read.
    #[error("{}", texts::OTHER_BMP)]
    OtherBmp,
    /// It cannot be decoded: a clause that says why.
    #[error("{0}")]
    Damaged(String),
}

/// Reads a picture from the bytes of its file. Memory follows the bytes that there are, not those that a header promises.
///
/// # Errors
/// When it is no picture, cut short or damaged.
pub fn read(bytes: &[u8]) -> Result<DecodedPicture, PictureFileError> {
    let (size_px, pixels) = if bytes.starts_with(&[0xff, 0xd8]) {
        read_jpeg(bytes)?
    } else if bytes.starts_with(b"\x89PNG") {
        read_png(bytes)?
    } else if bytes.starts_with(b"BM") {
        bmp::read(bytes, CONFIG.max_side_px as u32).map_err(|error| match error {
            BmpError::CutShort => PictureFileError::CutShort,
            BmpError::OtherKind => PictureFileError::OtherBmp,
        })?
    } else {
        return Err(PictureFileError::OtherFormat);
    };
    if size_px.contains(&0) || size_px[0].checked_mul(size_px[1]) != Some(pixels.len()) {
        return Err(damaged(&texts::NO_PICTURE_SIZE));
    }
    Ok(DecodedPicture { size_px, pixels })
}

fn damaged(reason: &dyn Display) -> PictureFileError {
    PictureFileError::Damaged(legible(&reason.to_string(), CONFIG.max_reason_chars))
}

fn read_jpeg(bytes: &[u8]) -> Result<Pixels, PictureFileError> {
    // The mark of the end. Decoders fill what is missing before it with grey.
    if !bytes.windows(2).any(|pair| pair == [0xff, 0xd9]) {
        return Err(PictureFileError::CutShort);
    }
    if !jpeg_sampling::is_common(bytes) {
        return Err(damaged(&texts::OTHER_SAMPLING));
    }
    let options = DecoderOptions::default()
        .set_strict_mode(true)
        .set_max_width(CONFIG.max_side_px)
        .set_max_height(CONFIG.max_side_px)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(Cursor::new(bytes), options);
    decoder.decode_headers().map_err(|error| damaged(&error))?;
    let (width, height) = decoder.dimensions().ok_or_else(|| damaged(&texts::NO_PICTURE_SIZE))?;
    let pixels = width.saturating_mul(height);
    if pixels > bytes.len().saturating_mul(CONFIG.max_jpeg_pixels_per_byte) {
        return Err(damaged(&texts::PICTURE_TOO_LARGE));
    }
    let colours = decoder.decode().map_err(|error| damaged(&error))?;
    Ok(([width, height], colours.chunks_exact(3).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()))
}

fn read_png(bytes: &[u8]) -> Result<Pixels, PictureFileError> {
    let most =
        CONFIG.max_png_start_bytes.saturating_add(bytes.len().saturating_mul(CONFIG.max_png_expansion));
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: most });
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(|error| damaged(&error))?;
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    let is_small = [width, height].iter().all(|side| *side <= CONFIG.max_side_px);
    let size = reader.output_buffer_size().filter(|size| is_small && *size <= most);
    let mut buffer = vec![0; size.ok_or_else(|| damaged(&texts::PICTURE_TOO_LARGE))?];
    let frame = reader.next_frame(&mut buffer).map_err(|error| damaged(&error))?;
    let samples = frame.color_type.samples();
    let colour = |pixel: &[u8]| match *pixel {
        [red, green, blue, ..] => [red, green, blue],
        [grey, ..] => [grey; 3],
        [] => [0; 3],
    };
    let used = buffer.get(..frame.buffer_size()).ok_or_else(|| damaged(&texts::NO_PICTURE_SIZE))?;
    Ok(([frame.width as usize, frame.height as usize], used.chunks_exact(samples).map(colour).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn png_of([width, height]: [u32; 2], pixels: &[u8]) -> Vec<u8> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.write_header().unwrap().write_image_data(pixels).unwrap();
        file
    }

    #[test]
    fn a_png_file_is_read_and_one_that_is_cut_is_damaged() {
        let file = png_of([2, 1], &[1, 2, 3, 4, 5, 6]);
        let picture = read(&file).unwrap();
        assert_eq!((picture.size_px, &picture.pixels[..]), ([2, 1], &[[1, 2, 3], [4, 5, 6]][..]));
        for length in 4..file.len() - 12 {
            let error = read(&file[..length]).unwrap_err();
            assert!(matches!(error, PictureFileError::Damaged(_)), "{length}: {error:?}");
        }
        assert_eq!(read(b"plain text"), Err(PictureFileError::OtherFormat));
        assert_eq!(read(b"\xff\xd8\xff"), Err(PictureFileError::CutShort));
    }

    #[test]
    fn a_header_that_promises_more_than_the_bytes_can_hold_reserves_nothing() {
        // The header says 16,000 x 16,000 pixels.
        let mut file = png_of([1, 1], &[0; 3]);
        file[16..24].copy_from_slice(&[0, 0, 0x3e, 0x80, 0, 0, 0x3e, 0x80]);
        let checksum = crc32(&file[12..29]);
        file[29..33].copy_from_slice(&checksum.to_be_bytes());
        assert!(matches!(read(&file), Err(PictureFileError::Damaged(_))));
        // Start of image, a frame of 16,000 x 16,000 pixels of one component, end of image.
        let jpeg = [
            &[0xff, 0xd8][..],
            &[0xff, 0xc0, 0, 11, 8, 0x3e, 0x80, 0x3e, 0x80, 1, 1, 0x11, 0],
            &[0xff, 0xda, 0, 8, 1, 1, 0, 0, 63, 0],
            &[0xff, 0xd9],
        ]
        .concat();
        assert!(matches!(read(&jpeg), Err(PictureFileError::Damaged(_))));
    }

    /// The checksum of PNG chunks.
    fn crc32(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(!0_u32, |sum, byte| {
            (0..8).fold(sum ^ u32::from(*byte), |sum, _| {
                if sum & 1 == 1 { (sum >> 1) ^ 0xedb8_8320 } else { sum >> 1 }
            })
        })
    }
}
