//! Scan Context: a place seen from above as polar images, which a rotation of the robot shifts by columns (docs/maths/loops.md, section 2).
//!
//! Source: Kim and Kim, *Scan Context*, IROS 2018; Kim, Choi, Kim, *Scan Context++*, T-RO 2021 (alignment by sector keys, virtual views
//! against lateral offsets). This one differs in three ways. The rings widen with the range, so that both rooms and yards fill them. A second
//! image holds the occupied height slices of each bin, because under a ceiling the greatest height is the ceiling's everywhere. Heights are
//! measured from the base, levelled by gravity, so that slopes and a lying robot change nothing.

use geometry::{Isometry, Rotation, Vector3, so3};
use nalgebra::{Matrix3, Translation3};

// These constants define the stored format: a change needs a new `KEYFRAME_DESCRIPTOR_VERSION`.

/// Number of rings, whose radii grow by a constant factor.
pub const RINGS: usize = 24;
/// Number of sectors, 6 degrees each.
pub const SECTORS: usize = 60;
/// Length of a ring key: the fill of each ring, then the mean height of each three rings.
pub const RING_KEY_LENGTH: usize = RINGS + RINGS / 3;
/// Inner radius, metres. Nearer points belong to objects that are near the robot for a short time only.
const MIN_RADIUS_M: f32 = 1.5;
/// Outer radius, metres. Farther points are sparse.
const MAX_RADIUS_M: f32 = 45.0;
/// Depth below the base at which the scale of the greatest heights begins, metres.
const HEIGHT_DEPTH_M: f32 = 3.0;
/// Resolution of the greatest heights, metres.
const HEIGHT_STEP_M: f32 = 0.06;
/// Depth below the base at which the first height slice begins, metres.
const SLICE_DEPTH_M: f32 = 0.9;
/// Height of a slice, metres.
const SLICE_M: f32 = 0.5;

/// Sector by sector, one byte for each ring.
type PolarImage = [[u8; RINGS]; SECTORS];

/// Scan Context of one scan. About 3.3 kB.
#[derive(Clone, Debug, PartialEq)]
pub struct ScanContext {
    /// Greatest height of each bin, in steps of `HEIGHT_STEP_M`; 0 where a bin is empty.
    heights: Box<PolarImage>,
    /// Occupied height slices of each bin, one bit each.
    slices: Box<PolarImage>,
    ring_key: [f32; RING_KEY_LENGTH],
    sector_key: [f32; SECTORS],
}

/// Number of points that are projected together.
const PROJECTION_BLOCK: usize = 16;

/// A levelled point in polar coordinates about the vertical.
#[derive(Clone, Copy, Debug, Default)]
struct PolarPoint {
    squared_radius_m2: f32,
    /// Angle from the heading, 0 to [`SECTORS`].
    sectors: f32,
    height_m: f32,
}

impl PolarPoint {
    /// Of a point in the base frame, levelled by `turn`, as seen from `origin`.
    #[inline]
    fn of(point: &[f32; 3], turn: &Matrix3<f32>, origin: [f32; 2]) -> Self {
        let [x, y, height_m] =
            [0, 1, 2].map(|r| turn[(r, 0)] * point[0] + turn[(r, 1)] * point[1] + turn[(r, 2)] * point[2]);
        let (x, y) = (x - origin[0], y - origin[1]);
        let turns = points::angle::atan2(y, x) / std::f32::consts::TAU;
        let turns = if turns < 0.0 { turns + 1.0 } else { turns };
        Self { squared_radius_m2: x * x + y * y, sectors: turns * SECTORS as f32, height_m }
    }
}

/// Finds the ring of a squared radius without a logarithm for each point.
struct RingTable {
    /// Squared inner radius of each ring, square metres; the last one is infinite.
    squared_inner_radii_m2: [f32; RINGS + 1],
    /// Ring of the least value of each interval of squared radii. An eighth of an octave is narrower than a ring, so the others are in this ring or in the
    /// next one.
    first: [u8; Self::INTERVALS],
}

