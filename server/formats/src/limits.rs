//! Limits of all formats.

/// Largest chunk of a recording, packed or not, that is read, bytes. A damaged length may ask for any amount of memory.
pub const CHUNK_BYTES_MAX: u64 = 1 << 30;
