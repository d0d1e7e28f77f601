//! Bitmaps of grid cells and counters that add 64 cells at once: the inner loop of the correlative matcher.

/// A bitmap of the cells of a plane. One word holds 64 cells that follow each other along y.
#[derive(Clone, Debug, Default)]
pub(crate) struct BitGrid {
    /// Cell of the first bit.
    origin: [i64; 2],
    columns: usize,
    words_per_column: usize,
    words: Vec<u64>,
}

impl BitGrid {
    /// A bitmap in which these cells are set. It takes one bit for each cell of their bounding box.
    pub fn from_cells(cells: &[[i64; 2]]) -> Self {
        let Some(first) = cells.first() else { return Self::default() };
        let (min, max) = cells.iter().fold((*first, *first), |(min, max), cell| {
            ([min[0].min(cell[0]), min[1].min(cell[1])], [max[0].max(cell[0]), max[1].max(cell[1])])
        });
        let columns = (max[0] - min[0] + 1) as usize;
        let words_per_column = (max[1] - min[1] + 1) as usize / 64 + 1;
        let mut grid =
            Self { origin: min, columns, words_per_column, words: vec![0; columns * words_per_column] };
        for cell in cells {
            let (column, row) = ((cell[0] - min[0]) as usize, (cell[1] - min[1]) as usize);
            grid.words[column * words_per_column + row / 64] |= 1 << (row % 64);
        }
        grid
    }

    /// The words that are not zero, ordered by x and then y, each with the cell of its lowest bit.
    pub fn words(&self) -> impl Iterator<Item = ([i64; 2], u64)> {
        let cell = |index: usize| {
            let (column, word) = (index / self.words_per_column, index % self.words_per_column);
            [self.origin[0] + column as i64, self.origin[1] + 64 * word as i64]
        };
        self.words.iter().enumerate().filter(|(_, word)| **word != 0).map(move |(i, word)| (cell(i), *word))
    }

    /// The 64 cells along y that begin at this cell, lowest bit first.
    #[inline]
    pub fn window(&self, [x, y]: [i64; 2]) -> u64 {
        // The cast turns columns before the first into columns far beyond the last.
        let column = (x - self.origin[0]) as usize;
        if column >= self.columns {
            return 0;
        }
        let row = y - self.origin[1];
        let (word, shift) = (row.div_euclid(64), row.rem_euclid(64));
        let words = &self.words[column * self.words_per_column..(column + 1) * self.words_per_column];
        let at = |index: i64| words.get(index as usize).copied().unwrap_or(0);
        if shift == 0 { at(word) } else { at(word) >> shift | at(word + 1) << (64 - shift) }
    }
}

/// 64 counters, each from 0 to [`Self::MAX`], stored as bit planes: plane `k` holds bit `k` of every counter.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BitCounters([u64; 7]);

impl BitCounters {
    /// Highest count; one more overflows to zero.
    pub const MAX: usize = 127;

    /// Adds 1 to every counter whose bit is set in `carry`.
    #[inline]
    pub fn add(&mut self, mut carry: u64) {
        for plane in &mut self.0 {
            if carry == 0 {
                return;
            }
            let both = *plane & carry;
            *plane ^= carry;
            carry = both;
        }
    }

    /// A bit for each counter that has reached `count`.
    pub fn at_least(&self, count: u8) -> u64 {
        let (mut above, mut equal) = (0, !0);
        for (index, plane) in self.0.iter().enumerate().rev() {
            if count >> index & 1 == 1 {
                equal &= plane;
            } else {
                above |= equal & plane;
                equal &= !plane;
            }
        }
        above | equal
    }

    /// The counter of a bit from 0 to 63.
    #[inline]
    pub fn get(&self, bit: u32) -> u8 {
        self.0.iter().enumerate().map(|(index, plane)| ((plane >> bit & 1) as u8) << index).sum()
    }
}

/// Indices of the bits that are set, lowest first.
pub(crate) fn set_bits(mut word: u64) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let bit = word.trailing_zeros();
        word &= word.wrapping_sub(1);
        (bit < 64).then_some(bit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::RngTree;
    use std::collections::BTreeSet;

    #[test]
    fn windows_and_words_agree_with_a_set_of_cells() {
        let mut rng = RngTree::new(3).child("bits").rng();
        let mut draw = |reach: f64| rng.range(-reach, reach) as i64;
        let cells: Vec<[i64; 2]> = (0..3_000).map(|_| [draw(40.0), draw(150.0)]).collect();
        let (grid, listed) = (BitGrid::from_cells(&cells), cells.iter().copied().collect::<BTreeSet<_>>());
        for _ in 0..2_000 {
            let [x, y] = [draw(45.0), draw(300.0)];
            let window = grid.window([x, y]);
            for step in 0..64 {
                assert_eq!(window >> step & 1 == 1, listed.contains(&[x, y + step]), "{x} {y} {step}");
            }
        }
        let back: Vec<[i64; 2]> = grid
            .words()
            .flat_map(|([x, y], word)| set_bits(word).map(move |bit| [x, y + i64::from(bit)]))
            .collect();
        assert_eq!(back, listed.into_iter().collect::<Vec<_>>());
        assert_eq!(BitGrid::from_cells(&[]).window([0, 0]), 0);
    }

    #[test]
    fn counters_agree_with_64_integers() {
        let mut rng = RngTree::new(4).child("counts").rng();
        let (mut counters, mut slow) = (BitCounters::default(), [0_u8; 64]);
        for _ in 0..BitCounters::MAX {
            let word = rng.bits() & rng.bits();
            counters.add(word);
            for bit in set_bits(word) {
                slow[bit as usize] += 1;
            }
        }
        for bit in 0..64 {
            assert_eq!(counters.get(bit), slow[bit as usize]);
        }
        for count in 0..=127 {
            let expected = (0..64).filter(|bit| slow[*bit as usize] >= count);
            assert_eq!(set_bits(counters.at_least(count)).collect::<Vec<_>>(), expected.collect::<Vec<_>>());
        }
    }
}
