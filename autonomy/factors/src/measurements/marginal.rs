//! The linear factor that replaces marginalised variables.

use crate::error::FactorError;
use crate::factor::{Factor, Linearised};
use crate::names::{Key, VariableKind};
use crate::texts;
use crate::value::{Value, Values};
use nalgebra::{DMatrix, DVector};

/// Normal equations `H δ = b` over some variables. `δ` is their error from fixed values. The linearisation point never changes, which is the
/// approximation of every fixed-lag smoother.
#[derive(Clone, Debug)]
pub struct Marginal {
    keys: Vec<Key>,
    kinds: Vec<VariableKind>,
    at: Vec<Value>,
    /// `R` with `RᵀR = H`.
    root: DMatrix<f64>,
    /// `y` with `Rᵀy = b`: the residual is `R δ - y`.
    offset: DVector<f64>,
}

/// Eigenvalues below this share of the greatest carry no information.
const MIN_EIGENVALUE_SHARE: f64 = 1e-13;

impl Marginal {
    /// From `H` and `b` over `keys`, linearised at the values `at`.
    ///
    /// # Errors
    /// When the sizes do not match, or an entry is not finite.
    pub fn new(
        keys: Vec<Key>,
        at: Vec<Value>,
        information: &DMatrix<f64>,
        right_hand_side: &DVector<f64>,
    ) -> Result<Self, FactorError> {
        let kinds: Vec<VariableKind> = at.iter().map(Value::kind).collect();
        let size: usize = kinds.iter().map(|kind| kind.dimension()).sum();
        if keys.len() != at.len() || information.shape() != (size, size) || right_hand_side.len() != size {
            return Err(FactorError::Information { problem: texts::OTHER_DIMENSION });
        }
        if !information.iter().chain(right_hand_side.iter()).all(|entry| entry.is_finite()) {
            return Err(FactorError::Information { problem: texts::NOT_FINITE_ENTRIES });
        }
        let eigen = information.clone().symmetric_eigen();
        let least = eigen.eigenvalues.amax() * MIN_EIGENVALUE_SHARE;
        let useful: Vec<usize> = (0..size).filter(|&index| eigen.eigenvalues[index] > least).collect();
        let scales: Vec<f64> = useful.iter().map(|&index| eigen.eigenvalues[index].sqrt()).collect();
        let root = DMatrix::from_fn(useful.len(), size, |row, column| {
            scales[row] * eigen.eigenvectors[(column, useful[row])]
        });
        let along = |row: usize| eigen.eigenvectors.column(useful[row]).dot(right_hand_side);
        let offset = DVector::from_fn(useful.len(), |row, _| along(row) / scales[row]);
        Ok(Self { keys, kinds, at, root, offset })
    }
}

impl Factor for Marginal {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn kinds(&self) -> &[VariableKind] {
        &self.kinds
    }

    fn rows(&self) -> usize {
        self.offset.len()
    }

    fn linearise(&self, values: &Values, out: &mut Linearised) -> Result<(), FactorError> {
        let mut negated_residual = self.offset.clone();
        let mut start = 0;
        for (index, (&key, at)) in self.keys.iter().zip(&self.at).enumerate() {
            let value = values.get(key).ok_or(FactorError::UnknownVariable { key })?;
            if value.kind() != at.kind() {
                return Err(FactorError::Kind { key, found: value.kind(), needed: at.kind() });
            }
            let size = at.kind().dimension();
            let columns = self.root.columns(start, size);
            negated_residual -= columns * at.local(value).rows(0, size);
            let jacobian = columns * at.local_jacobian(value).view((0, 0), (size, size));
            for (column, entries) in jacobian.column_iter().enumerate() {
                out.jacobian_column_mut(index, column).copy_from_slice(entries.as_slice());
            }
            start += size;
        }
        out.residual_mut().copy_from_slice(negated_residual.as_slice());
        Ok(())
    }
}
