//! Inspection points at the gauges of a site, and visits to them: where the robot stands, where it believes to stand, and what light there is.

use anyhow::{Context, Result};
use gauges::Picture;
use geometry::{Isometry, Rng, RngTree, Rotation, Vector3, so3};
use jpeg_encoder::{ColorType, Encoder};
use nalgebra::{Point3, Translation3};
use picture_changes::PosedCamera;
use sim::{
    CameraConfig, CameraImage, CameraScene, CameraSnapshot, Face, Fixture, SimulatedQuantity, SimulatedSite,
};
use std::io::Cursor;
use vocab::CameraAim;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// How visits differ. Positions and headings are drawn from what docs/benchmarks/missions.md has measured in 480 visits; docs/benchmarks/picture-changes.md says how.
#[derive(Clone, Copy, Debug)]
struct VisitConfig {
    /// Standard deviation of the position of the robot along x and y, metres: a mean distance of 0.9 cm.
    position_deviation_m: f64,
    /// Standard deviation of its heading, radians: the worst of 480 is three of it, 1.35 degrees.
    heading_deviation_rad: f64,
    /// Standard deviations of the error of the estimate: targets were at worst 1.2 % of 0.8 m off the middle of the picture.
    estimate_deviation_m: f64,
    estimate_deviation_rad: f64,
    /// Standard deviation of roll and pitch of a standing robot, radians. Chosen.
    tilt_deviation_rad: f64,
    /// Share of the lamps that are out.
    lamps_out: f64,
    /// Least and greatest light of the others.
    lamp_levels: [f64; 2],
    /// Height of the sun over the horizon, least and greatest, radians.
    sun_heights_rad: [f64; 2],
    /// Least and greatest light of the sun.
    sun_strengths: [f64; 2],
    /// Quality of the JPEG files, as the simulated robot has it.
    jpeg_quality: u8,
}

const VISITS: VisitConfig = VisitConfig {
    position_deviation_m: 0.0072,
    heading_deviation_rad: 0.0078,
    estimate_deviation_m: 0.003,
    estimate_deviation_rad: 0.0015,
    tilt_deviation_rad: 0.003,
    lamps_out: 0.15,
    lamp_levels: [0.6, 1.2],
    sun_heights_rad: [0.4, 1.2],
    sun_strengths: [0.3, 2.5],
    jpeg_quality: 90,
};

/// Distances from gauges at which the robot stands, metres, nearest first in the middle of what operators choose.
const STANDS_M: [f64; 4] = [1.6, 1.3, 1.9, 1.1];
/// Directions from the gauge, radians from its normal.
const STAND_DIRECTIONS_RAD: [f64; 5] = [0.2, -0.2, 0.1, -0.1, 0.0];

/// A gauge, and where the robot stands to look at it.
#[derive(Clone, Debug)]
pub struct GaugePoint {
    /// The gauge.
    pub fixture: Fixture,
    /// Where the robot has to stand.
    pub site_from_node: Isometry,
    /// The zoom at which the picture shows the asked width at the gauge.
    pub zoom: f64,
    /// Distance of the gauge from the camera, metres.
    pub distance_m: f64,
    /// Poses of the base at the visits of missions, by the truth and as the robot believes, site frame; empty: they are drawn.
    pub poses: Vec<[Isometry; 2]>,
}

/// A picture with what the robot knows of it, and the truth.
#[derive(Clone, Debug)]
pub struct Visit {
    /// The picture, after it was a JPEG file.
    pub picture: Picture,
    /// The camera as the robot believes.
    pub estimated: PosedCamera,
    /// The camera in truth; for scoring only.
    pub truth: PosedCamera,
    /// What the gauge shows.
    pub value: f64,
}

/// The gauges of a site with a place to look at them from: this far aside from where they face, or at [`STAND_DIRECTIONS_RAD`].
pub fn gauge_points(
    site: &SimulatedSite,
    scene: &CameraScene,
    shown_width_m: f64,
    aside_rad: Option<f64>,
) -> Vec<GaugePoint> {
    let gauges = scene.fixtures().iter().filter(|fixture| matches!(fixture.face, Face::Gauge { .. }));
    let directions = aside_rad.map_or(STAND_DIRECTIONS_RAD.to_vec(), |aside| vec![aside, -aside]);
    gauges.filter_map(|fixture| gauge_point(site, fixture, shown_width_m, &directions)).collect()
}

fn gauge_point(
    site: &SimulatedSite,
    fixture: &Fixture,
    shown_width_m: f64,
    directions: &[f64],
) -> Option<GaugePoint> {
    let cameras = CameraConfig::default();
    let plate = fixture.site_from_plate.translation.vector;
    let outward = fixture.site_from_plate.rotation * Vector3::z();
    STANDS_M.into_iter().flat_map(|away_m| directions.iter().map(move |turn| (away_m, *turn))).find_map(
        |(away_m, turn)| {
            let ahead = Rotation::from_euler_angles(0.0, 0.0, turn) * outward;
            let above = plate + ahead * away_m;
            let (down, _) = site.cast_ray(&above, &-Vector3::z(), 2.5)?;
            let feet = above - Vector3::z() * down;
            // The robot stands across the gauge as often as it faces it: the head turns.
            let heading = (-ahead.y).atan2(-ahead.x) + 0.5 * turn.signum();
            let base = Translation3::from(feet + Vector3::z() * sim::STANDING_HEIGHT);
            let site_from_node = Isometry::from_parts(base, Rotation::from_euler_angles(0.0, 0.0, heading));
            let head = (site_from_node * Point3::from(cameras.base_from_head_m)).coords;
            let offset = head - plate;
            let distance_m = offset.norm();
            let is_free = site.has_room(&feet)
                && site
                    .cast_ray(&(plate + outward * 0.01), &(offset / distance_m), distance_m - 0.05)
                    .is_none();
            let view_m = 2.0 * distance_m * (0.5 * cameras.field_of_view_rad).tan();
            let zoom = (view_m / shown_width_m).clamp(1.0, cameras.zoom_max);
            is_free.then(|| GaugePoint {
                fixture: fixture.clone(),
                site_from_node,
                zoom,
                distance_m,
                poses: Vec::new(),
            })
        },
    )
}

