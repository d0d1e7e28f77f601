//! The Bayes tree: cliques in an arena.

use crate::linear::assembly::scalars;
use crate::linear::dense::panel_len;
use crate::linear::dense::substitute_back;

/// Variables that are eliminated together, conditioned on others.
#[derive(Clone, Debug, Default)]
pub struct Clique {
    /// Variables eliminated in this clique.
    pub frontal: Vec<u32>,
    /// Variables it is conditioned on. All of them are frontal in cliques above.
    pub separator: Vec<u32>,
    /// Number of the clique above.
    pub parent: Option<u32>,
    /// Numbers of the cliques below.
    pub children: Vec<u32>,
    /// Columns of the square-root information matrix, as [`crate::linear::assembly::Assembly::append_panel`] leaves them.
    pub panel: Vec<f64>,
    /// Schur complement for the parent: packed normal equations over the separator.
    pub update: Vec<f64>,
}

/// Cliques by number. Numbers of removed cliques are used again.
#[derive(Debug, Default)]
pub struct Tree {
    cliques: Vec<Option<Clique>>,
    free: Vec<u32>,
    /// Clique in which each variable is frontal; `None` while it is in none.
    clique_of: Vec<Option<u32>>,
}

impl Tree {
    /// A clique.
    pub fn get(&self, number: u32) -> Option<&Clique> {
        self.cliques.get(number as usize).and_then(Option::as_ref)
    }

    fn get_mut(&mut self, number: u32) -> Option<&mut Clique> {
        self.cliques.get_mut(number as usize).and_then(Option::as_mut)
    }

    /// The clique in which a variable is frontal.
    pub fn clique_of(&self, variable: u32) -> Option<u32> {
        self.clique_of.get(variable as usize).copied().flatten()
    }

    /// Number of cliques.
    pub fn len(&self) -> usize {
        self.cliques.len() - self.free.len()
    }

    /// One past the greatest number in use.
    pub fn numbers(&self) -> usize {
        self.cliques.len()
    }

    /// Number of stored floating-point values.
    pub fn scalars(&self) -> usize {
        self.cliques.iter().flatten().map(|clique| clique.panel.len() + clique.update.len()).sum()
    }

    /// Makes room for `variables`.
    pub fn resize(&mut self, variables: usize) {
        self.clique_of.resize(variables, None);
    }

    /// Adds a clique below the clique that eliminates the first variable of its separator. That clique must exist.
    pub fn insert(&mut self, mut clique: Clique) -> u32 {
        clique.parent = clique.separator.first().and_then(|&first| self.clique_of(first));
        let parent = clique.parent;
        let number = self.free.pop().unwrap_or(self.cliques.len() as u32);
        for &variable in &clique.frontal {
            self.clique_of[variable as usize] = Some(number);
        }
        if number as usize == self.cliques.len() {
            self.cliques.push(Some(clique));
        } else {
            self.cliques[number as usize] = Some(clique);
        }
        if let Some(parent) = parent.and_then(|parent| self.get_mut(parent)) {
            parent.children.push(number);
        }
        number
    }

    /// Attaches a subtree whose parent was removed to the clique that now eliminates the first variable of its separator. `rank` gives the
    /// elimination order.
    pub fn reattach(&mut self, number: u32, rank: impl Fn(u32) -> u32) {
        let Some(clique) = self.get(number) else { return };
        let first = clique.separator.iter().min_by_key(|&&variable| rank(variable)).copied();
        let parent = first.and_then(|first| self.clique_of(first));
        if let Some(clique) = self.get_mut(number) {
            clique.parent = parent;
        }
        if let Some(parent) = parent.and_then(|parent| self.get_mut(parent)) {
            parent.children.push(number);
        }
    }

    /// Removes a clique. Its variables belong to no clique until they are inserted again.
    pub fn remove(&mut self, number: u32) -> Option<Clique> {
        let clique = self.cliques.get_mut(number as usize)?.take()?;
        for &variable in &clique.frontal {
            self.clique_of[variable as usize] = None;
        }
        self.free.push(number);
        Some(clique)
    }

    /// Adds to `found` every clique that contains `variable`. They form a connected part of the tree.
    pub fn containing(&self, variable: u32, found: &mut Vec<u32>) {
        let mut waiting: Vec<u32> = self.clique_of(variable).into_iter().collect();
        while let Some(number) = waiting.pop() {
            found.push(number);
            let children = self.get(number).map_or(&[][..], |clique| &clique.children);
            let has =
                |&&child: &&u32| self.get(child).is_some_and(|clique| clique.separator.contains(&variable));
            waiting.extend(children.iter().filter(has));
        }
    }
}

impl Clique {
    /// Solves for the frontal variables. `all` must hold the separator's solution. The result is left in `local`, frontal scalars first.
    pub fn solve(&self, dimensions: &[u8], starts: &[usize], all: &[f64], local: &mut Vec<f64>) {
        let variables = self.frontal.iter().chain(&self.separator);
        crate::linear::factorisation::gather(starts, variables, all, local);
        let columns = scalars(&self.frontal, dimensions);
        debug_assert_eq!(self.panel.len(), panel_len(columns, local.len() + 1));
        substitute_back(&self.panel, columns, 1, 0, local);
    }
}
