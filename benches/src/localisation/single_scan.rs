//! Global localisation of a standing robot from one scan, at random poses in the site.

use crate::arguments::Arguments;
use crate::mapped_site::MappedSite;
use anyhow::{Context, Result};
use benches::{quantile, thread_ms};
use geometry::{Isometry, Rng, RngTree, Vector3, isometry_from_pose, so3};
use localisation::{GlobalLocaliser, PoseHypothesis, RelocalisationResult};
use mapping::KeyframeDescriptor;
use messages::Sensor;
use points::Downsampler;
use sim::{SimConfig, Simulator, Start};
use std::sync::Arc;
use vocab::{Span, Vec3};

/// A pose is right within this distance of the ground truth, metres.
const POSITION_TOLERANCE_M: f64 = 0.2;
/// A pose is right within this angle of the ground truth, radians.
const ROTATION_TOLERANCE_RAD: f64 = 0.052;
/// Greatest distance of a random pose from a keyframe that is visible from there, metres.
const KEYFRAME_DISTANCE_MAX_M: f64 = 4.0;
/// Largest number of random draws for one pose.
const DRAWS_MAX: usize = 400;

/// Prints the names of the columns. *right* and *WRONG*: one hypothesis was accepted. *ambiguous* and *without*: several hypotheses fit, with and
/// without the right one. *nowhere*: no hypothesis fits well.
pub fn print_header() {
    println!(
        "{:<8}{:>8}{:>8}{:>8}{:>11}{:>9}{:>9}{:>11}{:>9}",
        "site", "places", "right", "WRONG", "ambiguous", "without", "nowhere", "median ms", "p99 ms"
    );
}

/// Localises at random poses.
pub fn run(mapped: &MappedSite, arguments: &Arguments) -> Result<()> {
    let localiser = GlobalLocaliser::new(Arc::clone(&mapped.localisation_map));
    localiser.prepare_search();
    let mut rng = RngTree::new(arguments.seed).child("places").rng();
    let mut downsampler = Downsampler::default();
    let (mut right_count, mut wrong, mut ambiguous, mut without, mut nowhere) = (0, 0, 0, 0, 0);
    let mut times = Vec::new();
    for number in 0..arguments.places {
        let start = random_place(mapped, &mut rng).context("no place has room for the robot")?;
        let (xyz, sensor, map_from_base) = sweep(mapped, arguments, start, number as u64)?;
        let before = thread_ms();
        let place = KeyframeDescriptor::new(&xyz, &map_from_base.rotation, sensor, &mut downsampler);
        // The robot knows the direction of gravity, not its heading.
        let up_from_base = randomise_heading(&map_from_base, &mut rng);
        let found = localiser.find_poses(&place, &up_from_base.rotation, None);
        times.push(thread_ms() - before);
        let right = found.iter().position(|one| is_right(&one.map_from_base, &map_from_base));
        let is_right = |one: &PoseHypothesis| is_right(&one.map_from_base, &map_from_base);
        match localiser.classify(&found) {
            RelocalisationResult::Unique(one) if is_right(&one) => right_count += 1,
            RelocalisationResult::Unique(_) => wrong += 1,
            RelocalisationResult::Ambiguous(several) if several.iter().any(is_right) => ambiguous += 1,
            RelocalisationResult::Ambiguous(_) => without += 1,
            RelocalisationResult::LowConfidence(_) | RelocalisationResult::NotFound => nowhere += 1,
        }
        if arguments.verbose {
            print_each(number, &start, &map_from_base, right, &found);
        }
    }
    times.sort_by(f64::total_cmp);
    println!(
        "{:<8}{:>8}{:>8}{:>8}{:>11}{:>9}{:>9}{:>11.1}{:>9.1}",
        mapped.site.name(),
        arguments.places,
        right_count,
        wrong,
        ambiguous,
        without,
        nowhere,
        quantile(&times, 0.5),
        quantile(&times, 0.99)
    );
    Ok(())
}

