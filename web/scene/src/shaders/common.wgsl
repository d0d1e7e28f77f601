// Shared by all shaders. Colours are gamma-encoded throughout. Positions are metres relative to the camera along the map's axes,
// which keeps them small and exact.

struct FrameUniforms {
    clip_from_relative: mat4x4<f32>,
    camera: vec4<f32>,
    viewport: vec4<f32>,
    heights: vec4<f32>,
    style: vec4<f32>,
    grid_shape: vec4<f32>,
    ground_top: vec4<f32>,
    ground_bottom: vec4<f32>,
    plain: vec4<f32>,
    grid: vec4<f32>,
    colour_map: array<vec4<f32>, 12>,
}

@group(0) @binding(0) var<uniform> frame: FrameUniforms;

// Depth is stored as a logarithm in 24 bits of a colour target, because not every browser can draw into floats. It covers 0.008 m to
// 8 km in steps of 1.2e-6 octaves. All ones mean an empty pixel. The fourth byte is the radius of the point, in sixteenths of a pixel.
const DEPTH_LEAST_LOG2: f32 = -7.0;
const DEPTH_OCTAVES: f32 = 20.0;
const DEPTH_STEPS: f32 = 16777215.0;

// Edge of the blocks that have one number of pixels to read each (reach.wgsl), pixels. Chosen: half the largest radius of a point.
const BLOCK: i32 = 8;

fn log_depth(depth: f32) -> f32 {
    return clamp((log2(max(depth, 0.001)) - DEPTH_LEAST_LOG2) / DEPTH_OCTAVES, 0.0, 0.999999);
}

fn metres(packed_log: f32) -> f32 {
    return exp2(packed_log * DEPTH_OCTAVES + DEPTH_LEAST_LOG2);
}

fn pack_depth(log_of_depth: f32, radius: f32) -> vec4<f32> {
    let whole = u32(log_of_depth * DEPTH_STEPS);
    let bytes = vec3<u32>(whole >> 16u, (whole >> 8u) & 255u, whole & 255u);
    return vec4<f32>(vec3<f32>(bytes) / 255.0, clamp(radius * 16.0 / 255.0, 0.0, 1.0));
}

fn unpack_depth(packed: vec4<f32>) -> f32 {
    let bytes = floor(packed.rgb * 255.0 + 0.5);
    return dot(bytes, vec3<f32>(65536.0, 256.0, 1.0)) / DEPTH_STEPS;
}

fn unpack_radius(packed: vec4<f32>) -> f32 {
    return packed.a * 255.0 / 16.0;
}

fn colour_map_at(value: f32) -> vec3<f32> {
    let position = clamp(value, 0.0, 1.0) * 11.0;
    let below = min(u32(position), 10u);
    return mix(frame.colour_map[below].rgb, frame.colour_map[below + 1u].rgb, position - f32(below));
}

// A corner of the triangle that covers the whole target.
fn full_screen_triangle(vertex: u32) -> vec4<f32> {
    let corner = vec2<f32>(f32((vertex << 1u) & 2u), f32(vertex & 2u));
    return vec4<f32>(corner * 2.0 - 1.0, 0.0, 1.0);
}
