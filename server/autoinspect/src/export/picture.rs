//! Draws a map from above: the highest point in each pixel, coloured by its height.

use png::{BitDepth, ColorType, Encoder};
use std::collections::BTreeMap;
use std::io::{self, Write};
use store::{MapCloud, MapClouds, StoreError};

/// Fixed parameters of a [`MapPicture`].
#[derive(Clone, Copy, Debug)]
struct PictureConfig {
    /// Largest number of pixels of a picture. A larger map gets larger pixels. Chosen: 192 MB of memory while it is drawn, three bytes a pixel.
    max_pixels: f64,
    /// Distance between the lines that show the scale, metres. Chosen: ten metres can be counted in a hall.
    grid_m: f64,
    /// Points with a greater coordinate are left out, metres: they are errors. Chosen: 1,000 km; single precision resolves 6 cm there.
    max_coordinate_m: f64,
    /// Share of the pixels at each end of the heights that gets the end colour, so that a single mast does not stretch the colour range. Chosen: 2 % as a round number:
    /// more makes roofs and floors flat colours.
    height_tail_share: f64,
}

const CONFIG: PictureConfig =
    PictureConfig { max_pixels: 64e6, grid_m: 10.0, max_coordinate_m: 1e6, height_tail_share: 0.02 };
const PAPER: [u8; 3] = [250, 250, 248];
const GRID_LINE: [u8; 3] = [226, 228, 230];
/// Colours from low to high. They can be distinguished also by red-green colour-blind people, and in grey.
const RAMP: [[u8; 3]; 6] =
    [[48, 40, 110], [45, 92, 150], [34, 140, 141], [70, 178, 104], [170, 204, 60], [240, 196, 48]];

/// Heights in the map, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heights {
    pub from: f64,
    pub to: f64,
}

/// Parameters of a [`MapPicture`] that the user chooses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Edge of a pixel, metres.
    pub pixel: f64,
    /// Points higher than this above the keyframe that saw them are left out, metres.
    pub above_robot: f64,
    /// Heights to show; `None` shows all.
    pub heights: Option<Heights>,
}

/// Heights on a grid.
pub struct MapPicture {
    /// Edge of a pixel, metres; larger than requested if the map is very large.
    pixel: f64,
    /// Number of the leftmost column and of the lowest row, counted from the map's origin.
    first: [i64; 2],
    size: [usize; 2],
    /// Heights row by row from the top, metres; NaN without a point.
    heights: Vec<f32>,
    points: u64,
}

impl MapPicture {
    /// Draws `clouds`; `None` if no point is within the chosen heights. Memory: about 50 bytes for each pixel that is not empty.
    pub fn of(clouds: MapClouds, settings: Settings) -> Result<Option<Self>, StoreError> {
        let mut cells = BTreeMap::new();
        let mut points = 0;
        for cloud in clouds {
            points += add(&mut cells, &cloud?, &settings);
        }
        Ok(Self::from_cells(cells, settings.pixel, points))
    }

    fn from_cells(cells: BTreeMap<[i64; 2], f32>, pixel: f64, points: u64) -> Option<Self> {
        let mut low = *cells.keys().next()?;
        let mut high = low;
        for cell in cells.keys() {
            low = [low[0].min(cell[0]), low[1].min(cell[1])];
            high = [high[0].max(cell[0]), high[1].max(cell[1])];
        }
        let spans = [high[0] - low[0] + 1, high[1] - low[1] + 1];
        // Number of requested pixels that become one pixel, along each axis.
        let bin = ((spans[0] as f64 * spans[1] as f64 / CONFIG.max_pixels).sqrt().ceil() as i64).max(1);
        let first = low.map(|c| c.div_euclid(bin));
        let size = [0, 1].map(|axis| (high[axis].div_euclid(bin) - first[axis] + 1) as usize);
        let mut heights = vec![f32::NAN; size[0] * size[1]];
        for (cell, height) in cells {
            let [column, row] = [0, 1].map(|axis| (cell[axis].div_euclid(bin) - first[axis]) as usize);
            let at = (size[1] - 1 - row) * size[0] + column;
            // `f32::max` of NaN and a height is the height.
            heights[at] = heights[at].max(height);
        }
        Some(Self { pixel: pixel * bin as f64, first, size, heights, points })
    }

