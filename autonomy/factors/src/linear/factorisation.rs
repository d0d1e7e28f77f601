//! Sparse Cholesky factorisation of a whole system, used by the batch solvers.

use super::assembly::{Assembly, packed_len, scalars, substitute_forward};
use super::dense::{Stored, dot, substitute_back};
use super::dissection::{self, DissectionConfig};
use super::ordering::{Adjacency, minimum_degree};
use super::symbolic::{Cluster, Forest, analyse};
use std::collections::BTreeMap;

/// Normal equations as a sum of packed contributions. Each contribution covers a few variables.
#[derive(Clone, Debug, Default)]
pub struct System {
    /// Number of scalars of each variable.
    pub dimensions: Vec<u8>,
    variables: Vec<u32>,
    variable_starts: Vec<usize>,
    values: Vec<f64>,
    value_starts: Vec<usize>,
    right_hand_sides: usize,
}

impl System {
    /// An empty system over variables of the given dimensions.
    pub fn new(dimensions: Vec<u8>, right_hand_sides: usize) -> Self {
        Self {
            dimensions,
            right_hand_sides,
            variable_starts: vec![0],
            value_starts: vec![0],
            ..Self::default()
        }
    }

    /// Adds a zero contribution over `variables`.
    pub fn push(&mut self, variables: &[u32]) {
        self.variables.extend_from_slice(variables);
        self.variable_starts.push(self.variables.len());
        let entries = packed_len(scalars(variables, &self.dimensions), self.right_hand_sides);
        self.values.resize(self.values.len() + entries, 0.0);
        self.value_starts.push(self.values.len());
    }

    /// Number of contributions.
    pub fn len(&self) -> usize {
        self.variable_starts.len() - 1
    }

    /// Variables of a contribution.
    pub fn variables(&self, index: usize) -> &[u32] {
        &self.variables[self.variable_starts[index]..self.variable_starts[index + 1]]
    }

    /// Packed values of a contribution.
    pub fn values(&self, index: usize) -> &[f64] {
        &self.values[self.value_starts[index]..self.value_starts[index + 1]]
    }

    /// Packed values of a contribution, for writing.
    pub fn values_mut(&mut self, index: usize) -> &mut [f64] {
        &mut self.values[self.value_starts[index]..self.value_starts[index + 1]]
    }

    /// First scalar of each variable in a vector of all unknowns. The last entry is the vector's length.
    pub fn starts(&self) -> Vec<usize> {
        let mut starts = vec![0];
        let mut sum = 0;
        for &dimension in &self.dimensions {
            sum += usize::from(dimension);
            starts.push(sum);
        }
        starts
    }

    /// Diagonal of the normal equations.
    pub fn diagonal(&self) -> Vec<f64> {
        self.sum_of_columns(|column| column[0])
    }

    /// The first right-hand side: all unknowns in the order of the variables.
    pub fn gradient(&self) -> Vec<f64> {
        self.sum_of_columns(|column| column[column.len() - self.right_hand_sides])
    }

    /// For every unknown, the sum of `entry` over its columns. Each column runs from the diagonal down.
    fn sum_of_columns(&self, entry: impl Fn(&[f64]) -> f64) -> Vec<f64> {
        let starts = self.starts();
        let mut sums = vec![0.0; starts.last().copied().unwrap_or(0)];
        for index in 0..self.len() {
            let variables = self.variables(index);
            let mut rest = self.values(index);
            let mut height = scalars(variables, &self.dimensions) + self.right_hand_sides;
            for &variable in variables {
                for sum in &mut sums[starts[variable as usize]..starts[variable as usize + 1]] {
                    let (column, after) = rest.split_at(height);
                    *sum += entry(column);
                    rest = after;
                    height -= 1;
                }
            }
        }
        sums
    }

