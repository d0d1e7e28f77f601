//! The camera as the tile plan needs it.

/// From where and how a map is viewed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Viewpoint {
    /// Position of the camera, map frame, metres.
    pub position: [f64; 3],
    /// Unit vector into the picture, map frame.
    pub forward: [f32; 3],
    /// Pixels that one metre covers at a distance of one metre.
    pub focal_px: f32,
    /// Cosine of the angle between the middle and a corner of the picture.
    pub corner_cos: f32,
}
