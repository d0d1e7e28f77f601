//! Sources of the shaders, concatenated from their parts. A unit test validates each with naga.

const COMMON: &str = include_str!("shaders/common.wgsl");
const DRAW: &str = include_str!("shaders/draw.wgsl");
const COLOUR_DEPTH: &str = include_str!("shaders/colour_depth.wgsl");

/// Every shader of the scene: its name and its source.
pub(crate) fn sources() -> [(&'static str, String); 7] {
    [
        ("points", [COMMON, DRAW, include_str!("shaders/points.wgsl")].concat()),
        ("meshes", [COMMON, DRAW, include_str!("shaders/meshes.wgsl")].concat()),
        ("reach", [COMMON, include_str!("shaders/reach.wgsl")].concat()),
        ("fill", [COMMON, COLOUR_DEPTH, include_str!("shaders/fill.wgsl")].concat()),
        ("shade", [COMMON, COLOUR_DEPTH, include_str!("shaders/shade.wgsl")].concat()),
        ("overlay", [COMMON, COLOUR_DEPTH, include_str!("shaders/overlay.wgsl")].concat()),
        ("present", include_str!("shaders/present.wgsl").to_owned()),
    ]
}