    /// Product of the normal equations with a vector.
    pub fn multiply(&self, vector: &[f64]) -> Vec<f64> {
        let starts = self.starts();
        let mut product = vec![0.0; vector.len()];
        let (mut from, mut to) = (Vec::new(), Vec::new());
        for index in 0..self.len() {
            let variables = self.variables(index);
            gather(&starts, variables.iter(), vector, &mut from);
            gather(&starts, variables.iter(), &product, &mut to);
            let size = from.len();
            let mut column = self.values(index);
            for j in 0..size {
                to[j] += column[0] * from[j];
                for i in j + 1..size {
                    to[i] += column[i - j] * from[j];
                    to[j] += column[i - j] * from[i];
                }
                column = &column[size - j + self.right_hand_sides..];
            }
            scatter(&starts, variables, &to, &mut product);
        }
        product
    }

    fn cliques(&self) -> impl Iterator<Item = &[u32]> + Clone {
        (0..self.len()).map(|index| self.variables(index))
    }
}

/// Elimination order by minimum degree or, for large graphs, by nested dissection if that costs less.
pub fn fill_reducing(graph: &Adjacency) -> Vec<u32> {
    let config = DissectionConfig::default();
    let order = minimum_degree(graph, &[]);
    if graph.len() < config.min_variables {
        return order;
    }
    let dissected = minimum_degree(graph, &dissection::groups(graph, &config));
    let work = |order: &[u32]| -> f64 {
        let of_cluster = |cluster: &Cluster| {
            let (columns, below) = (cluster.frontal.len() as f64, cluster.separator.len() as f64);
            // Half of the sum of squared column heights, approximately.
            ((columns + below).powi(3) - below.powi(3)) / 6.0
        };
        analyse(graph, order, &vec![1; graph.len()], &[]).clusters.iter().map(of_cluster).sum()
    };
    if work(&dissected) < work(&order) { dissected } else { order }
}

/// Everything that depends only on the structure of a system. Computed once and used by every iteration.
#[derive(Clone, Debug)]
pub struct EliminationPlan {
    /// Clusters of the elimination.
    pub forest: Forest,
    /// Contributions, sorted by the cluster that adds them.
    contributions: Vec<u32>,
    contribution_starts: Vec<usize>,
    starts: Vec<usize>,
}

impl EliminationPlan {
    /// Finds an elimination order and analyses the structure.
    pub fn new(system: &System) -> Self {
        let graph = Adjacency::from_cliques(system.dimensions.len(), system.cliques());
        let order = fill_reducing(&graph);
        Self::with_order_of(system, &graph, &order)
    }

    /// Analyses the structure for a given elimination order.
    pub fn with_order(system: &System, order: &[u32]) -> Self {
        let graph = Adjacency::from_cliques(system.dimensions.len(), system.cliques());
        Self::with_order_of(system, &graph, order)
    }

    fn with_order_of(system: &System, graph: &Adjacency, order: &[u32]) -> Self {
        let forest = analyse(graph, order, &system.dimensions, &[]);
        let home = |index: usize| {
            let first =
                system.variables(index).iter().min_by_key(|&&variable| forest.rank[variable as usize]);
            first.map_or(0, |&variable| forest.cluster_of[variable as usize] as usize)
        };
        let mut contribution_starts = vec![0; forest.clusters.len() + 1];
        for index in 0..system.len() {
            contribution_starts[home(index) + 1] += 1;
        }
        for index in 0..forest.clusters.len() {
            contribution_starts[index + 1] += contribution_starts[index];
        }
        let mut cursor = contribution_starts.clone();
        let mut contributions = vec![0; system.len()];
        for index in 0..system.len() {
            let slot = &mut cursor[home(index)];
            contributions[*slot] = index as u32;
            *slot += 1;
        }
        Self { forest, contributions, contribution_starts, starts: system.starts() }
    }

    fn of(&self, cluster: usize) -> &[u32] {
        &self.contributions[self.contribution_starts[cluster]..self.contribution_starts[cluster + 1]]
    }
}

/// A variable that the normal equations do not determine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Undetermined(pub u32);

