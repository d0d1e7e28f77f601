//! One update: remove the changed top of the tree, eliminate it again, insert it, and back-substitute downwards.

use super::tree::Clique;
use super::{Incremental, Staged, Updated};
use crate::error::SolveError;
use crate::factor::Linearised;
use crate::graph::Entry;
use crate::linear::assembly::{packed_len, scalars};
use crate::linear::factorisation::{Undetermined, scatter, variable_of};
use crate::linear::ordering::{Adjacency, minimum_degree};
use crate::linear::symbolic::{Forest, analyse};
use crate::names::{FactorId, Key, VariableKind};
use crate::value::Value;

/// State that is restored when an update fails.
struct Undo {
    variables: usize,
    factors: usize,
    removed: Vec<(FactorId, Entry)>,
    moved: Vec<(Key, Value, Vec<f64>)>,
    linear: Vec<(FactorId, Vec<f64>)>,
}

/// The part of the tree that is eliminated again.
pub(super) struct Top {
    /// Removed cliques, ascending.
    pub(super) cliques: Vec<u32>,
    /// Their frontal variables, and new variables.
    pub(super) variables: Vec<u32>,
    /// Subtrees below the removed cliques.
    pub(super) orphans: Vec<u32>,
    /// Factors of the top.
    pub(super) factors: Vec<FactorId>,
    /// Number in `variables` of each variable, or `u32::MAX`.
    number: Vec<u32>,
}

/// The eliminated top: cliques with global variable numbers, children first.
pub(super) struct Eliminated {
    pub(super) cliques: Vec<Clique>,
    /// Rank of each variable of the top in the new elimination order.
    rank: Vec<u32>,
}

impl Incremental {
    /// Applies the staged changes and brings the solution up to date.
    ///
    /// # Errors
    /// When a variable is not determined or a factor cannot be evaluated. The staged changes are then dropped, and the solver's state is
    /// restored.
    pub fn update(&mut self) -> Result<Updated, SolveError> {
        let staged = std::mem::take(&mut self.staged);
        let measured = touched(self, &staged);
        let mut undo = self.apply_staged(staged);
        let far = self.far_variables(self.config.relinearise_angle_rad, self.config.relinearise_length_m);
        let mut result = self.try_update(&measured, &far, &mut undo);
        if matches!(result, Err(SolveError::Undetermined { .. })) {
            // The cause may be rounding in the Schur complements of the subtrees. A second attempt starts from all factors.
            let all = self.far_variables(0.0, 0.0);
            result = self.afresh(&measured, &all, &mut undo);
        }
        if result.is_err() {
            self.undo(undo);
        }
        result
    }

    /// Linearises every factor at the present estimate, including staged changes, and solves for all variables.
    ///
    /// # Errors
    /// As for [`Self::update`].
    pub fn relinearise_all(&mut self) -> Result<Updated, SolveError> {
        let staged = std::mem::take(&mut self.staged);
        let measured = touched(self, &staged);
        let mut undo = self.apply_staged(staged);
        let all = self.far_variables(0.0, 0.0);
        let result = self.afresh(&measured, &all, &mut undo);
        if result.is_err() {
            self.undo(undo);
        }
        result
    }

    fn afresh(&mut self, measured: &[u32], moved: &[u32], undo: &mut Undo) -> Result<Updated, SolveError> {
        self.move_variables(moved, undo)?;
        let everything: Vec<u32> =
            (0..self.values.len() as u32).filter(|&v| !self.forgotten[v as usize]).collect();
        let top = self.top(&everything);
        self.replace(&top, measured, moved.len())
    }

    fn try_update(&mut self, measured: &[u32], far: &[u32], undo: &mut Undo) -> Result<Updated, SolveError> {
        let mut seeds = measured.to_vec();
        let mut around = Vec::new();
        for &variable in far {
            self.tree.containing(variable, &mut around);
        }
        seeds.extend(around.iter().filter_map(|&number| self.tree.get(number)?.frontal.first().copied()));
        self.move_variables(far, undo)?;
        let mut top = self.top(&seeds);
        let alive = self.values.len() - self.forgotten.iter().filter(|&&forgotten| forgotten).count();
        if top.variables.len() as f64 > self.config.batch_share * alive as f64 && !top.orphans.is_empty() {
            let everything: Vec<u32> =
                (0..self.values.len() as u32).filter(|&v| !self.forgotten[v as usize]).collect();
            top = self.top(&everything);
        }
        self.replace(&top, measured, far.len())
    }

