//! Draws on every graphics adapter that exists, software devices such as lavapipe and llvmpipe included, and checks the pixels.
//!
//! `AUTOINSPECT_SCENE_PICTURES=DIR` stores the pictures as PNG files.

use super::{TestTile, palette, view};
use crate::render_targets::attachment;
use crate::*;
use glam::{DQuat, DVec2, DVec3};

const SIZE: [u32; 2] = [1280, 800];

struct TestGpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    name: String,
}

impl TestGpu {
    /// One for each back end that works on this machine; prints a note when there is none.
    fn all() -> Vec<Self> {
        let studios: Vec<Self> =
            [wgpu::Backends::VULKAN, wgpu::Backends::GL].into_iter().filter_map(Self::on).collect();
        if studios.is_empty() {
            println!("skipped: no graphics adapter here, not even a software one");
        }
        studios
    }

    fn on(backends: wgpu::Backends) -> Option<Self> {
        let descriptor =
            wgpu::InstanceDescriptor { backends, ..wgpu::InstanceDescriptor::new_without_display_handle() };
        let instance = wgpu::Instance::new(descriptor);
        let options = wgpu::RequestAdapterOptions::default();
        let adapter = pollster::block_on(instance.request_adapter(&options)).ok()?;
        // The scene must draw within the limits that WebGL2 guarantees.
        let limits = wgpu::Limits::downlevel_webgl2_defaults();
        let descriptor =
            wgpu::DeviceDescriptor { required_limits: limits, ..wgpu::DeviceDescriptor::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).ok()?;
        Some(Self { device, queue, name: format!("{:?}", adapter.get_info().backend).to_lowercase() })
    }

    fn renderer(&self) -> Renderer {
        Renderer::new(&self.device, &self.queue, wgpu::TextureFormat::Rgba8Unorm)
    }

    /// Prepares and paints a view, and returns its pixels.
    fn render(&self, renderer: &mut Renderer, view: &View, name: &str) -> Image {
        let [width, height] = view.viewport_px;
        let extent = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let target = self.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: extent,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let stride = (width * 4).next_multiple_of(256);
        let back = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(stride * height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        renderer.prepare(&mut encoder, view);
        {
            let texture_view = target.create_view(&wgpu::TextureViewDescriptor::default());
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[Some(attachment(
                    &texture_view,
                    wgpu::LoadOp::Clear(wgpu::Color::GREEN),
                ))],
                ..wgpu::RenderPassDescriptor::default()
            });
            renderer.paint(&mut pass);
        }
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(stride), rows_per_image: None };
        let copy = wgpu::TexelCopyBufferInfo { buffer: &back, layout };
        encoder.copy_texture_to_buffer(target.as_image_copy(), copy, extent);
        self.queue.submit([encoder.finish()]);
        back.slice(..).map_async(wgpu::MapMode::Read, |_| {});
        self.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        let mapped = back.slice(..).get_mapped_range().unwrap();
        let rows = mapped.chunks(stride as usize).flat_map(|row| &row[..width as usize * 4]);
        let picture = Image { width, pixels: rows.copied().collect::<Vec<u8>>() };
        picture.keep(&format!("{name}-{}.png", self.name), height);
        picture
    }
}

struct Image {
    width: u32,
    pixels: Vec<u8>,
}

impl Image {
    fn at(&self, pixel: DVec2) -> [u8; 3] {
        let start = (pixel.y as usize * self.width as usize + pixel.x as usize) * 4;
        [self.pixels[start], self.pixels[start + 1], self.pixels[start + 2]]
    }