impl RingTable {
    /// Bits of a number below its exponent and the first three of its fraction: numbers that differ in these alone share an interval.
    const INTERVAL_BITS: u32 = f32::MANTISSA_DIGITS - 1 - 3;
    /// First interval: of the squared inner radius of the first ring.
    const FIRST_INTERVAL: u32 = (MIN_RADIUS_M * MIN_RADIUS_M).to_bits() >> Self::INTERVAL_BITS;
    const INTERVALS: usize = (((MAX_RADIUS_M * MAX_RADIUS_M).to_bits() >> Self::INTERVAL_BITS)
        - Self::FIRST_INTERVAL) as usize
        + 1;

    fn new() -> Self {
        let growth = (MAX_RADIUS_M / MIN_RADIUS_M).powf(2.0 / RINGS as f32);
        let mut squared_inner_radii_m2 = [f32::INFINITY; RINGS + 1];
        let mut radius_m2 = MIN_RADIUS_M * MIN_RADIUS_M;
        for inner in &mut squared_inner_radii_m2[..RINGS] {
            *inner = radius_m2;
            radius_m2 *= growth;
        }
        let first = std::array::from_fn(|interval| {
            let least = f32::from_bits((interval as u32 + Self::FIRST_INTERVAL) << Self::INTERVAL_BITS);
            squared_inner_radii_m2[1..].partition_point(|inner| *inner <= least) as u8
        });
        Self { squared_inner_radii_m2, first }
    }

    /// The ring of a squared radius, square metres. `None` outside the rings and for NaN.
    #[inline]
    fn ring(&self, squared_radius_m2: f32) -> Option<usize> {
        const INNER_M2: f32 = MIN_RADIUS_M * MIN_RADIUS_M;
        const OUTER_M2: f32 = MAX_RADIUS_M * MAX_RADIUS_M;
        if !(INNER_M2..OUTER_M2).contains(&squared_radius_m2) {
            return None;
        }
        let interval = (squared_radius_m2.to_bits() >> Self::INTERVAL_BITS) - Self::FIRST_INTERVAL;
        let ring = usize::from(self.first[interval as usize]);
        Some(ring + usize::from(squared_radius_m2 >= self.squared_inner_radii_m2[ring + 1]))
    }
}

/// Best alignment of two scan contexts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanContextAlignment {
    /// Distance, 0 (equal) to 1 (nothing in common).
    pub distance: f32,
    /// Rotation of the second about the vertical in the first, radians.
    pub yaw: f64,
}

/// The rotation without its heading: it turns base coordinates so that z points up and x keeps its heading.
pub fn level_from_base(parent_from_base: &Rotation) -> Rotation {
    let forward = parent_from_base * Vector3::x();
    let heading = so3::exp(&(Vector3::z() * forward.y.atan2(forward.x)));
    heading.inverse() * parent_from_base
}

impl ScanContext {
    /// Computes the scan context of a motion-corrected cloud (base frame, metres), levelled, as seen from a point that lies `origin` metres
    /// ahead of the base and to its left. Linear in the points. Points that are not finite are skipped.
    pub fn new(xyz: &[[f32; 3]], level_from_base: &Rotation, origin: [f32; 2]) -> Self {
        let turn = level_from_base.to_rotation_matrix().into_inner().map(|value| value as f32);
        let rings = RingTable::new();
        let (mut heights, mut slices) = (Box::new([[0; RINGS]; SECTORS]), Box::new([[0; RINGS]; SECTORS]));
        for block in xyz.chunks(PROJECTION_BLOCK) {
            // Blocks of points without a branch among them are computed several at a time.
            let mut projected = [PolarPoint::default(); PROJECTION_BLOCK];
            for (polar, point) in projected.iter_mut().zip(block) {
                *polar = PolarPoint::of(point, &turn, origin);
            }
            for polar in &projected[..block.len()] {
                let Some(ring) = rings.ring(polar.squared_radius_m2).filter(|_| polar.height_m.is_finite())
                else {
                    continue;
                };
                let sector = (polar.sectors as usize).min(SECTORS - 1);
                let height = ((polar.height_m + HEIGHT_DEPTH_M) / HEIGHT_STEP_M).clamp(1.0, 255.0) as u8;
                heights[sector][ring] = height.max(heights[sector][ring]);
                let slice = (polar.height_m + SLICE_DEPTH_M) / SLICE_M;
                if (0.0..8.0).contains(&slice) {
                    slices[sector][ring] |= 1 << slice as u8;
                }
            }
        }
        Self { ring_key: ring_key(&heights, &slices), sector_key: sector_key(&slices), heights, slices }
    }