    fn replace(&mut self, top: &Top, measured: &[u32], relinearised: usize) -> Result<Updated, SolveError> {
        let last = |variable: u32| u8::from(measured.binary_search(&variable).is_ok());
        let groups: Vec<u8> = top.variables.iter().map(|&variable| last(variable)).collect();
        let eliminated = self.eliminate(top, &groups, &[]);
        let eliminated = eliminated.map_err(|bad| SolveError::Undetermined { key: Key(bad.0) })?;
        let roots = self.put_back(top, eliminated);
        let solved = self.solve(&roots, top);
        Ok(Updated { relinearised, eliminated: top.variables.len(), solved, cliques: self.tree.len() })
    }

    /// Moves staged variables and factors into the problem.
    fn apply_staged(&mut self, staged: Staged) -> Undo {
        let mut undo = Undo {
            variables: self.values.len(),
            factors: self.graph.ids(),
            removed: Vec::new(),
            moved: Vec::new(),
            linear: Vec::new(),
        };
        for value in staged.values {
            let dimension = value.kind().dimension();
            self.values.insert(value);
            self.dimensions.push(dimension as u8);
            self.delta.resize(self.delta.len() + dimension, 0.0);
            self.starts.push(self.delta.len());
            self.factors_of.push(Vec::new());
            self.forgotten.push(false);
        }
        self.tree.resize(self.values.len());
        for id in staged.removals {
            if let Ok(entry) = self.graph.remove(id) {
                for key in entry.factor.keys() {
                    self.factors_of[key.index()].retain(|&other| other != id);
                }
                undo.removed.push((id, entry));
            }
        }
        for entry in staged.entries {
            let id = FactorId(self.graph.ids() as u32);
            for key in entry.factor.keys() {
                self.factors_of[key.index()].push(id);
            }
            self.graph.push(entry);
            self.linear.push(Vec::new());
        }
        undo
    }

    fn undo(&mut self, undo: Undo) {
        for id in (undo.factors..self.graph.ids()).rev() {
            let id = FactorId(id as u32);
            let keys = self.graph.get(id).map_or(Vec::new(), |entry| entry.factor.keys().to_vec());
            for key in keys {
                self.factors_of[key.index()].retain(|&other| other != id);
            }
        }
        self.graph.truncate(undo.factors);
        self.linear.truncate(undo.factors);
        for (id, entry) in undo.removed {
            for key in entry.factor.keys() {
                let list = &mut self.factors_of[key.index()];
                let place = list.partition_point(|&other| other < id);
                list.insert(place, id);
            }
            self.graph.restore(id, entry);
        }
        for (key, value, delta) in undo.moved.into_iter().rev() {
            let _ = self.values.set(key, value);
            self.delta[self.starts[key.index()]..self.starts[key.index() + 1]].copy_from_slice(&delta);
        }
        for (id, packed) in undo.linear.into_iter().rev() {
            if let Some(slot) = self.linear.get_mut(id.index()) {
                *slot = packed;
            }
        }
        self.values.truncate(undo.variables);
        self.dimensions.truncate(undo.variables);
        self.starts.truncate(undo.variables + 1);
        self.delta.truncate(self.starts.last().copied().unwrap_or(0));
        self.factors_of.truncate(undo.variables);
        self.forgotten.truncate(undo.variables);
        self.tree.resize(undo.variables);
    }

    /// Variables of the tree whose solution is farther from the linearisation point than the thresholds.
    fn far_variables(&self, angle: f64, length: f64) -> Vec<u32> {
        let far = |&variable: &u32| {
            let index = variable as usize;
            let delta = &self.delta[self.starts[index]..self.starts[index + 1]];
            let angles = match self.values.get(Key(variable)).map(Value::kind) {
                Some(VariableKind::Pose) => 0..3,
                Some(VariableKind::Planar) => 2..3,
                _ => 0..0,
            };
            delta.iter().enumerate().any(|(axis, component)| {
                component.abs() > if angles.contains(&axis) { angle } else { length }
            })
        };
        (0..self.values.len() as u32)
            .filter(|&variable| self.tree.clique_of(variable).is_some())
            .filter(far)
            .collect()
    }

