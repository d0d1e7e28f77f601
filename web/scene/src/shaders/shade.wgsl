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

fn occlusion(pixel: vec2<i32>, depth: f32, radius: f32) -> f32 {
    let diagonal = radius * 0.7071;
    var sum = in_front(pixel, vec2<f32>(radius, 0.0), depth);
    sum += in_front(pixel, vec2<f32>(-radius, 0.0), depth);
    sum += in_front(pixel, vec2<f32>(0.0, radius), depth);
    sum += in_front(pixel, vec2<f32>(0.0, -radius), depth);
    sum += in_front(pixel, vec2<f32>(diagonal, diagonal), depth);
    sum += in_front(pixel, vec2<f32>(-diagonal, diagonal), depth);
    sum += in_front(pixel, vec2<f32>(diagonal, -diagonal), depth);
    sum += in_front(pixel, vec2<f32>(-diagonal, -diagonal), depth);
    return sum / 8.0;
}

@fragment
fn fs_shade(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(position.xy);
    let ground = mix(globals.ground_top.rgb, globals.ground_bottom.rgb, position.y / globals.viewport.y);
    let depth = unpack_depth(packed_at(pixel));
    if depth > 0.9999995 {
        return vec4<f32>(ground, 1.0);
    }
    let fine = occlusion(pixel, depth, 1.3 * globals.viewport.z);
    let broad = occlusion(pixel, depth, 4.0 * globals.viewport.z);
    let light = exp(-globals.style.y * (9.0 * fine + 4.0 * broad));
    let colour = textureLoad(picture_colour, pixel, 0).rgb * max(light, 0.12);
    return vec4<f32>(colour, 1.0);
}
