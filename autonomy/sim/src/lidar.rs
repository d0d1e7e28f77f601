//! The LiDAR: a Hesai XT-32 with its table of elevations, firing times, range noise and dropouts.
//!
//! The head turns at 10 Hz, clockwise seen from above, and begins its sweep facing backwards. In every column the 32 channels fire
//! one after the other while the head turns and the robot moves. The rays of a column start at the pose of the body at that instant,
//! and points are given in the frame of the LiDAR at that instant, as in raw data.
//! Sources: the vendor's angle and firing-time tables of the PandarXT-32 (nominal: 15° to -16° in steps of 1°, 1.512 µs
//! between channels) and its user manual (0.05 to 120 m, 80 m at 10 % reflectivity, 1 cm).

use crate::people::{PERSON_BIT, People};
use crate::ray_packet::{LANES, Lane, NO_HIT, RayPacket};
use crate::site::SimulatedSite;
use crate::timing::{BLOCK_SECONDS, BLOCKS_PER_SWEEP, SWEEP_HZ};
use geometry::{Isometry, Rng};
use messages::Scan;
use std::f64::consts::{PI, TAU};
use vocab::Stamp;

/// Channels, counted from the highest.
pub const RINGS: usize = 32;
/// Columns of a sweep at full resolution.
pub const FULL_COLUMNS: u32 = 2000;

/// Elevation of the highest channel, degrees.
const TOP_ELEVATION_DEG: f64 = 15.0;
/// Angle between neighbouring channels, degrees.
const ELEVATION_STEP_DEG: f64 = 1.0;
/// Time between the firings of neighbouring channels, nanoseconds.
const FIRING_STEP_NANOS: f64 = 1512.0;
/// Duration of a sweep, nanoseconds.
const NANOS_PER_SWEEP: f64 = 1e9 / SWEEP_HZ as f64;

/// Returns from nearer than this are dropped, metres.
const MIN_RANGE_M: f32 = 0.3;
/// Greatest range, metres.
const MAX_RANGE_M: f32 = 120.0;
/// Standard deviation of the range, metres.
const RANGE_NOISE_M: f32 = 0.01;
/// Range up to which a target of 10 % reflectivity is seen at normal incidence, metres.
const RANGE_AT_10_PERCENT_M: f32 = 80.0;
/// Share of returns that are lost at random.
const DROPOUT_SHARE: f32 = 0.002;

/// The LiDAR.
#[derive(Clone, Debug)]
pub(crate) struct Lidar {
    base_from_lidar: Isometry,
    columns: u32,
    channels: Vec<Channel>,
    /// `None` for a LiDAR without errors: every ray that hits a surface within range returns its exact range.
    rng: Option<Rng>,
    sweep: Scan,
}

/// One channel.
#[derive(Clone, Copy, Debug)]
struct Channel {
    /// Sine of the elevation.
    sin: f32,
    /// Cosine of the elevation.
    cos: f32,
    /// Sine of the angle by which the head has turned when the channel fires.
    lag_sin: f32,
    /// Cosine of that angle.
    lag_cos: f32,
    /// Time after the start of the column at which the channel fires, nanoseconds.
    delay_nanos: f64,
}

/// Up to [`LANES`] neighbouring columns, axis by axis.
struct ColumnGroup {
    columns: usize,
    start_nanos: [f64; LANES],
    azimuth_sin: Lane,
    azimuth_cos: Lane,
    origin: [Lane; 3],
    /// `rotation[row][column]` of the LiDAR in the site.
    rotation: [[Lane; 3]; 3],
}

/// The returns of one channel in the columns of a group.
#[derive(Clone, Copy)]
struct Returns {
    /// Unit vectors, LiDAR frame.
    direction: [Lane; 3],
    /// Metres; NaN where there is no return.
    range: Lane,
    intensity: Lane,
}