    /// Sets the linearisation points of `variables` to their present estimates. Linearises their factors and the new ones.
    fn move_variables(&mut self, variables: &[u32], undo: &mut Undo) -> Result<(), SolveError> {
        let mut stale: Vec<FactorId> = (0..self.graph.ids() as u32)
            .rev()
            .map(FactorId)
            .take_while(|id| self.linear[id.index()].is_empty())
            .collect();
        for &variable in variables {
            let key = Key(variable);
            let range = self.starts[key.index()]..self.starts[key.index() + 1];
            let delta = self.delta[range.clone()].to_vec();
            if let Some(&value) = self.values.get(key) {
                self.values.retract_one(key, &delta);
                undo.moved.push((key, value, delta));
            }
            self.delta[range].fill(0.0);
            stale.extend(&self.factors_of[key.index()]);
        }
        stale.sort_unstable();
        stale.dedup();
        let mut scratch = Linearised::default();
        for id in stale {
            let Some(entry) = self.graph.get(id) else { continue };
            scratch.reset(&*entry.factor);
            let done = entry.factor.linearise(&self.values, &mut scratch);
            done.map_err(|source| SolveError::Factor { factor: id, source })?;
            let (_, weight) = entry.evaluate(scratch.squared());
            let unknowns = entry.factor.kinds().iter().map(|kind| kind.dimension()).sum();
            let mut packed = vec![0.0; packed_len(unknowns, 1)];
            scratch.normal_equations(weight, &mut packed);
            if packed.iter().any(|value| !value.is_finite()) {
                let key = entry.factor.keys().first().copied().unwrap_or(Key(0));
                return Err(SolveError::NotFinite { factor: id, key });
            }
            undo.linear.push((id, std::mem::replace(&mut self.linear[id.index()], packed)));
        }
        Ok(())
    }

    /// The cliques of `seeds` and all above them.
    pub(super) fn top(&self, seeds: &[u32]) -> Top {
        let mut visited = vec![false; self.tree.numbers()];
        let mut cliques = Vec::new();
        let mut variables: Vec<u32> = Vec::new();
        for &seed in seeds {
            let mut next = self.tree.clique_of(seed);
            if next.is_none() {
                // A new variable, which no clique contains yet.
                variables.push(seed);
            }
            while let Some(number) = next {
                if std::mem::replace(&mut visited[number as usize], true) {
                    break;
                }
                cliques.push(number);
                next = self.tree.get(number).and_then(|clique| clique.parent);
            }
        }
        cliques.sort_unstable();
        let mut orphans = Vec::new();
        for clique in cliques.iter().filter_map(|&number| self.tree.get(number)) {
            variables.extend(&clique.frontal);
            orphans.extend(clique.children.iter().filter(|&&child| !visited[child as usize]));
        }
        variables.sort_unstable();
        variables.dedup();
        let mut number = vec![u32::MAX; self.values.len()];
        for (index, &variable) in variables.iter().enumerate() {
            number[variable as usize] = index as u32;
        }
        let inside = |&id: &FactorId| {
            let entry = self.graph.get(id);
            entry.is_some_and(|entry| entry.factor.keys().iter().all(|key| number[key.index()] != u32::MAX))
        };
        let all = variables.iter().flat_map(|&variable| &self.factors_of[variable as usize]).copied();
        let mut factors: Vec<FactorId> = all.collect();
        factors.sort_unstable();
        factors.dedup();
        factors.retain(inside);
        Top { cliques, variables, orphans, factors, number }
    }

    /// Orders and eliminates the top. Variables of lower `groups` come first, and variables of different `parts` go into different cliques. The
    /// tree is not changed.
    pub(super) fn eliminate(
        &mut self,
        top: &Top,
        groups: &[u8],
        parts: &[u8],
    ) -> Result<Eliminated, Undetermined> {
        let local = |variable: u32| top.number[variable as usize];
        let mut lists: Vec<Vec<u32>> = Vec::with_capacity(top.factors.len() + top.orphans.len());
        for &id in &top.factors {
            let keys = self.graph.get(id).map_or(&[][..], |entry| entry.factor.keys());
            lists.push(keys.iter().map(|key| local(key.0)).collect());
        }
        for &orphan in &top.orphans {
            let separator = self.tree.get(orphan).map_or(&[][..], |clique| &clique.separator);
            lists.push(separator.iter().map(|&variable| local(variable)).collect());
        }
        let dimensions: Vec<u8> = top.variables.iter().map(|&v| self.dimensions[v as usize]).collect();
        let graph = Adjacency::from_cliques(top.variables.len(), lists.iter().map(Vec::as_slice));
        let order = minimum_degree(&graph, groups);
        let forest = analyse(&graph, &order, &dimensions, parts);
        let cliques = self.eliminate_forest(top, &forest, &lists, &dimensions)?;
        Ok(Eliminated { cliques, rank: forest.rank })
    }

