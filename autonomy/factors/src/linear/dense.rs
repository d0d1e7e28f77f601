//! Partial Cholesky factorisation of a dense front. Nearly all floating-point operations of a solve happen here.
//!
//! A front is symmetric. Only its lower triangle is stored, column by column. The leading `eliminate` columns are replaced by their Cholesky
//! columns, the others by the Schur complement. Right-hand sides are extra rows at the bottom, so the elimination includes the forward
//! substitution.
//!
//! Panels of [`PANEL`] columns are factorised eight columns at a time, after the updates by the panel's earlier columns. The panel is then
//! copied into strips of eight rows. The rest of the matrix is updated in tiles of eight rows by [`NR`] columns whose sums stay in registers.
//! Every front ends with eight spare rows and columns, into which the last tiles may write, so there are no edge cases. The same code is
//! compiled for AVX-512, for AVX2 with FMA, and for the baseline. The processor alone decides which one runs, so equal inputs give equal bits on
//! equal processors.

/// Rows of a tile, and the spare rows and columns of a front.
pub const STRIP: usize = 8;
/// Columns of a panel.
const PANEL: usize = 64;

/// A symmetric matrix being assembled or factorised, lower triangle, column-major.
#[derive(Default, Debug)]
pub struct Front {
    data: Vec<f64>,
    size: usize,
    stride: usize,
    packed: Vec<f64>,
}

/// Precision in which the entries of a finished factor are stored.
pub trait Stored: Copy + Into<f64> + std::fmt::Debug {
    /// Rounds to this precision.
    fn store(value: f64) -> Self;
}

impl Stored for f64 {
    fn store(value: f64) -> Self {
        value
    }
}

/// Half the memory. For factors that only compute steps: the next iteration corrects the rounding.
impl Stored for f32 {
    fn store(value: f64) -> Self {
        value as Self
    }
}

/// Index of the column whose pivot was not clearly positive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadPivot(pub usize);

/// A pivot below this share of its diagonal entry before elimination is rounding noise. The matrix counts as singular there.
const MIN_PIVOT_SHARE: f64 = 1e-13;

/// Number of entries of a panel of `columns` in a front of `size` rows.
pub fn panel_len(columns: usize, size: usize) -> usize {
    columns * size - columns * (columns.max(1) - 1) / 2
}

impl Front {
    /// Resets the front to a zero matrix of `size` rows.
    pub fn reset(&mut self, size: usize) {
        self.size = size;
        self.stride = (size + STRIP).next_multiple_of(STRIP);
        // With a stride that is a multiple of 2 KiB, the columns would compete for the same cache lines.
        if self.stride.is_multiple_of(256) {
            self.stride += STRIP;
        }
        self.data.clear();
        self.data.resize(self.stride * (size + STRIP), 0.0);
    }

    /// Number of rows, including right-hand sides.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Column `column` from its diagonal entry down.
    pub fn column(&self, column: usize) -> &[f64] {
        let start = column * self.stride;
        &self.data[start + column..start + self.size]
    }

    /// The whole column from row 0. Rows above the diagonal are undefined.
    pub fn column_mut(&mut self, column: usize) -> &mut [f64] {
        let start = column * self.stride;
        &mut self.data[start..start + self.size]
    }

    /// Adds the first `len` of `values` to `column`, from `row` down, and returns the others.
    pub fn add_down<'a>(&mut self, column: usize, row: usize, len: usize, values: &'a [f64]) -> &'a [f64] {
        let (values, rest) = values.split_at(len);
        let start = column * self.stride + row;
        for (entry, value) in self.data[start..start + len].iter_mut().zip(values) {
            *entry += value;
        }
        rest
    }

    /// Adds the first `len` of `values` to `row`, from `column` on, and returns the others.
    pub fn add_across<'a>(&mut self, row: usize, column: usize, len: usize, values: &'a [f64]) -> &'a [f64] {
        let (values, rest) = values.split_at(len);
        let entries = self.data[column * self.stride + row..].iter_mut().step_by(self.stride);
        for (entry, value) in entries.zip(values) {
            *entry += value;
        }
        rest
    }

    /// Factorises the first `eliminate` columns and leaves the Schur complement in the others (docs/maths/factors.md, equation 7).
    ///
    /// Cost: about `e n² - e² n + e³/3` multiply-adds for `e` of `n` columns.
    ///
    /// # Errors
    /// The first column whose pivot is not clearly positive (or not a number).
    pub fn eliminate(&mut self, eliminate: usize) -> Result<(), BadPivot> {
        let (data, packed) = (&mut self.data, &mut self.packed);
        let shape = Shape { size: self.size, stride: self.stride, eliminate };
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx512f") {
                // SAFETY: the processor has the features that the function was compiled for.
                #[allow(unsafe_code, reason = "the call of a function compiled for detected features")]
                return unsafe { eliminate_avx512(data, packed, shape) };
            }
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                // SAFETY: as above.
                #[allow(unsafe_code, reason = "the call of a function compiled for detected features")]
                return unsafe { eliminate_avx2(data, packed, shape) };
            }
        }
        eliminate_with::<4, false>(data, packed, shape)
    }
}

