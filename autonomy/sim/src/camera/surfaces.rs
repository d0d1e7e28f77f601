//! Colour and temperature of what a ray hits.

use super::fixtures::{Face, Fixture};
use crate::shape::Material;

/// How a surface reflects light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Finish {
    /// Share of light that is scattered, linear red, green and blue.
    pub(super) albedo: [f32; 3],
    /// Strength of the highlight.
    pub(super) gloss: f32,
}

/// Amplitude of the texture of walls and floors, as a share of their albedo.
const TEXTURE: f32 = 0.14;
/// Details of the texture, per metre, and their shares of the amplitude.
const DETAILS: [(f32, f32); 2] = [(1.7, 0.6), (28.0, 0.4)];

/// Temperature of the air at the height 0, degrees Celsius.
const AIR_CELSIUS: f32 = 20.0;
/// Rise of that temperature with height, kelvin a metre: warm air collects under the ceiling.
const RISE_K_PER_M: f32 = 0.4;
/// Temperature of skin, degrees Celsius.
const SKIN_CELSIUS: f32 = 33.0;
/// Temperature of clothes that are worn, degrees Celsius.
const CLOTHES_CELSIUS: f32 = 27.5;
/// How far the wall round a warm machine is heated, metres: standard deviation of a bell.
const HEATED_M: f32 = 0.22;
/// Share of a machine's excess temperature that the wall beside it has.
const HEATED_SHARE: f32 = 0.3;

/// How a material reflects light, at a point of its surface, site frame, metres.
pub(super) fn finish(material: Material, point: [f32; 3]) -> Finish {
    let (albedo, gloss) = base(material);
    let strength = match material {
        Material::Concrete | Material::Asphalt | Material::Wood | Material::Foliage => TEXTURE * 1.6,
        Material::Floor | Material::Plaster | Material::Cardboard | Material::Rubber => TEXTURE,
        _ => TEXTURE * 0.4,
    };
    let texture = DETAILS.iter().map(|(scale, share)| share * (noise(point, *scale) - 0.5)).sum::<f32>();
    let factor = 1.0 + 2.0 * strength * texture;
    Finish { albedo: albedo.map(|c| c * factor), gloss }
}

/// Linear albedo and gloss of a material.
fn base(material: Material) -> ([f32; 3], f32) {
    match material {
        Material::Concrete => ([0.36, 0.35, 0.33], 0.02),
        Material::Floor => ([0.30, 0.31, 0.31], 0.12),
        Material::Plaster => ([0.66, 0.65, 0.61], 0.02),
        Material::WhiteSheet => ([0.74, 0.75, 0.76], 0.15),
        Material::Steel => ([0.34, 0.35, 0.37], 0.5),
        Material::Galvanised => ([0.47, 0.49, 0.5], 0.35),
        Material::DarkPaint => ([0.07, 0.08, 0.09], 0.2),
        Material::YellowPaint => ([0.72, 0.48, 0.04], 0.2),
        Material::BluePaint => ([0.05, 0.13, 0.36], 0.2),
        Material::Rubber => ([0.03, 0.03, 0.03], 0.05),
        Material::Wood => ([0.42, 0.27, 0.14], 0.05),
        Material::Cardboard => ([0.44, 0.31, 0.19], 0.01),
        Material::Glass => ([0.08, 0.1, 0.1], 0.8),
        Material::Cloth => ([0.13, 0.16, 0.24], 0.01),
        Material::Skin => ([0.55, 0.36, 0.27], 0.05),
        Material::Foliage => ([0.08, 0.2, 0.05], 0.02),
        Material::Asphalt => ([0.08, 0.08, 0.085], 0.02),
        Material::Reflector => ([0.8, 0.8, 0.82], 0.6),
    }
}

/// Smooth noise between 0 and 1 with details of `1 / scale` metres: values at the corners of a grid, interpolated.
fn noise(point: [f32; 3], scale: f32) -> f32 {
    let at = point.map(|c| c * scale);
    let cell = at.map(f32::floor);
    let share = [0, 1, 2].map(|i| {
        let s = at[i] - cell[i];
        s * s * (3.0 - 2.0 * s)
    });
    let cell = cell.map(|c| c as i32);
    let mut sum = 0.0;
    for corner in 0..8 {
        let bits = [corner & 1, (corner >> 1) & 1, (corner >> 2) & 1];
        let weight: f32 = (0..3).map(|i| if bits[i] == 1 { share[i] } else { 1.0 - share[i] }).product();
        let hash = hash([0, 1, 2].map(|i| (cell[i] + bits[i]) as u32));
        sum += weight * (hash >> 8) as f32 / (1 << 24) as f32;
    }
    sum
}

/// Mixes three numbers to one that looks random (multiplications by large primes, and the finisher of MurmurHash3).
pub(super) fn hash([a, b, c]: [u32; 3]) -> u32 {
    let mut h = a.wrapping_mul(0x9e37_79b1) ^ b.wrapping_mul(0x85eb_ca77) ^ c.wrapping_mul(0xc2b2_ae3d);
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

/// Temperature of the air at a point, degrees Celsius.
pub(crate) fn air_celsius(point: [f32; 3]) -> f32 {
    AIR_CELSIUS + RISE_K_PER_M * point[2]
}

/// Temperature of a surface of the site, degrees Celsius. Linear in the number of fixtures.
pub(super) fn wall_celsius(fixtures: &[Fixture], point: [f32; 3]) -> f32 {
    let air = air_celsius(point);
    let heated = fixtures.iter().filter_map(|fixture| {
        let Face::Warm { celsius } = fixture.face else { return None };
        let middle = fixture.site_from_plate.translation.vector;
        let squared: f32 = (0..3).map(|i| (point[i] - middle[i] as f32).powi(2)).sum();
        let bell = (-0.5 * squared / (HEATED_M * HEATED_M)).exp();
        Some(HEATED_SHARE * (celsius as f32 - air) * bell)
    });
    air + heated.sum::<f32>()
}

/// Temperature of a point of a plate, relative to its middle, degrees Celsius.
pub(super) fn plate_celsius(fixture: &Fixture, point: [f32; 2], air: f32) -> f32 {
    let Face::Warm { celsius } = fixture.face else { return air };
    let half = fixture.face.half_m();
    let edge = (0..2).map(|i| (point[i] / half[i] as f32).powi(2)).sum::<f32>();
    // A quarter cooler at the edges.
    air + (celsius as f32 - air) * (1.0 - 0.25 * edge.min(1.0))
}

/// Temperature of a part of a person, degrees Celsius.
pub(super) fn person_celsius(material: Material) -> f32 {
    if material == Material::Skin { SKIN_CELSIUS } else { CLOTHES_CELSIUS }
}
