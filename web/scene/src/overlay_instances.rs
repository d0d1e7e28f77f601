//! Instances of the overlay shader: one for each line segment and each marker. Polylines are split into segments here.

use crate::view::Colour;
use bytemuck::{Pod, Zeroable};
use glam::DVec3;

/// Height above a pose's feet at which graph and trajectory are drawn, m, so that they do not sink into the floor.
pub(crate) const LIFT: DVec3 = DVec3::new(0.0, 0.0, 0.05);

/// A line segment, as `vs_lines` reads it.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct LineInstance {
    pub(crate) from: [f32; 3],
    pub(crate) to: [f32; 3],
    pub(crate) colour: Colour,
    /// Logical pixels.
    pub(crate) width: f32,
    /// Opacity where a surface hides it.
    pub(crate) behind: f32,
    /// Length of a dash and its gap, metres; 0 for a solid line.
    pub(crate) dash: f32,
    /// Metres from the start of the polyline to the start of the segment.
    pub(crate) along: f32,
}

/// A marker, as `vs_markers` reads it.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct MarkerInstance {
    pub(crate) centre: [f32; 3],
    /// Direction of the marker's x axis, map frame; zero keeps it upright.
    pub(crate) ahead: [f32; 3],
    pub(crate) fill: Colour,
    pub(crate) rim: Colour,
    /// Largest and smallest radius, logical pixels.
    pub(crate) radius_max: f32,
    pub(crate) radius_min: f32,
    /// Radius in the map, m, which perspective scales; 0 draws the largest radius at every distance.
    pub(crate) radius_world: f32,
    /// Number of the shape in `edge_distance` of overlay.wgsl.
    pub(crate) shape: f32,
    /// Opacity where a surface hides it.
    pub(crate) behind: f32,
    /// Range of the projected radius in which the marker is drawn, logical pixels.
    pub(crate) visible_px: [f32; 2],
}

/// The value of [`MarkerInstance::visible_px`] for markers that are drawn at every distance.
pub(crate) const ALWAYS_VISIBLE: [f32; 2] = [0.0, 1e9];

/// Colour, width and dashes of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stroke {
    pub(crate) colour: Colour,
    pub(crate) width: f32,
    pub(crate) behind: f32,
    pub(crate) dash: f32,
}

/// Appends the segments of a polyline. Points nearer than `min_step_m` to the last kept one are skipped, except the last point.
pub(crate) fn push_polyline(
    segments: &mut Vec<LineInstance>,
    points: &[DVec3],
    stroke: Stroke,
    min_step_m: f64,
) {
    let mut finite = points.iter().copied().filter(|p| p.is_finite()).peekable();
    let Some(mut from) = finite.next() else {
        return;
    };
    let mut along = 0.0;
    while let Some(to) = finite.next() {
        let length = from.distance(to);
        if length < min_step_m && finite.peek().is_some() {
            continue;
        }
        segments.push(LineInstance {
            from: from.as_vec3().to_array(),
            to: to.as_vec3().to_array(),
            colour: stroke.colour,
            width: stroke.width,
            behind: stroke.behind,
            dash: stroke.dash,
            along: along as f32,
        });
        along += length;
        from = to;
    }
}

/// The points of a closed horizontal circle (m).
pub(crate) fn circle(centre: DVec3, radius: f64) -> Vec<DVec3> {
    const CORNERS: u32 = 48;
    (0..=CORNERS)
        .map(|i| {
            let (sin, cos) = (f64::from(i) / f64::from(CORNERS) * std::f64::consts::TAU).sin_cos();
            centre + DVec3::new(cos, sin, 0.0) * radius
        })
        .collect()
}

/// The points, [`LIFT`] higher.
pub(crate) fn lifted(points: &[DVec3]) -> Vec<DVec3> {
    points.iter().map(|p| *p + LIFT).collect()
}
