//! Indices of the cells of a grid.

/// Index of a cell: x and y in cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CellIndex {
    /// Along x.
    pub x: i32,
    /// Along y.
    pub y: i32,
}

/// Largest integer not above `value`, without the library call of `f64::floor`.
#[inline]
pub(crate) fn floor(value: f64) -> i32 {
    let truncated = value as i32;
    truncated - i32::from(f64::from(truncated) > value)
}

#[cfg(test)]
mod tests {
    use super::floor;

    #[test]
    fn floor_rounds_down() {
        for (value, expected) in [(0.0, 0), (0.9, 0), (-0.1, -1), (-1.0, -1), (-1.5, -2), (7.0, 7)] {
            assert_eq!(floor(value), expected, "{value}");
        }
    }
}
