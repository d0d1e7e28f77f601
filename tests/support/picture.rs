//! Screenshots, which are saved and measured.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

use base64::Engine;

use super::workspace_root;

pub struct Picture {
    png: Vec<u8>,
    pub width: usize,
    pub height: usize,
    /// Pixels for each of the page, along both sides.
    scale: f64,
    /// Red, green, blue of each pixel, row by row from the top.
    pixels: Vec<[u8; 3]>,
}

/// A part of a picture, in pixels.
#[derive(Clone, Copy)]
pub struct Area {
    pub left: usize,
    pub top: usize,
    pub right: usize,
    pub bottom: usize,
}

impl Picture {
    /// Decodes a screenshot of a page of `page_width` CSS pixels; `None` if it is not a PNG file.
    pub(super) fn from_base64(text: &str, page_width: u32) -> Option<Self> {
        let png = base64::engine::general_purpose::STANDARD.decode(text).ok()?;
        let mut decoder = png::Decoder::new(std::io::Cursor::new(&png));
        decoder.set_transformations(png::Transformations::EXPAND | png::Transformations::STRIP_16);
        let mut reader = decoder.read_info().ok()?;
        let mut bytes = vec![0; reader.output_buffer_size()?];
        let info = reader.next_frame(&mut bytes).ok()?;
        let samples = Some(info.color_type.samples()).filter(|samples| *samples >= 3)?;
        let pixels = bytes[..info.buffer_size()].chunks_exact(samples).map(|p| [p[0], p[1], p[2]]).collect();
        let scale = f64::from(info.width) / f64::from(page_width);
        Some(Self { width: info.width as usize, height: info.height as usize, scale, pixels, png })
    }

    /// Width and height of the page, CSS pixels.
    pub fn page_size(&self) -> [f64; 2] {
        [self.width, self.height].map(|px| px as f64 / self.scale)
    }

    /// Saves the picture as a test artefact.
    pub fn save(&self, name: &str) -> PathBuf {
        let folder = workspace_root().join("artifacts");
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join(format!("{name}.png"));
        fs::write(&path, &self.png).unwrap();
        path
    }

    /// The middle of the picture, where no card covers the map.
    pub fn middle(&self) -> Area {
        Area {
            left: self.width / 4,
            top: self.height / 5,
            right: self.width * 13 / 20,
            bottom: self.height * 4 / 5,
        }
    }

    /// Whether a place of the page, in CSS pixels, has the colour of walls by height: teal, between the slate of floors and the sand of what is highest.
    pub fn shows_wall(&self, x: f64, y: f64) -> bool {
        let (x, y) = (x * self.scale, y * self.scale);
        let (column, row) = (x.round() as usize, y.round() as usize);
        let is_inside = x >= 0.0 && y >= 0.0 && column < self.width;
        let pixel = self.pixels.get(row * self.width + column).filter(|_| is_inside);
        pixel.is_some_and(|pixel| {
            let [red, green, blue] = pixel.map(f64::from);
            green > 70.0 && red < 0.75 * green && (0.8..1.15).contains(&(blue / green))
        })
    }

    fn rows(&self, area: Area) -> impl Iterator<Item = &[u8; 3]> {
        (area.top..area.bottom).flat_map(move |row| &self.pixels[row * self.width..][area.left..area.right])
    }

    /// Number of different colours in an area.
    pub fn colours(&self, area: Area) -> usize {
        self.rows(area).collect::<BTreeSet<_>>().len()
    }

    /// The share of an area's pixels that are lit: at least `step` brighter in one channel than the dark background.
    pub fn lit(&self, area: Area, step: u8) -> f64 {
        const GROUND: [u8; 3] = [0x0d, 0x11, 0x17];
        let brighter =
            |pixel: &[u8; 3]| pixel.iter().zip(GROUND).any(|(&is, ground)| is > ground.saturating_add(step));
        let (lit, all) =
            self.rows(area).fold((0_u32, 0_u32), |(lit, all), p| (lit + u32::from(brighter(p)), all + 1));
        f64::from(lit) / f64::from(all.max(1))
    }
}
