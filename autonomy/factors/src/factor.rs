//! Factors: a whitened residual of a few variables, with its Jacobians.

use crate::error::FactorError;
use crate::names::{Key, VariableKind};
use crate::value::{Planar, Value, Values};
use geometry::{Isometry, Matrix3, Matrix6};
use nalgebra::{SMatrix, SVector};
use std::fmt::Debug;

/// A measurement that constrains a few variables. Its cost is the squared length of its *whitened* residual `W r`, where `WᵀW` is the
/// information matrix.
///
/// Implementations are pure: the same values give the same bits.
pub trait Factor: Debug + Send + Sync {
    /// The variables. Each occurs once.
    fn keys(&self) -> &[Key];

    /// The kind that each variable must have, in the order of [`Self::keys`].
    fn kinds(&self) -> &[VariableKind];

    /// Length of the residual.
    fn rows(&self) -> usize;

    /// Writes the whitened residual and, for each variable, the whitened Jacobian with respect to the error that moves the variable.
    ///
    /// # Errors
    /// When a variable is missing or of another kind, or the measurement constrains nothing at these values.
    fn linearise(&self, values: &Values, out: &mut Linearised) -> Result<(), FactorError>;

    /// Writes the whitened residual alone. Factors override it where Jacobians are costly.
    ///
    /// # Errors
    /// As for [`Self::linearise`].
    fn residual(&self, values: &Values, out: &mut Linearised) -> Result<(), FactorError> {
        self.linearise(values, out)
    }

    /// The measurement, if it is a relative pose between two poses. Initialisation uses it.
    fn relative_pose(&self) -> Option<RelativePose> {
        None
    }

    /// The known pose, if the factor is a prior on one pose.
    fn anchor(&self) -> Option<Value> {
        None
    }
}

/// A relative pose of the second variable in the first, with its information.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RelativePose {
    /// SE(3), information of `[rotation; translation]`.
    Space(Isometry, Matrix6),
    /// SE(2), information of `[x; y; yaw]`.
    Plane(Planar, Matrix3),
}

/// A factor's whitened Jacobians and residual at some values, `[J₀ J₁ … -r]`, column-major.
#[derive(Clone, Debug, Default)]
pub struct Linearised {
    rows: usize,
    /// First column of each variable. The last entry is the residual's column.
    starts: Vec<usize>,
    data: Vec<f64>,
}

impl Linearised {
    /// Sets all entries to zero, in the shape of `factor`.
    pub fn reset(&mut self, factor: &dyn Factor) {
        self.rows = factor.rows();
        self.starts.clear();
        let mut start = 0;
        for kind in factor.kinds() {
            self.starts.push(start);
            start += kind.dimension();
        }
        self.starts.push(start);
        self.data.clear();
        self.data.resize(self.rows * (start + 1), 0.0);
    }

    /// Writes the Jacobian of the variable at `index` in the factor's keys. Entries beyond its shape are ignored.
    pub fn set_jacobian<const R: usize, const C: usize>(
        &mut self,
        index: usize,
        jacobian: &SMatrix<f64, R, C>,
    ) {
        let Some(&start) = self.starts.get(index) else { return };
        for (column, values) in jacobian.as_slice().chunks_exact(R).enumerate() {
            self.column_mut(start + column).copy_from_slice(values);
        }
    }

    /// One column of a Jacobian, for factors whose size is only known at run time.
    pub fn jacobian_column_mut(&mut self, index: usize, column: usize) -> &mut [f64] {
        let start = self.starts[index];
        self.column_mut(start + column)
    }

    /// Writes the residual.
    pub fn set_residual<const R: usize>(&mut self, residual: &SVector<f64, R>) {
        for (value, &component) in self.residual_mut().iter_mut().zip(residual.as_slice()) {
            *value = -component;
        }
    }

    /// The *negated* residual, for writing.
    pub fn residual_mut(&mut self) -> &mut [f64] {
        let last = self.starts.last().copied().unwrap_or(0);
        self.column_mut(last)
    }

    /// The negated residual.
    pub fn negated_residual(&self) -> &[f64] {
        &self.data[self.data.len() - self.rows..]
    }

    /// Rows and all columns, residual last.
    pub fn columns(&self) -> impl Iterator<Item = &[f64]> {
        self.data.chunks_exact(self.rows.max(1))
    }

    /// Squared length of the residual.
    pub fn squared(&self) -> f64 {
        self.negated_residual().iter().map(|value| value * value).sum()
    }

    fn column_mut(&mut self, column: usize) -> &mut [f64] {
        &mut self.data[column * self.rows..(column + 1) * self.rows]
    }

    /// Packed normal equations `[J -r]ᵀ[J -r] * weight` (docs/maths/factors.md, equation 4): the lower triangle, column by column. `out` must have the right length.
    pub fn normal_equations(&self, weight: f64, out: &mut [f64]) {
        match self.rows {
            3 => normal_equations::<3>(&self.data, weight, out),
            6 => normal_equations::<6>(&self.data, weight, out),
            rows => {
                let columns = self.data.len() / rows.max(1);
                let column = |index: usize| &self.data[index * rows..(index + 1) * rows];
                let mut slots = out.iter_mut();
                for left in 0..columns {
                    for right in left..columns {
                        let Some(slot) = slots.next() else { return };
                        let sum: f64 = column(left).iter().zip(column(right)).map(|(a, b)| a * b).sum();
                        *slot = sum * weight;
                    }
                }
            }
        }
    }
}

fn normal_equations<const R: usize>(data: &[f64], weight: f64, out: &mut [f64]) {
    let (columns, _) = data.as_chunks::<R>();
    let mut slots = out.iter_mut();
    for (index, left) in columns.iter().enumerate() {
        let scaled = left.map(|value| value * weight);
        for right in &columns[index..] {
            let Some(slot) = slots.next() else { return };
            let mut sum = 0.0;
            for row in 0..R {
                sum += scaled[row] * right[row];
            }
            *slot = sum;
        }
    }
}
