//! From light to bytes: exposure, noise and the curve of sRGB.

use super::CameraImage;
use super::optics::Intrinsics;
use geometry::Rng;

/// The mean brightness of a picture is exposed to this share of white.
const KEY: f32 = 0.26;
/// Greatest gain: darker scenes stay dark.
const MAX_GAIN: f32 = 12.0;
/// Standard deviation of the noise at white at gain 1, as a share of white.
const SHOT_NOISE: f32 = 0.006;
/// Standard deviation of the noise at black at gain 1.
const READ_NOISE: f32 = 0.002;
/// Loss of light in the corners of the picture.
const CORNER_LOSS: f32 = 0.22;

/// Exposes a picture by the mean of the logarithms of its light, adds noise, and encodes it.
pub(super) fn expose(light: &[[f32; 3]], intrinsics: &Intrinsics, rng: &mut Rng) -> CameraImage {
    let luminance = |[r, g, b]: [f32; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
    let logarithms: f32 = light.iter().map(|rgb| (luminance(*rgb) + 1e-3).ln()).sum();
    let mean = (logarithms / light.len().max(1) as f32).exp();
    // The curve 1 - exp(-x) takes the mean to the key.
    let gain = (-(1.0 - KEY).ln() / mean).min(MAX_GAIN);
    let (width, height) = (intrinsics.width_px, intrinsics.height_px);
    let table = encoding();
    let mut rgb = Vec::with_capacity(light.len() * 3);
    for (pixel, colour) in light.iter().enumerate() {
        let x = (pixel as u32 % width) as f32 / width as f32 - 0.5;
        let y = (pixel as u32 / width) as f32 / height as f32 - 0.5;
        let fade = 1.0 - CORNER_LOSS * 2.0 * (x * x + y * y);
        for value in colour {
            let exposed = 1.0 - (-gain * fade * value).exp();
            let deviation = (SHOT_NOISE * SHOT_NOISE * exposed * gain.max(1.0)
                + (READ_NOISE * gain.max(1.0)).powi(2))
            .sqrt();
            let noisy = exposed + deviation * nearly_normal(rng.bits());
            rgb.push(table[(noisy.clamp(0.0, 1.0) * (table.len() - 1) as f32 + 0.5) as usize]);
        }
    }
    CameraImage { width_px: width, height_px: height, rgb }
}

/// A number of mean 0 and standard deviation 1 from 64 random bits: the sum of four uniform ones (Irwin-Hall), at most 3.5.
fn nearly_normal(bits: u64) -> f32 {
    let sum: u64 = (0..4).map(|part| (bits >> (16 * part)) & 0xffff).sum();
    (sum as f32 / 65_536.0 - 2.0) * 3.0_f32.sqrt()
}

/// sRGB bytes of linear values from 0 to 1.
fn encoding() -> Vec<u8> {
    const STEPS: usize = 4096;
    let encode = |step: usize| {
        let linear = step as f32 / (STEPS - 1) as f32;
        let curve =
            if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
        (curve * 255.0).round() as u8
    };
    (0..STEPS).map(encode).collect()
}
