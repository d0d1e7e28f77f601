//! Pictures as files: photos as JPEG, thermal pictures as PNG for people and as PNG of temperatures for programs.

use jpeg_encoder::{ColorType, Encoder};
use ports::ActionFile;
use sim::{CameraImage, ThermalImage};
use site_model::{Reading, ThermalScale};

/// Parameters of the files of pictures.
struct PictureEncodingConfig {
    /// Quality of photos, 1 to 100. Letters of a few pixels stay legible; a picture has 60 to 120 kB. Chosen: with more, files grow; with less, letters smear.
    jpeg_quality: u8,
}

const CONFIG: PictureEncodingConfig = PictureEncodingConfig { jpeg_quality: 90 };

/// A picture, and what can be read from it.
pub(super) struct EncodedPicture {
    pub(super) files: Vec<ActionFile>,
    pub(super) readings: Vec<Reading>,
}

pub(super) fn encode_photo(image: &CameraImage) -> Option<EncodedPicture> {
    let mut bytes = Vec::new();
    let [width, height] = [image.width_px, image.height_px].map(u16::try_from);
    let encoder = Encoder::new(&mut bytes, CONFIG.jpeg_quality);
    encoder.encode(&image.rgb, width.ok()?, height.ok()?, ColorType::Rgb).ok()?;
    Some(EncodedPicture { files: vec![file("photo.jpg", "image/jpeg", bytes)], readings: Vec::new() })
}

pub(super) fn encode_thermal(image: &ThermalImage) -> Option<EncodedPicture> {
    let coldest = image.celsius.iter().copied().fold(f32::INFINITY, f32::min);
    let warmest = image.celsius.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let range = (warmest - coldest).max(ThermalScale::MIN_SPAN_K as f32);
    let coloured: Vec<u8> =
        image.celsius.iter().flat_map(|celsius| colour((celsius - coldest) / range)).collect();
    // Big-endian, as PNG has it.
    let steps = |celsius: &f32| {
        let kelvin = celsius + ThermalScale::ZERO_CELSIUS_K as f32;
        (kelvin * ThermalScale::STEPS_PER_K as f32).round() as u16
    };
    let raw: Vec<u8> = image.celsius.iter().flat_map(|celsius| steps(celsius).to_be_bytes()).collect();
    let size = [image.width_px, image.height_px];
    let picture = png(size, png::ColorType::Rgb, png::BitDepth::Eight, &coloured)?;
    let temperatures = png(size, png::ColorType::Grayscale, png::BitDepth::Sixteen, &raw)?;
    let centre = (image.height_px / 2 * image.width_px + image.width_px / 2) as usize;
    let reading = |name: &str, celsius: f32| Reading {
        name: name.to_owned(),
        value: f64::from(celsius),
        standard_deviation: None,
        unit: "°C".to_owned(),
    };
    Some(EncodedPicture {
        files: vec![
            file("thermal.png", "image/png", picture),
            file("temperatures_centikelvin.png", "image/png", temperatures),
        ],
        readings: vec![
            reading("centre_temperature", *image.celsius.get(centre)?),
            reading("lowest_temperature", coldest),
            reading("highest_temperature", warmest),
        ],
    })
}

/// Colour of a share between the coldest and the warmest pixel.
fn colour(share: f32) -> [u8; 3] {
    const PALETTE: [[f32; 3]; 6] = ThermalScale::PALETTE;
    let at = share.clamp(0.0, 1.0) * (PALETTE.len() - 1) as f32;
    let low = (at as usize).min(PALETTE.len() - 2);
    let part = at - low as f32;
    [0, 1, 2].map(|i| (PALETTE[low][i] + (PALETTE[low + 1][i] - PALETTE[low][i]) * part).round() as u8)
}

fn png(
    [width, height]: [u32; 2],
    color: png::ColorType,
    depth: png::BitDepth,
    pixels: &[u8],
) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header().ok()?;
    writer.write_image_data(pixels).ok()?;
    writer.finish().ok()?;
    Some(bytes)
}

fn file(name: &str, media_type: &str, bytes: Vec<u8>) -> ActionFile {
    ActionFile { name: name.to_owned(), media_type: media_type.to_owned(), bytes }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn temperatures_can_be_read_back_from_the_picture_of_a_thermal_camera() {
        let celsius = vec![-15.0, 20.0, 20.005, 85.5, 33.3, 0.0];
        let image = ThermalImage { width_px: 3, height_px: 2, celsius: celsius.clone() };
        let EncodedPicture { files, readings } = encode_thermal(&image).expect("encoded");
        let decoder = png::Decoder::new(std::io::Cursor::new(&files[1].bytes));
        let mut reader = decoder.read_info().expect("a PNG");
        let mut pixels = vec![0; reader.output_buffer_size().expect("small")];
        reader.next_frame(&mut pixels).expect("read");
        for (pixel, expected) in pixels.chunks_exact(2).zip(&celsius) {
            let read = f32::from(u16::from_be_bytes([pixel[0], pixel[1]])) / 100.0 - 273.15;
            assert!((read - expected).abs() < 0.006, "{read} for {expected}");
        }
        assert_eq!(readings[2].value, 85.5);
        assert_eq!((colour(-1.0), colour(1.0)), ([0, 0, 20], [255, 255, 240]));
    }
}