    /// Restores a scan context from [`Self::images`]. `None` if an image does not have the right size.
    pub fn from_images(heights: &[u8], slices: &[u8]) -> Option<Self> {
        let (heights, slices) = (Box::new(polar_image(heights)?), Box::new(polar_image(slices)?));
        Some(Self { ring_key: ring_key(&heights, &slices), sector_key: sector_key(&slices), heights, slices })
    }

    /// Both images, greatest heights and occupied slices, sector by sector. The keys are computed from them.
    pub fn images(&self) -> [Vec<u8>; 2] {
        [&self.heights, &self.slices].map(|image| image.as_flattened().to_vec())
    }

    /// The ring key, which does not change when the robot turns.
    pub fn ring_key(&self) -> &[f32; RING_KEY_LENGTH] {
        &self.ring_key
    }

    /// Share of the bins that are not empty, 0 to 1.
    pub fn fill(&self) -> f32 {
        let filled = self.slices.iter().flatten().filter(|&&bin| bin != 0).count();
        filled as f32 / (RINGS * SECTORS) as f32
    }

    /// Best alignment of `other` with this one. The `peaks` best correlations of the sector keys and their neighbours are tried on the images.
    /// About 15 us for three.
    pub fn align(&self, other: &Self, peaks: usize) -> ScanContextAlignment {
        let mut fits = [0.0_f32; SECTORS];
        for (shift, fit) in fits.iter_mut().enumerate() {
            *fit = (0..SECTORS).map(|s| self.sector_key[(s + shift) % SECTORS] * other.sector_key[s]).sum();
        }
        let mut order: [usize; SECTORS] = std::array::from_fn(|shift| shift);
        order.sort_by(|&a, &b| fits[b].total_cmp(&fits[a]).then(a.cmp(&b)));
        let mut best = ScanContextAlignment { distance: f32::INFINITY, yaw: 0.0 };
        for &peak in order.iter().take(peaks) {
            for shift in [peak + SECTORS - 1, peak, peak + 1].map(|shift| shift % SECTORS) {
                let distance = self.distance(other, shift);
                if distance < best.distance {
                    let turns = shift as f64 / SECTORS as f64;
                    best = ScanContextAlignment { distance, yaw: std::f64::consts::TAU * turns };
                }
            }
        }
        best
    }

    /// Mean distance of both images with `other` turned by `shift` sectors (equation 4).
    fn distance(&self, other: &Self, shift: usize) -> f32 {
        let (mut both, mut either) = (0_u32, 0_u32);
        let (mut height, mut columns) = (0.0_f32, 0_u32);
        for sector in 0..SECTORS {
            let here = (sector + shift) % SECTORS;
            let (a, b) = (&self.slices[here], &other.slices[sector]);
            for (a, b) in a.chunks_exact(8).zip(b.chunks_exact(8)) {
                let (a, b) = (word(a), word(b));
                both += (a & b).count_ones();
                either += (a | b).count_ones();
            }
            if let Some(cosine) = cosine(&self.heights[here], &other.heights[sector]) {
                height += 1.0 - cosine;
                columns += 1;
            }
        }
        let slices = 1.0 - both as f32 / either.max(1) as f32;
        // A column that is empty in one of the images counts as different.
        let height = (height + (SECTORS as u32 - columns) as f32) / SECTORS as f32;
        0.5 * (slices + height)
    }
}

