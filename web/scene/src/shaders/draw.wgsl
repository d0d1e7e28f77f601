// Uniforms of one draw call: a tile, a scan or a mesh.

struct DrawUniforms {
    relative_from_local: mat4x4<f32>,
    kind: vec4<f32>,
    tint: vec4<f32>,
}

@group(1) @binding(0) var<uniform> draw: DrawUniforms;

struct Surface {
    @location(0) colour: vec4<f32>,
    @location(1) depth: vec4<f32>,
}
