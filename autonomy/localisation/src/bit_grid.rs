//! A picture of cells that are there or not, 64 to a word, and sums of such words, 64 at a time.

/// Cells of a plane, some of them set. Words run along y.
#[derive(Clone, Debug, Default)]
pub(crate) struct BitGrid {
    /// Of the first cell.
    corner: [i64; 2],
    columns: usize,
    /// Words of each column.
    height: usize,
    words: Vec<u64>,
}

impl BitGrid {
    /// Of these cells. One bit for each cell of the box about them.
    pub fn of(cells: &[[i64; 2]]) -> Self {
        let Some(first) = cells.first() else { return Self::default() };
        let (least, most) = cells.iter().fold((*first, *first), |(least, most), at| {
            ([least[0].min(at[0]), least[1].min(at[1])], [most[0].max(at[0]), most[1].max(at[1])])
        });
        let columns = (most[0] - least[0] + 1) as usize;
        let height = (most[1] - least[1] + 1) as usize / 64 + 1;
        let mut bits = Self { corner: least, columns, height, words: vec![0; columns * height] };
        for at in cells {
            let (column, row) = ((at[0] - least[0]) as usize, (at[1] - least[1]) as usize);
            bits.words[column * height + row / 64] |= 1 << (row % 64);
        }
        bits
    }

    /// Words in which something is set, in order of x and then y, each with its first cell.
    pub fn words(&self) -> impl Iterator<Item = ([i64; 2], u64)> {
        let cell = |index: usize| {
            let (column, word) = (index / self.height, index % self.height);
            [self.corner[0] + column as i64, self.corner[1] + 64 * word as i64]
        };
        self.words.iter().enumerate().filter(|(_, word)| **word != 0).map(move |(i, word)| (cell(i), *word))
    }

    /// Whether the 64 cells from this one on, along y, are set.
    #[inline]
    pub fn run(&self, [x, y]: [i64; 2]) -> u64 {
        // What lies before the corner wraps round to far beyond the end.
        let column = (x - self.corner[0]) as usize;
        if column >= self.columns {
            return 0;
        }
        let row = y - self.corner[1];
        let (word, shift) = (row.div_euclid(64), row.rem_euclid(64));
        let words = &self.words[column * self.height..(column + 1) * self.height];
        let at = |index: i64| words.get(index as usize).copied().unwrap_or(0);
        if shift == 0 { at(word) } else { at(word) >> shift | at(word + 1) << (64 - shift) }
    }
}

/// 64 counters up to 127.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BitCounters([u64; 7]);

impl BitCounters {
    /// BitCounters each bit that is set.
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

    /// Which counters have come so far.
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

    /// One counter, of bit 0 to 63.
    #[inline]
    pub fn get(&self, bit: u32) -> u8 {
        self.0.iter().enumerate().map(|(index, plane)| ((plane >> bit & 1) as u8) << index).sum()
    }
}

/// The bits that are set, lowest first.
pub(crate) fn each(mut word: u64) -> impl Iterator<Item = u32> {
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
    fn runs_are_what_a_list_of_cells_says_wherever_they_begin() {
        let mut rng = RngTree::new(3).child("bits").rng();
        let mut draw = |reach: f64| rng.range(-reach, reach) as i64;
        let cells: Vec<[i64; 2]> = (0..3_000).map(|_| [draw(40.0), draw(150.0)]).collect();
        let (bits, listed) = (BitGrid::of(&cells), cells.iter().copied().collect::<BTreeSet<_>>());
        for _ in 0..2_000 {
            let [x, y] = [draw(45.0), draw(300.0)];
            let run = bits.run([x, y]);
            for step in 0..64 {
                assert_eq!(run >> step & 1 == 1, listed.contains(&[x, y + step]), "{x} {y} {step}");
            }
        }
        let back: Vec<[i64; 2]> = bits
            .words()
            .flat_map(|([x, y], word)| each(word).map(move |bit| [x, y + i64::from(bit)]))
            .collect();
        assert_eq!(back, listed.into_iter().collect::<Vec<_>>());
        assert_eq!(BitGrid::of(&[]).run([0, 0]), 0);
    }

    #[test]
    fn counters_count() {
        let mut rng = RngTree::new(4).child("counts").rng();
        let (mut counts, mut slow) = (BitCounters::default(), [0_u8; 64]);
        for _ in 0..127 {
            let word = rng.bits() & rng.bits();
            counts.add(word);
            for bit in each(word) {
                slow[bit as usize] += 1;
            }
        }
        for bit in 0..64 {
            assert_eq!(counts.get(bit), slow[bit as usize]);
        }
        for least in 0..=127 {
            let expected = (0..64).filter(|bit| slow[*bit as usize] >= least);
            assert_eq!(each(counts.at_least(least)).collect::<Vec<_>>(), expected.collect::<Vec<_>>());
        }
    }
}
