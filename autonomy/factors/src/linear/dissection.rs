//! Nested dissection: small sets of variables (separators) whose removal splits a large graph in two, applied recursively.
//!
//! Breadth-first search from a peripheral variable sorts a part into levels. The separator between two neighbouring levels is the smallest set
//! of variables that covers all edges between them (a minimum vertex cover, by Kőnig's theorem from a maximum matching). Among the levels near
//! the middle the one with the lowest cost wins. Minimum degree then orders the variables within the parts. All separators come after their
//! parts.
//! Source: George, *Nested dissection of a regular finite element mesh*, SIAM J. Numer. Anal. 10, 1973; Pothen, Fan, *Computing the
//! block triangular form of a sparse matrix*, ACM TOMS 16, 1990, for the cover.

use super::ordering::Adjacency;

/// Parameters of the elimination order of large graphs. They change the time of a solve, not its result. Tuned on the published graphs of
/// `cargo xtask bench graphs`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DissectionConfig {
    /// From this number of variables on, nested dissection is compared with minimum degree. Source: tuned on those graphs. The search of the separators takes time
    /// itself.
    pub min_variables: usize,
    /// Parts with fewer variables are ordered by minimum degree alone. Source: tuned on those graphs.
    pub min_part_variables: usize,
    /// The smaller side of a cut must have at least this share of the variables. Source: tuned on those graphs. More balanced cuts have larger separators.
    pub min_smaller_share: f64,
    /// A separator may have at most one variable of this number of variables of its part. Source: tuned on those graphs. A larger separator costs more than the cut
    /// saves.
    pub min_variables_per_separator_variable: usize,
    /// Greatest depth of the recursion. Chosen: parts of halves reach [`Self::min_part_variables`] far earlier, so it only bounds uneven cuts.
    pub max_depth: u8,
}

impl Default for DissectionConfig {
    fn default() -> Self {
        Self {
            min_variables: 8_000,
            min_part_variables: 96,
            min_smaller_share: 0.3,
            min_variables_per_separator_variable: 4,
            max_depth: 24,
        }
    }
}

const NONE: u32 = u32::MAX;

/// Groups for [`super::ordering::minimum_degree`]: 0 inside the parts, then the separators. The separator of the first cut comes last.
pub fn groups(graph: &Adjacency, config: &DissectionConfig) -> Vec<u8> {
    let mut search =
        Search { config: *config, graph, part: vec![0; graph.len()], level: vec![NONE; graph.len()] };
    let mut groups = vec![0; graph.len()];
    let mut parts = 1;
    let mut waiting: Vec<(Vec<u32>, u8)> = vec![((0..graph.len() as u32).collect(), 0)];
    while let Some((variables, depth)) = waiting.pop() {
        if variables.len() < config.min_part_variables || depth == config.max_depth {
            continue;
        }
        let Some(cut) = search.cut(&variables) else { continue };
        for &variable in &cut.separator {
            groups[variable as usize] = config.max_depth - depth;
            search.part[variable as usize] = NONE;
        }
        for side in [cut.below, cut.above, cut.unreached] {
            if side.is_empty() {
                continue;
            }
            for &variable in &side {
                search.part[variable as usize] = parts;
            }
            parts += 1;
            waiting.push((side, depth + 1));
        }
    }
    groups
}

struct Cut {
    separator: Vec<u32>,
    below: Vec<u32>,
    above: Vec<u32>,
    /// Variables that the search did not reach: other connected components.
    unreached: Vec<u32>,
}

struct Search<'a> {
    config: DissectionConfig,
    graph: &'a Adjacency,
    part: Vec<u32>,
    level: Vec<u32>,
}