/// Back-substitution through the panel of a cluster. The panel holds columns, each from its diagonal entry down, with `right_hand_sides` last.
/// `local` holds the cluster's scalars, frontal first. The separator's scalars are given. The first `columns` scalars are solved for the
/// right-hand side `which`.
pub fn substitute_back<T: Stored>(
    panel: &[T],
    columns: usize,
    right_hand_sides: usize,
    which: usize,
    local: &mut [f64],
) {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        // SAFETY: the processor has the features that the function was compiled for.
        #[allow(unsafe_code, reason = "the call of a function compiled for detected features")]
        return unsafe { substitute_back_avx2(panel, columns, right_hand_sides, which, local) };
    }
    substitute_back_with::<T, false>(panel, columns, right_hand_sides, which, local);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn substitute_back_avx2<T: Stored>(
    panel: &[T],
    columns: usize,
    right_hand_sides: usize,
    which: usize,
    local: &mut [f64],
) {
    substitute_back_with::<T, true>(panel, columns, right_hand_sides, which, local);
}

#[inline(always)]
fn substitute_back_with<T: Stored, const FMA: bool>(
    panel: &[T],
    columns: usize,
    right_hand_sides: usize,
    which: usize,
    local: &mut [f64],
) {
    let size = local.len() + right_hand_sides;
    let mut end = panel_len(columns, size);
    for column in (0..columns).rev() {
        let start = end - (size - column);
        let entries = &panel[start..end];
        let known = &local[column + 1..];
        let right: f64 = entries[1 + known.len() + which].into();
        let pivot: f64 = entries[0].into();
        local[column] = (right - dot_with::<T, FMA>(&entries[1..=known.len()], known)) / pivot;
        end = start;
    }
}

/// Dot product. The order of the sums is fixed.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    dot_with::<f64, false>(a, b)
}

/// Dot product in sixteen interleaved sums, which the processor can compute in parallel.
#[inline(always)]
fn dot_with<T: Stored, const FMA: bool>(a: &[T], b: &[f64]) -> f64 {
    const LANES: usize = 16;
    let (a_chunks, a_rest) = a.as_chunks::<LANES>();
    let (b_chunks, b_rest) = b.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for (x, y) in a_chunks.iter().zip(b_chunks) {
        for lane in 0..LANES {
            sums[lane] = multiply_add::<FMA>(x[lane].into(), y[lane], sums[lane]);
        }
    }
    let mut rest = 0.0;
    for (x, y) in a_rest.iter().zip(b_rest) {
        rest = multiply_add::<FMA>((*x).into(), *y, rest);
    }
    let mut width = LANES / 2;
    while width > 0 {
        for lane in 0..width {
            sums[lane] += sums[lane + width];
        }
        width /= 2;
    }
    sums[0] + rest
}

