//! A deterministic hash table from grid cells to `u32` indices.
//!
//! The standard table seeds itself differently in every process. This one has a fixed hash function, so equal insertions give equal
//! behaviour. It uses linear probing, removes by shifting entries back, is never iterated, and is at most half full.

/// A cell of a regular grid, packed into 63 bits: 21 per axis, so ±1,048,575 cells from the origin. Cells farther out are clamped to the border
/// and share its entries. Maps never reach that far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct CellKey(u64);

/// Offset that makes every axis of a key positive.
const BIAS: i64 = 1 << 20;
/// No cell packs to this.
const EMPTY: u64 = u64::MAX;

impl CellKey {
    /// Packs integer cell coordinates.
    #[inline]
    pub fn new(cell: [i64; 3]) -> Self {
        let pack = |c: i64| (c.clamp(1 - BIAS, BIAS - 1) + BIAS) as u64;
        Self(pack(cell[0]) | pack(cell[1]) << 21 | pack(cell[2]) << 42)
    }

    /// The cell that holds a point, in a grid whose cells have an edge of one divided by `cells_per_metre`, metres. A coordinate
    /// that is not a number counts as the lowest.
    #[inline]
    #[expect(clippy::manual_clamp, reason = "clamp would keep what is not a number")]
    pub fn of_point(point: &[f32; 3], cells_per_metre: f32) -> Self {
        const LIMIT: f32 = (BIAS - 1) as f32;
        // Adding it rounds to integers, which are the lowest bits of the sum: 1.5 times 2 to the 23rd.
        const ROUNDER: f32 = 12_582_912.0;
        let pack = |c: f32| {
            let scaled = (c * cells_per_metre).max(-LIMIT).min(LIMIT);
            let sum = scaled + ROUNDER;
            let is_rounded_up = sum - ROUNDER > scaled;
            let cell = (sum.to_bits() as i32) - (ROUNDER.to_bits() as i32) - i32::from(is_rounded_up);
            (cell + BIAS as i32) as u32
        };
        let [x, y, z] = point.map(pack).map(u64::from);
        Self(x | y << 21 | z << 42)
    }

    /// The integer cell coordinates.
    pub fn cell(self) -> [i64; 3] {
        let unpack = |shift: u32| ((self.0 >> shift) & ((1 << 21) - 1)) as i64 - BIAS;
        [unpack(0), unpack(21), unpack(42)]
    }
}

/// Hash table from cells to `u32`.
#[derive(Clone, Debug)]
pub struct CellTable {
    /// Key and value of each slot.
    slots: Vec<(u64, u32)>,
    /// 64 minus the logarithm of the number of slots.
    shift: u32,
    len: usize,
}

impl Default for CellTable {
    fn default() -> Self {
        Self::with_capacity(512)
    }
}

impl CellTable {
    /// A table that holds this many cells before it first grows.
    pub fn with_capacity(cells: usize) -> Self {
        let slots = (cells.max(8) * 2).next_power_of_two();
        Self { slots: vec![(EMPTY, 0); slots], shift: 64 - slots.trailing_zeros(), len: 0 }
    }

    /// Number of cells held.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether no cell is held.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Removes every cell and keeps the memory.
    pub fn clear(&mut self) {
        self.slots.fill((EMPTY, 0));
        self.len = 0;
    }

    /// The value stored for a cell.
    #[inline]
    pub fn get(&self, key: CellKey) -> Option<u32> {
        let mut slot = self.home_slot(key.0);
        loop {
            let (stored, value) = self.slots[slot];
            if stored == key.0 {
                return Some(value);
            }
            if stored == EMPTY {
                return None;
            }
            slot = (slot + 1) & (self.slots.len() - 1);
        }
    }

    /// The values of several cells, looked up only in the first slot of each cell's search. `None` for a cell that is not in that slot: it may be
    /// stored in another one. The reads do not depend on one another, so that the processor makes them at the same time.
    #[inline]
    pub fn peek<const N: usize>(&self, keys: &[CellKey; N]) -> [Option<u32>; N] {
        let slots: [(u64, u32); N] = std::array::from_fn(|index| self.slots[self.home_slot(keys[index].0)]);
        std::array::from_fn(|index| (slots[index].0 == keys[index].0).then_some(slots[index].1))
    }

    /// The value stored for a cell, and whether it is new: `value` is stored if the cell had none.
    #[inline]
    pub fn get_or_insert(&mut self, key: CellKey, value: u32) -> (u32, bool) {
        let mut slot = self.home_slot(key.0);
        loop {
            let (stored, found) = self.slots[slot];
            if stored == key.0 {
                return (found, false);
            }
            if stored == EMPTY {
                break;
            }
            slot = (slot + 1) & (self.slots.len() - 1);
        }
        self.slots[slot] = (key.0, value);
        self.len += 1;
        if self.len * 2 > self.slots.len() {
            self.grow();
        }
        (value, true)
    }

    /// Removes a cell and returns its value.
    pub fn remove(&mut self, key: CellKey) -> Option<u32> {
        let mask = self.slots.len() - 1;
        let mut hole = self.home_slot(key.0);
        while self.slots[hole].0 != key.0 {
            if self.slots[hole].0 == EMPTY {
                return None;
            }
            hole = (hole + 1) & mask;
        }
        let value = self.slots[hole].1;
        // Later entries of the same run move back, but not before their home slot.
        let mut next = (hole + 1) & mask;
        while self.slots[next].0 != EMPTY {
            let home = self.home_slot(self.slots[next].0);
            if next.wrapping_sub(home) & mask >= next.wrapping_sub(hole) & mask {
                self.slots[hole] = self.slots[next];
                hole = next;
            }
            next = (next + 1) & mask;
        }
        self.slots[hole] = (EMPTY, 0);
        self.len -= 1;
        Some(value)
    }

    /// The slot at which the search for a key begins (Fibonacci hashing).
    #[inline]
    fn home_slot(&self, key: u64) -> usize {
        ((key ^ (key >> 29)).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> self.shift) as usize
    }

    fn grow(&mut self) {
        let slots = self.slots.len() * 2;
        let old = std::mem::replace(&mut self.slots, vec![(EMPTY, 0); slots]);
        self.shift -= 1;
        for (key, value) in old.into_iter().filter(|&(key, _)| key != EMPTY) {
            let mut slot = self.home_slot(key);
            while self.slots[slot].0 != EMPTY {
                slot = (slot + 1) & (slots - 1);
            }
            self.slots[slot] = (key, value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cell_of_a_point_is_rounded_down_and_clamped() {
        let key = |point: [f32; 3]| CellKey::of_point(&point, 4.0).cell();
        assert_eq!(key([0.0, 0.25, 0.249]), [0, 1, 0]);
        assert_eq!(key([-0.0, -0.001, -0.25]), [0, -1, -1]);
        assert_eq!(key([1234.6, -1234.6, 1e9]), [4938, -4939, BIAS - 1]);
        assert_eq!(key([f32::NEG_INFINITY, f32::INFINITY, f32::NAN]), [1 - BIAS, BIAS - 1, 1 - BIAS]);
    }

    #[test]
    fn a_key_returns_the_coordinates_of_its_cell() {
        for cell in [[0, 0, 0], [-1, 2, -3], [BIAS - 1, 1 - BIAS, 77]] {
            assert_eq!(CellKey::new(cell).cell(), cell);
        }
    }
}
