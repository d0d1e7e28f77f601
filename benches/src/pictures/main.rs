//! Renders the pictures that a robot takes on the sites, photos and thermal ones, and compares the CPU time of each with the bar.

#![allow(clippy::print_stdout, reason = "the table is this program's output")]

use anyhow::{Context, Error, Result, ensure};
use benches::{quantile, thread_ms};
use clap::Parser;
use geometry::isometry_from_pose;
use jpeg_encoder::{ColorType, Encoder};
use nalgebra::Point3;
use sim::{CameraImage, CameraScene, Fixture, RouteFollower, SWEEP_HZ, SimConfig, Simulator};
use site_files::SiteSource;
use std::sync::Arc;
use vocab::{CameraAim, Span};

/// CPU time of the pictures of the simulated cameras.
///
/// Example: cargo xtask bench pictures
#[derive(Parser)]
struct Arguments {
    /// Sites, separated by commas: names, generated:SEED, or buildings as FILE.glb.
    #[arg(long, value_delimiter = ',', default_value = "b1,torus,plant,twins")]
    sites: Vec<String>,
    /// Places of the walk at which pictures are taken.
    #[arg(long, default_value_t = 40)]
    places: usize,
    /// Number of people on the site.
    #[arg(long, default_value_t = 10)]
    people: u32,
    /// Fail if the bar is missed.
    #[arg(long)]
    bar: bool,
}

/// Longest time for a picture, milliseconds.
const MAX_PICTURE_MS: f64 = 300.0;
/// Time of walking between two places, seconds.
const WALK_S: f64 = 8.0;
/// Fixtures are looked at from within this distance, metres.
const MAX_FIXTURE_M: f64 = 8.0;
/// Quality of the JPEG files, as the simulated robot has it.
const JPEG_QUALITY: u8 = 90;

/// CPU times, milliseconds.
#[derive(Default)]
struct Times {
    photos: Vec<f64>,
    encoded: Vec<f64>,
    thermal: Vec<f64>,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    println!(
        "| site | photos | rendered: median, 95 %, worst, ms | encoded: median, worst, ms | thermal pictures | median, 95 %, worst, ms | scene made once, ms |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    let mut worst_ms = 0.0_f64;
    for name in &arguments.sites {
        let source: SiteSource = name.parse().map_err(Error::msg)?;
        worst_ms = worst_ms.max(row(name, source, &arguments)?);
    }
    println!("worst picture with its encoding: {worst_ms:.0} ms, at most {MAX_PICTURE_MS:.0} ms");
    ensure!(!arguments.bar || worst_ms <= MAX_PICTURE_MS, "a picture takes too long");
    Ok(())
}

/// Takes the pictures of a site and prints its row. Returns the longest time of one, milliseconds.
fn row(name: &str, source: SiteSource, arguments: &Arguments) -> Result<f64> {
    let site = source.load()?;
    let route = site.route("round").or_else(|| site.routes().first()).context("the site has no route")?;
    let mut config = SimConfig::new(Arc::clone(&site), 1);
    (config.lidar_columns, config.people) = (SWEEP_HZ, arguments.people);
    config.start = Some(route.start);
    let mut walker = RouteFollower::new(route.clone());
    let mut simulator = Simulator::new(config);
    let begun = thread_ms();
    let scene = CameraScene::new(Arc::clone(&site));
    let scene_ms = thread_ms() - begun;
    let mut times = Times::default();
    for _ in 0..arguments.places {
        walk(&mut simulator, &mut walker);
        take_pictures(&mut simulator, &scene, &mut times)?;
    }
    for list in [&mut times.photos, &mut times.encoded, &mut times.thermal] {
        list.sort_by(f64::total_cmp);
    }
    let Times { photos, encoded, thermal } = &times;
    let [median, high, worst] = [0.5, 0.95, 1.0].map(|share| quantile(photos, share));
    let [thermal_median, thermal_high, thermal_worst] =
        [0.5, 0.95, 1.0].map(|share| quantile(thermal, share));
    println!(
        "| {name} | {} | {median:.0}, {high:.0}, {worst:.0} | {:.1}, {:.1} | {} | {thermal_median:.0}, {thermal_high:.0}, {thermal_worst:.0} | {scene_ms:.0} |",
        photos.len(),
        quantile(encoded, 0.5),
        quantile(encoded, 1.0),
        thermal.len(),
    );
    Ok((worst + quantile(encoded, 1.0)).max(thermal_worst))
}

/// Walks on along the route.
fn walk(simulator: &mut Simulator, walker: &mut RouteFollower) {
    let mut events = Vec::new();
    for _ in 0..(10.0 * WALK_S) as usize {
        simulator.command(walker.drive(&simulator.truth()).unwrap_or_default());
        simulator.advance(simulator.now() + Span::from_millis(100), &mut events);
        events.clear();
    }
}

/// Takes pictures all round, and of what hangs near on walls, as large as zoom makes it.
fn take_pictures(simulator: &mut Simulator, scene: &CameraScene, times: &mut Times) -> Result<()> {
    let mut aims: Vec<CameraAim> =
        [-1.5, 0.0, 1.5].map(|pan_rad| CameraAim { pan_rad, tilt_rad: 0.0, zoom: 1.0 }).into();
    let site_from_base =
        isometry_from_pose(&simulator.truth().site_from_base).context("the robot has no pose")?;
    let snapshot = simulator.camera_snapshot();
    let cameras = sim::CameraConfig::default();
    let distance_m = |fixture: &&Fixture| {
        (fixture.site_from_plate.translation.vector - site_from_base.translation.vector).norm()
    };
    let near = scene.fixtures().iter().filter(|fixture| distance_m(fixture) <= MAX_FIXTURE_M);
    aims.extend(near.take(3).map(|fixture| {
        let target = Point3::from(fixture.site_from_plate.translation.vector);
        let in_base = site_from_base.inverse() * target;
        cameras.aim_at(&in_base.coords, cameras.zoom_max)
    }));
    for aim in &aims {
        let begun = thread_ms();
        let photo = snapshot.clone().picture(scene, aim);
        let rendered = thread_ms();
        encode(&photo)?;
        times.photos.push(rendered - begun);
        times.encoded.push(thread_ms() - rendered);
        let begun = thread_ms();
        std::hint::black_box(snapshot.clone().thermal_picture(scene, aim));
        times.thermal.push(thread_ms() - begun);
    }
    Ok(())
}

fn encode(photo: &CameraImage) -> Result<()> {
    let mut bytes = Vec::new();
    let [width, height] = [u16::try_from(photo.width_px)?, u16::try_from(photo.height_px)?];
    Encoder::new(&mut bytes, JPEG_QUALITY).encode(&photo.rgb, width, height, ColorType::Rgb)?;
    std::hint::black_box(bytes);
    Ok(())
}
