//! Elimination orders are permutations, respect groups, and cause little fill on graphs with a known answer.

use super::dissection::{self, DissectionConfig};
use super::ordering::{Adjacency, minimum_degree};
use geometry::RngTree;
use std::collections::BTreeSet;

/// Number of entries below the factor's diagonal, found by symbolic elimination.
fn fill(graph: &Adjacency, order: &[u32]) -> usize {
    let mut neighbours: Vec<BTreeSet<u32>> =
        (0..graph.len()).map(|variable| graph.of(variable).iter().copied().collect()).collect();
    let mut total = 0;
    for &pivot in order {
        let clique: Vec<u32> = std::mem::take(&mut neighbours[pivot as usize]).into_iter().collect();
        total += clique.len();
        for &a in &clique {
            neighbours[a as usize].remove(&pivot);
            neighbours[a as usize].extend(clique.iter().filter(|&&b| b != a));
        }
    }
    total
}

fn is_permutation(order: &[u32]) -> bool {
    let mut sorted = order.to_vec();
    sorted.sort_unstable();
    sorted.iter().enumerate().all(|(index, &value)| index == value as usize)
}

fn grid(side: u32) -> Adjacency {
    let mut edges = Vec::new();
    for y in 0..side {
        for x in 0..side {
            let here = y * side + x;
            if x + 1 < side {
                edges.push([here, here + 1]);
            }
            if y + 1 < side {
                edges.push([here, here + side]);
            }
        }
    }
    Adjacency::from_cliques((side * side) as usize, edges.iter().map(|edge| edge.as_slice()))
}

#[test]
fn a_tree_has_no_fill_and_a_grid_less_than_half_of_the_natural_order() {
    let mut rng = RngTree::new(5).child("tree").rng();
    let edges: Vec<[u32; 2]> =
        (1..300).map(|child| [(rng.uniform() * f64::from(child)) as u32, child]).collect();
    let tree = Adjacency::from_cliques(300, edges.iter().map(|edge| edge.as_slice()));
    let order = minimum_degree(&tree, &[]);
    assert!(is_permutation(&order));
    assert_eq!(fill(&tree, &order), 299);

    let grid = grid(30);
    let order = minimum_degree(&grid, &[]);
    assert!(is_permutation(&order));
    let natural: Vec<u32> = (0..900).collect();
    let (ours, banded) = (fill(&grid, &order), fill(&grid, &natural));
    // The natural order gives 26,000 entries, minimum degree about 10,000.
    assert!(ours < banded / 2, "{ours} against {banded}");
}

#[test]
fn lower_groups_are_eliminated_first() {
    let grid = grid(20);
    let groups: Vec<u8> = (0..400).map(|variable| u8::from(variable % 7 == 0) * 2).collect();
    let order = minimum_degree(&grid, &groups);
    assert!(is_permutation(&order));
    assert!(order.windows(2).all(|pair| groups[pair[0] as usize] <= groups[pair[1] as usize]));
    assert_eq!(order, minimum_degree(&grid, &groups));
}

#[test]
fn isolated_variables_and_empty_graphs_are_ordered() {
    assert!(minimum_degree(&Adjacency::from_cliques(0, [].into_iter()), &[]).is_empty());
    let cliques: [&[u32]; 3] = [&[1, 1], &[3, 4, 4, 5], &[2]];
    let graph = Adjacency::from_cliques(6, cliques.into_iter());
    assert_eq!(graph.of(4), [3, 5]);
    assert!(is_permutation(&minimum_degree(&graph, &[])));
}

#[test]
fn dissection_splits_a_ring_into_small_disconnected_parts() {
    // Eight parallel tracks around a ring, like a patrol that repeats the same round.
    let (round, strands) = (200, 8);
    let name = |place: u32, strand: u32| (place % round) + round * strand;
    let mut edges: Vec<[u32; 2]> = Vec::new();
    for strand in 0..strands {
        for place in 0..round {
            edges.push([name(place, strand), name(place + 1, strand)]);
            if (place + strand) % 3 == 0 {
                edges.push([name(place, strand), name(place, (strand + 1) % strands)]);
            }
        }
    }
    let graph = Adjacency::from_cliques((round * strands) as usize, edges.iter().map(|edge| edge.as_slice()));
    let groups = dissection::groups(&graph, &DissectionConfig::default());
    let order = minimum_degree(&graph, &groups);
    assert!(is_permutation(&order));
    // The first cut takes two cross-sections of the ring.
    let last = groups.iter().copied().max().unwrap();
    let first_cut = groups.iter().filter(|&&group| group == last).count();
    assert!((2 * strands as usize..=3 * strands as usize).contains(&first_cut), "{first_cut}");
    // The variables outside separators form parts, each smaller than half the ring.
    let mut seen: Vec<bool> = groups.iter().map(|&group| group > 0).collect();
    let mut largest = 0;
    for start in 0..graph.len() {
        let mut waiting = vec![start as u32];
        let mut size = 0;
        while let Some(variable) = waiting.pop() {
            if !std::mem::replace(&mut seen[variable as usize], true) {
                size += 1;
                waiting.extend(graph.of(variable as usize));
            }
        }
        largest = largest.max(size);
    }
    assert!(largest < 200, "{largest}");
    assert!(fill(&graph, &order) < 2 * fill(&graph, &minimum_degree(&graph, &[])));
}
