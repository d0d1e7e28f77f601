//! Reads JPEG, PNG and BMP files. The content says which of them a file is, because names are often wrong.

mod bmp;
mod texts;

use crate::failure::Failure;
use bmp::{BmpError, Pixels};
use gauges::Picture;
use std::fs;
use std::io::Cursor;
use std::path::Path;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// Which pictures are read.
#[derive(Clone, Copy, Debug)]
struct PictureFileConfig {
    /// Largest width and height, pixels. Chosen: more than any camera, and less than what fills the memory.
    max_side_px: usize,
    /// Most bytes that a PNG file may unpack to. Chosen: 16,384 x 16,384 pixels of four bytes.
    max_png_bytes: usize,
}

const CONFIG: PictureFileConfig = PictureFileConfig { max_side_px: 16_384, max_png_bytes: 1 << 30 };

/// Reads a picture.
pub fn read(path: &Path) -> Result<Picture, Failure> {
    let bytes = fs::read(path).map_err(|error| Failure::unreadable(path, error))?;
    let (size_px, pixels) = if bytes.starts_with(&[0xff, 0xd8]) {
        read_jpeg(path, &bytes)?
    } else if bytes.starts_with(b"\x89PNG") {
        read_png(path, &bytes)?
    } else if bytes.starts_with(b"BM") {
        bmp::read(&bytes, CONFIG.max_side_px as u32).map_err(|error| match error {
            BmpError::CutShort => Failure::usage(texts::picture_cut_short(path)),
            BmpError::OtherKind => Failure::usage(texts::other_bmp(path)),
        })?
    } else {
        return Err(Failure::usage(texts::no_picture(path)));
    };
    Picture::new(size_px, pixels).map_err(|error| Failure::usage(texts::damaged_picture(path, &error)))
}

fn read_jpeg(path: &Path, bytes: &[u8]) -> Result<Pixels, Failure> {
    // The mark of the end. Decoders fill what is missing before it with grey.
    if !bytes.windows(2).any(|pair| pair == [0xff, 0xd9]) {
        return Err(Failure::usage(texts::picture_cut_short(path)));
    }
    let options = DecoderOptions::default()
        .set_strict_mode(true)
        .set_max_width(CONFIG.max_side_px)
        .set_max_height(CONFIG.max_side_px)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(Cursor::new(bytes), options);
    let damaged = |error: &dyn std::fmt::Display| Failure::usage(texts::damaged_picture(path, error));
    let colours = decoder.decode().map_err(|error| damaged(&error))?;
    let (width, height) = decoder.dimensions().ok_or_else(|| damaged(&texts::NO_SIZE))?;
    Ok(([width, height], colours.chunks_exact(3).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()))
}

fn read_png(path: &Path, bytes: &[u8]) -> Result<Pixels, Failure> {
    let damaged = |error: &dyn std::fmt::Display| Failure::usage(texts::damaged_picture(path, error));
    let mut decoder =
        png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: CONFIG.max_png_bytes });
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(|error| damaged(&error))?;
    let size = reader.output_buffer_size().filter(|size| *size <= CONFIG.max_png_bytes);
    let mut buffer = vec![0; size.ok_or_else(|| damaged(&texts::TOO_LARGE))?];
    let frame = reader.next_frame(&mut buffer).map_err(|error| damaged(&error))?;
    let samples = frame.color_type.samples();
    let colour = |pixel: &[u8]| match *pixel {
        [red, green, blue, ..] => [red, green, blue],
        [grey, ..] => [grey; 3],
        [] => [0; 3],
    };
    let pixels = buffer[..frame.buffer_size()].chunks_exact(samples).map(colour).collect();
    Ok(([frame.width as usize, frame.height as usize], pixels))
}
