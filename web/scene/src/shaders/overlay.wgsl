// Draws lines, markers and the grid on top of the shaded image, faintly where a surface hides them.

// Lines lie on floors that are drawn as points. So a line counts as visible up to this distance (m) and ratio of depths behind a
// point.
const BEHIND_BY: f32 = 0.12;
const BEHIND_RATIO: f32 = 1.015;

fn visibility(position: vec4<f32>, depth: f32, behind: f32) -> f32 {
    let scene = metres(unpack_depth(packed_at(vec2<i32>(position.xy))));
    return select(1.0, behind, depth > scene * BEHIND_RATIO + BEHIND_BY);
}

// Premultiplied, and faded at an edge that is `inside_px` pixels away.
fn blended(colour: vec4<f32>, inside_px: f32, shown: f32) -> vec4<f32> {
    let alpha = colour.a * clamp(inside_px + 0.5, 0.0, 1.0) * shown;
    return vec4<f32>(colour.rgb * alpha, alpha);
}

fn clip_of(position: vec3<f32>) -> vec4<f32> {
    return frame.clip_from_relative * vec4<f32>(position - frame.camera.xyz, 1.0);
}

fn pixel_of(clip: vec4<f32>) -> vec2<f32> {
    return clip.xy / clip.w * frame.viewport.xy * 0.5;
}

// Two triangles of a quad from -1 to 1.
fn corner_of(vertex: u32) -> vec2<f32> {
    let right = vertex == 1u || vertex == 2u || vertex == 4u;
    let top = vertex == 2u || vertex == 4u || vertex == 5u;
    return vec2<f32>(select(-1.0, 1.0, right), select(-1.0, 1.0, top));
}

// Positions are already divided by w, so that pixels are interpolated evenly across the screen. Quantities of the map are therefore
// divided by depth before interpolation.
struct Line {
    @builtin(position) clip: vec4<f32>,
    @location(0) colour: vec4<f32>,
    // Pixels along and across the segment, from its start.
    @location(1) place: vec2<f32>,
    // Length (pixels), half width (pixels), opacity when hidden, length of a dash (metres, 0 for none).
    @location(2) @interpolate(flat) shape: vec4<f32>,
    // One over depth, metres along the whole line over depth.
    @location(3) over_depth: vec2<f32>,
}

// Depth of the cut, m: 20 % beyond `CameraProjection::NEAR_M`.
const NEAR: f32 = 0.012;

@vertex
fn vs_lines(
    @builtin(vertex_index) vertex: u32,
    @location(0) from_map: vec3<f32>, @location(1) to_map: vec3<f32>, @location(2) colour: vec4<f32>,
    // Width (logical pixels), opacity when hidden, length of a dash (metres), metres along at the start.
    @location(3) style: vec4<f32>,
) -> Line {
    var from_clip = clip_of(from_map);
    var to_clip = clip_of(to_map);
    var out: Line;
    if from_clip.w < NEAR && to_clip.w < NEAR {
        out.clip = vec4<f32>(2.0, 2.0, 2.0, 1.0);
        return out;
    }
    // Cut at the near plane, because points behind the camera project to the wrong side.
    var cut = vec2<f32>(0.0, 1.0);
    if from_clip.w < NEAR {
        cut.x = (NEAR - from_clip.w) / (to_clip.w - from_clip.w);
    }
    if to_clip.w < NEAR {
        cut.y = (NEAR - from_clip.w) / (to_clip.w - from_clip.w);
    }
    let start = mix(from_clip, to_clip, cut.x);
    let end = mix(from_clip, to_clip, cut.y);
    let start_px = pixel_of(start);
    let end_px = pixel_of(end);
    let span = end_px - start_px;
    let length_px = max(length(span), 0.001);
    let along = select(vec2<f32>(1.0, 0.0), span / length_px, length_px > 0.01);
    let across = vec2<f32>(-along.y, along.x);
    let half_width = 0.5 * style.x * frame.viewport.z;
    let corner = corner_of(vertex);
    let margin = half_width + 1.0;
    let at_end = corner.x > 0.0;
    let base = select(start, end, at_end);
    let pixel = select(start_px, end_px, at_end) + along * corner.x * margin + across * corner.y * margin;
    out.clip = vec4<f32>(pixel / (frame.viewport.xy * 0.5), base.z / base.w, 1.0);
    out.colour = colour;
    out.place = vec2<f32>(select(-margin, length_px + margin, at_end), corner.y * margin);
    out.shape = vec4<f32>(length_px, half_width, style.y, style.z);
    let metres_at = style.w + length(to_map - from_map) * select(cut.x, cut.y, at_end);
    out.over_depth = vec2<f32>(1.0, metres_at) / base.w;
    return out;
}

@fragment
fn fs_lines(in: Line) -> @location(0) vec4<f32> {
    let beyond = in.place.x - clamp(in.place.x, 0.0, in.shape.x);
    let from_axis = length(vec2<f32>(beyond, in.place.y));
    let depth = 1.0 / in.over_depth.x;
    let gap = in.shape.w > 0.0 && fract(in.over_depth.y * depth / max(in.shape.w, 0.001)) > 0.55;
    let shown = select(visibility(in.clip, depth, in.shape.z), 0.0, gap);
    return blended(in.colour, in.shape.y - from_axis, shown);
}

struct MarkerInstance {
    @builtin(position) clip: vec4<f32>,
    @location(0) fill: vec4<f32>,
    @location(1) rim: vec4<f32>,
    // Pixels from the middle.
    @location(2) place: vec2<f32>,
    // Radius (pixels), shape, opacity when hidden, width of the rim (pixels).
    @location(3) @interpolate(flat) shape: vec4<f32>,
    @location(4) @interpolate(flat) depth: f32,
}

