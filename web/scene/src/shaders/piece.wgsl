// One tile, scan or model: its own uniforms.

struct Piece {
    relative_from_local: mat4x4<f32>,
    kind: vec4<f32>,
    tint: vec4<f32>,
}

@group(1) @binding(0) var<uniform> piece: Piece;

struct Surface {
    @location(0) colour: vec4<f32>,
    @location(1) depth: vec4<f32>,
}
