//! The format in which points are sent, and its decoder.
//!
//! A chunk is a header of [`HEADER_LEN`] bytes and a payload, all little endian:
//!
//! | offset | type | meaning |
//! | --- | --- | --- |
//! | 0 | 4 bytes | `AIPC` |
//! | 4 | u8 | version, 1 |
//! | 5 | u8 | packing of the payload: 0 none, 1 one zstd frame |
//! | 6 | u8 | level of the tile, 0 the coarsest; 0 for scans |
//! | 7 | u8 | 0, reserved |
//! | 8 | u32 | number of points |
//! | 12 | u32 | bytes of payload, which end the chunk |
//! | 16 | 3 f32 | origin, metres, frame of the chunk |
//! | 28 | f32 | step of the lattice, metres |
//! | 32 | f32 | sensor units for each count of intensity |
//! | 36 | f32 | typical distance between neighbouring points, metres; 0 when unknown |
//!
//! The unpacked payload is seven planes of one byte for each point: low and high bytes of the zigzag differences of x, then y, then z, then
//! the wrapping differences of intensity. Points are in Morton order, which makes the differences small and similar, so that the planes
//! compress well.

use bytemuck::{Pod, Zeroable};
use ruzstd::decoding::{FrameDecoder, errors::FrameDecoderError};
use vocab::Aabb;

/// Bytes before the payload.
pub const HEADER_LEN: usize = 40;
/// Largest ratio of unpacked to packed payload. The encoder does not pack a payload above it, and the decoder rejects it, so that a few bytes
/// cannot allocate gigabytes.
pub const MAX_EXPANSION: usize = 256;
/// Largest number of points in one chunk.
pub const MAX_POINTS: usize = 1 << 24;

pub(crate) const MAGIC: [u8; 4] = *b"AIPC";
pub(crate) const VERSION: u8 = 1;
pub(crate) const PACKING_STORED: u8 = 0;
pub(crate) const PACKING_ZSTD: u8 = 1;
/// Number of planes: low and high bytes of three coordinates, and intensity.
pub(crate) const PLANES: usize = 7;

/// One point as the GPU reads it: lattice coordinates relative to the chunk's origin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Pod, Zeroable)]
#[repr(C)]
pub struct GpuPoint {
    /// Steps from the origin along x, y and z.
    pub position: [u16; 3],
    /// Counts of [`PointChunk::intensity_unit`].
    pub intensity: u8,
    /// Free for the receiver; the codec sets it to 0.
    pub spare: u8,
}

/// Points on a lattice. The message or tile that contains the chunk defines its frame: base for a scan, keyframe or map for a tile.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointChunk {
    /// Position of lattice coordinate (0, 0, 0), metres.
    pub origin: [f32; 3],
    /// Edge of a lattice cell, metres.
    pub step: f32,
    /// Sensor units for each count of intensity.
    pub intensity_unit: f32,
    /// Typical distance between neighbouring points, metres; 0 when unknown.
    pub spacing: f32,
    /// Level of the tile, 0 the coarsest.
    pub level: u8,
    /// The points.
    pub points: Vec<GpuPoint>,
}

impl PointChunk {
    /// Position of a point of this chunk, metres, frame of the chunk.
    pub fn position(&self, point: &GpuPoint) -> [f32; 3] {
        std::array::from_fn(|axis| self.origin[axis] + self.step * f32::from(point.position[axis]))
    }

    /// The smallest box around the points, metres, frame of the chunk.
    pub fn bounds(&self) -> Aabb {
        let mut bounds = Aabb::EMPTY;
        for point in &self.points {
            bounds.include(self.position(point));
        }
        bounds
    }
}

