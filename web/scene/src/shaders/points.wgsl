// Draws points as single pixels; the fill passes grow them.

struct Point {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) colour: vec4<f32>,
    @location(1) @interpolate(flat) depth: vec4<f32>,
}

@vertex
fn vs_points(@location(0) point: vec4<u32>) -> Point {
    let relative = draw.relative_from_local * vec4<f32>(vec3<f32>(point.xyz), 1.0);
    let height = relative.z + frame.camera.z;
    var out: Point;
    out.clip = frame.clip_from_relative * vec4<f32>(relative.xyz, 1.0);
    let clipped = height < frame.heights.x || height > frame.heights.y;
    if clipped && draw.kind.w > 0.5 {
        out.clip = vec4<f32>(2.0, 2.0, 2.0, 1.0);
    }
    // Of two clouds that are wiped, the earlier one is drawn left of a line across the image and the later one right of it.
    let side = draw.kind.z;
    let across = 0.5 + 0.5 * out.clip.x / max(out.clip.w, 0.001);
    if (side < -0.5 && across > -side - 1.0) || (side > 0.5 && across < side - 1.0) {
        out.clip = vec4<f32>(2.0, 2.0, 2.0, 1.0);
    }
    let depth = max(out.clip.w, 0.001);
    // The same formula as `PointSizeConfig::radius_px` in uniforms.rs.
    let radius = draw.kind.x * frame.camera.w / depth * frame.style.x;
    out.depth = pack_depth(log_depth(depth), drawn_radius(radius));
    out.colour = vec4<f32>(mix(point_colour(height, f32(point.w & 255u) / 255.0), draw.tint.rgb, draw.tint.w), 1.0);
    return out;
}

// The radius (pixels) of a point that would close its surface with `closing`. Beyond the largest radius the surface stays open, and the
// point shrinks towards a dot.
fn drawn_radius(closing: f32) -> f32 {
    let largest = frame.viewport.w;
    if closing <= largest {
        return max(closing, frame.grid_shape.z);
    }
    return clamp(largest * largest / closing, min(frame.grid_shape.w, largest), largest);
}

fn point_colour(height: f32, intensity: f32) -> vec3<f32> {
    let mode = frame.style.z;
    if mode > 2.5 {
        return frame.plain.rgb;
    } else if mode > 1.5 {
        return colour_map_at(draw.kind.y);
    } else if mode > 0.5 {
        // Most surfaces reflect little; the square root spreads low intensities.
        return colour_map_at(sqrt(intensity));
    }
    return colour_map_at((height - frame.heights.z) / frame.heights.w);
}

@fragment
fn fs_points(in: Point) -> Surface {
    return Surface(in.colour, in.depth);
}