/// From a list sector by sector. `None` if it does not have the right length.
fn polar_image(bins: &[u8]) -> Option<PolarImage> {
    let mut image = [[0; RINGS]; SECTORS];
    (bins.len() == RINGS * SECTORS).then(|| {
        image.as_flattened_mut().copy_from_slice(bins);
        image
    })
}

/// Pose of the second base in the first one according to an alignment, if the second was seen from `origin`.
pub fn first_from_second(
    alignment: &ScanContextAlignment,
    level_from_first: &Rotation,
    level_from_second: &Rotation,
    origin: [f32; 2],
) -> Isometry {
    let turn = so3::exp(&(Vector3::z() * alignment.yaw));
    let shift = turn * Vector3::new(-f64::from(origin[0]), -f64::from(origin[1]), 0.0);
    let back = level_from_first.inverse();
    Isometry::from_parts(Translation3::from(back * shift), back * turn * level_from_second)
}

fn ring_key(heights: &PolarImage, slices: &PolarImage) -> [f32; RING_KEY_LENGTH] {
    let mut key = [0.0; RING_KEY_LENGTH];
    for ring in 0..RINGS {
        let filled: u32 = slices.iter().map(|sector| sector[ring].count_ones()).sum();
        key[ring] = filled as f32 / (8 * SECTORS) as f32;
    }
    for (index, value) in key[RINGS..].iter_mut().enumerate() {
        let sum: u32 = heights.iter().flat_map(|s| &s[3 * index..3 * index + 3]).map(|&h| u32::from(h)).sum();
        *value = sum as f32 / (255 * 3 * SECTORS) as f32;
    }
    key
}

/// Fill of each sector minus the mean, so that the correlation compares shapes.
fn sector_key(slices: &PolarImage) -> [f32; SECTORS] {
    let fill: [f32; SECTORS] =
        std::array::from_fn(|s| slices[s].iter().map(|bin| bin.count_ones()).sum::<u32>() as f32);
    let mean = fill.iter().sum::<f32>() / SECTORS as f32;
    fill.map(|value| value - mean)
}

fn word(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |word, &byte| word << 8 | u64::from(byte))
}