#[derive(Clone, Copy)]
struct Shape {
    size: usize,
    stride: usize,
    eliminate: usize,
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx2,fma")]
fn eliminate_avx512(data: &mut [f64], packed: &mut Vec<f64>, shape: Shape) -> Result<(), BadPivot> {
    eliminate_with::<8, true>(data, packed, shape)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn eliminate_avx2(data: &mut [f64], packed: &mut Vec<f64>, shape: Shape) -> Result<(), BadPivot> {
    eliminate_with::<4, true>(data, packed, shape)
}

/// `NR`: columns of a tile. `FMA`: whether the processor has fused multiply-add.
#[inline(always)]
fn eliminate_with<const NR: usize, const FMA: bool>(
    data: &mut [f64],
    packed: &mut Vec<f64>,
    shape: Shape,
) -> Result<(), BadPivot> {
    let mut original = [0.0; PANEL];
    let mut start = 0;
    while start < shape.eliminate {
        let width = PANEL.min(shape.eliminate - start);
        for (offset, value) in original[..width].iter_mut().enumerate() {
            *value = data[(start + offset) * (shape.stride + 1)];
        }
        let mut column = start;
        while column < start + width {
            let columns = STRIP.min(start + width - column);
            update_columns::<FMA>(data, shape, start, column, columns);
            factorise_columns::<FMA>(data, shape, column, columns, &original[column - start..])?;
            column += columns;
        }
        let rest = start + width;
        if rest < shape.size {
            pack(data, packed, shape, start, width);
            update_rest::<NR, FMA>(data, packed, shape, rest, width);
        }
        start = rest;
    }
    Ok(())
}

#[inline(always)]
fn multiply_add<const FMA: bool>(a: f64, b: f64, sum: f64) -> f64 {
    if FMA { a.mul_add(b, sum) } else { a * b + sum }
}

#[inline(always)]
fn eight(values: &[f64], at: usize) -> [f64; STRIP] {
    let mut out = [0.0; STRIP];
    out.copy_from_slice(&values[at..at + STRIP]);
    out
}

/// Subtracts the contributions of the panel's columns from `start` to `column` from the next `columns` columns.
#[inline(always)]
fn update_columns<const FMA: bool>(
    data: &mut [f64],
    Shape { size, stride, .. }: Shape,
    start: usize,
    column: usize,
    columns: usize,
) {
    if start == column {
        return;
    }
    let mut row = column;
    while row < size {
        let mut tile = [[0.0; STRIP]; STRIP];
        for earlier in start..column {
            let rows = eight(data, earlier * stride + row);
            let factors = eight(data, earlier * stride + column);
            for j in 0..STRIP {
                for i in 0..STRIP {
                    tile[j][i] = multiply_add::<FMA>(rows[i], factors[j], tile[j][i]);
                }
            }
        }
        for (j, sums) in tile.iter().enumerate().take(columns) {
            let at = (column + j) * stride + row;
            for (value, sum) in data[at..at + STRIP].iter_mut().zip(sums) {
                *value -= sum;
            }
        }
        row += STRIP;
    }
}

/// Cholesky factorisation of at most eight columns that already have their updates.
#[inline(always)]
fn factorise_columns<const FMA: bool>(
    data: &mut [f64],
    Shape { size, stride, .. }: Shape,
    column: usize,
    columns: usize,
    original: &[f64],
) -> Result<(), BadPivot> {
    // The triangle on the diagonal; `lower[j][i]` is row i of column j.
    let mut lower = [[0.0; STRIP]; STRIP];
    let mut inverse = [0.0; STRIP];
    for j in 0..columns {
        for i in j..columns {
            let mut value = data[(column + j) * stride + column + i];
            for earlier in &lower[..j] {
                value = multiply_add::<FMA>(-earlier[i], earlier[j], value);
            }
            lower[j][i] = value;
        }
        let pivot = lower[j][j];
        // The negation makes NaN fail, too.
        if !(pivot > MIN_PIVOT_SHARE * original[j] && pivot.is_finite() && pivot > 0.0) {
            return Err(BadPivot(column + j));
        }
        let root = pivot.sqrt();
        inverse[j] = 1.0 / root;
        lower[j][j] = root;
        for value in &mut lower[j][j + 1..columns] {
            *value *= inverse[j];
        }
        let at = (column + j) * stride + column;
        data[at + j..at + columns].copy_from_slice(&lower[j][j..columns]);
    }
    // Rows below: eight at a time.
    let mut row = column + columns;
    while row < size {
        let mut solved = [[0.0; STRIP]; STRIP];
        for j in 0..columns {
            let at = (column + j) * stride + row;
            let mut values = eight(data, at);
            for (earlier, column_below) in solved[..j].iter().zip(&lower) {
                for i in 0..STRIP {
                    values[i] = multiply_add::<FMA>(-earlier[i], column_below[j], values[i]);
                }
            }
            for value in &mut values {
                *value *= inverse[j];
            }
            solved[j] = values;
            data[at..at + STRIP].copy_from_slice(&values);
        }
        row += STRIP;
    }
    Ok(())
}

/// Copies the rows below a panel into strips of eight rows, each strip column by column.
#[inline(always)]
fn pack(data: &[f64], packed: &mut Vec<f64>, Shape { size, stride, .. }: Shape, start: usize, width: usize) {
    let rest = start + width;
    let strips = (size - rest).div_ceil(STRIP);
    packed.clear();
    packed.reserve(strips * width * STRIP);
    for strip in 0..strips {
        for column in start..rest {
            packed.extend_from_slice(&eight(data, column * stride + rest + strip * STRIP));
        }
    }
}

/// Subtracts the product of the packed panel with itself from all columns to the right of the panel.
#[inline(always)]
fn update_rest<const NR: usize, const FMA: bool>(
    data: &mut [f64],
    packed: &[f64],
    Shape { size, stride, .. }: Shape,
    rest: usize,
    width: usize,
) {
    let strip_length = width * STRIP;
    let strips = (size - rest).div_ceil(STRIP);
    for column_strip in 0..strips {
        let factors = &packed[column_strip * strip_length..][..strip_length];
        for part in (0..STRIP).step_by(NR) {
            let first_column = rest + column_strip * STRIP + part;
            if first_column >= size {
                break;
            }
            for row_strip in column_strip..strips {
                let rows = &packed[row_strip * strip_length..][..strip_length];
                let tile = tile::<NR, FMA>(rows, factors, part);
                let row = rest + row_strip * STRIP;
                for (j, sums) in tile.iter().enumerate() {
                    let at = (first_column + j) * stride + row;
                    for (value, sum) in data[at..at + STRIP].iter_mut().zip(sums) {
                        *value -= sum;
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn tile<const NR: usize, const FMA: bool>(rows: &[f64], factors: &[f64], part: usize) -> [[f64; STRIP]; NR] {
    let mut sums = [[0.0; STRIP]; NR];
    let (rows, _) = rows.as_chunks::<STRIP>();
    let (factors, _) = factors.as_chunks::<STRIP>();
    for (row, factor) in rows.iter().zip(factors) {
        for j in 0..NR {
            for i in 0..STRIP {
                sums[j][i] = multiply_add::<FMA>(row[i], factor[part + j], sums[j][i]);
            }
        }
    }
    sums
}
