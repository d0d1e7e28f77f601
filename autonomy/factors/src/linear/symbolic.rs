//! Symbolic analysis: from an elimination order to a forest of clusters, which eliminate several variables together.
//!
//! A cluster eliminates its *frontal* variables and adds a Schur complement over its *separator* to its parent. Clusters are the supernodes of a
//! sparse Cholesky factorisation and the cliques of a Bayes tree. Clusters whose columns have the same rows are merged. Clusters that would gain
//! few zeros are merged, too, because larger dense blocks run faster.

use super::ordering::Adjacency;

/// Variables that are eliminated together.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cluster {
    /// Variables eliminated in this cluster, in this order.
    pub frontal: Vec<u32>,
    /// Variables that they are conditioned on, in elimination order.
    pub separator: Vec<u32>,
    /// The cluster that eliminates the first variable of the separator. `None` for a root.
    pub parent: Option<u32>,
    /// Clusters whose parent this is, ascending.
    pub children: Vec<u32>,
}

/// Clusters, children before parents.
#[derive(Clone, Debug, Default)]
pub struct Forest {
    /// In the order of processing.
    pub clusters: Vec<Cluster>,
    /// The cluster that eliminates each variable.
    pub cluster_of: Vec<u32>,
    /// Rank of each variable in the elimination order.
    pub rank: Vec<u32>,
}

/// Parameters of the merging of clusters: which share of the stored entries may be zeros, by the number of columns of the merged cluster. They change the
/// time of a solve, not its result. Such classes of width are those of the relaxed supernodes of CHOLMOD (Chen, Davis, Hager, Rajamanickam, *Algorithm 887*,
/// ACM TOMS 35, 2008); the values are chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ClusterMergeConfig {
    /// Most columns of a narrow cluster. Chosen: four poses of six columns; such fronts are small whatever they hold.
    max_narrow_columns: usize,
    /// Share of zeros that a narrow cluster may have. Chosen: half, because small fronts cost more to gather than to compute.
    max_narrow_zeros_share: f64,
    /// Most columns of a medium cluster. Chosen: twice [`Self::max_narrow_columns`], a class between both.
    max_medium_columns: usize,
    /// Share of zeros that a medium cluster may have. Chosen: between the shares of narrow and of wide clusters.
    max_medium_zeros_share: f64,
    /// Most columns of a wide cluster. Chosen: twice [`Self::max_medium_columns`].
    max_wide_columns: usize,
    /// Share of zeros that a wide cluster may have. Chosen: between the shares of medium and of the widest clusters.
    max_wide_zeros_share: f64,
    /// Share of zeros that any wider cluster may have. Chosen: near none, because zeros of wide clusters cost most.
    max_widest_zeros_share: f64,
}

impl Default for ClusterMergeConfig {
    fn default() -> Self {
        Self {
            max_narrow_columns: 24,
            max_narrow_zeros_share: 0.5,
            max_medium_columns: 48,
            max_medium_zeros_share: 0.2,
            max_wide_columns: 96,
            max_wide_zeros_share: 0.06,
            max_widest_zeros_share: 0.02,
        }
    }
}

impl ClusterMergeConfig {
    /// Share of stored entries that may be zeros in a merged cluster, by its number of columns.
    fn max_zeros_share(&self, columns: usize) -> f64 {
        if columns <= self.max_narrow_columns {
            self.max_narrow_zeros_share
        } else if columns <= self.max_medium_columns {
            self.max_medium_zeros_share
        } else if columns <= self.max_wide_columns {
            self.max_wide_zeros_share
        } else {
            self.max_widest_zeros_share
        }
    }
}

#[derive(Default)]
struct Building {
    frontal: Vec<u32>,
    separator: Vec<u32>,
    /// Number of frontal scalars.
    columns: usize,
    rows_below: usize,
    /// Zeros stored because of merging.
    zeros: usize,
    children: Vec<u32>,
    merged: bool,
}

/// Clusters for `graph` eliminated in `order`. `dimensions` are the scalars of each variable. Variables of different `parts` never share a
/// cluster. An empty slice means one part.
///
/// Cost: proportional to the number of blocks in the factor.
pub fn analyse(graph: &Adjacency, order: &[u32], dimensions: &[u8], parts: &[u8]) -> Forest {
    let mut rank = vec![0_u32; graph.len()];
    for (place, &variable) in order.iter().enumerate() {
        rank[variable as usize] = place as u32;
    }
    let part = |variable: u32| parts.get(variable as usize).copied().unwrap_or(0);
    let mut clusters = eliminate(graph, order, &rank, dimensions, part);
    merge_for_size(&ClusterMergeConfig::default(), &mut clusters, &rank, part);
    finish(clusters, graph.len())
}