/// Cosine of the angle between two columns. `None` if one is empty.
fn cosine(a: &[u8; RINGS], b: &[u8; RINGS]) -> Option<f32> {
    let (mut aa, mut bb, mut ab) = (0_u32, 0_u32, 0_u32);
    for ring in 0..RINGS {
        let (x, y) = (u32::from(a[ring]), u32::from(b[ring]));
        aa += x * x;
        bb += y * y;
        ab += x * y;
    }
    (aa > 0 && bb > 0).then(|| ab as f32 / (aa as f32 * bb as f32).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::RngTree;

    /// A hall with boxes in it, as seen from the origin.
    fn hall(seed: u64) -> Vec<[f32; 3]> {
        let mut rng = RngTree::new(seed).child("hall").rng();
        let mut points = Vec::new();
        for _ in 0..25 {
            let (x, y) = (rng.range(-14.0, 14.0), rng.range(-9.0, 9.0));
            let (width, height) = (rng.range(0.3, 1.5), rng.range(0.3, 3.0));
            for _ in 0..150 {
                let [dx, dy] = [0; 2].map(|_| rng.range(0.0, width));
                points.push([(x + dx) as f32, (y + dy) as f32, rng.range(-0.5, height) as f32]);
            }
        }
        points
    }

    fn moved(points: &[[f32; 3]], by: &Isometry) -> Vec<[f32; 3]> {
        let move_one = |p: &[f32; 3]| {
            let q = by * nalgebra::Point3::from(p.map(f64::from));
            [q.x as f32, q.y as f32, q.z as f32]
        };
        points.iter().map(move_one).collect()
    }

    #[test]
    fn a_turned_tilted_and_shifted_view_is_recognised_and_placed() {
        let level = Rotation::identity();
        let first = ScanContext::new(&hall(1), &level, [0.0; 2]);
        let truth = Isometry::new(Vector3::new(-1.1, 0.9, 0.0), Vector3::z() * 2.2);
        let tilt = so3::exp(&Vector3::new(0.1, -0.15, 0.0));
        // The base is tilted; its cloud is the hall in its frame.
        let first_from_base = truth * tilt;
        let cloud = moved(&hall(1), &first_from_base.inverse());
        let levelled = level_from_base(&first_from_base.rotation);
        // The robot stands 1.42 m away. Seen from where the first one stood, only the borders of the bins differ.
        let back = truth.rotation.inverse() * -truth.translation.vector;
        let origin = [back.x as f32, back.y as f32];
        let second = ScanContext::new(&cloud, &levelled, origin);
        let alignment = first.align(&second, 3);
        let plain = first.align(&ScanContext::new(&cloud, &levelled, [0.0; 2]), 3);
        let other = first.align(&ScanContext::new(&hall(2), &level, [0.0; 2]), 3);
        assert!(
            alignment.distance < 0.35 && alignment.distance < 0.6 * other.distance,
            "{alignment:?} {other:?}"
        );
        assert!(plain.distance < other.distance, "{plain:?} {other:?}");
        let found = first_from_second(&alignment, &level, &levelled, origin);
        let error = geometry::se3::local(&first_from_base, &found);
        assert!(error.fixed_rows::<3>(3).norm() < 0.2 && error.norm() < 0.25, "{error}");
    }

    #[test]
    fn the_ring_table_gives_the_logarithmic_rings() {
        let rings = RingTable::new();
        let rings_per_log = RINGS as f32 / (MAX_RADIUS_M / MIN_RADIUS_M).ln();
        for step in 0..200_000 {
            let radius_m = MIN_RADIUS_M * 1e-3f32.mul_add(step as f32 * 0.25, 1.0);
            let exact = (radius_m / MIN_RADIUS_M).ln() * rings_per_log;
            let is_at_border = (exact - exact.round()).abs() < 1e-4;
            let expected = (radius_m < MAX_RADIUS_M).then_some((exact as usize).min(RINGS - 1));
            if !is_at_border {
                assert_eq!(rings.ring(radius_m * radius_m), expected, "{radius_m} m");
            }
        }
        for outside in [0.0, 2.2, 2025.0, f32::INFINITY, f32::NAN] {
            assert_eq!(rings.ring(outside), None, "{outside}");
        }
    }

    #[test]
    fn the_ring_key_does_not_change_when_the_robot_turns() {
        let level = Rotation::identity();
        let a = ScanContext::new(&hall(3), &level, [0.0; 2]);
        let turn =
            Isometry::new(Vector3::zeros(), Vector3::z() * (std::f64::consts::TAU / SECTORS as f64 * 7.0));
        let b = ScanContext::new(&moved(&hall(3), &turn), &level, [0.0; 2]);
        let other = ScanContext::new(&hall(4), &level, [0.0; 2]);
        let apart = |x: &ScanContext, y: &ScanContext| -> f32 {
            x.ring_key().iter().zip(y.ring_key()).map(|(x, y)| (x - y).powi(2)).sum()
        };
        assert!(apart(&a, &b) < 0.05 * apart(&a, &other), "{} {}", apart(&a, &b), apart(&a, &other));
    }

    #[test]
    fn empty_and_invalid_clouds_match_nothing() {
        let level = Rotation::identity();
        let empty = ScanContext::new(&[], &level, [0.0; 2]);
        let broken = ScanContext::new(&[[f32::NAN; 3], [f32::INFINITY; 3]], &level, [0.0; 2]);
        assert_eq!(empty, broken);
        assert_eq!(empty.align(&ScanContext::new(&hall(1), &level, [0.0; 2]), 3).distance, 1.0);
    }
}
