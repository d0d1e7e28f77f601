//! Nodes and edges of the paths: nodes where paths meet or end, where they bend, and at regular distances.

use crate::corridor::Passage;
use crate::path_graph::{BlockedSegment, LinkKind, PathGraph, PlaceKind};
use geometry::Vector3;
use std::collections::{BTreeMap, BTreeSet};

/// A straight edge between two places of the graph, the smaller number first.
pub(crate) type StraightEdges = BTreeMap<(usize, usize), LinkKind>;

/// The edges of a graph of paths. Each is straight, free, and near the paths that it stands for.
pub(crate) fn straight_edges(graph: &PathGraph, passage: &Passage<'_>) -> StraightEdges {
    let mut edges = StraightEdges::new();
    let is_node = |place: usize| {
        graph.places[place].kind != PlaceKind::Plain
            || graph.links[place].len() != 2
            || graph.links[place].values().any(|link| link.kind != LinkKind::Walk)
    };
    let mut done: BTreeSet<usize> = BTreeSet::new();
    for node in (0..graph.places.len()).filter(|place| is_node(*place)) {
        for (next, link) in &graph.links[node] {
            if link.kind != LinkKind::Walk {
                insert(&mut edges, node, *next, link.kind);
            } else if !done.contains(next) || is_node(*next) {
                let chain = chain(graph, node, *next, &is_node);
                done.extend(&chain[1..chain.len() - 1]);
                add_chain(&mut edges, graph, passage, &chain);
            }
        }
    }
    // What is left are rings without any node.
    for place in 0..graph.places.len() {
        if let Some(next) =
            graph.links[place].keys().next().filter(|_| !is_node(place) && !done.contains(&place))
        {
            let chain = chain(graph, place, *next, &|other| other == place);
            done.extend(&chain);
            add_chain(&mut edges, graph, passage, &chain);
        }
    }
    edges
}

/// Makes one node of two that are joined by an edge shorter than [`crate::TopomapConfig::node_merge_m`], the shortest edge first, where all other edges of
/// the node that goes stay free.
pub(crate) fn merge_near_nodes(edges: &mut StraightEdges, graph: &PathGraph, passage: &Passage<'_>) {
    while let Some((keep, gone)) = mergeable(edges, graph, passage) {
        for next in neighbours(edges, gone) {
            edges.remove(&(gone.min(next), gone.max(next)));
            if next != keep {
                insert(edges, keep, next, LinkKind::Walk);
            }
        }
    }
}

/// The two nodes to merge next: the one that stays, and the one that goes.
fn mergeable(edges: &StraightEdges, graph: &PathGraph, passage: &Passage<'_>) -> Option<(usize, usize)> {
    let config = &passage.floor.config;
    let length_m = |a: usize, b: usize| (graph.feet(a) - graph.feet(b)).norm();
    let mut short: Vec<(f64, usize, usize)> = edges
        .iter()
        .filter(|(_, kind)| **kind == LinkKind::Walk)
        .map(|(&(a, b), _)| (length_m(a, b), a, b))
        .filter(|(length_m, ..)| *length_m < config.node_merge_m)
        .collect();
    short.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    let can_go = |keep: usize, gone: usize| {
        // Dead ends stay: the robot has been there for a reason.
        graph.places[gone].kind == PlaceKind::Plain
            && neighbours(edges, gone).len() > 1
            && neighbours(edges, gone).into_iter().filter(|next| *next != keep).all(|next| {
                let is_joined = edges.contains_key(&(keep.min(next), keep.max(next)));
                let is_short = length_m(keep, next) <= config.node_spacing_m + config.node_merge_m;
                is_joined || is_short && passage.is_free(&graph.feet(keep), &graph.feet(next))
            })
    };
    short.into_iter().find_map(|(_, a, b)| {
        // The node with more edges stays.
        let degree = |node: usize| neighbours(edges, node).len();
        let order = if degree(a) >= degree(b) { [(a, b), (b, a)] } else { [(b, a), (a, b)] };
        order.into_iter().find(|(keep, gone)| can_go(*keep, *gone))
    })
}

fn neighbours(edges: &StraightEdges, node: usize) -> Vec<usize> {
    let other = |(a, b): &(usize, usize)| match node {
        n if n == *a => Some(*b),
        n if n == *b => Some(*a),
        _ => None,
    };
    edges.keys().filter_map(other).collect()
}

