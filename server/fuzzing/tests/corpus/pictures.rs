//! Seeds of pictures.

use crate::clouds::Seed;
use jpeg_encoder::{ColorType, Encoder, SamplingFactor};

const SIZE_PX: [u16; 2] = [24, 18];

pub fn seeds() -> Vec<Seed> {
    let colours: Vec<u8> =
        (0..SIZE_PX[0] as usize * SIZE_PX[1] as usize * 3).map(|i| (i * 7 % 251) as u8).collect();
    let jpeg = |is_progressive: bool, sampling: SamplingFactor| {
        let mut file = Vec::new();
        let mut encoder = Encoder::new(&mut file, 60);
        encoder.set_progressive(is_progressive);
        encoder.set_sampling_factor(sampling);
        encoder.encode(&colours, SIZE_PX[0], SIZE_PX[1], ColorType::Rgb).unwrap();
        file
    };
    let png = |colour: png::ColorType, depth: png::BitDepth, bytes: usize| {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, SIZE_PX[0].into(), SIZE_PX[1].into());
        encoder.set_color(colour);
        encoder.set_depth(depth);
        if colour == png::ColorType::Indexed {
            encoder.set_palette(vec![0, 10, 20, 200, 210, 220]);
        }
        let pixels: Vec<u8> = colours.iter().copied().cycle().take(bytes).collect();
        encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
        file
    };
    let (width, height) = (SIZE_PX[0] as usize, SIZE_PX[1] as usize);
    vec![
        ("picture", "baseline", jpeg(false, SamplingFactor::R_4_2_0)),
        ("picture", "progressive", jpeg(true, SamplingFactor::R_4_4_4)),
        ("picture", "rgb", png(png::ColorType::Rgb, png::BitDepth::Eight, width * height * 3)),
        ("picture", "grey_16", png(png::ColorType::Grayscale, png::BitDepth::Sixteen, width * height * 2)),
        ("picture", "palette", png(png::ColorType::Indexed, png::BitDepth::One, width / 8 * height)),
        ("picture", "bmp", bmp(24, 2)),
        ("picture", "bmp_downwards", bmp(32, -2)),
    ]
}

/// A BMP file of 3 columns and two rows.
fn bmp(bits: u16, height: i32) -> Vec<u8> {
    let row_bytes = (3 * bits as usize / 8).next_multiple_of(4);
    let mut file = b"BM".to_vec();
    file.extend((54 + 2 * row_bytes as u32).to_le_bytes());
    file.extend([0; 4]);
    file.extend(54_u32.to_le_bytes());
    file.extend(40_u32.to_le_bytes());
    file.extend(3_u32.to_le_bytes());
    file.extend(height.to_le_bytes());
    file.extend(1_u16.to_le_bytes());
    file.extend(bits.to_le_bytes());
    file.extend([0; 24]);
    file.extend((0..2 * row_bytes).map(|i| i as u8));
    file
}