fn print_each(
    number: usize,
    start: &Start,
    truth: &Isometry,
    right: Option<usize>,
    found: &[PoseHypothesis],
) {
    let place = format!("{:.1},{:.1},{:.1}", start.position.x, start.position.y, start.position.z);
    let right = right.map_or_else(|| "-".to_owned(), |index| index.to_string());
    // Error of the best hypothesis in the frame of the base, metres.
    let off = found.first().map(|one| (truth.inverse() * one.map_from_base).translation.vector);
    let off = off.map_or_else(|| "-".to_owned(), |off| format!("{:.3} {:.3} {:.3}", off.x, off.y, off.z));
    let list: Vec<String> =
        found.iter().take(4).map(|one| format!("{:.3}/{:.3}", one.fit, one.violation_share)).collect();
    println!("{number:>4} {place:>16} {right:>3} {off:>21}  {}", list.join("  "));
}

/// A random pose at which the robot has room and a keyframe of the map is visible.
fn random_place(mapped: &MappedSite, rng: &mut Rng) -> Option<Start> {
    let keyframes = mapped.localisation_map.keyframes();
    for _ in 0..DRAWS_MAX {
        let index = ((rng.uniform() * keyframes.len() as f64) as usize).min(keyframes.len() - 1);
        let at = (mapped.site_from_map * keyframes[index].0).translation.vector;
        let (away, toward) =
            (KEYFRAME_DISTANCE_MAX_M * rng.uniform().sqrt(), rng.range(0.0, std::f64::consts::TAU));
        let over = at + Vector3::new(away * toward.cos(), away * toward.sin(), 0.0);
        let offset = over - at;
        let hidden =
            offset.norm() > 1e-3 && mapped.site.cast_ray(&at, &offset.normalize(), offset.norm()).is_some();
        if hidden {
            continue;
        }
        let Some((down, _)) = mapped.site.cast_ray(&over, &-Vector3::z(), 1.5) else { continue };
        let floor = over - Vector3::z() * down;
        if mapped.site.has_room(&floor) {
            let position = Vec3::new(floor.x, floor.y, floor.z);
            return Some(Start { position, yaw: rng.range(0.0, std::f64::consts::TAU) });
        }
    }
    None
}

/// One scan of a standing robot: its points and the position of the LiDAR (base frame, metres), and the true pose of the base in the map.
fn sweep(
    mapped: &MappedSite,
    arguments: &Arguments,
    start: Start,
    number: u64,
) -> Result<(Vec<[f32; 3]>, [f32; 3], Isometry)> {
    let config = SimConfig {
        lidar_columns: arguments.columns,
        people: arguments.people,
        start: Some(start),
        ..SimConfig::new(mapped.site.name(), 10_000 * arguments.seed + number)
    };
    let mut simulator = Simulator::on(Arc::clone(&mapped.site), config);
    let base_from_lidar = simulator.boot().mounting.base_from_lidar;
    let base_from_lidar =
        base_from_lidar.as_ref().and_then(isometry_from_pose).unwrap_or_else(Isometry::identity);
    let mut events = Vec::new();
    // The robot first comes to rest, 1.5 s.
    simulator.advance(simulator.now() + Span::from_millis(1_500), &mut events);
    events.clear();
    simulator.advance(simulator.now() + Span::from_millis(350), &mut events);
    let scan = events.iter().find_map(|event| match &event.sensor {
        Sensor::Scan(scan) => Some(scan),
        _ => None,
    });
    let scan = scan.context("the LiDAR sent no scan")?;
    let turn = base_from_lidar.cast::<f32>();
    let xyz = scan.xyz.iter().map(|p| (turn * nalgebra::Point3::from(*p)).into()).collect();
    let site_from_base =
        isometry_from_pose(&simulator.truth().site_from_base).context("the ground truth is no pose")?;
    let sensor = turn.translation.vector.into();
    Ok((xyz, sensor, mapped.site_from_map.inverse() * site_from_base))
}

/// The same tilt with a random heading.
fn randomise_heading(map_from_base: &Isometry, rng: &mut Rng) -> Isometry {
    let turn = so3::exp(&(Vector3::z() * rng.range(0.0, std::f64::consts::TAU)));
    Isometry::from_parts(nalgebra::Translation3::identity(), turn * map_from_base.rotation)
}

fn is_right(found: &Isometry, truth: &Isometry) -> bool {
    let off = truth.inverse() * found;
    off.translation.vector.norm() <= POSITION_TOLERANCE_M
        && so3::log(&off.rotation).norm() <= ROTATION_TOLERANCE_RAD
}