@vertex
fn vs_markers(
    @builtin(vertex_index) vertex: u32,
    @location(0) centre_map: vec3<f32>, @location(1) ahead: vec3<f32>,
    @location(2) fill: vec4<f32>, @location(3) rim: vec4<f32>,
    // Largest and smallest radius (logical pixels), radius in the world (metres, 0 for the largest), shape.
    @location(4) style: vec4<f32>,
    // Opacity when hidden, range of the projected radius in which the marker is drawn (logical pixels).
    @location(5) visible: vec3<f32>,
) -> MarkerInstance {
    let centre = clip_of(centre_map);
    var out: MarkerInstance;
    if centre.w < NEAR {
        out.clip = vec4<f32>(2.0, 2.0, 2.0, 1.0);
        return out;
    }
    let scale = frame.viewport.z;
    let world_px = style.z * frame.camera.w / centre.w;
    if world_px < visible.y * scale || world_px >= visible.z * scale {
        out.clip = vec4<f32>(2.0, 2.0, 2.0, 1.0);
        return out;
    }
    let radius = select(clamp(world_px, style.y * scale, style.x * scale), style.x * scale, style.z <= 0.0);
    let margin = radius + 2.0;
    let corner = corner_of(vertex) * margin;
    // The direction of `ahead` on the screen, which is the marker's local x axis.
    var axis = vec2<f32>(1.0, 0.0);
    if dot(ahead, ahead) > 0.0 {
        let tip = clip_of(centre_map + ahead * 0.2);
        let on_screen = pixel_of(tip) - pixel_of(centre);
        if tip.w > NEAR && length(on_screen) > 0.001 {
            axis = normalize(on_screen);
        }
    }
    let turned = vec2<f32>(corner.x * axis.x - corner.y * axis.y, corner.x * axis.y + corner.y * axis.x);
    let pixel = pixel_of(centre) + turned;
    out.clip = vec4<f32>(pixel / (frame.viewport.xy * 0.5), centre.z / centre.w, 1.0);
    out.fill = fill;
    out.rim = rim;
    out.place = corner;
    out.shape = vec4<f32>(radius, style.w, visible.x, min(1.5 * scale, 0.35 * radius));
    out.depth = centre.w;
    return out;
}

// Pixels from the edge of a shape of unit size, negative inside.
fn edge_distance(place: vec2<f32>, radius: f32, shape: f32) -> f32 {
    if shape < 0.5 {
        return length(place) - radius;
    } else if shape < 1.5 {
        return (abs(place.x) + abs(place.y) - radius) * 0.7071;
    } else if shape < 2.5 {
        let beyond = abs(place) - vec2<f32>(radius * 0.8);
        return max(beyond.x, beyond.y);
    } else if shape < 3.5 {
        // An arrow head along x.
        let flank = dot(vec2<f32>(place.x - radius, abs(place.y)), vec2<f32>(0.4472, 0.8944));
        return max(flank, -0.7 * radius - place.x);
    } else if shape < 4.5 {
        return abs(length(place) - radius * 0.86) - radius * 0.14;
    }
    // A disc of 0.62 of the radius, and a point along x whose flanks are tangents of the disc.
    let disc = length(place) - 0.62 * radius;
    let flank = dot(vec2<f32>(place.x, abs(place.y)), vec2<f32>(0.62, 0.7846)) - 0.62 * radius;
    return min(disc, max(flank, 0.3844 * radius - place.x));
}

@fragment
fn fs_markers(in: MarkerInstance) -> @location(0) vec4<f32> {
    let edge = edge_distance(in.place, in.shape.x, in.shape.y);
    let shown = visibility(in.clip, in.depth, in.shape.z);
    let core = clamp(0.5 - (edge + in.shape.w), 0.0, 1.0);
    let colour = mix(in.rim, in.fill, core);
    return blended(colour, -edge, shown);
}

struct Ground {
    @builtin(position) clip: vec4<f32>,
    @location(0) map: vec2<f32>,
    @location(1) depth: f32,
    @location(2) local: vec2<f32>,
}

@vertex
fn vs_grid(@builtin(vertex_index) vertex: u32) -> Ground {
    let corner = corner_of(vertex);
    let half = frame.grid_shape.x;
    let middle = frame.camera.xy;
    let relative = vec3<f32>(corner * half, frame.style.w - frame.camera.z);
    let clip = frame.clip_from_relative * vec4<f32>(relative, 1.0);
    return Ground(clip, middle + corner * half, clip.w, corner);
}

fn line_share(place: vec2<f32>, spacing: f32, width: vec2<f32>) -> f32 {
    let cell = place / spacing;
    let from_line = abs(fract(cell - 0.5) - 0.5) * spacing;
    let share = clamp(1.0 - from_line / max(width, vec2<f32>(1e-6)), vec2<f32>(0.0), vec2<f32>(1.0));
    // Lines closer together than pixels are faded out, because they would shimmer.
    let calm = clamp(0.25 * spacing / max(width.x, width.y) - 0.5, 0.0, 1.0);
    return max(share.x, share.y) * calm;
}

@fragment
fn fs_grid(in: Ground) -> @location(0) vec4<f32> {
    let width = fwidth(in.map) * frame.viewport.z;
    let fine = line_share(in.map, frame.grid_shape.y, width);
    let bold = line_share(in.map, frame.grid_shape.y * 10.0, width * 1.4);
    let fade = clamp(1.0 - length(in.local), 0.0, 1.0);
    let share = max(fine * 0.45, bold) * fade * frame.grid.a;
    let shown = visibility(in.clip, in.depth, 0.0);
    return vec4<f32>(frame.grid.rgb * share * shown, share * shown);
}
