// Colour and packed depth of the picture so far.

@group(1) @binding(0) var picture_colour: texture_2d<f32>;
@group(1) @binding(1) var picture_depth: texture_2d<f32>;

fn inside(pixel: vec2<i32>) -> vec2<i32> {
    return clamp(pixel, vec2<i32>(0), vec2<i32>(globals.viewport.xy) - 1);
}

fn packed_at(pixel: vec2<i32>) -> vec4<f32> {
    return textureLoad(picture_depth, inside(pixel), 0);
}