impl Lidar {
    /// A LiDAR at `base_from_lidar` with that number of columns per sweep, rounded up to a multiple of 10; without `rng` it has no errors.
    pub(crate) fn new(base_from_lidar: Isometry, columns: u32, rng: Option<Rng>) -> Self {
        let rings = (0..RINGS).map(|ring| {
            let (sin, cos) = (TOP_ELEVATION_DEG - ELEVATION_STEP_DEG * ring as f64).to_radians().sin_cos();
            let delay_nanos = FIRING_STEP_NANOS * ring as f64;
            let (lag_sin, lag_cos) = (TAU * delay_nanos / NANOS_PER_SWEEP).sin_cos();
            Channel {
                sin: sin as f32,
                cos: cos as f32,
                lag_sin: lag_sin as f32,
                lag_cos: lag_cos as f32,
                delay_nanos,
            }
        });
        let columns = columns.clamp(1, FULL_COLUMNS).next_multiple_of(BLOCKS_PER_SWEEP as u32);
        Self { base_from_lidar, columns, channels: rings.collect(), rng, sweep: Scan::default() }
    }

    /// Advances by one block, number `block` of the sweep that began at `sweep_start`. The last block of a sweep returns the scan.
    /// `site_from_base` gives the pose of the base at seconds after the start of the block.
    pub(crate) fn advance(
        &mut self,
        site: &SimulatedSite,
        people: &People,
        block: u32,
        sweep_start: Stamp,
        blind: bool,
        site_from_base: impl Fn(f64) -> Isometry,
    ) -> Option<Scan> {
        if block == 0 {
            let capacity = self.columns as usize * RINGS;
            self.sweep = Scan { stamp: sweep_start, ..Scan::default() };
            self.sweep.xyz.reserve(capacity);
            self.sweep.intensity.reserve(capacity);
            self.sweep.offset_ns.reserve(capacity);
            self.sweep.ring.reserve(capacity);
        }
        let per_block = self.columns / BLOCKS_PER_SWEEP as u32;
        let first = block * per_block;
        if !blind {
            for group in (first..first + per_block).step_by(LANES) {
                let end = (group + LANES as u32).min(first + per_block);
                self.cast_column_group(site, people, &self.group(group..end, block, &site_from_base));
            }
        }
        (i64::from(block) + 1 == BLOCKS_PER_SWEEP).then(|| std::mem::take(&mut self.sweep))
    }

    fn group(
        &self,
        columns: std::ops::Range<u32>,
        block: u32,
        site_from_base: &impl Fn(f64) -> Isometry,
    ) -> ColumnGroup {
        let zero = [0.0; LANES];
        let mut group = ColumnGroup {
            columns: columns.len(),
            start_nanos: [0.0; LANES],
            azimuth_sin: zero,
            azimuth_cos: zero,
            origin: [zero; 3],
            rotation: [[zero; 3]; 3],
        };
        let middle_of_firing = FIRING_STEP_NANOS * (RINGS - 1) as f64 / 2.0 * 1e-9;
        for lane in 0..LANES {
            // Lanes beyond the end repeat the last column; their returns are dropped.
            let column = (columns.start + lane as u32).min(columns.end - 1);
            let turn = f64::from(column) / f64::from(self.columns);
            let nanos = turn * NANOS_PER_SWEEP;
            let in_block = nanos * 1e-9 - f64::from(block) * BLOCK_SECONDS + middle_of_firing;
            let site_from_lidar = site_from_base(in_block) * self.base_from_lidar;
            let rotation = site_from_lidar.rotation.to_rotation_matrix().into_inner();
            let (sin, cos) = (PI - TAU * turn).sin_cos();
            group.start_nanos[lane] = nanos;
            (group.azimuth_sin[lane], group.azimuth_cos[lane]) = (sin as f32, cos as f32);
            for row in 0..3 {
                group.origin[row][lane] = site_from_lidar.translation.vector[row] as f32;
                for axis in 0..3 {
                    group.rotation[row][axis][lane] = rotation[(row, axis)] as f32;
                }
            }
        }
        group
    }

    fn cast_column_group(&mut self, site: &SimulatedSite, people: &People, group: &ColumnGroup) {
        let silent =
            Returns { direction: [[0.0; LANES]; 3], range: [f32::NAN; LANES], intensity: [0.0; LANES] };
        let mut seen = [silent; RINGS];
        for (ring, returns) in self.channels.iter().zip(&mut seen) {
            returns.direction = ring.directions(group);
            let mut packet = RayPacket::new(group.origin, group.rotate(&returns.direction), MAX_RANGE_M);
            site.bvh().cast(&mut packet);
            people.cast(&mut packet);
            compute_returns(site, people, &packet, self.rng.as_mut(), returns);
        }
        for lane in 0..group.columns {
            for (number, (ring, returns)) in self.channels.iter().zip(&seen).enumerate() {
                let range = returns.range[lane];
                if range.is_nan() {
                    continue;
                }
                self.sweep.xyz.push([0, 1, 2].map(|axis| returns.direction[axis][lane] * range));
                self.sweep.intensity.push(returns.intensity[lane]);
                self.sweep.offset_ns.push((group.start_nanos[lane] + ring.delay_nanos).round() as i32);
                self.sweep.ring.push(number as u16);
            }
        }
    }
}