/// A value of the gauge that does not swing.
pub fn steady(value: f64) -> SimulatedQuantity {
    SimulatedQuantity { mean: value, amplitude: 0.0, period_s: 900.0, rise_per_s: 0.0 }
}

/// Takes the picture of a visit. The number decides pose, light and noise; `value` is what the gauge shows.
///
/// # Errors
/// When the picture is no JPEG file.
pub fn visit(scene: &CameraScene, point: &GaugePoint, number: u64, value: f64) -> Result<Visit> {
    visit_at(scene, point, number, steady(value), 0.0)
}

/// As [`visit`], of what the gauge shows at that time since the start of the simulation, seconds.
///
/// # Errors
/// When the picture is no JPEG file.
pub fn visit_at(
    scene: &CameraScene,
    point: &GaugePoint,
    number: u64,
    shown: SimulatedQuantity,
    seconds: f64,
) -> Result<Visit> {
    let tree = RngTree::new(number).child(&point.fixture.tag);
    let mut rng = tree.child("pose").rng();
    let lit = in_light_of(scene, &mut tree.child("light").rng());
    let lit = lit.with_reading(&point.fixture.tag, shown).context("the gauge is on the site")?;
    let drawn = point.site_from_node
        * small_error(
            &mut rng,
            VISITS.position_deviation_m,
            VISITS.heading_deviation_rad,
            VISITS.tilt_deviation_rad,
        );
    let estimate = drawn
        * small_error(
            &mut rng,
            VISITS.estimate_deviation_m,
            VISITS.estimate_deviation_rad,
            0.5 * VISITS.estimate_deviation_rad,
        );
    let [site_from_base, estimate] = match (usize::try_from(number), point.poses.is_empty()) {
        (Ok(number), false) => *point.poses.get(number).context("a visit of the missions")?,
        _ => [drawn, estimate],
    };
    let cameras = CameraConfig::default();
    let target = Point3::from(point.fixture.site_from_plate.translation.vector);
    let aim = cameras.aim_at(&estimate.inverse_transform_point(&target).coords, point.zoom);
    let image = CameraSnapshot::alone(site_from_base, seconds, rng.bits()).picture(&lit, &aim);
    let camera = |site_from_base: &Isometry| camera(&cameras, &aim, site_from_base);
    Ok(Visit {
        picture: through_jpeg(&image)?,
        estimated: camera(&estimate),
        truth: camera(&site_from_base),
        value: shown.at(seconds),
    })
}

/// An error of a standing robot's pose.
fn small_error(rng: &mut Rng, position_m: f64, heading_rad: f64, tilt_rad: f64) -> Isometry {
    let turn = Vector3::new(tilt_rad * rng.normal(), tilt_rad * rng.normal(), heading_rad * rng.normal());
    let offset = Translation3::new(
        position_m * rng.normal(),
        position_m * rng.normal(),
        0.3 * position_m * rng.normal(),
    );
    Isometry::from_parts(offset, so3::exp(&turn))
}

/// The scene with some lamps out, the others at other levels, and the sun elsewhere.
fn in_light_of(scene: &CameraScene, rng: &mut Rng) -> CameraScene {
    let seed = rng.bits();
    let level = |position: [f32; 3]| {
        let place = position.map(|c| (c * 10.0).round() as i64);
        let mut lamp = RngTree::new(seed).child(&format!("{place:?}")).rng();
        let is_out = lamp.uniform() < VISITS.lamps_out;
        if is_out { 0.0 } else { lamp.range(VISITS.lamp_levels[0], VISITS.lamp_levels[1]) as f32 }
    };
    let height = rng.range(VISITS.sun_heights_rad[0], VISITS.sun_heights_rad[1]);
    let (sin, cos) = rng.range(0.0, std::f64::consts::TAU).sin_cos();
    let to_sun = [cos * height.cos(), sin * height.cos(), height.sin()].map(|c| c as f32);
    let strength = rng.range(VISITS.sun_strengths[0], VISITS.sun_strengths[1]) as f32;
    scene.relit(level, (strength, to_sun))
}

fn camera(cameras: &CameraConfig, aim: &CameraAim, site_from_base: &Isometry) -> PosedCamera {
    let aim = cameras.clamped(aim);
    let intrinsics = cameras.intrinsics(aim.zoom);
    PosedCamera {
        focal_px: intrinsics.focal_px,
        // Here the middle of the first pixel is 0, there its outer corner.
        centre_px: intrinsics.centre_px.map(|centre| centre - 0.5),
        map_from_camera: site_from_base * cameras.base_from_camera(&aim),
    }
}

/// The picture as it is after it was stored.
fn through_jpeg(image: &CameraImage) -> Result<Picture> {
    let mut bytes = Vec::new();
    let [width, height] = [u16::try_from(image.width_px)?, u16::try_from(image.height_px)?];
    Encoder::new(&mut bytes, VISITS.jpeg_quality).encode(&image.rgb, width, height, ColorType::Rgb)?;
    let options = DecoderOptions::default().jpeg_set_out_colorspace(ColorSpace::RGB);
    let colours =
        JpegDecoder::new_with_options(Cursor::new(bytes), options).decode().context("a JPEG file")?;
    let pixels = colours.chunks_exact(3).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    Ok(Picture::new([usize::from(width), usize::from(height)], pixels)?)
}
