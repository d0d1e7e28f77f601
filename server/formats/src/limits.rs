//! Limits of all formats. They hold the memory for a file within bounds, whatever its header claims.

/// Largest chunk of a recording, packed or not, that is read, bytes. A damaged length may ask for any amount of memory. Recorders write chunks of 1 to 4 MB.
pub const MAX_CHUNK_BYTES: u64 = 256 << 20;

/// Largest size that the points of a compressed PCD file may unpack to, bytes: 12 million points of 20 bytes. The compression can make 264 bytes of
/// one, so a small file could ask for gigabytes.
pub(crate) const MAX_UNPACKED_BYTES: usize = 256 << 20;

/// Limits of reading a survey.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SurveyLimits {
    /// Most usable points. Reading takes 16 bytes a point, and up to twice that while it grows.
    pub points: usize,
}

impl SurveyLimits {
    /// Any number of points.
    pub const NONE: Self = Self { points: usize::MAX };
}