impl Channel {
    /// Direction of the channel in every column of the group, LiDAR frame.
    fn directions(&self, group: &ColumnGroup) -> [Lane; 3] {
        let mut direction = [[self.sin; LANES]; 3];
        for lane in 0..LANES {
            let (sin, cos) = (group.azimuth_sin[lane], group.azimuth_cos[lane]);
            // The head turns clockwise, so the lag is subtracted from the azimuth of the column.
            direction[0][lane] = self.cos * (cos * self.lag_cos + sin * self.lag_sin);
            direction[1][lane] = self.cos * (sin * self.lag_cos - cos * self.lag_sin);
        }
        direction
    }
}

impl ColumnGroup {
    fn rotate(&self, local: &[Lane; 3]) -> [Lane; 3] {
        let mut out = [[0.0; LANES]; 3];
        for row in 0..3 {
            for lane in 0..LANES {
                let matrix = &self.rotation[row];
                out[row][lane] = matrix[0][lane] * local[0][lane]
                    + matrix[1][lane] * local[1][lane]
                    + matrix[2][lane] * local[2][lane];
            }
        }
        out
    }
}

/// Turns ray hits into range and intensity as the receiver measures them.
fn compute_returns(
    site: &SimulatedSite,
    people: &People,
    packet: &RayPacket,
    mut rng: Option<&mut Rng>,
    returns: &mut Returns,
) {
    for lane in 0..LANES {
        let (solid, range) = (packet.solid[lane], packet.range[lane]);
        if solid == NO_HIT || range < MIN_RANGE_M {
            continue;
        }
        let end = packet.end(lane);
        let (normal, material) = if solid & PERSON_BIT != 0 {
            people.surface(solid, end)
        } else {
            (site.bvh().normal(solid, end), site.bvh().solids()[solid as usize].material)
        };
        let slant = (0..3).map(|i| normal[i] * packet.direction[i][lane]).sum::<f32>().abs();
        let reflectivity = material.reflectivity();
        let mut measured = (range, 1.0);
        if let Some(rng) = rng.as_deref_mut() {
            let Some(noisy) = simulate_echo(rng, range, reflectivity * slant) else { continue };
            measured = noisy;
        }
        returns.range[lane] = measured.0;
        // Calibrated units: 100 for a white target, more for retroreflectors only.
        let strength = 100.0 * reflectivity * (0.5 + 0.5 * slant) * measured.1;
        returns.intensity[lane] = strength.round().clamp(0.0, 255.0);
    }
}

/// The range with noise and a factor on the intensity, or `None` when the echo is too weak (far, dark or grazing).
fn simulate_echo(rng: &mut Rng, range: f32, brightness: f32) -> Option<(f32, f32)> {
    let (luck, noise) = (rng.bits(), rng.bits());
    // Echo strength, 1 where a 10 % target at the specified range would put it.
    let echo = brightness / 0.1 * (RANGE_AT_10_PERCENT_M / range).powi(2);
    let seen = ((echo - 0.15) / 0.85).clamp(0.0, 1.0) * (1.0 - DROPOUT_SHARE);
    if (luck >> 40) as f32 * (1.0 / (1_u32 << 24) as f32) >= seen {
        return None;
    }
    let shade = 1.0 + 0.1 * ((luck & 0xffff) as f32 / 65_536.0 - 0.5);
    Some((range + RANGE_NOISE_M * approximate_normal(noise), shade))
}

/// An approximately normal number (mean 0, deviation 1) from 64 random bits: the sum of four uniform numbers, limited to ±3.46. It costs
/// a tenth of the Box-Muller transform and is needed 640,000 times a second.
fn approximate_normal(bits: u64) -> f32 {
    let sum: u32 = [0, 16, 32, 48].iter().map(|shift| (bits >> shift) as u32 & 0xffff).sum();
    (sum as f32 / 65_535.0 - 2.0) * 1.732_050_8
}
