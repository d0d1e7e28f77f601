// How many pixels to each side the fill passes read: the largest radius of the points that reach a block of pixels. Most blocks are reached
// by small points or by none. With one number for the whole image, one large point near the camera would make every pixel read 15 pixels to each side.

// A radius in the form of the packed depth's fourth byte: for `fs_block` the packed depth itself, for `fs_reach` what `fs_block` drew.
@group(1) @binding(0) var radius_texture: texture_2d<f32>;

@vertex
fn vs_reach(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    return full_screen_triangle(vertex);
}

// The largest radius of the points in a block.
@fragment
fn fs_block(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let first = vec2<i32>(position.xy) * BLOCK;
    let last = vec2<i32>(frame.viewport.xy) - 1;
    var largest = 0.0;
    for (var y = 0; y < BLOCK; y++) {
        for (var x = 0; x < BLOCK; x++) {
            let pixel = min(first + vec2<i32>(x, y), last);
            largest = max(largest, textureLoad(radius_texture, pixel, 0).a);
        }
    }
    return vec4<f32>(largest);
}

// The largest radius of the points of all blocks that reach a block. A point spreads along its row and then along its column, so it reaches
// what is within its radius in both. The largest possible radius, 15.9 pixels, reaches two blocks and no third.
@fragment
fn fs_reach(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let block = vec2<i32>(position.xy);
    let last = (vec2<i32>(frame.viewport.xy) - 1) / BLOCK;
    var largest = 0.0;
    for (var y = -2; y <= 2; y++) {
        for (var x = -2; x <= 2; x++) {
            let radius = textureLoad(radius_texture, clamp(block + vec2<i32>(x, y), vec2<i32>(0), last), 0).a;
            // Between the nearest pixels of both blocks.
            let distance = f32(max(max(abs(x), abs(y)) * BLOCK - BLOCK + 1, 0));
            if unpack_radius(vec4<f32>(radius)) >= distance {
                largest = max(largest, radius);
            }
        }
    }
    return vec4<f32>(largest);
}
