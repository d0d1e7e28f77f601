//! Initial estimates from the measurements alone: chordal relaxation.
//!
//! Rotations come first. Without the constraint to rotation matrices, `R_j = R_i R_ij` is linear, and one sparse solve finds the best matrices.
//! Each matrix is then replaced by the nearest rotation. With known rotations the positions are a linear problem, too.
//! Sources: Martinec, Pajdla, CVPR 2007; Carlone and others, *Initialization techniques for 3D SLAM*, ICRA 2015.

use crate::error::SolveError;
use crate::factor::RelativePose;
use crate::graph::FactorGraph;
use crate::linear::factorisation::{EliminationPlan, Factorisation, System, fill_reducing};
use crate::linear::ordering::Adjacency;
use crate::names::{Key, VariableKind};
use crate::value::{Planar, Value, Values};
use geometry::{Isometry, Matrix3, Rotation, Vector3};
use nalgebra::{Matrix2, SMatrix, SVector, UnitComplex, Vector2};

/// Parameters of [`chordal`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChordalConfig {
    /// Weight of a prior relative to the greatest weight of the measurements. Chosen: it only has to fix the frame
    /// more firmly than any measurement does. The default is ten times.
    pub relative_anchor_weight: f64,
}

impl Default for ChordalConfig {
    fn default() -> Self {
        Self { relative_anchor_weight: 10.0 }
    }
}

impl ChordalConfig {
    /// Weight of a prior among measurements of this greatest weight.
    fn anchor_weight(&self, greatest: f64) -> f64 {
        self.relative_anchor_weight * if greatest > 0.0 { greatest } else { 1.0 }
    }
}

/// Estimates all poses from the graph's relative poses and pose priors. `values` gives the kind of each variable. Variables other than poses
/// keep their estimates. Full information matrices are replaced by their mean over the axes, so the result should be refined by a few iterations
/// of [`crate::optimise`].
///
/// Cost: two sparse factorisations of half and a sixth of the full problem's size.
///
/// # Errors
/// When relative poses do not connect every pose to one with a prior.
pub fn chordal(graph: &FactorGraph, values: &Values, config: &ChordalConfig) -> Result<Values, SolveError> {
    let measurements = Measurements::collect(graph, values);
    measurements.check_connected(values)?;
    let mut out = values.clone();
    solve_space(&measurements, values, config, &mut out)?;
    solve_plane(&measurements, values, config, &mut out)?;
    Ok(out)
}

struct Edge<P> {
    from: u32,
    to: u32,
    measured: P,
    /// Mean information per axis.
    rotation_weight: f64,
    translation_weight: f64,
}

#[derive(Default)]
struct Measurements {
    space: Vec<Edge<Isometry>>,
    plane: Vec<Edge<Planar>>,
    anchors: Vec<(u32, Value)>,
}

impl Measurements {
    fn collect(graph: &FactorGraph, values: &Values) -> Self {
        let mut out = Self::default();
        for (_, entry) in graph.iter().filter(|(_, entry)| entry.weight > 0.0) {
            let keys = entry.factor.keys();
            if let (Some(anchor), &[key]) = (entry.factor.anchor(), keys)
                && values.get(key).is_some_and(|value| value.kind() == anchor.kind())
            {
                out.anchors.push((key.0, anchor));
            }
            let &[Key(from), Key(to)] = keys else { continue };
            let mean = |diagonal: &[f64]| entry.weight * diagonal.iter().sum::<f64>() / diagonal.len() as f64;
            match entry.factor.relative_pose() {
                Some(RelativePose::Space(measured, information)) => {
                    let diagonal = information.diagonal();
                    out.space.push(Edge {
                        from,
                        to,
                        measured,
                        rotation_weight: mean(&diagonal.as_slice()[..3]),
                        translation_weight: mean(&diagonal.as_slice()[3..]),
                    });
                }
                Some(RelativePose::Plane(measured, information)) => {
                    let diagonal = information.diagonal();
                    out.plane.push(Edge {
                        from,
                        to,
                        measured,
                        rotation_weight: diagonal[2],
                        translation_weight: mean(&diagonal.as_slice()[..2]),
                    });
                }
                None => {}
            }
        }
        out
    }

    /// Checks that every pose is connected to an anchor.
    fn check_connected(&self, values: &Values) -> Result<(), SolveError> {
        let pairs: Vec<[u32; 2]> = self
            .space
            .iter()
            .map(|edge| [edge.from, edge.to])
            .chain(self.plane.iter().map(|edge| [edge.from, edge.to]))
            .collect();
        let adjacency = Adjacency::from_cliques(values.len(), pairs.iter().map(|pair| pair.as_slice()));
        let mut reached = vec![false; values.len()];
        let mut waiting: Vec<u32> = self.anchors.iter().map(|(key, _)| *key).collect();
        while let Some(key) = waiting.pop() {
            if !std::mem::replace(&mut reached[key as usize], true) {
                waiting.extend(adjacency.of(key as usize));
            }
        }
        let lost = values.iter().find(|(key, value)| {
            matches!(value.kind(), VariableKind::Planar | VariableKind::Pose) && !reached[key.index()]
        });
        lost.map_or(Ok(()), |(key, _)| Err(SolveError::Disconnected { key }))
    }
}