/// Whether an edge leads past both ends of a blocked stretch, within a distance of them.
pub(crate) fn has_edge_past(
    edges: &StraightEdges,
    graph: &PathGraph,
    blocked: &BlockedSegment,
    within_m: f64,
) -> bool {
    edges.keys().any(|&(a, b)| {
        let (from, span) = (graph.feet(a), graph.feet(b) - graph.feet(a));
        [blocked.from_m, blocked.to_m].iter().all(|at| {
            let share = (at - from).dot(&span) / span.norm_squared().max(1e-9);
            (0.0..=1.0).contains(&share) && (at - from - span * share).norm() <= within_m
        })
    })
}

fn insert(edges: &mut StraightEdges, a: usize, b: usize, kind: LinkKind) {
    edges.entry((a.min(b), a.max(b))).or_insert(kind);
}

/// The places from a node by its neighbour to the next node.
fn chain(graph: &PathGraph, from: usize, next: usize, is_node: &impl Fn(usize) -> bool) -> Vec<usize> {
    let mut chain = vec![from, next];
    while !is_node(chain[chain.len() - 1]) {
        let (before, at) = (chain[chain.len() - 2], chain[chain.len() - 1]);
        let Some(next) = graph.links[at].keys().copied().find(|next| *next != before) else { break };
        chain.push(next);
    }
    chain
}

/// Adds the edges of a chain of places.
fn add_chain(edges: &mut StraightEdges, graph: &PathGraph, passage: &Passage<'_>, chain: &[usize]) {
    let feet: Vec<Vector3> = chain.iter().map(|place| graph.feet(*place)).collect();
    let mut corners = vec![0];
    split_at_bends(&feet, passage, 0, feet.len() - 1, &mut corners);
    let mut stops = vec![0];
    for pair in corners.windows(2) {
        split_evenly(&feet, passage, pair[0], pair[1], &mut stops);
    }
    for pair in stops.windows(2) {
        insert(edges, chain[pair[0]], chain[pair[1]], LinkKind::Walk);
    }
}

/// Whether the straight line from one place of a chain to another can stand for the part between them.
fn is_straight(feet: &[Vector3], passage: &Passage<'_>, first: usize, last: usize) -> bool {
    last == first + 1
        || (farthest(feet, first, last).1 <= passage.floor.config.max_deviation_m
            && (feet[first] - feet[last]).norm() > 1e-6
            && passage.is_free(&feet[first], &feet[last]))
}

/// The place of a part of a chain that is farthest from the straight line between its ends, and that distance, metres.
fn farthest(feet: &[Vector3], first: usize, last: usize) -> (usize, f64) {
    let (a, span) = (feet[first], feet[last] - feet[first]);
    let distance_m = |at: &Vector3| {
        let share = ((at - a).dot(&span) / span.norm_squared().max(1e-9)).clamp(0.0, 1.0);
        (at - a - span * share).norm()
    };
    let inner = (first + 1..last).map(|index| (index, distance_m(&feet[index])));
    inner.fold((usize::midpoint(first, last), 0.0), |best, next| if next.1 > best.1 { next } else { best })
}

/// Adds the indices at which a chain bends, and its end (Douglas and Peucker, 1973).
fn split_at_bends(
    feet: &[Vector3],
    passage: &Passage<'_>,
    first: usize,
    last: usize,
    corners: &mut Vec<usize>,
) {
    if is_straight(feet, passage, first, last) {
        corners.push(last);
        return;
    }
    let (index, distance_m) = farthest(feet, first, last);
    // A straight part that is not free is halved.
    let index =
        if distance_m > passage.floor.config.min_bend_m { index } else { usize::midpoint(first, last) };
    split_at_bends(feet, passage, first, index, corners);
    split_at_bends(feet, passage, index, last, corners);
}

/// Adds the indices that divide a straight part of a chain into pieces of equal length, and its end.
fn split_evenly(feet: &[Vector3], passage: &Passage<'_>, first: usize, last: usize, stops: &mut Vec<usize>) {
    let length_m = (feet[last] - feet[first]).norm();
    let pieces = (length_m / passage.floor.config.node_spacing_m).ceil().max(1.0) as usize;
    let mut at = first;
    for piece in 1..pieces {
        let wanted = feet[first].lerp(&feet[last], piece as f64 / pieces as f64);
        let offset = |index: &usize| (feet[*index] - wanted).norm();
        let nearest = (at + 1..last).min_by(|a, b| offset(a).total_cmp(&offset(b)));
        if let Some(next) = nearest {
            split_at_bends(feet, passage, at, next, stops);
            at = next;
        }
    }
    split_at_bends(feet, passage, at, last, stops);
}
