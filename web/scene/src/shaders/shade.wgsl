// Background and eye-dome lighting (Boucheny, 2009): a pixel darkens by how far its neighbours stand in front of it,
// measured as a ratio of depths, so that it works at every distance.

@vertex
fn vs_shade(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    return whole_picture(vertex);
}

fn in_front(pixel: vec2<i32>, offset: vec2<f32>, depth: f32) -> f32 {
    let neighbour = unpack_depth(packed_at(pixel + vec2<i32>(round(offset))));
    // A silhouette far in front counts no more than a ledge, or every post would wear a halo.
    return clamp((depth - neighbour) * DEPTH_OCTAVES, 0.0, 0.35);
}

// Four neighbours: `along` and those a quarter turn from it.
fn occlusion(pixel: vec2<i32>, depth: f32, along: vec2<f32>) -> f32 {
    let turned = vec2<f32>(-along.y, along.x);
    let sum = in_front(pixel, along, depth) + in_front(pixel, -along, depth)
        + in_front(pixel, turned, depth) + in_front(pixel, -turned, depth);
    return sum * 0.25;
}

@fragment
fn fs_shade(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(position.xy);
    let ground = mix(globals.ground_top.rgb, globals.ground_bottom.rgb, position.y / globals.viewport.y);
    let depth = unpack_depth(packed_at(pixel));
    if depth > 0.9999995 {
        return vec4<f32>(ground, 1.0);
    }
    var light = 1.0;
    if globals.style.y > 0.0 {
        // Edges from the nearest neighbours, soft shadows from those farther away.
        let fine = occlusion(pixel, depth, vec2<f32>(1.3 * globals.viewport.z, 0.0));
        let broad = occlusion(pixel, depth, vec2<f32>(2.8 * globals.viewport.z));
        light = max(exp(-globals.style.y * (9.0 * fine + 4.0 * broad)), 0.12);
    }
    let colour = textureLoad(picture_colour, pixel, 0).rgb * light;
    return vec4<f32>(colour, 1.0);
}
