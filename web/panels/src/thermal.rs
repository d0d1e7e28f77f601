//! Thermal pictures: temperatures in colours of a scale, which two pictures can share so that they compare.

use egui::{Color32, ColorImage, Context, TextureHandle, TextureOptions};
use site_model::ThermalScale;

/// The temperatures that the ends of the palette stand for, degrees Celsius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    pub(crate) lowest: f64,
    pub(crate) highest: f64,
}

impl Scale {
    /// The scale of two pictures.
    pub(crate) fn of_both(self, other: Self) -> Self {
        Self { lowest: self.lowest.min(other.lowest), highest: self.highest.max(other.highest) }
    }
}

/// Colour of a share of a scale, 0 to 1.
pub(crate) fn colour(share: f64) -> Color32 {
    const PALETTE: [[f32; 3]; 6] = ThermalScale::PALETTE;
    let at = share.clamp(0.0, 1.0) as f32 * (PALETTE.len() - 1) as f32;
    let low = (at as usize).min(PALETTE.len() - 2);
    let part = at - low as f32;
    let [r, g, b] =
        std::array::from_fn(|k| (PALETTE[low][k] + part * (PALETTE[low + 1][k] - PALETTE[low][k])) as u8);
    Color32::from_rgb(r, g, b)
}

/// Temperatures of the pixels of a picture.
pub(crate) struct ThermalPicture {
    size: [usize; 2],
    /// Hundredths of a kelvin, row by row.
    centikelvin: Vec<u16>,
    /// The picture in the colours of a scale, once it was drawn.
    drawn: Option<(Scale, TextureHandle)>,
}

impl ThermalPicture {
    pub(crate) fn new(size: [usize; 2], centikelvin: Vec<u16>) -> Self {
        Self { size, centikelvin, drawn: None }
    }

    /// Columns and rows.
    pub(crate) fn size(&self) -> [usize; 2] {
        self.size
    }

    /// The scale of this picture alone.
    pub(crate) fn scale(&self) -> Scale {
        let celsius = |value: Option<&u16>| celsius(value.copied().unwrap_or_default());
        let lowest = celsius(self.centikelvin.iter().min());
        Scale {
            lowest,
            highest: celsius(self.centikelvin.iter().max()).max(lowest + ThermalScale::MIN_SPAN_K),
        }
    }

    /// Temperature of a pixel, degrees Celsius.
    pub(crate) fn at(&self, column: usize, row: usize) -> Option<f64> {
        let [columns, rows] = self.size;
        let is_inside = column < columns && row < rows;
        self.centikelvin.get(row * columns + column).filter(|_| is_inside).map(|value| celsius(*value))
    }

    /// The pixel of the greatest temperature.
    pub(crate) fn warmest(&self) -> Option<[usize; 2]> {
        let (index, _) = self.centikelvin.iter().enumerate().max_by_key(|(_, value)| **value)?;
        Some([index % self.size[0].max(1), index / self.size[0].max(1)])
    }

    /// The picture in the colours of a scale.
    pub(crate) fn texture(&mut self, ctx: &Context, scale: Scale) -> TextureHandle {
        if let Some((drawn, texture)) = &self.drawn
            && *drawn == scale
        {
            return texture.clone();
        }
        let span = (scale.highest - scale.lowest).max(f64::EPSILON);
        let pixels = self.centikelvin.iter().map(|value| colour((celsius(*value) - scale.lowest) / span));
        let image = ColorImage::new(self.size, pixels.collect());
        let texture = ctx.load_texture("thermal picture", image, TextureOptions::LINEAR);
        self.drawn = Some((scale, texture.clone()));
        texture
    }
}

fn celsius(centikelvin: u16) -> f64 {
    f64::from(centikelvin) / ThermalScale::STEPS_PER_K - ThermalScale::ZERO_CELSIUS_K
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn temperatures_are_read_and_the_scale_spans_them() {
        let picture = ThermalPicture::new([2, 2], vec![29_315, 30_315, 29_315, 29_815]);
        assert!((picture.at(1, 0).unwrap() - 30.0).abs() < 1e-9);
        assert_eq!((picture.at(2, 0), picture.at(0, 2)), (None, None));
        assert_eq!(picture.warmest(), Some([1, 0]));
        let scale = picture.scale();
        assert!((scale.lowest - 20.0).abs() < 1e-9 && (scale.highest - 30.0).abs() < 1e-9);
        let flat = ThermalPicture::new([1, 1], vec![29_315]).scale();
        assert!((flat.highest - 25.0).abs() < 1e-9, "noise is not stretched");
        assert!((flat.of_both(scale).highest - 30.0).abs() < 1e-9);
        assert_eq!(
            (colour(-1.0), colour(2.0)),
            (Color32::from_rgb(0, 0, 20), Color32::from_rgb(255, 255, 240))
        );
    }
}