/// Variables of one kind and their elimination order.
struct Part {
    /// Index of each variable in `keys`, or `u32::MAX`.
    number: Vec<u32>,
    keys: Vec<Key>,
    order: Vec<u32>,
}

impl Part {
    fn new<P>(values: &Values, kind: VariableKind, edges: &[Edge<P>]) -> Self {
        let mut number = vec![u32::MAX; values.len()];
        let mut keys = Vec::new();
        for (key, _) in values.iter().filter(|(_, value)| value.kind() == kind) {
            number[key.index()] = keys.len() as u32;
            keys.push(key);
        }
        let pairs: Vec<[u32; 2]> =
            edges.iter().map(|edge| [number[edge.from as usize], number[edge.to as usize]]).collect();
        let adjacency = Adjacency::from_cliques(keys.len(), pairs.iter().map(|pair| pair.as_slice()));
        Self { number, order: fill_reducing(&adjacency), keys }
    }

    /// Solves a system over these variables. Each solution holds the unknowns for one right-hand side.
    fn solve(&self, system: &System, right_hand_sides: usize) -> Result<Vec<Vec<f64>>, SolveError> {
        let plan = EliminationPlan::with_order(system, &self.order);
        let mut factorisation = Factorisation::<f64>::new();
        factorisation
            .factorise(&plan, system, &[])
            .map_err(|bad| SolveError::Undetermined { key: self.keys[bad.0 as usize] })?;
        Ok((0..right_hand_sides).map(|which| factorisation.solve(&plan, &system.dimensions, which)).collect())
    }
}

/// Writes packed normal equations `weight · JᵀJ` over one or two variables. `entry(row, column)` gives the lower triangle.
fn write_packed(values: &mut [f64], size: usize, entry: impl Fn(usize, usize) -> f64) {
    let pairs = (0..size).flat_map(|column| (column..size).map(move |row| (row, column)));
    for (slot, (row, column)) in values.iter_mut().zip(pairs) {
        *slot = entry(row, column);
    }
}

/// Best matrices with `M_j ≈ M_i A_ij`. One linear system solves for all rows. `D` is the size of a rotation matrix.
fn relaxed_rotations<P, const D: usize>(
    part: &Part,
    edges: &[Edge<P>],
    anchors: &[(u32, SMatrix<f64, D, D>)],
    config: &ChordalConfig,
    rotation: impl Fn(&P) -> SMatrix<f64, D, D>,
) -> Result<Vec<SMatrix<f64, D, D>>, SolveError> {
    let mut system = System::new(vec![D as u8; part.keys.len()], D);
    let mut greatest = 0.0_f64;
    for edge in edges {
        let variables = [part.number[edge.from as usize], part.number[edge.to as usize]];
        system.push(&variables);
        let (matrix, weight) = (rotation(&edge.measured), edge.rotation_weight);
        greatest = greatest.max(weight);
        let index = system.len() - 1;
        // Row k of M_j, as a column vector, equals A_ijᵀ times row k of M_i.
        write_packed(system.values_mut(index), 2 * D + D, |row, column| match (row / D, column / D) {
            (0, 0) | (1, 1) if row == column => weight,
            (1, 0) => -weight * matrix[(column, row - D)],
            _ => 0.0,
        });
    }
    let anchor_weight = config.anchor_weight(greatest);
    for (variable, known) in anchors {
        system.push(&[part.number[*variable as usize]]);
        let index = system.len() - 1;
        write_packed(system.values_mut(index), D + D, |row, column| match (row / D, column / D) {
            (0, 0) if row == column => anchor_weight,
            (1, 0) => anchor_weight * known[(row - D, column)],
            _ => 0.0,
        });
    }
    let rows = part.solve(&system, D)?;
    Ok((0..part.keys.len())
        .map(|number| SMatrix::from_fn(|row, column| rows[row][number * D + column]))
        .collect())
}