/// Why bytes are not a chunk.
#[derive(Debug, thiserror::Error)]
pub enum ChunkDecodeError {
    /// Fewer bytes than a header.
    #[error("{present} bytes are too few for a point chunk")]
    Short {
        /// Bytes given.
        present: usize,
    },
    /// The first four bytes are not `AIPC`.
    #[error("this is not a point chunk")]
    Magic,
    /// Unknown version.
    #[error("point chunk of version {found}; this program reads version {VERSION}")]
    Version {
        /// Version in the header.
        found: u8,
    },
    /// Unknown packing.
    #[error("point chunk with unknown packing {found}")]
    Packing {
        /// Packing in the header.
        found: u8,
    },
    /// The length of the payload differs from the header.
    #[error("point chunk announces {announced} bytes of payload, {present} are there")]
    PayloadLength {
        /// Bytes according to the header.
        announced: usize,
        /// Bytes given after the header.
        present: usize,
    },
    /// More points than the payload may unpack to.
    #[error("point chunk announces {points} points in {present} bytes")]
    TooManyPoints {
        /// Points according to the header.
        points: usize,
        /// Bytes of payload.
        present: usize,
    },
    /// Origin, step, spacing or unit is not finite, or the step or unit is not positive.
    #[error("point chunk with an impossible lattice")]
    Lattice,
    /// The zstd frame is damaged.
    #[error("could not unpack a point chunk")]
    Unpack(#[source] Box<FrameDecoderError>),
    /// The length of the unpacked payload does not fit the number of points.
    #[error("point chunk unpacks to {found} bytes instead of {expected}")]
    PlaneLength {
        /// Bytes that the announced points need.
        expected: usize,
        /// Bytes found.
        found: usize,
    },
}

/// Reads a chunk.
///
/// Any bytes give a chunk or an error. It allocates at most [`MAX_EXPANSION`] times `bytes.len()` plus 2 MiB.
pub fn decode(bytes: &[u8]) -> Result<PointChunk, ChunkDecodeError> {
    let (mut chunk, packing, count, payload) = read_header(bytes)?;
    let expected = count * PLANES;
    let unpacked;
    let planes: &[u8] = match packing {
        PACKING_STORED => payload,
        PACKING_ZSTD => {
            unpacked = unpack(payload, expected)?;
            &unpacked
        }
        found => return Err(ChunkDecodeError::Packing { found }),
    };
    if planes.len() != expected {
        return Err(ChunkDecodeError::PlaneLength { expected, found: planes.len() });
    }
    chunk.points = read_planes(planes, count);
    Ok(chunk)
}

/// The checked header as a chunk without points, the packing, the number of points and the payload.
fn read_header(bytes: &[u8]) -> Result<(PointChunk, u8, usize, &[u8]), ChunkDecodeError> {
    let Some((header, payload)) = bytes.split_first_chunk::<HEADER_LEN>() else {
        return Err(ChunkDecodeError::Short { present: bytes.len() });
    };
    if header[..4] != MAGIC {
        return Err(ChunkDecodeError::Magic);
    }
    if header[4] != VERSION {
        return Err(ChunkDecodeError::Version { found: header[4] });
    }
    let word = |at: usize| [header[at], header[at + 1], header[at + 2], header[at + 3]];
    let float = |at: usize| f32::from_le_bytes(word(at));
    let (count, announced) = (u32::from_le_bytes(word(8)) as usize, u32::from_le_bytes(word(12)) as usize);
    if announced != payload.len() {
        return Err(ChunkDecodeError::PayloadLength { announced, present: payload.len() });
    }
    if count > MAX_POINTS || count * PLANES > payload.len().saturating_mul(MAX_EXPANSION) {
        return Err(ChunkDecodeError::TooManyPoints { points: count, present: payload.len() });
    }
    let chunk = PointChunk {
        origin: [float(16), float(20), float(24)],
        step: float(28),
        intensity_unit: float(32),
        spacing: float(36),
        level: header[6],
        points: Vec::new(),
    };
    // The far corner must be finite too, so that no position is infinite.
    let far_corner = chunk.position(&GpuPoint { position: [u16::MAX; 3], ..GpuPoint::default() });
    let finite = chunk.origin.iter().chain(&far_corner).chain([&chunk.spacing, &chunk.intensity_unit]);
    if !finite.into_iter().all(|v| v.is_finite()) || chunk.step <= 0.0 || chunk.intensity_unit <= 0.0 {
        return Err(ChunkDecodeError::Lattice);
    }
    Ok((chunk, header[5], count, payload))
}

fn unpack(payload: &[u8], expected: usize) -> Result<Vec<u8>, ChunkDecodeError> {
    let mut planes = vec![0; expected];
    let mut decoder = FrameDecoder::new();
    // The encoder's window never exceeds the next power of two above the content.
    decoder.set_max_window_size((expected as u64).next_power_of_two().max(1024));
    let found =
        decoder.decode_all(payload, &mut planes).map_err(|e| ChunkDecodeError::Unpack(Box::new(e)))?;
    if found != expected {
        return Err(ChunkDecodeError::PlaneLength { expected, found });
    }
    Ok(planes)
}

/// Reads the points. `planes` has exactly [`PLANES`] bytes for each of `count` points.
fn read_planes(planes: &[u8], count: usize) -> Vec<GpuPoint> {
    let mut points = vec![GpuPoint::default(); count];
    if count == 0 {
        return points;
    }
    let mut rest = planes;
    for axis in 0..3 {
        let (low, after) = rest.split_at(count);
        let (high, after) = after.split_at(count);
        rest = after;
        let mut value = 0_u16;
        for ((point, low), high) in points.iter_mut().zip(low).zip(high) {
            value = value.wrapping_add(unzigzag(u16::from_le_bytes([*low, *high])));
            point.position[axis] = value;
        }
    }
    let mut value = 0_u8;
    for (point, difference) in points.iter_mut().zip(rest) {
        value = value.wrapping_add(*difference);
        point.intensity = value;
    }
    points
}

/// Moves the sign of a difference into its lowest bit, so that small differences of either sign have a zero high byte.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) fn zigzag(difference: u16) -> u16 {
    let signed = difference as i16;
    ((signed << 1) ^ (signed >> 15)) as u16
}

fn unzigzag(coded: u16) -> u16 {
    (coded >> 1) ^ (coded & 1).wrapping_neg()
}
