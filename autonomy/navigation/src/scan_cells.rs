//! What one scan saw in the cells around the robot.

use crate::cell_index::CellIndex;

/// What one scan saw in one cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellHits {
    /// Height of the lowest point, metres.
    pub lowest: f32,
    /// Height of the highest point, metres.
    pub highest: f32,
    /// Slices with points, one bit each.
    pub slices: u64,
    /// Sum of the positions of the points at the height of the robot's body, within the cell, in units of its side.
    body_sum: [f32; 2],
    /// Number of those points.
    body_points: u32,
}

impl CellHits {
    const NONE: Self = Self {
        lowest: f32::INFINITY,
        highest: f32::NEG_INFINITY,
        slices: 0,
        body_sum: [0.0; 2],
        body_points: 0,
    };

    /// The mean of the points at the height of the robot's body, within the cell, in units of 1/256 of its side; none without such points.
    pub fn body_at(&self) -> Option<[u8; 2]> {
        let count = (self.body_points > 0).then_some(self.body_points as f32)?;
        Some(self.body_sum.map(|sum| (256.0 * sum / count) as u8))
    }

    fn is_none(&self) -> bool {
        self.lowest > self.highest
    }
}

/// The cells in a square window around the robot that a scan saw. An array is used rather than an ordered tree, because a scan has tens of
/// thousands of points. The memory is kept from scan to scan.
#[derive(Clone, Debug, Default)]
pub(crate) struct ScanCells {
    /// The cell of the window with the lowest coordinates.
    first: [i32; 2],
    /// Cells along a side of the window.
    side: i32,
    /// Column by column: ascending by x, then by y.
    hits: Vec<CellHits>,
    /// Offsets in `hits` of the cells that were seen.
    seen: Vec<u32>,
}

impl ScanCells {
    /// Forgets the last scan. The window now reaches `reach` cells to each side of `centre`. Linear in the cells that the last scan saw, unless
    /// `reach` changes.
    pub fn restart(&mut self, centre: CellIndex, reach: i32) {
        for &offset in &self.seen {
            self.hits[offset as usize] = CellHits::NONE;
        }
        self.seen.clear();
        self.first = [centre.x.saturating_sub(reach), centre.y.saturating_sub(reach)];
        let side = 2 * reach + 1;
        if self.side != side {
            self.side = side;
            self.hits = vec![CellHits::NONE; side as usize * side as usize];
        }
    }

    /// Inserts a point of the height `z`, metres, in the slices `slices`; `body`: where it is within the cell, in units of its side, if it is at the height of the
    /// robot's body. A point outside the window is ignored.
    pub fn insert(&mut self, index: CellIndex, z: f32, slices: u64, body: Option<[f32; 2]>) {
        let Some(offset) = self.offset(index) else { return };
        let hits = &mut self.hits[offset];
        if hits.is_none() {
            self.seen.push(offset as u32);
        }
        hits.lowest = hits.lowest.min(z);
        hits.highest = hits.highest.max(z);
        hits.slices |= slices;
        if let Some([x, y]) = body {
            hits.body_sum[0] += x;
            hits.body_sum[1] += y;
            hits.body_points += 1;
        }
    }

    /// What the scan saw in a cell, if it saw anything.
    pub fn get(&self, index: CellIndex) -> Option<&CellHits> {
        self.hits.get(self.offset(index)?).filter(|hits| !hits.is_none())
    }

    /// Sorts the seen cells by x, then by y, so that [`Self::seen`] does not depend on the order of the points.
    pub fn sort(&mut self) {
        self.seen.sort_unstable();
    }

    /// The cells that the scan saw.
    pub fn seen(&self) -> impl Iterator<Item = (CellIndex, CellHits)> {
        self.seen.iter().map(|&offset| {
            let (x, y) = (offset as i32 / self.side, offset as i32 % self.side);
            (CellIndex { x: self.first[0] + x, y: self.first[1] + y }, self.hits[offset as usize])
        })
    }

    fn offset(&self, index: CellIndex) -> Option<usize> {
        let x = i64::from(index.x) - i64::from(self.first[0]);
        let y = i64::from(index.y) - i64::from(self.first[1]);
        let side = i64::from(self.side);
        let is_inside = (0..side).contains(&x) && (0..side).contains(&y);
        is_inside.then_some((x * side + y) as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seen_cells_are_sorted_and_cells_outside_the_window_are_ignored() {
        let mut cells = ScanCells::default();
        let at = |x, y| CellIndex { x, y };
        cells.restart(at(-5, 7), 3);
        for (index, z) in [(at(-4, 10), 0.5), (at(-8, 4), 0.1), (at(-4, 9), 0.2), (at(-4, 10), 0.3)] {
            cells.insert(index, z, 1, Some([0.25, z]));
        }
        cells.insert(at(-9, 7), 0.0, 1, None);
        cells.insert(at(i32::MAX, i32::MIN), 0.0, 1, None);
        cells.sort();
        let seen: Vec<_> = cells.seen().map(|(index, hits)| (index, hits.lowest, hits.highest)).collect();
        assert_eq!(seen, [(at(-8, 4), 0.1, 0.1), (at(-4, 9), 0.2, 0.2), (at(-4, 10), 0.3, 0.5)]);
        assert!(cells.get(at(-4, 10)).is_some() && cells.get(at(-5, 7)).is_none());
        assert_eq!(
            cells.get(at(-4, 10)).and_then(CellHits::body_at),
            Some([64, 102]),
            "the mean of 0.5 and 0.3"
        );
        cells.restart(at(0, 0), 3);
        assert!(cells.seen().next().is_none() && cells.get(at(-1, 3)).is_none(), "of the last scan");
    }
}
