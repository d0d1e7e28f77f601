//! What the overlay shader reads for each line segment and each marker, and how polylines become segments.

use crate::view::Colour;
use bytemuck::{Pod, Zeroable};
use glam::DVec3;

/// One segment; see `vs_lines`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Segment {
    pub(crate) from: [f32; 3],
    pub(crate) to: [f32; 3],
    pub(crate) colour: Colour,
    /// Logical pixels.
    pub(crate) width: f32,
    /// Opacity where something stands in front.
    pub(crate) behind: f32,
    /// Length of a dash and its gap, metres; 0 for a solid line.
    pub(crate) dash: f32,
    /// Metres from the start of the polyline to the start of the segment.
    pub(crate) along: f32,
}

/// One marker; see `vs_marks`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Mark {
    pub(crate) centre: [f32; 3],
    /// Direction that the marker's x axis follows on the screen; zero keeps it upright.
    pub(crate) ahead: [f32; 3],
    pub(crate) fill: Colour,
    pub(crate) rim: Colour,
    /// Greatest and least radius, logical pixels.
    pub(crate) radius_max: f32,
    pub(crate) radius_min: f32,
    /// Radius in the world, metres; 0 draws the greatest radius at every distance.
    pub(crate) radius_world: f32,
    /// As `edge_distance` in the shader counts them.
    pub(crate) shape: f32,
    pub(crate) behind: f32,
}

/// How a line looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stroke {
    pub(crate) colour: Colour,
    pub(crate) width: f32,
    pub(crate) behind: f32,
    pub(crate) dash: f32,
}

/// Appends the segments of a polyline. Points nearer than `step_min` (metres) to the last one drawn are skipped, but
/// never the end.
pub(crate) fn push_polyline(segments: &mut Vec<Segment>, points: &[DVec3], stroke: Stroke, step_min: f64) {
    let mut finite = points.iter().copied().filter(|p| p.is_finite()).peekable();
    let Some(mut from) = finite.next() else {
        return;
    };
    let mut along = 0.0;
    while let Some(to) = finite.next() {
        let length = from.distance(to);
        if length < step_min && finite.peek().is_some() {
            continue;
        }
        segments.push(Segment {
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

/// The points of a level circle (metres), closed.
pub(crate) fn circle(centre: DVec3, radius: f64) -> Vec<DVec3> {
    const CORNERS: u32 = 48;
    (0..=CORNERS)
        .map(|i| {
            let (sin, cos) = (f64::from(i) / f64::from(CORNERS) * std::f64::consts::TAU).sin_cos();
            centre + DVec3::new(cos, sin, 0.0) * radius
        })
        .collect()
}
