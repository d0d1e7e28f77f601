// Bindings of the colour and the packed depth that earlier passes drew.

@group(1) @binding(0) var colour_texture: texture_2d<f32>;
@group(1) @binding(1) var depth_texture: texture_2d<f32>;

fn inside(pixel: vec2<i32>) -> vec2<i32> {
    return clamp(pixel, vec2<i32>(0), vec2<i32>(frame.viewport.xy) - 1);
}

fn packed_at(pixel: vec2<i32>) -> vec4<f32> {
    return textureLoad(depth_texture, inside(pixel), 0);
}
