//! Morton keys: interleave three 16-bit lattice coordinates, so that points near in space are near in order.

/// Every third bit, from bit 0.
const THIRDS: u64 = 0x1249_2492_4924_9249;

/// Bits of `x` at positions 0, 3, 6 and so on, of `y` one higher, of `z` two higher: 48 bits in all.
pub(crate) fn interleave([x, y, z]: [u16; 3]) -> u64 {
    spread(x) | (spread(y) << 1) | (spread(z) << 2)
}

/// The inverse of [`interleave`]; bits above the 48th are ignored.
pub(crate) fn split(key: u64) -> [u16; 3] {
    [gather(key), gather(key >> 1), gather(key >> 2)]
}

/// Moves bit `i` to bit `3 i`, in steps that each halve the length of the runs that move together.
fn spread(value: u16) -> u64 {
    let mut v = u64::from(value);
    v = (v | (v << 16)) & 0x001f_0000_ff00_00ff;
    v = (v | (v << 8)) & 0x100f_00f0_0f00_f00f;
    v = (v | (v << 4)) & 0x10c3_0c30_c30c_30c3;
    (v | (v << 2)) & THIRDS
}

/// Moves bit `3 i` to bit `i` and drops the others.
fn gather(key: u64) -> u16 {
    let mut v = key & THIRDS;
    v = (v ^ (v >> 2)) & 0x10c3_0c30_c30c_30c3;
    v = (v ^ (v >> 4)) & 0x100f_00f0_0f00_f00f;
    v = (v ^ (v >> 8)) & 0x001f_0000_ff00_00ff;
    (v ^ (v >> 16)) as u16
}