/// One cluster per variable. But a variable joins a child whose separator consists of this variable and its own separator.
fn eliminate(
    graph: &Adjacency,
    order: &[u32],
    rank: &[u32],
    dimensions: &[u8],
    part: impl Fn(u32) -> u8,
) -> Vec<Building> {
    let len = order.len();
    let mut clusters: Vec<Building> = Vec::with_capacity(len);
    // Clusters whose first separator variable is this one.
    let mut waiting: Vec<Vec<u32>> = vec![Vec::new(); len];
    let mut mark = vec![u32::MAX; len];
    for (place, &variable) in order.iter().enumerate() {
        mark[variable as usize] = place as u32;
        let mut separator: Vec<u32> = Vec::new();
        let mut add = |other: u32| {
            if mark[other as usize] != place as u32 {
                mark[other as usize] = place as u32;
                separator.push(other);
            }
        };
        graph
            .of(variable as usize)
            .iter()
            .filter(|&&other| rank[other as usize] > place as u32)
            .for_each(|&other| add(other));
        let children = std::mem::take(&mut waiting[variable as usize]);
        for &child in &children {
            clusters[child as usize].separator.iter().for_each(|&other| add(other));
        }
        separator.sort_unstable_by_key(|&other| rank[other as usize]);
        let heir = children.iter().position(|&child| {
            let child = &clusters[child as usize];
            child.separator.len() == separator.len() + 1 && part(child.frontal[0]) == part(variable)
        });
        let scalars = usize::from(dimensions[variable as usize]);
        let below = separator.iter().map(|&other| usize::from(dimensions[other as usize])).sum();
        let first = separator.first().copied();
        let index = match heir {
            Some(position) => {
                let index = children[position];
                let cluster = &mut clusters[index as usize];
                cluster.frontal.push(variable);
                cluster.separator = separator;
                cluster.columns += scalars;
                cluster.rows_below = below;
                cluster.children.extend(children.iter().filter(|&&child| child != index));
                index
            }
            None => {
                clusters.push(Building {
                    frontal: vec![variable],
                    separator,
                    columns: scalars,
                    rows_below: below,
                    children,
                    ..Building::default()
                });
                clusters.len() as u32 - 1
            }
        };
        if let Some(first) = first {
            waiting[first as usize].push(index);
        }
    }
    clusters
}

/// Merges children into their parents where that stores few zeros, starting at the leaves.
fn merge_for_size(
    config: &ClusterMergeConfig,
    clusters: &mut [Building],
    rank: &[u32],
    part: impl Fn(u32) -> u8,
) {
    // Sorted by the last frontal variable, so that children come before their parents.
    let mut sequence: Vec<u32> = (0..clusters.len() as u32).collect();
    let last = |cluster: &Building| cluster.frontal.last().map_or(0, |&variable| rank[variable as usize]);
    sequence.sort_unstable_by_key(|&index| last(&clusters[index as usize]));
    for index in sequence {
        let mut waiting = std::mem::take(&mut clusters[index as usize].children);
        // Children with the most rows below come first. They add the fewest zeros and leave room for the others.
        waiting.sort_by_key(|&child| (std::cmp::Reverse(clusters[child as usize].rows_below), child));
        let mut kept = Vec::new();
        let mut absorbed: Vec<u32> = Vec::new();
        for child in waiting {
            let (parent, candidate) = (&clusters[index as usize], &clusters[child as usize]);
            let height = parent.columns + parent.rows_below;
            let zeros = parent.zeros + candidate.zeros + candidate.columns * (height - candidate.rows_below);
            let columns = parent.columns + candidate.columns;
            let entries = columns * (columns + 1) / 2 + columns * parent.rows_below;
            let apart = part(parent.frontal[0]) != part(candidate.frontal[0]);
            if apart || (zeros as f64) > config.max_zeros_share(columns) * entries as f64 {
                kept.push(child);
                continue;
            }
            let candidate = &mut clusters[child as usize];
            candidate.merged = true;
            kept.append(&mut candidate.children);
            absorbed.append(&mut candidate.frontal);
            let parent = &mut clusters[index as usize];
            parent.columns = columns;
            parent.zeros = zeros;
        }
        let parent = &mut clusters[index as usize];
        absorbed.append(&mut parent.frontal);
        parent.frontal = absorbed;
        parent.children = kept;
    }
}

/// Numbers clusters and variables in depth-first order, children first.
fn finish(mut building: Vec<Building>, variables: usize) -> Forest {
    let mut is_child = vec![false; building.len()];
    for cluster in building.iter().filter(|cluster| !cluster.merged) {
        for &child in &cluster.children {
            is_child[child as usize] = true;
        }
    }
    let mut forest = Forest {
        clusters: Vec::with_capacity(building.len()),
        cluster_of: vec![0; variables],
        rank: vec![0; variables],
    };
    let mut place = 0;
    let roots: Vec<usize> =
        (0..building.len()).filter(|&index| !building[index].merged && !is_child[index]).collect();
    for root in roots {
        // Each entry: a cluster and the final numbers of its finished children.
        let mut stack: Vec<(usize, Vec<u32>)> = vec![(root, Vec::new())];
        while let Some((index, mut done)) = stack.pop() {
            if let Some(child) = building[index].children.pop() {
                stack.push((index, done));
                stack.push((child as usize, Vec::new()));
                continue;
            }
            let number = forest.clusters.len() as u32;
            done.sort_unstable();
            for &child in &done {
                forest.clusters[child as usize].parent = Some(number);
            }
            let source = &mut building[index];
            for &variable in &source.frontal {
                forest.cluster_of[variable as usize] = number;
                forest.rank[variable as usize] = place;
                place += 1;
            }
            forest.clusters.push(Cluster {
                frontal: std::mem::take(&mut source.frontal),
                separator: std::mem::take(&mut source.separator),
                parent: None,
                children: done,
            });
            if let Some((_, siblings)) = stack.last_mut() {
                siblings.push(number);
            }
        }
    }
    let rank = &forest.rank;
    for cluster in &mut forest.clusters {
        cluster.separator.sort_unstable_by_key(|&variable| rank[variable as usize]);
    }
    forest
}