/// Best positions for given differences `t_j - t_i` of all edges.
fn positions<P, const D: usize>(
    part: &Part,
    edges: &[Edge<P>],
    anchors: &[(u32, SVector<f64, D>)],
    config: &ChordalConfig,
    shift: impl Fn(&Edge<P>) -> SVector<f64, D>,
) -> Result<Vec<SVector<f64, D>>, SolveError> {
    let mut system = System::new(vec![1; part.keys.len()], D);
    let mut greatest = 0.0_f64;
    for edge in edges {
        let variables = [part.number[edge.from as usize], part.number[edge.to as usize]];
        system.push(&variables);
        let (shift, weight) = (shift(edge), edge.translation_weight);
        greatest = greatest.max(weight);
        let index = system.len() - 1;
        write_packed(system.values_mut(index), 2 + D, |row, column| match (row, column) {
            (0, 0) | (1, 1) => weight,
            (1, 0) => -weight,
            (_, 0) => -weight * shift[row - 2],
            (_, 1) => weight * shift[row - 2],
            _ => 0.0,
        });
    }
    let anchor_weight = config.anchor_weight(greatest);
    for (variable, known) in anchors {
        system.push(&[part.number[*variable as usize]]);
        let index = system.len() - 1;
        write_packed(system.values_mut(index), 1 + D, |row, column| match (row, column) {
            (0, 0) => anchor_weight,
            (_, 0) => anchor_weight * known[row - 1],
            _ => 0.0,
        });
    }
    let axes = part.solve(&system, D)?;
    Ok((0..part.keys.len()).map(|number| SVector::from_fn(|axis, _| axes[axis][number])).collect())
}

fn solve_space(
    measurements: &Measurements,
    values: &Values,
    config: &ChordalConfig,
    out: &mut Values,
) -> Result<(), SolveError> {
    let part = Part::new(values, VariableKind::Pose, &measurements.space);
    let anchors: Vec<(u32, Isometry)> = measurements
        .anchors
        .iter()
        .filter_map(|(key, value)| if let Value::Pose(pose) = value { Some((*key, *pose)) } else { None })
        .collect();
    let known: Vec<(u32, Matrix3)> =
        anchors.iter().map(|(key, pose)| (*key, pose.rotation.to_rotation_matrix().into_inner())).collect();
    let relaxed = relaxed_rotations(&part, &measurements.space, &known, config, |measured| {
        measured.rotation.to_rotation_matrix().into_inner()
    })?;
    let rotations: Vec<Rotation> = relaxed.iter().map(nearest_rotation).collect();
    let known: Vec<(u32, Vector3)> =
        anchors.iter().map(|(key, pose)| (*key, pose.translation.vector)).collect();
    let positions = positions(&part, &measurements.space, &known, config, |edge| {
        rotations[part.number[edge.from as usize] as usize] * edge.measured.translation.vector
    })?;
    for (number, &key) in part.keys.iter().enumerate() {
        let pose = Isometry::from_parts(positions[number].into(), rotations[number]);
        out.set(key, Value::Pose(pose)).map_err(|_| SolveError::UnknownVariable { key })?;
    }
    Ok(())
}

fn solve_plane(
    measurements: &Measurements,
    values: &Values,
    config: &ChordalConfig,
    out: &mut Values,
) -> Result<(), SolveError> {
    let part = Part::new(values, VariableKind::Planar, &measurements.plane);
    let anchors: Vec<(u32, Planar)> = measurements
        .anchors
        .iter()
        .filter_map(|(key, value)| if let Value::Planar(pose) = value { Some((*key, *pose)) } else { None })
        .collect();
    let matrix = |pose: &Planar| pose.rotation.to_rotation_matrix().into_inner();
    let known: Vec<(u32, Matrix2<f64>)> = anchors.iter().map(|(key, pose)| (*key, matrix(pose))).collect();
    let relaxed = relaxed_rotations(&part, &measurements.plane, &known, config, matrix)?;
    let rotations: Vec<UnitComplex<f64>> = relaxed
        .iter()
        .map(|m| UnitComplex::new((m[(1, 0)] - m[(0, 1)]).atan2(m[(0, 0)] + m[(1, 1)])))
        .collect();
    let known: Vec<(u32, Vector2<f64>)> =
        anchors.iter().map(|(key, pose)| (*key, pose.translation.vector)).collect();
    let positions = positions(&part, &measurements.plane, &known, config, |edge| {
        rotations[part.number[edge.from as usize] as usize] * edge.measured.translation.vector
    })?;
    for (number, &key) in part.keys.iter().enumerate() {
        let pose = Planar::from_parts(positions[number].into(), rotations[number]);
        out.set(key, Value::Planar(pose)).map_err(|_| SolveError::UnknownVariable { key })?;
    }
    Ok(())
}

/// The rotation closest to a matrix in the Frobenius norm. The identity if the matrix has no singular value decomposition.
fn nearest_rotation(matrix: &Matrix3) -> Rotation {
    let decomposition = matrix.svd(true, true);
    let (Some(u), Some(v)) = (decomposition.u, decomposition.v_t) else { return Rotation::identity() };
    let mut flip = Matrix3::identity();
    flip[(2, 2)] = (u * v).determinant().signum();
    let rotation = nalgebra::Rotation3::from_matrix_unchecked(u * flip * v);
    Rotation::from_rotation_matrix(&rotation)
}
