//! Square roots of information matrices.

use crate::error::FactorError;
use crate::texts;
use nalgebra::{DMatrix, SMatrix, SVector};

/// A matrix `W` with `WᵀW = Ω`, the information (inverse covariance) of a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Whitening<const N: usize>(SMatrix<f64, N, N>);

/// How far an information matrix may be from symmetric and positive semidefinite.
#[derive(Clone, Copy, Debug, PartialEq)]
struct InformationTolerance {
    /// Greatest difference of entries across the diagonal, as a share of the greatest entry, because files contain rounded numbers.
    max_asymmetry: f64,
    /// Greatest negative eigenvalue that counts as a rounding error, as a share of the greatest one.
    max_negative: f64,
    /// Least pivot of the Cholesky decomposition, as a share of its diagonal entry. Below it the decomposition is by eigenvalues.
    min_pivot: f64,
}

impl Default for InformationTolerance {
    fn default() -> Self {
        Self { max_asymmetry: 1e-6, max_negative: 1e-9, min_pivot: 1e-12 }
    }
}

impl<const N: usize> Whitening<N> {
    /// From a full information matrix. It must be finite, symmetric and without negative eigenvalues. Directions without information are
    /// allowed.
    ///
    /// # Errors
    /// When the matrix does not meet these conditions.
    pub fn from_information(information: &SMatrix<f64, N, N>) -> Result<Self, FactorError> {
        let tolerance = InformationTolerance::default();
        let refuse = |problem| Err(FactorError::Information { problem });
        if !information.iter().all(|entry| entry.is_finite()) {
            return refuse(texts::NOT_FINITE_ENTRIES);
        }
        let asymmetry = (information - information.transpose()).amax();
        if asymmetry > tolerance.max_asymmetry * information.amax() {
            return refuse(texts::NOT_SYMMETRIC);
        }
        let symmetric = (information + information.transpose()) * 0.5;
        if let Some(root) = cholesky(&symmetric, tolerance.min_pivot) {
            return Ok(Self(root));
        }
        let eigen = DMatrix::from_column_slice(N, N, symmetric.as_slice()).symmetric_eigen();
        let greatest = eigen.eigenvalues.amax();
        if eigen
            .eigenvalues
            .iter()
            .any(|&value| value < -tolerance.max_negative * greatest || !value.is_finite())
        {
            return refuse(texts::NEGATIVE_EIGENVALUE);
        }
        let root = SMatrix::from_fn(|row, column| {
            eigen.eigenvalues[row].max(0.0).sqrt() * eigen.eigenvectors[(column, row)]
        });
        Ok(Self(root))
    }

    /// From independent standard deviations.
    ///
    /// # Errors
    /// When one is not a positive number.
    pub fn from_deviations(deviations: &SVector<f64, N>) -> Result<Self, FactorError> {
        if deviations.iter().any(|&deviation| deviation.is_nan() || deviation <= 0.0) {
            return Err(FactorError::NotFinite { what: texts::STANDARD_DEVIATION });
        }
        Ok(Self(SMatrix::from_diagonal(&deviations.map(|deviation| 1.0 / deviation))))
    }

    /// `W`.
    pub const fn matrix(&self) -> &SMatrix<f64, N, N> {
        &self.0
    }

    /// `WᵀW`.
    pub fn information(&self) -> SMatrix<f64, N, N> {
        self.0.transpose() * self.0
    }
}

/// Upper triangular `W`; `None` unless every pivot is clearly positive.
fn cholesky<const N: usize>(matrix: &SMatrix<f64, N, N>, min_pivot: f64) -> Option<SMatrix<f64, N, N>> {
    let mut upper = SMatrix::<f64, N, N>::zeros();
    for row in 0..N {
        for column in row..N {
            let mut value = matrix[(row, column)];
            for above in 0..row {
                value -= upper[(above, row)] * upper[(above, column)];
            }
            if column == row {
                if value <= min_pivot * matrix[(row, row)] || value <= 0.0 {
                    return None;
                }
                upper[(row, row)] = value.sqrt();
            } else {
                upper[(row, column)] = value / upper[(row, row)];
            }
        }
    }
    Some(upper)
}
