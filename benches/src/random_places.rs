//! Global localisation of a standing robot from one scan, at random poses in the site.

use crate::mapped_site::MappedSite;
use crate::{POSITION_TOLERANCE_M, ROTATION_TOLERANCE_RAD, thread_ms};
use anyhow::{Context, Result};
use geometry::{Isometry, Rng, RngTree, Vector3, isometry_from_pose, so3};
use localisation::{GlobalLocaliser, PoseHypothesis, RelocalisationResult};
use mapping::KeyframeDescriptor;
use messages::Sensor;
use points::Downsampler;
use sim::{SimConfig, Simulator, Start};
use std::sync::Arc;
use vocab::{Span, Vec3};

/// Greatest distance of a random pose from a keyframe that is visible from there, metres.
const MAX_KEYFRAME_DISTANCE_M: f64 = 4.0;
/// Largest number of random draws for one pose.
const MAX_DRAWS: usize = 400;

/// Parameters of the places.
#[derive(Clone, Copy, Debug)]
pub struct PlacesPlan {
    /// Number of places.
    pub count: usize,
    /// Seed of the places and of the simulations at them.
    pub seed: u64,
    /// LiDAR columns per sweep.
    pub columns: u32,
    /// Number of people who walk on the site.
    pub people: u32,
}

/// Numbers of places by their result.
#[derive(Clone, Debug, Default)]
pub struct PlaceCounts {
    /// One hypothesis was accepted, and it is right.
    pub right: usize,
    /// One hypothesis was accepted, and it is wrong.
    pub wrong: usize,
    /// Several hypotheses fit, the right one among them.
    pub ambiguous: usize,
    /// Several hypotheses fit, without the right one.
    pub without: usize,
    /// No hypothesis fits well.
    pub nowhere: usize,
    /// CPU time of each place, milliseconds, ascending.
    pub times_ms: Vec<f64>,
}

/// One place with its result.
pub struct PlaceResult<'a> {
    /// Number of the place.
    pub number: usize,
    /// Where the robot stands.
    pub start: &'a Start,
    /// True pose of the base in the map.
    pub map_from_base: &'a Isometry,
    /// Rank of the right hypothesis.
    pub right: Option<usize>,
    /// All hypotheses, the best first.
    pub found: &'a [PoseHypothesis],
}

/// Localises at random places and calls `observer` with each result.
///
/// # Errors
/// When no place has room for the robot.
pub fn localise_at_places(
    mapped: &MappedSite,
    plan: &PlacesPlan,
    observer: &mut dyn FnMut(&PlaceResult<'_>),
) -> Result<PlaceCounts> {
    let localiser = GlobalLocaliser::new(Arc::clone(&mapped.localisation_map));
    localiser.prepare_search();
    let mut rng = RngTree::new(plan.seed).child("places").rng();
    let mut downsampler = Downsampler::default();
    let mut counts = PlaceCounts::default();
    for number in 0..plan.count {
        let start = random_place(mapped, &mut rng).context("no place has room for the robot")?;
        let (xyz, sensor, map_from_base) = sweep(mapped, plan, start, number as u64)?;
        let before = thread_ms();
        let place = KeyframeDescriptor::new(&xyz, &map_from_base.rotation, sensor, &mut downsampler);
        // The robot knows the direction of gravity, not its heading.
        let up_from_base = randomise_heading(&map_from_base, &mut rng);
        let found = localiser.find_poses(&place, &up_from_base.rotation, None);
        counts.times_ms.push(thread_ms() - before);
        let right = found.iter().position(|one| is_right(&one.map_from_base, &map_from_base));
        let is_right = |one: &PoseHypothesis| is_right(&one.map_from_base, &map_from_base);
        let count = match localiser.classify(&found) {
            RelocalisationResult::Unique(one) if is_right(&one) => &mut counts.right,
            RelocalisationResult::Unique(_) => &mut counts.wrong,
            RelocalisationResult::Ambiguous(several) if several.iter().any(is_right) => &mut counts.ambiguous,
            RelocalisationResult::Ambiguous(_) => &mut counts.without,
            RelocalisationResult::LowConfidence(_) | RelocalisationResult::NotFound => &mut counts.nowhere,
        };
        *count += 1;
        let map_from_base = &map_from_base;
        observer(&PlaceResult { number, start: &start, map_from_base, right, found: &found });
    }
    counts.times_ms.sort_by(f64::total_cmp);
    Ok(counts)
}

/// A random pose at which the robot has room and a keyframe of the map is visible.
fn random_place(mapped: &MappedSite, rng: &mut Rng) -> Option<Start> {
    let keyframes = mapped.localisation_map.keyframes();
    for _ in 0..MAX_DRAWS {
        let index = ((rng.uniform() * keyframes.len() as f64) as usize).min(keyframes.len() - 1);
        let at = (mapped.site_from_map * keyframes[index].0).translation.vector;
        let (away, toward) =
            (MAX_KEYFRAME_DISTANCE_M * rng.uniform().sqrt(), rng.range(0.0, std::f64::consts::TAU));
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
    plan: &PlacesPlan,
    start: Start,
    number: u64,
) -> Result<(Vec<[f32; 3]>, [f32; 3], Isometry)> {
    let config = SimConfig {
        lidar_columns: plan.columns,
        people: plan.people,
        start: Some(start),
        ..SimConfig::new(Arc::clone(&mapped.site), 10_000 * plan.seed + number)
    };
    let mut simulator = Simulator::new(config);
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
