//! A hash set of integer cells with open addressing: one `u64` for each slot, no allocation for each entry.

/// Bits for each coordinate of a cell.
const COORDINATE_BITS: u32 = 21;
/// Coordinates run from 0 to one less than this.
pub(crate) const COORDINATE_END: u32 = 1 << COORDINATE_BITS;

const MIN_SLOTS: usize = 1024;
const EMPTY: u64 = 0;

/// The set of occupied cells. It needs at most 22 bytes for each cell, and 32 while it grows.
#[derive(Clone, Debug, Default)]
pub(crate) struct CellSet {
    /// Slots; their number is a power of two, or zero at first. At most three quarters of them are occupied.
    slots: Vec<u64>,
    occupied: usize,
}

impl CellSet {
    /// Number of cells occupied.
    pub(crate) fn len(&self) -> usize {
        self.occupied
    }

    /// Removes all cells and keeps the memory.
    pub(crate) fn clear(&mut self) {
        self.slots.fill(EMPTY);
        self.occupied = 0;
    }

    /// Inserts a cell; false if it was occupied before. Only the lowest 21 bits of each coordinate count.
    pub(crate) fn insert(&mut self, cell: [u32; 3]) -> bool {
        if self.occupied * 4 >= self.slots.len() * 3 {
            self.grow();
        }
        let inserted = place(&mut self.slots, key_of(cell));
        self.occupied += usize::from(inserted);
        inserted
    }

    fn grow(&mut self) {
        let mut slots = vec![EMPTY; (self.slots.len() * 2).max(MIN_SLOTS)];
        for key in self.slots.iter().copied().filter(|key| *key != EMPTY) {
            place(&mut slots, key);
        }
        self.slots = slots;
    }
}

/// Never [`EMPTY`]: the highest bit is set, and 63 bits suffice for the coordinates.
fn key_of(cell: [u32; 3]) -> u64 {
    let [x, y, z] = cell.map(|c| u64::from(c & (COORDINATE_END - 1)));
    (1 << 63) | (z << (2 * COORDINATE_BITS)) | (y << COORDINATE_BITS) | x
}

/// Inserts `key`; false if it was there before. The number of slots is a power of two, and not all are occupied.
fn place(slots: &mut [u64], key: u64) -> bool {
    let mask = slots.len() - 1;
    // Fibonacci hashing: the high bits of the product mix all bits of the key.
    let mut at = (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as usize & mask;
    while slots[at] != EMPTY {
        if slots[at] == key {
            return false;
        }
        at = (at + 1) & mask;
    }
    slots[at] = key;
    true
}
