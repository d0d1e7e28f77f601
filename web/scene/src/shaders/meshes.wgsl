// Draws the robot's mesh, with a key light, a light at the camera and ambient light from the sky.

struct Solid {
    @builtin(position) clip: vec4<f32>,
    @location(0) normal: vec3<f32>,
    @location(1) colour: vec4<f32>,
    @location(2) relative: vec3<f32>,
}

@vertex
fn vs_meshes(
    @location(0) position: vec3<f32>, @location(1) normal: vec3<f32>, @location(2) colour: vec4<f32>,
) -> Solid {
    let relative = draw.relative_from_local * vec4<f32>(position, 1.0);
    var out: Solid;
    out.clip = frame.clip_from_relative * vec4<f32>(relative.xyz, 1.0);
    out.normal = (draw.relative_from_local * vec4<f32>(normal, 0.0)).xyz;
    out.colour = colour;
    out.relative = relative.xyz;
    return out;
}

@fragment
fn fs_meshes(in: Solid) -> Surface {
    let normal = normalize(in.normal);
    let to_eye = -normalize(in.relative);
    let key = max(dot(normal, vec3<f32>(0.36, -0.48, 0.8)), 0.0);
    let fill = max(dot(normal, to_eye), 0.0);
    let sky = 0.5 + 0.5 * normal.z;
    let glint = pow(max(dot(reflect(-to_eye, normal), vec3<f32>(0.36, -0.48, 0.8)), 0.0), 24.0);
    // Vertices with half opacity take the theme's colour, the others keep their own.
    let base = mix(in.colour.rgb, draw.tint.rgb, step(in.colour.a, 0.75));
    let shaded = base * (0.28 + 0.18 * sky + 0.42 * key + 0.22 * fill) + vec3<f32>(0.10 * glint);
    let clip = frame.clip_from_relative * vec4<f32>(in.relative, 1.0);
    return Surface(vec4<f32>(shaded, 1.0), pack_depth(log_depth(clip.w), 0.0));
}