/// Cholesky factor of a system.
#[derive(Debug)]
pub struct Factorisation<T = f64> {
    panels: Vec<T>,
    panel_starts: Vec<usize>,
    right_hand_sides: usize,
    assembly: Assembly,
}

impl<T: Stored> Factorisation<T> {
    /// An empty factorisation.
    pub fn new() -> Self {
        Self {
            panels: Vec::new(),
            panel_starts: Vec::new(),
            right_hand_sides: 0,
            assembly: Assembly::default(),
        }
    }

    /// Factorises `system` with `damping` added to the diagonal (one entry per scalar, or empty). The memory of an earlier factorisation is
    /// reused.
    ///
    ///
    /// Memory: the factor, and the Schur complements whose parents are not assembled yet.
    ///
    /// # Errors
    /// The first variable that is not determined.
    pub fn factorise(
        &mut self,
        plan: &EliminationPlan,
        system: &System,
        damping: &[f64],
    ) -> Result<(), Undetermined> {
        self.right_hand_sides = system.right_hand_sides;
        self.panels.clear();
        self.panel_starts.clear();
        let clusters = &plan.forest.clusters;
        let mut updates: Vec<Vec<f64>> = vec![Vec::new(); clusters.len()];
        for (index, cluster) in clusters.iter().enumerate() {
            let assembly = &mut self.assembly;
            assembly.begin(&cluster.frontal, &cluster.separator, &system.dimensions, self.right_hand_sides);
            for &contribution in plan.of(index) {
                let contribution = contribution as usize;
                let variables = system.variables(contribution);
                assembly.add(variables, &system.dimensions, system.values(contribution));
            }
            if !damping.is_empty() {
                let entries = |&variable: &u32| {
                    &damping[plan.starts[variable as usize]..plan.starts[variable as usize + 1]]
                };
                assembly.damp(cluster.frontal.iter().flat_map(entries).copied());
            }
            for &child in &cluster.children {
                let update = std::mem::take(&mut updates[child as usize]);
                assembly.add(&clusters[child as usize].separator, &system.dimensions, &update);
            }
            assembly.eliminate().map_err(|bad| variable_of(&cluster.frontal, &system.dimensions, bad.0))?;
            self.panel_starts.push(self.panels.len());
            assembly.append_panel(&mut self.panels);
            if !cluster.separator.is_empty() {
                updates[index] = assembly.update();
            }
        }
        Ok(())
    }

    /// Solution for the right-hand side `which`: all unknowns in the order of the variables.
    pub fn solve(&self, plan: &EliminationPlan, dimensions: &[u8], which: usize) -> Vec<f64> {
        let mut solution = vec![0.0; plan.starts.last().copied().unwrap_or(0)];
        let mut local = Vec::new();
        for (index, cluster) in plan.forest.clusters.iter().enumerate().rev() {
            gather(&plan.starts, cluster.frontal.iter().chain(&cluster.separator), &solution, &mut local);
            let columns = scalars(&cluster.frontal, dimensions);
            let panel = &self.panels[self.panel_starts[index]..];
            substitute_back(panel, columns, self.right_hand_sides, which, &mut local);
            scatter(&plan.starts, &cluster.frontal, &local, &mut solution);
        }
        solution
    }

    /// Squared length of the first right-hand side after forward substitution: the predicted decrease of the cost by a full step.
    pub fn squared_right_hand_side(&self, plan: &EliminationPlan, dimensions: &[u8]) -> f64 {
        let mut sum = 0.0;
        for (cluster, &start) in plan.forest.clusters.iter().zip(&self.panel_starts) {
            let columns = scalars(&cluster.frontal, dimensions);
            let size = columns + scalars(&cluster.separator, dimensions) + self.right_hand_sides;
            let mut end = start;
            for column in 0..columns {
                end += size - column;
                let entry: f64 = self.panels[end - self.right_hand_sides].into();
                sum += entry * entry;
            }
        }
        sum
    }

