//! Encodes chunks on the robot: quantises the points, sorts them, and packs their differences.

use crate::chunk::{
    GpuPoint, HEADER_LEN, MAGIC, MAX_EXPANSION, MAX_POINTS, PACKING_STORED, PACKING_ZSTD, PLANES, PointChunk,
    VERSION, zigzag,
};
use crate::morton;
use vocab::Aabb;

/// Permitted range of a lattice's step, metres.
const STEP_RANGE: std::ops::RangeInclusive<f32> = 1e-4..=100.0;
/// Largest number of steps from the origin to a point.
const MAX_STEPS: f32 = u16::MAX as f32;
/// Points with a greater coordinate are left out of scans and maps, metres: no sensor measures them, and differences must be finite.
pub(crate) const MAX_COORDINATE_M: f32 = 1e6;
/// zstd's fastest level. Higher levels save 2 % on these planes and take three times as long.
const ZSTD_LEVEL: i32 = 1;

/// Encodes a scan, quantised to `resolution` metres, in any frame. 1 cm is enough for a display.
///
/// The error of each coordinate is at most half the step. The step is `resolution`, doubled until the whole scan spans
/// at most 65,535 steps (655 m at 1 cm). Points that are not finite or beyond 1,000 km are left out, as are all
/// after the first [`MAX_POINTS`]. `intensity` may be empty or short; missing values count as 0. The order of
/// points changes.
pub fn encode_scan(xyz: &[[f32; 3]], intensity: &[f32], resolution: f32) -> Vec<u8> {
    encode(&quantise(xyz, intensity, resolution))
}

/// The chunk that [`encode_scan`] writes, in the order of the input, for callers that set level and spacing.
pub fn quantise(xyz: &[[f32; 3]], intensity: &[f32], resolution: f32) -> PointChunk {
    let usable = |p: &[f32; 3]| p.iter().all(|c| c.abs() <= MAX_COORDINATE_M);
    let mut bounds = Aabb::EMPTY;
    for point in xyz.iter().filter(|p| usable(p)) {
        bounds.include(*point);
    }
    let origin = bounds.min.map(|c| if c.is_finite() { c } else { 0.0 });
    let extent = (0..3).map(|axis| bounds.max[axis] - bounds.min[axis]).fold(0.0, f32::max);
    let step = lattice_step(resolution, extent);
    let unit = intensity_unit(intensity);
    let intensities = intensity.iter().copied().chain(std::iter::repeat(0.0));
    let points = xyz
        .iter()
        .zip(intensities)
        .filter(|(p, _)| usable(p))
        .take(MAX_POINTS)
        .map(|(p, value)| GpuPoint {
            position: std::array::from_fn(|axis| ((p[axis] - origin[axis]) / step).round() as u16),
            intensity: (value / unit).round() as u8,
            spare: 0,
        })
        .collect();
    PointChunk { origin, step, intensity_unit: unit, spacing: 0.0, level: 0, points }
}

/// The wanted resolution, doubled until `extent` fits into 16 bits.
fn lattice_step(resolution: f32, extent: f32) -> f32 {
    let wanted = if resolution.is_nan() { crate::POINT_RESOLUTION_M } else { resolution };
    let mut step = wanted.clamp(*STEP_RANGE.start(), *STEP_RANGE.end());
    while extent / step > MAX_STEPS - 1.0 {
        step *= 2.0;
    }
    step
}

/// Sensor units for each of 255 counts: 1/255 for intensities up to 1, 1 for intensities up to 255, else the smallest sufficient power of
/// two. These coarse steps avoid flickering colours between scans.
pub(crate) fn intensity_unit(intensity: &[f32]) -> f32 {
    let greatest = intensity.iter().copied().filter(|v| v.is_finite()).fold(0.0, f32::max);
    if greatest <= 1.0 {
        1.0 / 255.0
    } else if greatest <= 255.0 {
        1.0
    } else {
        (greatest / 255.0).log2().ceil().exp2()
    }
}

/// Encodes a chunk. Points are sorted in Morton order; those beyond [`MAX_POINTS`] are left out.
pub fn encode(chunk: &PointChunk) -> Vec<u8> {
    let points = &chunk.points[..chunk.points.len().min(MAX_POINTS)];
    let planes = write_planes(points);
    let packed = zstd::bulk::compress(&planes, ZSTD_LEVEL)
        .ok()
        .filter(|packed| packed.len() < planes.len() && packed.len() * MAX_EXPANSION >= planes.len());
    let (packing, payload) = match &packed {
        Some(packed) => (PACKING_ZSTD, packed),
        None => (PACKING_STORED, &planes),
    };
    let mut bytes = Vec::with_capacity(HEADER_LEN + payload.len());
    bytes.extend_from_slice(&MAGIC);
    bytes.extend_from_slice(&[VERSION, packing, chunk.level, 0]);
    bytes.extend_from_slice(&(points.len() as u32).to_le_bytes());
    bytes.extend_from_slice(&(payload.len() as u32).to_le_bytes());
    for value in chunk.origin.into_iter().chain([chunk.step, chunk.intensity_unit, chunk.spacing]) {
        bytes.extend_from_slice(&value.to_le_bytes());
    }
    bytes.extend_from_slice(payload);
    bytes
}

/// Writes the seven planes of differences that [`crate::chunk`] describes.
fn write_planes(points: &[GpuPoint]) -> Vec<u8> {
    let ordered = morton_order(points);
    let count = ordered.len();
    let mut planes = vec![0; count * PLANES];
    let mut previous = [0_u16; 3];
    let mut previous_intensity = 0_u8;
    for (i, key) in ordered.into_iter().enumerate() {
        let position = morton::split(key >> 8);
        for axis in 0..3 {
            let [low, high] = zigzag(position[axis].wrapping_sub(previous[axis])).to_le_bytes();
            planes[2 * axis * count + i] = low;
            planes[(2 * axis + 1) * count + i] = high;
        }
        let intensity = key as u8;
        planes[6 * count + i] = intensity.wrapping_sub(previous_intensity);
        (previous, previous_intensity) = (position, intensity);
    }
    planes
}

/// Sorted Morton keys, each with the point's intensity in its lowest byte.
fn morton_order(points: &[GpuPoint]) -> Vec<u64> {
    let mut keys: Vec<u64> =
        points.iter().map(|p| (morton::interleave(p.position) << 8) | u64::from(p.intensity)).collect();
    keys.sort_unstable();
    keys
}
