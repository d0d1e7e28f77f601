//! The shaders' texts, put together from their parts. A unit test runs each through naga.

const COMMON: &str = include_str!("shaders/common.wgsl");
const PIECE: &str = include_str!("shaders/piece.wgsl");
const PICTURE: &str = include_str!("shaders/picture.wgsl");

/// Every shader of the scene: its name and its whole text.
pub(crate) fn sources() -> [(&'static str, String); 6] {
    [
        ("points", [COMMON, PIECE, include_str!("shaders/points.wgsl")].concat()),
        ("solids", [COMMON, PIECE, include_str!("shaders/solids.wgsl")].concat()),
        ("fill", [COMMON, PICTURE, include_str!("shaders/fill.wgsl")].concat()),
        ("shade", [COMMON, PICTURE, include_str!("shaders/shade.wgsl")].concat()),
        ("overlay", [COMMON, PICTURE, include_str!("shaders/overlay.wgsl")].concat()),
        ("present", include_str!("shaders/present.wgsl").to_owned()),
    ]
}
