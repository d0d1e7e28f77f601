//! The earlier picture as the later one sees it, with a frame round each region that has changed: a PNG file.

use ::picture_changes::{ChangedRegion, Homography};
use gauges::Picture;

/// What the earlier picture does not show.
const OUTSIDE: [u8; 3] = [40, 40, 40];
/// The frames, and the lines beside them that keep them legible on every colour.
const FRAME: [u8; 3] = [255, 211, 61];
const BESIDE: [u8; 3] = [0, 0, 0];
/// Distance of a frame from its region, pixels.
const FRAME_GAP_PX: f64 = 4.0;

/// The picture as PNG; none if the mapping has no inverse.
pub fn png(
    before: &Picture,
    after: &Picture,
    after_from_before: &Homography,
    regions: &[ChangedRegion],
) -> Option<Vec<u8>> {
    let before_from_after = after_from_before.inverse()?;
    let [width, height] = after.size_px();
    let mut pixels: Vec<[u8; 3]> = (0..width * height)
        .map(|at| {
            let from = before_from_after.map([(at % width) as f64, (at / width) as f64]);
            from.filter(|px| is_inside(*px, before.size_px())).map_or(OUTSIDE, |px| before.sample(px))
        })
        .collect();
    for region in regions {
        let [left, top] = region.min_px.map(|px| px as f64 - FRAME_GAP_PX);
        let [right, bottom] = region.max_px.map(|px| px as f64 + FRAME_GAP_PX);
        let corners = [[left, top], [right, top], [right, bottom], [left, bottom]];
        for radius in [2, 1] {
            let colour = if radius == 2 { BESIDE } else { FRAME };
            for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
                if let (Some(from), Some(to)) = (after_from_before.map(*from), after_from_before.map(*to)) {
                    draw_line(&mut pixels, [width, height], [from, to], (radius, colour));
                }
            }
        }
    }
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().and_then(|mut writer| writer.write_image_data(pixels.as_flattened())).ok()?;
    Some(file)
}

/// Whether a place is within the outer edges of a picture.
fn is_inside([x, y]: [f64; 2], [width, height]: [usize; 2]) -> bool {
    (-0.5..width as f64 - 0.5).contains(&x) && (-0.5..height as f64 - 0.5).contains(&y)
}

/// Draws squares of this radius, pixels, along a line. What lies outside is left out.
fn draw_line(
    pixels: &mut [[u8; 3]],
    [width, height]: [usize; 2],
    [from, to]: [[f64; 2]; 2],
    (radius, colour): (i64, [u8; 3]),
) {
    // A corner far outside would take a step for each pixel up to it.
    let longest = 4.0 * (width + height) as f64;
    let steps = (to[0] - from[0]).hypot(to[1] - from[1]).min(longest).ceil().max(1.0);
    for step in 0..=steps as usize {
        let share = step as f64 / steps;
        let [x, y] = [0, 1].map(|axis| (from[axis] + share * (to[axis] - from[axis])).round() as i64);
        for (dx, dy) in (-radius..=radius).flat_map(|dy| (-radius..=radius).map(move |dx| (dx, dy))) {
            let place = usize::try_from(x + dx).ok().zip(usize::try_from(y + dy).ok());
            if let Some((x, y)) = place.filter(|(x, y)| *x < width && *y < height) {
                pixels[y * width + x] = colour;
            }
        }
    }
}