    fn keep(&self, name: &str, height: u32) {
        let Some(folder) = std::env::var_os("AUTOINSPECT_SCENE_PICTURES") else {
            return;
        };
        let file = std::fs::File::create(std::path::Path::new(&folder).join(name)).unwrap();
        let mut encoder = png::Encoder::new(file, self.width, height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.write_header().unwrap().write_image_data(&self.pixels).unwrap();
    }
}

/// A hall of 24 x 16 m with racks and a pipe, in three levels of detail like a map.
fn hall() -> Vec<TestTile> {
    let mut levels: Vec<Vec<DVec3>> = vec![Vec::new(); 3];
    let mut put = |x: f64, y: f64, z: f64, i: i64, j: i64| {
        let level = if i % 4 == 0 && j % 4 == 0 {
            0
        } else if i % 2 == 0 && j % 2 == 0 {
            1
        } else {
            2
        };
        levels[level].push(DVec3::new(x, y, z));
    };
    let mut plane = |corner: DVec3, u: DVec3, v: DVec3| {
        let (long, high) = ((u.length() / 0.05) as i64, (v.length() / 0.05) as i64);
        for i in 0..long {
            for j in 0..high {
                let rough = ((i * 7 + j * 13) % 10) as f64 * 0.001;
                let at = corner + u * (i as f64 / long as f64) + v * (j as f64 / high as f64) + rough;
                put(at.x, at.y, at.z, i, j);
            }
        }
    };
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    plane(DVec3::new(-12.0, -8.0, 0.0), x * 24.0, y * 16.0);
    plane(DVec3::new(-12.0, 8.0, 0.0), x * 24.0, z * 4.0);
    plane(DVec3::new(12.0, -8.0, 0.0), y * 16.0, z * 4.0);
    plane(DVec3::new(-12.0, -8.0, 4.0), x * 24.0, y * 16.0);
    for rack in 0..3 {
        let corner = DVec3::new(-6.0 + 4.0 * f64::from(rack), 2.0, 0.0);
        for side in [x * 0.0, x * 1.0] {
            plane(corner + side, y * 4.0, z * 2.2);
        }
        for side in [y * 0.0, y * 4.0] {
            plane(corner + side, x * 1.0, z * 2.2);
        }
        plane(corner + z * 2.2, x * 1.0, y * 4.0);
    }
    levels.iter().zip([0.2, 0.1, 0.05]).map(|(points, spacing)| TestTile::new(points, spacing)).collect()
}

fn furnished_hall(gpu: &TestGpu) -> Renderer {
    let mut renderer = gpu.renderer();
    for (id, made) in (0..).zip(hall()) {
        renderer.upload_tile(TileId(id), WHOLE_MAP, &made.block());
    }
    let trajectory: Vec<DVec3> = (0..60)
        .map(|i| DVec3::new(-9.0 + 0.25 * f64::from(i), -3.0 + (f64::from(i) * 0.1).sin(), 0.0))
        .collect();
    renderer.set_trajectory(&trajectory);
    let nodes: Vec<PoseNode> =
        (0..).zip(trajectory.iter().step_by(6)).map(|(n, at)| node(n, *at, 0.0)).collect();
    let edges: Vec<[DVec3; 2]> = nodes.windows(2).map(|pair| [pair[0].position, pair[1].position]).collect();
    renderer.set_graph(&nodes, &edges);
    renderer.set_robot(Some(robot()));
    renderer.set_goal(
        Some(DVec3::new(9.0, 1.0, 0.0)),
        &[trajectory[59], DVec3::new(7.5, -1.0, 0.0), DVec3::new(9.0, 1.0, 0.0)],
    );
    renderer
}

fn node(number: u32, position: DVec3, uncertainty: f32) -> PoseNode {
    PoseNode { number, position, uncertainty }
}

fn robot() -> RobotState {
    RobotState {
        position: DVec3::new(5.75, -3.4, 0.5),
        orientation: DQuat::from_rotation_z(0.7),
        ok: true,
        selected: false,
        accuracy: 0.05,
        standing_height_m: 0.5,
    }
}

fn hall_view() -> View {
    let camera = CameraPose { target: DVec3::new(1.0, -1.0, 0.5), yaw: 0.9, pitch: 0.55, distance: 19.0 };
    let mut view = view(camera, SIZE);
    view.options.ceiling = 3.2;
    view
}

fn differs(a: [u8; 3], b: [u8; 3], by: u8) -> bool {
    a.iter().zip(b).any(|(a, b)| a.abs_diff(b) > by)
}

#[test]
fn surfaces_have_no_holes_and_the_background_has_the_themes_colour() {
    for gpu in TestGpu::all() {
        let mut renderer = furnished_hall(&gpu);
        let view = hall_view();
        let picture = gpu.render(&mut renderer, &view, "hall");
        let projection = CameraProjection::new(view.camera, SIZE);
        assert!(!differs(picture.at(DVec2::new(640.0, 2.0)), [13, 17, 23], 3), "{}", gpu.name);
        // The open floor has the lowest colour of the colour map, slate. Other pixels count as holes.
        let mut holes = 0;
        for i in 0..400 {
            let at = DVec3::new(-8.0 + f64::from(i % 20) * 0.2, -7.0 + f64::from(i / 20) * 0.12, 0.0);
            let (pixel, _) = projection.project(at).unwrap();
            let inside = pixel.cmpge(DVec2::ZERO).all() && pixel.cmplt(DVec2::new(1280.0, 800.0)).all();
            let [r, _, b] = if inside { picture.at(pixel) } else { [44, 62, 88] };
            holes += usize::from(b < r || b < 40);
        }
        assert!(holes < 8, "{}: {holes} holes in 400 points of the floor", gpu.name);
        assert!(renderer.statistics().points > 300_000);
    }
}

#[test]
fn a_lower_ceiling_limit_uncovers_the_yellow_robot() {
    for gpu in TestGpu::all() {
        let mut renderer = furnished_hall(&gpu);
        let mut view = hall_view();
        // The camera is above the ceiling and near enough for the robot's mesh.
        view.camera = CameraPose { target: robot().position, distance: 12.0, ..view.camera };
        let open = robot_pixels(&gpu.render(&mut renderer, &view, "open"), &view, 12);
        assert!(open > 60, "{}: {open} yellow pixels", gpu.name);
        view.options.ceiling = f32::MAX;
        let closed = robot_pixels(&gpu.render(&mut renderer, &view, "closed"), &view, 12);
        assert!(closed < open / 3, "{}: the ceiling does not cover the robot: {closed} of {open}", gpu.name);
    }
}

#[test]
fn with_a_deferred_overlay_the_first_image_shows_points_only_and_the_next_all() {
    for gpu in TestGpu::all() {
        let mut renderer = furnished_hall(&gpu);
        renderer.defer_overlay();
        let first = gpu.render(&mut renderer, &hall_view(), "deferred");
        assert!(renderer.needs_redraw(&hall_view()));
        let next = gpu.render(&mut renderer, &hall_view(), "deferred-next");
        assert!(!renderer.needs_redraw(&hall_view()));
        let mut undeferred = furnished_hall(&gpu);
        let all = gpu.render(&mut undeferred, &hall_view(), "undeferred");
        assert!(next.pixels == all.pixels);
        let mut bare = gpu.renderer();
        for (id, made) in (0..).zip(hall()) {
            bare.upload_tile(TileId(id), WHOLE_MAP, &made.block());
        }
        let points = gpu.render(&mut bare, &without_grid(), "points");
        assert!(first.pixels == points.pixels && first.pixels != all.pixels);
    }
}

fn without_grid() -> View {
    let view = hall_view();
    View { options: Options { grid: false, ..view.options }, ..view }
}

#[test]
fn moving_an_anchor_moves_its_points() {
    for gpu in TestGpu::all() {
        let mut renderer = gpu.renderer();
        let positions: Vec<DVec3> =
            (0..10_000).map(|i| DVec3::new(0.0, f64::from(i % 100), f64::from(i / 100)) * 0.01).collect();
        let anchor = AnchorId(7);
        renderer.upload_tile(TileId(1), anchor, &TestTile::new(&positions, 0.01).block());
        let camera = CameraPose { target: DVec3::new(0.0, 0.5, 0.5), yaw: 0.0, pitch: 0.0, distance: 4.0 };
        let view = view(camera, [400, 400]);
        let middle = DVec2::new(200.0, 200.0);
        let empty = gpu.render(&mut renderer, &view, "anchor-unplaced").at(middle);
        renderer.set_anchor(anchor, DVec3::ZERO, DQuat::IDENTITY);
        assert!(renderer.needs_redraw(&view));
        let there = gpu.render(&mut renderer, &view, "anchor-placed").at(middle);
        assert!(differs(there, empty, 15), "{}", gpu.name);
        assert!(!renderer.needs_redraw(&view));
        renderer.set_anchor(anchor, DVec3::new(0.0, 5.0, 0.0), DQuat::IDENTITY);
        let gone = gpu.render(&mut renderer, &view, "anchor-moved").at(middle);
        assert_eq!(gone, empty, "{}", gpu.name);
    }
}

#[test]
fn the_scene_draws_on_the_first_frame_and_picks_what_it_draws() {
    for gpu in TestGpu::all() {
        let mut renderer = furnished_hall(&gpu);
        let mut view = hall_view();
        view.options.colour_by = ColourBy::Intensity;
        view.options.grid = true;
        view.options.grid_height = -0.02;
        let close = CameraPose { target: robot().position, yaw: 2.5, pitch: 0.35, distance: 3.0 };
        gpu.render(&mut renderer, &view, "intensity");
        view.camera = close;
        view.options.colour_by = ColourBy::Height;
        gpu.render(&mut renderer, &view, "close");
        let projection = CameraProjection::new(close, SIZE);
        let options = PickOptions { target_px: 22.0, marker_px: 9.0, line_px: 6.0, point_px: 4.0 };
        let (body, _) = projection.project(robot().position).unwrap();
        assert_eq!(renderer.pick(&view, body, &options), Some(Hit::Robot));
        let floor = DVec3::new(4.5, -4.5, 0.0);
        let (pixel, _) = projection.project(floor).unwrap();
        let Some(Hit::Point(hit)) = renderer.pick(&view, pixel, &options) else {
            panic!("no point under {pixel}");
        };
        assert!(hit.distance(floor) < 0.15, "{hit}");
    }
}

#[test]
fn reading_fewer_pixels_where_points_are_small_changes_no_pixel() {
    for gpu in TestGpu::all() {
        let (mut renderer, mut far) = (furnished_hall(&gpu), furnished_hall(&gpu));
        far.read_all_around();
        // From outside, between the racks, and with the nose at the floor, where points are as large as they get. The last size has blocks of fewer pixels.
        let near = CameraPose { target: robot().position, yaw: 2.5, pitch: 0.35, distance: 3.0 };
        let nearest = CameraPose { target: DVec3::new(-4.0, 0.0, 0.1), yaw: 0.4, pitch: 0.2, distance: 0.7 };
        let cameras = [hall_view().camera, near, nearest];
        for (camera, size) in cameras.into_iter().zip([SIZE, SIZE, [1277, 795]]) {
            let view = View { camera, viewport_px: size, ..hall_view() };
            let all = gpu.render(&mut far, &view, "reach-far");
            let image = gpu.render(&mut renderer, &view, "reach");
            let changed = image.pixels.iter().zip(&all.pixels).filter(|(a, b)| a != b).count();
            assert_eq!(changed, 0, "{}: {camera:?}", gpu.name);
            let drawn = image.pixels.chunks(4).filter(|pixel| pixel[2] > 60).count();
            assert!(drawn > 100_000, "{}: {drawn} pixels show points at {camera:?}", gpu.name);
        }
    }
}

#[test]
fn an_empty_scene_is_only_background() {
    for gpu in TestGpu::all() {
        let mut renderer = gpu.renderer();
        let mut view = view(CameraPose::default(), [300, 200]);
        view.options.grid = true;
        let picture = gpu.render(&mut renderer, &view, "empty");
        assert!(!differs(picture.at(DVec2::new(150.0, 1.0)), [13, 17, 23], 3));
        assert_eq!(renderer.statistics(), FrameStatistics::default());
        assert_eq!(renderer.statistics().points_held, 0);
        assert_eq!(view.palette, palette());
    }
}

#[test]
fn compared_scans_have_their_own_colours_and_the_map_can_be_hidden() {
    for gpu in TestGpu::all() {
        let mut renderer = furnished_hall(&gpu);
        let wall = |x: f64| -> Vec<DVec3> {
            (0..20_000).map(|i| DVec3::new(x, f64::from(i % 200) * 0.02, f64::from(i / 200) * 0.02)).collect()
        };
        let scans = [TestTile::new(&wall(0.0), 0.02), TestTile::new(&wall(0.0), 0.02)];
        let [older, newer] = &scans;
        let place = |y: f64| DVec3::new(0.0, y, 20.0);
        renderer.set_compared([
            Some((&older.block(), place(0.0), DQuat::IDENTITY)),
            Some((&newer.block(), place(6.0), DQuat::IDENTITY)),
        ]);
        let camera = CameraPose { target: DVec3::new(0.0, 5.0, 21.0), yaw: 0.0, pitch: 0.0, distance: 12.0 };
        let mut view = View { options: Options { map: false, ..Options::default() }, ..view(camera, SIZE) };
        view.options.edl = 0.0;
        let picture = gpu.render(&mut renderer, &view, "compared");
        let projection = CameraProjection::new(camera, SIZE);
        for (y, colour) in [(2.0, palette().pair[0]), (8.0, palette().pair[1])] {
            let (pixel, _) = projection.project(DVec3::new(0.0, y, 21.0)).unwrap();
            assert!(!differs(picture.at(pixel), [colour[0], colour[1], colour[2]], 4), "{}", gpu.name);
        }
        assert_eq!(renderer.statistics().tiles, 0, "{}", gpu.name);
        renderer.set_compared([None, None]);
        gpu.render(&mut renderer, &view, "compared-no-more");
        assert_eq!(renderer.statistics().points, 0, "{}", gpu.name);
    }
}

#[test]
fn objects_of_two_visits_are_wiped_at_a_line_across_the_picture() {
    for gpu in TestGpu::all() {
        let mut renderer = gpu.renderer();
        // A wall across the picture, of both visits; the later one is nearer.
        let [earlier, later] = [0.0, -0.5].map(|x| {
            let place = |i: u32| DVec3::new(x, f64::from(i % 200) * 0.02, f64::from(i / 200) * 0.02);
            TestTile::new(&(0..20_000).map(place).collect::<Vec<_>>(), 0.02)
        });
        renderer.set_changed([Some(&earlier.block()), Some(&later.block())]);
        let camera = CameraPose { target: DVec3::new(0.0, 2.0, 1.0), yaw: 0.0, pitch: 0.0, distance: 6.0 };
        let mut view = View { options: Options { map: false, ..Options::default() }, ..view(camera, SIZE) };
        view.options.edl = 0.0;
        let middle = DVec2::new(f64::from(SIZE[0]), f64::from(SIZE[1])) / 2.0;
        let [before, after] = palette().changed;
        for (wipe, left, right) in
            [(Some(0.5), before, after), (None, after, after), (Some(1.0), before, before)]
        {
            view.options.wipe = wipe;
            let picture = gpu.render(&mut renderer, &view, "changed");
            for (side, colour) in [(-12.0, left), (12.0, right)] {
                let seen = picture.at(middle + DVec2::new(side, 0.0));
                assert!(
                    !differs(seen, [colour[0], colour[1], colour[2]], 4),
                    "{} {wipe:?} {side}: {seen:?}",
                    gpu.name
                );
            }
        }
        renderer.set_changed([None, None]);
        gpu.render(&mut renderer, &view, "changed-no-more");
        assert_eq!(renderer.statistics().points, 0, "{}", gpu.name);
    }
}

#[test]
fn nodes_take_the_uncertain_colour_by_their_uncertainty() {
    for gpu in TestGpu::all() {
        let mut renderer = gpu.renderer();
        let place = |n: u32| DVec3::new(0.0, 2.0 * f64::from(n), 0.0);
        let uncertainties = [0.0, 0.5, 1.0, f32::NAN];
        let nodes: Vec<PoseNode> =
            (0..).zip(uncertainties).map(|(n, uncertainty)| node(n, place(n), uncertainty)).collect();
        renderer.set_graph(&nodes, &[]);
        let camera = CameraPose { target: place(1), yaw: 0.0, pitch: 1.2, distance: 12.0 };
        let view = view(camera, SIZE);
        let projection = CameraProjection::new(camera, SIZE);
        let picture = gpu.render(&mut renderer, &view, "uncertainty");
        let (sure, vague) = (palette().node, palette().uncertain);
        let half: [u8; 4] = std::array::from_fn(|i| u8::midpoint(sure[i], vague[i]));
        for (n, wanted) in (0..).zip([sure, half, vague, vague]) {
            let (at, _) = projection.project(place(n) + DVec3::new(0.0, 0.0, 0.05)).unwrap();
            let seen = picture.at(at);
            assert!(!differs(seen, [wanted[0], wanted[1], wanted[2]], 20), "{} {n}: {seen:?}", gpu.name);
        }
    }
}

#[test]
fn loops_are_drawn_in_their_colours_and_the_selected_one_stands_out() {
    for gpu in TestGpu::all() {
        let mut renderer = gpu.renderer();
        let nodes: Vec<PoseNode> =
            (0..4).map(|n| node(n, DVec3::new(0.0, 2.0 * f64::from(n), 0.0), 0.0)).collect();
        renderer.set_graph(&nodes, &[]);
        let edge = |nodes: [u32; 2], state| {
            let ends = nodes.map(|n| DVec3::new(0.0, 2.0 * f64::from(n), 0.0));
            LoopEdge { nodes, ends, state }
        };
        renderer.set_loops(&[edge([0, 1], LoopState::Closed), edge([2, 3], LoopState::Rejected)]);
        let camera = CameraPose { target: DVec3::new(0.0, 3.0, 0.0), yaw: 0.0, pitch: 1.2, distance: 12.0 };
        let view = view(camera, SIZE);
        let projection = CameraProjection::new(camera, SIZE);
        let (at, _) = projection.project(DVec3::new(0.0, 1.0, 0.05)).unwrap();
        let thin = gpu.render(&mut renderer, &view, "loops");
        let purple = |[r, g, b]: [u8; 3]| r > 120 && b > 160 && g < 170 && g < r;
        assert!(purple(thin.at(at)), "{}: {:?}", gpu.name, thin.at(at));
        let beside = at + DVec2::new(0.0, 2.5);
        assert!(!purple(thin.at(beside)), "{}: a thin line", gpu.name);
        renderer.select_pair(Some([0, 1]));
        assert!(renderer.needs_redraw(&view));
        let thick = gpu.render(&mut renderer, &view, "loop-selected");
        assert!(purple(thick.at(beside - DVec2::new(0.0, 1.0))), "{}", gpu.name);
        let (node, _) = projection.project(DVec3::new(0.0, 0.0, 0.05)).unwrap();
        let colour = palette().pair[0];
        assert!(!differs(thick.at(node), [colour[0], colour[1], colour[2]], 30), "{}", gpu.name);
        let options = PickOptions { target_px: 22.0, marker_px: 9.0, line_px: 6.0, point_px: 4.0 };
        assert_eq!(renderer.pick(&view, at, &options), Some(Hit::Loop([0, 1])));
    }
}

/// Number of pixels of the robot's colour within `reach_px` of the robot's position.
fn robot_pixels(image: &Image, view: &View, reach_px: i32) -> usize {
    let (middle, _) = CameraProjection::new(view.camera, view.viewport_px).project(robot().position).unwrap();
    let around = (-reach_px..=reach_px).flat_map(|x| (-reach_px..=reach_px).map(move |y| (x, y)));
    let yellow = |[r, g, b]: [u8; 3]| r > 150 && g > 110 && b < r / 2;
    around.filter(|&(x, y)| yellow(image.at(middle + DVec2::new(f64::from(x), f64::from(y))))).count()
}

#[test]
fn the_robot_is_drawn_as_a_mesh_nearby_and_as_a_marker_of_constant_size_far_away() {
    for gpu in TestGpu::all() {
        let mut renderer = gpu.renderer();
        renderer.set_robot(Some(robot()));
        let at_distance = |distance| {
            let camera = CameraPose { target: robot().position, yaw: 0.4, pitch: 0.9, distance };
            view(camera, SIZE)
        };
        // A disc with a radius of 18 x 0.62 logical pixels, less its rim, fills the square around its centre.
        for distance in [60.0, 300.0, 2900.0] {
            let view = at_distance(distance);
            let filled = robot_pixels(&gpu.render(&mut renderer, &view, "robot-far"), &view, 6);
            assert!(filled > 160, "{} at {distance} m: {filled} of 169", gpu.name);
            let all = robot_pixels(&gpu.render(&mut renderer, &view, "robot-far"), &view, 60);
            assert!(all < 650, "{} at {distance} m: mesh and ring beside the marker: {all}", gpu.name);
        }
        let dense = View { pixels_per_point: 2.0, ..at_distance(300.0) };
        let filled = robot_pixels(&gpu.render(&mut renderer, &dense, "robot-far-dense"), &dense, 12);
        assert!(filled > 600, "{}: {filled} of 625 with two physical pixels for each logical one", gpu.name);
        // The mesh of 0.9 m spans 55 pixels at 14 m. Legs and sensor leave gaps that the marker would fill.
        let near = at_distance(14.0);
        let filled = robot_pixels(&gpu.render(&mut renderer, &near, "robot-near"), &near, 6);
        assert!((1..120).contains(&filled), "{}: {filled} of 169", gpu.name);
    }
}

#[test]
fn surfaces_are_drawn_at_the_shortest_camera_distance() {
    for gpu in TestGpu::all() {
        let mut renderer = gpu.renderer();
        let positions: Vec<DVec3> =
            (0..40_000).map(|i| DVec3::new(0.0, f64::from(i % 200), f64::from(i / 200)) * 0.005).collect();
        renderer.upload_tile(TileId(1), WHOLE_MAP, &TestTile::new(&positions, 0.005).block());
        let target = DVec3::new(0.0, 0.5, 0.5);
        let view = view(CameraPose { target, yaw: 0.0, pitch: 0.0, distance: 0.1 }, [400, 400]);
        let image = gpu.render(&mut renderer, &view, "hands-breadth");
        let covered =
            (0..400).filter(|x| image.at(DVec2::new(f64::from(*x), 200.0)) != image.at(DVec2::ZERO));
        assert!(covered.count() > 200, "{}", gpu.name);
        let background = view_of_nothing(&gpu, &view);
        assert!(differs(image.at(DVec2::splat(200.0)), background, 10), "{}", gpu.name);
    }
}

/// The colour in the middle of an empty scene.
fn view_of_nothing(gpu: &TestGpu, view: &View) -> [u8; 3] {
    gpu.render(&mut gpu.renderer(), view, "nothing").at(DVec2::splat(200.0))
}