    /// Solutions `y` of `L y = e` for the unit vectors `e` of all scalars of some variables. They are given on the union of the paths from the
    /// variables' clusters to the roots and are zero elsewhere. Their dot products are entries of the inverse of the normal equations
    /// (docs/maths/factors.md, equation 8).
    ///
    /// Cost: one forward substitution along the paths for each scalar.
    pub fn forward(&self, plan: &EliminationPlan, dimensions: &[u8], variables: &[u32]) -> Vec<Vec<f64>> {
        let clusters = &plan.forest.clusters;
        let mut path = Vec::new();
        for &variable in variables {
            let mut next = Some(plan.forest.cluster_of[variable as usize]);
            while let Some(index) = next {
                path.push(index);
                next = clusters[index as usize].parent;
            }
        }
        // Children have smaller numbers than their parents.
        path.sort_unstable();
        path.dedup();
        // Scalars of the path, numbered from 0.
        let mut start_of: BTreeMap<u32, usize> = BTreeMap::new();
        let mut len = 0;
        for &variable in path.iter().flat_map(|&index| &clusters[index as usize].frontal) {
            start_of.insert(variable, len);
            len += usize::from(dimensions[variable as usize]);
        }
        let places: Vec<Vec<usize>> = path
            .iter()
            .map(|&index| {
                let cluster = &clusters[index as usize];
                let all = cluster.frontal.iter().chain(&cluster.separator);
                all.filter_map(|variable| {
                    let start = *start_of.get(variable)?;
                    Some(start..start + usize::from(dimensions[*variable as usize]))
                })
                .flatten()
                .collect()
            })
            .collect();
        let unit = |scalar: usize| {
            let mut vector = vec![0.0; len];
            vector[scalar] = 1.0;
            for (&index, places) in path.iter().zip(&places) {
                let mut local: Vec<f64> = places.iter().map(|&place| vector[place]).collect();
                let columns = scalars(&clusters[index as usize].frontal, dimensions);
                let panel = &self.panels[self.panel_starts[index as usize]..];
                substitute_forward(panel, columns, self.right_hand_sides, &mut local);
                places.iter().zip(local).for_each(|(&place, value)| vector[place] = value);
            }
            vector
        };
        let starts = variables.iter().filter_map(|variable| Some((*start_of.get(variable)?, variable)));
        starts
            .flat_map(|(start, &variable)| start..start + usize::from(dimensions[variable as usize]))
            .map(unit)
            .collect()
    }
}

/// All pairwise dot products, column-major.
pub fn products(columns: &[Vec<f64>]) -> Vec<f64> {
    columns.iter().flat_map(|a| columns.iter().map(|b| dot(a, b))).collect()
}

/// Copies the scalars of some variables from `all` into `local`.
pub fn gather<'a>(
    starts: &[usize],
    variables: impl Iterator<Item = &'a u32>,
    all: &[f64],
    local: &mut Vec<f64>,
) {
    local.clear();
    for &variable in variables {
        local.extend_from_slice(&all[starts[variable as usize]..starts[variable as usize + 1]]);
    }
}

/// Copies the scalars of some variables from the beginning of `local` back into `all`.
pub fn scatter<'a>(
    starts: &[usize],
    variables: impl IntoIterator<Item = &'a u32>,
    local: &[f64],
    all: &mut [f64],
) {
    let mut rest = local;
    for &variable in variables {
        let target = &mut all[starts[variable as usize]..starts[variable as usize + 1]];
        let (values, after) = rest.split_at(target.len());
        target.copy_from_slice(values);
        rest = after;
    }
}

/// The variable to which a scalar of the front belongs.
pub fn variable_of(frontal: &[u32], dimensions: &[u8], scalar: usize) -> Undetermined {
    let mut end = 0;
    for &variable in frontal {
        end += usize::from(dimensions[variable as usize]);
        if scalar < end {
            return Undetermined(variable);
        }
    }
    Undetermined(frontal.last().copied().unwrap_or(0))
}
