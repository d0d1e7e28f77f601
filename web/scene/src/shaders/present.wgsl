// Copies the finished image into the viewport of the caller's pass.

@group(0) @binding(0) var finished: texture_2d<f32>;
@group(0) @binding(1) var finished_sampler: sampler;

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) uv: vec2<f32>,
}

@vertex
fn vs_present(@builtin(vertex_index) vertex: u32) -> Corner {
    let corner = vec2<f32>(f32((vertex << 1u) & 2u), f32(vertex & 2u));
    return Corner(vec4<f32>(corner * 2.0 - 1.0, 0.0, 1.0), vec2<f32>(corner.x, 1.0 - corner.y));
}

@fragment
fn fs_present(in: Corner) -> @location(0) vec4<f32> {
    return vec4<f32>(textureSample(finished, finished_sampler, in.uv).rgb, 1.0);
}

// For sRGB targets, which encode the colours that are written.
@fragment
fn fs_present_srgb(in: Corner) -> @location(0) vec4<f32> {
    let gamma = textureSample(finished, finished_sampler, in.uv).rgb;
    let low = gamma / 12.92;
    let high = pow((gamma + 0.055) / 1.055, vec3<f32>(2.4));
    return vec4<f32>(select(high, low, gamma <= vec3<f32>(0.04045)), 1.0);
}
