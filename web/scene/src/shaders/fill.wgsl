// Gap filling: grows points to discs, along rows first and then along columns. Every pixel takes the nearest point whose disc
// reaches it. The first pass leaves the half width of the disc in the column's direction as the radius for the second pass.

// How many pixels to each side are read, for each block of pixels: see reach.wgsl.
@group(2) @binding(0) var reach_texture: texture_2d<f32>;

struct Filled {
    @location(0) colour: vec4<f32>,
    @location(1) depth: vec4<f32>,
}

// A neighbour takes an occupied pixel only if it is in front by this share of the depth range, 0.0216 octaves or about 1.5 %. So
// points of one surface keep their own pixels and colours.
const FRONT_BY: f32 = 0.00108;

@vertex
fn vs_fill(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    return full_screen_triangle(vertex);
}

fn fill(pixel: vec2<i32>, along: vec2<i32>) -> Filled {
    let own = packed_at(pixel);
    var best = own;
    var best_depth = unpack_depth(own) - FRONT_BY;
    var best_pixel = pixel;
    var best_offset = 0.0;
    if own.r + own.g + own.b > 2.9999 {
        best_depth = 2.0;
    }
    let reach = i32(ceil(unpack_radius(textureLoad(reach_texture, pixel / BLOCK, 0))));
    for (var i = -reach; i <= reach; i++) {
        let at = inside(pixel + along * i);
        let candidate = textureLoad(depth_texture, at, 0);
        let offset = abs(f32(i));
        if offset <= unpack_radius(candidate) && i != 0 {
            let depth = unpack_depth(candidate);
            // Of points at one depth, the one nearer on the screen is taken, so that colours do not smear in one direction.
            if depth < 0.9999995 && depth + 0.00002 * offset < best_depth {
                best = candidate;
                best_depth = depth + 0.00002 * offset;
                best_pixel = at;
                best_offset = offset;
            }
        }
    }
    let radius = unpack_radius(best);
    let remains = sqrt(max(radius * radius - best_offset * best_offset, 0.0));
    return Filled(
        textureLoad(colour_texture, best_pixel, 0),
        vec4<f32>(best.rgb, clamp(remains * 16.0 / 255.0, 0.0, 1.0)),
    );
}

@fragment
fn fs_rows(@builtin(position) position: vec4<f32>) -> Filled {
    return fill(vec2<i32>(position.xy), vec2<i32>(1, 0));
}

@fragment
fn fs_columns(@builtin(position) position: vec4<f32>) -> Filled {
    return fill(vec2<i32>(position.xy), vec2<i32>(0, 1));
}