impl Search<'_> {
    /// Visits the component of `start` within its part. Returns its variables in breadth-first order.
    fn visit(&mut self, start: u32, variables: &[u32]) -> Vec<u32> {
        for &variable in variables {
            self.level[variable as usize] = NONE;
        }
        let part = self.part[start as usize];
        self.level[start as usize] = 0;
        let mut order = vec![start];
        let mut next = 0;
        while let Some(&variable) = order.get(next) {
            next += 1;
            for &other in self.graph.of(variable as usize) {
                if self.part[other as usize] == part && self.level[other as usize] == NONE {
                    self.level[other as usize] = self.level[variable as usize] + 1;
                    order.push(other);
                }
            }
        }
        order
    }

    fn cut(&mut self, variables: &[u32]) -> Option<Cut> {
        // Two searches, each from the farthest variable of the last one, give nearly a longest shortest path.
        let mut order = self.visit(*variables.first()?, variables);
        for _ in 0..2 {
            order = self.visit(*order.last()?, variables);
        }
        let count = order.len();
        let levels = self.level[*order.last()? as usize] + 1;
        let ends: Vec<usize> = (0..levels)
            .map(|level| order.partition_point(|&variable| self.level[variable as usize] <= level))
            .collect();
        let mut best: Option<(f64, u32, Vec<u32>)> = None;
        for (level, &end) in ends.iter().enumerate() {
            let smaller = end.min(count - end) as f64 / count as f64;
            if smaller < self.config.min_smaller_share {
                continue;
            }
            let first = if level == 0 { 0 } else { ends[level - 1] };
            let cover = self.cover(&order[first..end]);
            // A smaller separator may outweigh a small imbalance.
            let price = cover.len() as f64 / (smaller * (1.0 - smaller));
            if best.as_ref().is_none_or(|(least, _, _)| price < *least) {
                best = Some((price, level as u32, cover));
            }
        }
        let (_, level, separator) = best?;
        if separator.len() * self.config.min_variables_per_separator_variable > count {
            return None;
        }
        let inside = |variable: &&u32| separator.binary_search(variable).is_err();
        let (below, above): (Vec<u32>, Vec<u32>) =
            order.iter().filter(inside).partition(|&&variable| self.level[variable as usize] <= level);
        let unreached =
            variables.iter().copied().filter(|&variable| self.level[variable as usize] == NONE).collect();
        Some(Cut { separator, below, above, unreached })
    }

    /// The fewest variables that touch every edge from `level_set` to the level above, ascending.
    fn cover(&self, level_set: &[u32]) -> Vec<u32> {
        let up = |variable: u32| {
            let level = self.level[variable as usize] + 1;
            let part = self.part[variable as usize];
            let next = move |&&other: &&u32| {
                self.part[other as usize] == part && self.level[other as usize] == level
            };
            self.graph.of(variable as usize).iter().filter(next).copied()
        };
        // Right vertices, numbered by their index in a sorted list.
        let mut right: Vec<u32> = level_set.iter().flat_map(|&variable| up(variable)).collect();
        right.sort_unstable();
        right.dedup();
        let edges: Vec<Vec<u32>> = level_set
            .iter()
            .map(|&variable| {
                up(variable).filter_map(|other| right.binary_search(&other).ok().map(|i| i as u32)).collect()
            })
            .collect();
        let matching = Matching::new(edges, right.len());
        matching.cover(level_set, &right)
    }
}

/// A maximum matching of a bipartite graph.
struct Matching {
    edges: Vec<Vec<u32>>,
    left: Vec<u32>,
    right: Vec<u32>,
}

impl Matching {
    fn new(edges: Vec<Vec<u32>>, right: usize) -> Self {
        let mut matching = Self { left: vec![NONE; edges.len()], right: vec![NONE; right], edges };
        let mut seen = vec![NONE; right];
        for start in 0..matching.left.len() {
            matching.augment(start as u32, &mut seen);
        }
        matching
    }

    /// Searches an augmenting path from a free left vertex. `seen` holds, for each right vertex, the start that last visited it.
    fn augment(&mut self, start: u32, seen: &mut [u32]) {
        let mut came_from: Vec<(u32, u32)> = Vec::new();
        let mut waiting = vec![start];
        while let Some(left) = waiting.pop() {
            for &right in &self.edges[left as usize] {
                if std::mem::replace(&mut seen[right as usize], start) == start {
                    continue;
                }
                came_from.push((right, left));
                let next = self.right[right as usize];
                if next != NONE {
                    waiting.push(next);
                    continue;
                }
                // A free right vertex ends the path: flip the path back to its start.
                let mut right = right;
                while right != NONE {
                    let Some(&(_, left)) = came_from.iter().find(|(to, _)| *to == right) else { return };
                    self.right[right as usize] = left;
                    right = std::mem::replace(&mut self.left[left as usize], right);
                }
                return;
            }
        }
    }

    /// Minimum vertex cover: left vertices not reached, and right vertices reached, by alternating paths from free left vertices.
    fn cover(&self, left_names: &[u32], right_names: &[u32]) -> Vec<u32> {
        let mut left_seen = vec![false; self.left.len()];
        let mut right_seen = vec![false; self.right.len()];
        let mut waiting: Vec<u32> =
            (0..self.left.len() as u32).filter(|&left| self.left[left as usize] == NONE).collect();
        while let Some(left) = waiting.pop() {
            if std::mem::replace(&mut left_seen[left as usize], true) {
                continue;
            }
            for &right in &self.edges[left as usize] {
                if !std::mem::replace(&mut right_seen[right as usize], true)
                    && self.right[right as usize] != NONE
                {
                    waiting.push(self.right[right as usize]);
                }
            }
        }
        let left = left_names.iter().zip(&left_seen).filter(|(_, seen)| !**seen).map(|(name, _)| *name);
        let right = right_names.iter().zip(&right_seen).filter(|(_, seen)| **seen).map(|(name, _)| *name);
        let mut cover: Vec<u32> = left.chain(right).collect();
        cover.sort_unstable();
        cover
    }
}
