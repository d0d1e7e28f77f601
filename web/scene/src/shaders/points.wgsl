// Points as single pixels; the fill passes grow them.

struct Point {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) colour: vec4<f32>,
    @location(1) @interpolate(flat) depth: vec4<f32>,
}

const RADIUS_MIN: f32 = 1.45;

@vertex
fn vs_points(@location(0) point: vec4<u32>) -> Point {
    let relative = piece.relative_from_local * vec4<f32>(vec3<f32>(point.xyz), 1.0);
    let height = relative.z + globals.eye.z;
    var out: Point;
    out.clip = globals.clip_from_relative * vec4<f32>(relative.xyz, 1.0);
    let clipped = height < globals.heights.x || height > globals.heights.y;
    if clipped && piece.kind.w > 0.5 {
        out.clip = vec4<f32>(2.0, 2.0, 2.0, 1.0);
    }
    let depth = max(out.clip.w, 0.001);
    // As `radius_px` in uniforms.rs.
    let radius = piece.kind.x * globals.eye.w / depth * globals.style.x;
    out.depth = pack_depth(log_depth(depth), clamp(radius, RADIUS_MIN, globals.viewport.w));
    out.colour = vec4<f32>(mix(point_colour(height, f32(point.w & 255u) / 255.0), piece.tint.rgb, piece.tint.w), 1.0);
    return out;
}

fn point_colour(height: f32, intensity: f32) -> vec3<f32> {
    let mode = globals.style.z;
    if mode > 2.5 {
        return globals.plain.rgb;
    } else if mode > 1.5 {
        return ramp_colour(piece.kind.y);
    } else if mode > 0.5 {
        // Most surfaces reflect little; the root spreads them.
        return ramp_colour(sqrt(intensity));
    }
    return ramp_colour((height - globals.heights.z) / globals.heights.w);
}

@fragment
fn fs_points(in: Point) -> Surface {
    return Surface(in.colour, in.depth);
}