    fn eliminate_forest(
        &mut self,
        top: &Top,
        forest: &Forest,
        lists: &[Vec<u32>],
        dimensions: &[u8],
    ) -> Result<Vec<Clique>, Undetermined> {
        let mut inputs: Vec<Vec<u32>> = vec![Vec::new(); forest.clusters.len()];
        for (input, list) in lists.iter().enumerate() {
            if let Some(&first) = list.iter().min_by_key(|&&variable| forest.rank[variable as usize]) {
                inputs[forest.cluster_of[first as usize] as usize].push(input as u32);
            }
        }
        let global = |list: &[u32]| list.iter().map(|&variable| top.variables[variable as usize]).collect();
        let mut cliques: Vec<Clique> = Vec::with_capacity(forest.clusters.len());
        for (index, cluster) in forest.clusters.iter().enumerate() {
            let assembly = &mut self.assembly;
            assembly.begin(&cluster.frontal, &cluster.separator, dimensions, 1);
            for &input in &inputs[index] {
                let packed = match top.factors.get(input as usize) {
                    Some(id) => &self.linear[id.index()],
                    None => {
                        let orphan = top.orphans[input as usize - top.factors.len()];
                        let Some(clique) = self.tree.get(orphan) else { continue };
                        &clique.update
                    }
                };
                assembly.add(&lists[input as usize], dimensions, packed);
            }
            for &child in &cluster.children {
                let separator = &forest.clusters[child as usize].separator;
                assembly.add(separator, dimensions, &cliques[child as usize].update);
            }
            assembly.eliminate().map_err(|bad| {
                let Undetermined(variable) = variable_of(&cluster.frontal, dimensions, bad.0);
                Undetermined(top.variables[variable as usize])
            })?;
            let mut clique = Clique {
                frontal: global(&cluster.frontal),
                separator: global(&cluster.separator),
                ..Clique::default()
            };
            assembly.append_panel(&mut clique.panel);
            if !cluster.separator.is_empty() {
                clique.update = assembly.update();
            }
            cliques.push(clique);
        }
        Ok(cliques)
    }

    /// Replaces the top by its eliminated form and returns the new cliques, parents first.
    pub(super) fn put_back(&mut self, top: &Top, eliminated: Eliminated) -> Vec<u32> {
        for &number in &top.cliques {
            self.tree.remove(number);
        }
        let inserted = eliminated.cliques.into_iter().rev().map(|clique| self.tree.insert(clique)).collect();
        for &orphan in &top.orphans {
            self.tree.reattach(orphan, |variable| eliminated.rank[top.number[variable as usize] as usize]);
        }
        inserted
    }

    /// Solves for the variables of the new cliques, and for those below whose separators changed. Returns their number.
    pub(super) fn solve(&mut self, new: &[u32], top: &Top) -> usize {
        let mut solved = 0;
        let mut changed = vec![false; self.values.len()];
        let mut local = Vec::new();
        for &number in new {
            solved += self.solve_clique(number, &mut local, &mut changed);
        }
        let mut waiting = top.orphans.clone();
        while let Some(number) = waiting.pop() {
            let Some(clique) = self.tree.get(number) else { continue };
            if clique.separator.iter().any(|&variable| changed[variable as usize]) {
                waiting.extend(&clique.children);
                solved += self.solve_clique(number, &mut local, &mut changed);
            }
        }
        solved
    }

    fn solve_clique(&mut self, number: u32, local: &mut Vec<f64>, changed: &mut [bool]) -> usize {
        let Some(clique) = self.tree.get(number) else { return 0 };
        clique.solve(&self.dimensions, &self.starts, &self.delta, local);
        let mut rest = local.as_slice();
        for &variable in &clique.frontal {
            let index = variable as usize;
            let before = &self.delta[self.starts[index]..self.starts[index + 1]];
            let (now, after) = rest.split_at(before.len());
            changed[index] = before.iter().zip(now).any(|(a, b)| (a - b).abs() > self.config.min_change);
            rest = after;
        }
        scatter(&self.starts, &clique.frontal, local, &mut self.delta);
        debug_assert!(scalars(&clique.frontal, &self.dimensions) <= local.len());
        clique.frontal.len()
    }
}

/// Variables of staged factors and removals, and new ones.
fn touched(solver: &Incremental, staged: &Staged) -> Vec<u32> {
    let known = solver.values.len() as u32;
    let mut touched: Vec<u32> = (known..known + staged.values.len() as u32).collect();
    let removed = staged.removals.iter().filter_map(|&id| solver.graph.get(id));
    for entry in staged.entries.iter().chain(removed) {
        touched.extend(entry.factor.keys().iter().map(|key| key.0));
    }
    touched.sort_unstable();
    touched.dedup();
    touched
}