    /// Number of points within the chosen heights.
    pub fn points(&self) -> u64 {
        self.points
    }

    /// Writes the picture.
    pub fn write_png(&self, out: &mut impl Write) -> io::Result<()> {
        let mut encoder = Encoder::new(out, self.size[0] as u32, self.size[1] as u32);
        encoder.set_color(ColorType::Rgb);
        encoder.set_depth(BitDepth::Eight);
        let mut writer = encoder.write_header().map_err(io::Error::other)?;
        let (low, high) = self.colour_range();
        let colours: Vec<u8> = (0..self.heights.len())
            .flat_map(|at| {
                let height = self.heights[at];
                if height.is_nan() { self.ground(at) } else { ramp((height - low) / (high - low).max(0.1)) }
            })
            .collect();
        writer.write_image_data(&colours).map_err(io::Error::other)?;
        writer.finish().map_err(io::Error::other)
    }

    /// Least and greatest coordinates of the picture's area, metres, map frame.
    pub fn area_m(&self) -> [[f64; 2]; 2] {
        let corner = |more: [i64; 2]| [0, 1].map(|axis| (self.first[axis] + more[axis]) as f64 * self.pixel);
        [corner([0, 0]), corner(self.size.map(|cells| cells as i64))]
    }

    /// Content of the world file, six lines: size of a pixel and the map coordinates of the middle of the first one, metres.
    pub fn world_file(&self) -> String {
        let middle = |cell: i64| (cell as f64 + 0.5) * self.pixel;
        let (x, y) = (middle(self.first[0]), middle(self.first[1] + self.size[1] as i64 - 1));
        format!("{0}\n0\n0\n-{0}\n{x}\n{y}\n", self.pixel)
    }

    /// Heights of the first and last colour, metres.
    fn colour_range(&self) -> (f32, f32) {
        let mut seen: Vec<f32> = self.heights.iter().copied().filter(|height| !height.is_nan()).collect();
        seen.sort_by(f32::total_cmp);
        let at = |part: f64| seen.get((part * (seen.len() - 1) as f64) as usize).copied().unwrap_or(0.0);
        (at(CONFIG.height_tail_share), at(1.0 - CONFIG.height_tail_share))
    }

    /// Colour of a pixel without a point: background, or a line of the grid.
    fn ground(&self, at: usize) -> [u8; 3] {
        let cell = [at % self.size[0], self.size[1] - 1 - at / self.size[0]];
        let on_line = (0..2).any(|axis| {
            let from = (self.first[axis] + cell[axis] as i64) as f64 * self.pixel;
            (from / CONFIG.grid_m).ceil() * CONFIG.grid_m < from + self.pixel
        });
        if on_line { GRID_LINE } else { PAPER }
    }
}

/// Adds a keyframe's visible points to the cells; returns their number.
fn add(cells: &mut BTreeMap<[i64; 2], f32>, cloud: &MapCloud, settings: &Settings) -> u64 {
    let Some(map_from_keyframe) = geometry::isometry_from_pose(&cloud.map_from_keyframe) else {
        return 0;
    };
    let robot = map_from_keyframe.translation.vector.z;
    let mut entered = 0;
    for point in &cloud.xyz {
        let in_map = map_from_keyframe * nalgebra::Point3::from(point.map(f64::from));
        let wanted = settings.heights.is_none_or(|wanted| (wanted.from..=wanted.to).contains(&in_map.z));
        // False also for coordinates that are not finite.
        let near = in_map.x.abs() <= CONFIG.max_coordinate_m && in_map.y.abs() <= CONFIG.max_coordinate_m;
        if wanted && near && in_map.z - robot <= settings.above_robot {
            let cell = [in_map.x, in_map.y].map(|c| (c / settings.pixel).floor() as i64);
            let height = cells.entry(cell).or_insert(f32::NEG_INFINITY);
            *height = height.max(in_map.z as f32);
            entered += 1;
        }
    }
    entered
}

