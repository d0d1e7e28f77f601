//! Assembly of one front: sum its contributions, eliminate its frontal variables, substitute.
//!
//! Contributions are a factor's normal equations or the Schur complement of a child. Both have the form of *packed normal equations* over a list
//! of variables: the lower triangle, column by column, with the right-hand sides as last rows.

use super::dense::{BadPivot, Front, Stored, panel_len};

/// Buffers for one front at a time.
#[derive(Default, Debug)]
pub struct Assembly {
    front: Front,
    /// First row of each variable in the front. Valid only for the front's own variables.
    offset: Vec<u32>,
    segments: Vec<Segment>,
    columns: usize,
    right_hand_sides: usize,
}

/// Rows that are adjacent both in the contribution and in the front.
#[derive(Clone, Copy, Debug)]
struct Segment {
    to: usize,
    len: usize,
}

/// Number of scalars of some variables.
pub fn scalars(variables: &[u32], dimensions: &[u8]) -> usize {
    variables.iter().map(|&variable| usize::from(dimensions[variable as usize])).sum()
}

/// Number of entries of packed normal equations over `scalars` unknowns.
pub fn packed_len(scalars: usize, right_hand_sides: usize) -> usize {
    let size = scalars + right_hand_sides;
    size * (size + 1) / 2
}

impl Assembly {
    /// Starts a front over `frontal` and `separator` variables.
    pub fn begin(&mut self, frontal: &[u32], separator: &[u32], dimensions: &[u8], right_hand_sides: usize) {
        self.offset.resize(dimensions.len(), 0);
        let mut rows = 0;
        for &variable in frontal.iter().chain(separator) {
            self.offset[variable as usize] = rows;
            rows += u32::from(dimensions[variable as usize]);
        }
        self.columns = scalars(frontal, dimensions);
        self.right_hand_sides = right_hand_sides;
        self.front.reset(rows as usize + right_hand_sides);
    }

    /// Adds packed normal equations over `variables`. The front must contain all of them.
    pub fn add(&mut self, variables: &[u32], dimensions: &[u8], packed: &[f64]) {
        self.segments.clear();
        let mut from = 0;
        for &variable in variables {
            let to = self.offset[variable as usize] as usize;
            let len = usize::from(dimensions[variable as usize]);
            match self.segments.last_mut() {
                Some(last) if last.to + last.len == to => last.len += len,
                _ => self.segments.push(Segment { to, len }),
            }
            from += len;
        }
        debug_assert_eq!(packed.len(), packed_len(from, self.right_hand_sides));
        let to = self.front.size() - self.right_hand_sides;
        self.segments.push(Segment { to, len: self.right_hand_sides });
        let mut source = packed;
        for (index, segment) in self.segments[..self.segments.len() - 1].iter().enumerate() {
            for column in 0..segment.len {
                let target = segment.to + column;
                source = self.front.add_down(target, target, segment.len - column, source);
                for rows in &self.segments[index + 1..] {
                    // A block whose variables have the other order in the front is transposed.
                    source = if rows.to > target {
                        self.front.add_down(target, rows.to, rows.len, source)
                    } else {
                        self.front.add_across(target, rows.to, rows.len, source)
                    };
                }
            }
        }
    }

    /// Adds `extra` to the diagonal entries of the frontal variables.
    pub fn damp(&mut self, extra: impl Iterator<Item = f64>) {
        for (column, extra) in extra.enumerate().take(self.columns) {
            self.front.column_mut(column)[column] += extra;
        }
    }

    /// Eliminates the frontal variables.
    ///
    /// # Errors
    /// The first frontal scalar that is not determined by the normal equations.
    pub fn eliminate(&mut self) -> Result<(), BadPivot> {
        self.front.eliminate(self.columns)
    }

    /// Appends the eliminated columns. Each runs from its diagonal entry down, right-hand sides last.
    pub fn append_panel<T: Stored>(&self, out: &mut Vec<T>) {
        let size = self.front.size();
        out.reserve(panel_len(self.columns, size));
        for column in 0..self.columns {
            out.extend(self.front.column(column).iter().map(|&entry| T::store(entry)));
        }
    }

    /// Packed normal equations over the separator.
    pub fn update(&self) -> Vec<f64> {
        let size = self.front.size();
        let separator = size - self.columns - self.right_hand_sides;
        let mut out = Vec::with_capacity(packed_len(separator, self.right_hand_sides));
        for column in self.columns..size {
            out.extend_from_slice(self.front.column(column));
        }
        out
    }
}

/// Forward substitution through one panel: solves for the frontal scalars of `local` and subtracts their contribution from the others.
pub fn substitute_forward<T: Stored>(
    panel: &[T],
    columns: usize,
    right_hand_sides: usize,
    local: &mut [f64],
) {
    let size = local.len() + right_hand_sides;
    let mut start = 0;
    for column in 0..columns {
        let entries = &panel[start..start + size - column];
        let (done, below) = local.split_at_mut(column + 1);
        let pivot: f64 = entries[0].into();
        let solved = done[column] / pivot;
        done[column] = solved;
        for (value, entry) in below.iter_mut().zip(&entries[1..]) {
            let entry: f64 = (*entry).into();
            *value -= entry * solved;
        }
        start += size - column;
    }
}
