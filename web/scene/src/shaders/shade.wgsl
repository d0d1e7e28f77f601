// Background and eye-dome lighting (Boucheny, 2009): a pixel is darkened by the amount by which its neighbours
// are in front of it, as a ratio of depths, so that the shading does not depend on the distance.

@vertex
fn vs_shade(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    return full_screen_triangle(vertex);
}

fn in_front(pixel: vec2<i32>, offset: vec2<f32>, depth: f32) -> f32 {
    let neighbour = unpack_depth(packed_at(pixel + vec2<i32>(round(offset))));
    // Limited, so that an object far in front has no dark halo.
    return clamp((depth - neighbour) * DEPTH_OCTAVES, 0.0, 0.35);
}

// Compares with four neighbours: at `along` and at its three quarter turns.
fn occlusion(pixel: vec2<i32>, depth: f32, along: vec2<f32>) -> f32 {
    let turned = vec2<f32>(-along.y, along.x);
    let sum = in_front(pixel, along, depth) + in_front(pixel, -along, depth)
        + in_front(pixel, turned, depth) + in_front(pixel, -turned, depth);
    return sum * 0.25;
}

@fragment
fn fs_shade(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(position.xy);
    let ground = mix(frame.ground_top.rgb, frame.ground_bottom.rgb, position.y / frame.viewport.y);
    let depth = unpack_depth(packed_at(pixel));
    if depth > 0.9999995 {
        return vec4<f32>(ground, 1.0);
    }
    var light = 1.0;
    if frame.style.y > 0.0 {
        // The near neighbours shade edges, the farther ones give soft shadows.
        let fine = occlusion(pixel, depth, vec2<f32>(1.3 * frame.viewport.z, 0.0));
        let broad = occlusion(pixel, depth, vec2<f32>(2.8 * frame.viewport.z));
        light = max(exp(-frame.style.y * (9.0 * fine + 4.0 * broad)), 0.12);
    }
    let colour = textureLoad(colour_texture, pixel, 0).rgb * light;
    return vec4<f32>(colour, 1.0);
}