/// The colour of a share of the range, 0 to 1.
fn ramp(part: f32) -> [u8; 3] {
    let place = part.clamp(0.0, 1.0) * (RAMP.len() - 1) as f32;
    let below = (place as usize).min(RAMP.len() - 2);
    let share = place - below as f32;
    std::array::from_fn(|i| {
        let (low, high) = (f32::from(RAMP[below][i]), f32::from(RAMP[below + 1][i]));
        (low + share * (high - low)).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(picture: &MapPicture) -> (u32, u32, Vec<u8>) {
        let mut file = Vec::new();
        picture.write_png(&mut file).unwrap();
        let mut reader = png::Decoder::new(io::Cursor::new(file)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        (info.width, info.height, pixels)
    }

    #[test]
    fn north_is_up_and_colours_follow_the_height() {
        let cells = BTreeMap::from([([3, 4], 0.0), ([5, 7], 2.0)]);
        let picture = MapPicture::from_cells(cells, 0.5, 2).unwrap();
        let (width, height, pixels) = decoded(&picture);
        assert_eq!((width, height), (3, 4));
        assert_eq!(pixels[6..9], RAMP[5], "the high point is at the top right");
        assert_eq!(pixels[27..30], RAMP[0], "the low point is at the bottom left");
        assert_eq!(pixels[..3], PAPER);
        assert_eq!(picture.world_file(), "0.5\n0\n0\n-0.5\n1.75\n3.75\n");
    }

    #[test]
    fn grid_lines_are_at_multiples_of_ten_metres() {
        let cells = BTreeMap::from([([-3, -1], 0.0), ([25, 0], 0.0)]);
        let picture = MapPicture::from_cells(cells, 1.0, 2).unwrap();
        let (width, _, pixels) = decoded(&picture);
        let top: Vec<bool> = pixels.chunks(3).take(width as usize).map(|pixel| pixel == GRID_LINE).collect();
        // The upper row is at y = 0 and is a grid line; the lower one crosses the other lines.
        assert!(top[..28].iter().all(|line| *line));
        let lower: Vec<i64> = (0..29)
            .filter(|column| pixels[(29 + *column as usize) * 3..][..3] == GRID_LINE)
            .map(|column| column - 3)
            .collect();
        assert_eq!(lower, [0, 10, 20]);
    }

    #[test]
    fn high_points_and_invalid_points_are_left_out() {
        let cloud = MapCloud {
            keyframe: vocab::KeyframeId(0),
            map_from_keyframe: vocab::Pose::IDENTITY,
            xyz: vec![
                [1.0, 2.0, 0.5],
                [1.0, 2.0, 0.2],
                [1.0, 2.0, 3.0],
                [f32::NAN, 0.0, 0.0],
                [3e38, 0.0, 0.0],
            ],
            intensity: vec![0.0; 5],
        };
        let settings = Settings { pixel: 0.5, above_robot: 1.5, heights: None };
        let mut cells = BTreeMap::new();
        assert_eq!(add(&mut cells, &cloud, &settings), 2);
        assert_eq!(cells, BTreeMap::from([([2, 4], 0.5)]));
        let floor = Settings { heights: Some(Heights { from: 0.0, to: 0.3 }), ..settings };
        assert_eq!(add(&mut BTreeMap::new(), &cloud, &floor), 1);
    }

    #[test]
    fn an_enormous_map_gets_larger_pixels() {
        let cells = BTreeMap::from([([0, 0], 0.0), ([100_000_000, 99_999], 1.0)]);
        let picture = MapPicture::from_cells(cells, 0.05, 2).unwrap();
        assert!(picture.size[0] as f64 * picture.size[1] as f64 <= 1.01 * CONFIG.max_pixels);
        assert!(picture.pixel > 0.05);
        assert!(MapPicture::from_cells(BTreeMap::new(), 0.05, 0).is_none());
    }
}
