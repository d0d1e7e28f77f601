//! Pictures of temperatures.

use super::render::{CameraView, HitTarget};
use super::{leaks, surfaces};
use geometry::Rng;

/// Standard deviation of a temperature, kelvin: that of an uncooled microbolometer.
const NOISE_K: f64 = 0.05;
/// Temperature of the sky, degrees Celsius.
const SKY_CELSIUS: f32 = -15.0;

/// A picture of temperatures.
#[derive(Clone, Debug, PartialEq)]
pub struct ThermalImage {
    /// Columns.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// Degrees Celsius, row by row from the top left.
    pub celsius: Vec<f32>,
}

/// Measures the temperature at every pixel.
pub(super) fn measure(view: &CameraView<'_>, rng: &mut Rng) -> ThermalImage {
    let (width_px, height_px) = (view.intrinsics.width_px, view.intrinsics.height_px);
    let mut celsius = vec![SKY_CELSIUS; (width_px * height_px) as usize];
    let fixtures = &view.scene.fixtures;
    view.targets(|pixel, hit| {
        celsius[pixel] = match hit.target {
            HitTarget::Nothing => SKY_CELSIUS,
            HitTarget::Solid(_) => {
                surfaces::wall_celsius(fixtures, hit.point)
                    + leaks::warmth_k(&view.scene.leaks, hit.point, hit.normal)
            }
            HitTarget::Person(material) => surfaces::person_celsius(material),
            HitTarget::Plate(fixture, at) => {
                surfaces::plate_celsius(&fixtures[fixture], at, surfaces::air_celsius(hit.point))
            }
        };
    });
    for value in &mut celsius {
        *value += (NOISE_K * rng.normal()) as f32;
    }
    ThermalImage { width_px, height_px, celsius }
}
