//! Where a person would click to make inspection points: on walls and machines beside the nodes, in the map from above.

use crate::support::page::At;
use crate::support::picture::Picture;

/// Distances from a node at which walls are looked for, CSS pixels.
const REACH_PX: [f64; 2] = [22.0, 120.0];
/// Step of the distances, CSS pixels, and number of directions.
const STEP_PX: f64 = 3.0;
const DIRECTIONS: u32 = 32;
/// Least distance between two targets, CSS pixels.
const APART_PX: f64 = 26.0;
/// Least distance between a target and the markers of nodes, CSS pixels.
const BESIDE_NODES_PX: f64 = 16.0;

/// Places on walls, each beside another node as long as there are any.
pub(super) struct WallTargets {
    picture: Picture,
    nodes: Vec<At>,
    /// The node beside which the next one is looked for.
    next_node: usize,
    given: Vec<At>,
}

impl WallTargets {
    pub(super) fn new(picture: Picture, nodes: Vec<At>) -> Self {
        Self { picture, nodes, next_node: 0, given: Vec::new() }
    }

    /// The nearest wall to a node that is apart from the targets before it.
    fn beside(&self, node: At) -> Option<At> {
        let [nearest, farthest] = REACH_PX;
        let rings = ((farthest - nearest) / STEP_PX) as u32;
        (0..rings)
            .flat_map(|ring| (0..DIRECTIONS).map(move |direction| (ring, direction)))
            .map(|(ring, direction)| {
                let angle = f64::from(direction) / f64::from(DIRECTIONS) * std::f64::consts::TAU;
                let reach = nearest + STEP_PX * f64::from(ring);
                At { x: (node.x + reach * angle.cos()).round(), y: (node.y + reach * angle.sin()).round() }
            })
            .find(|at| self.is_wall(*at) && self.is_apart(*at))
    }

    /// Whether the place and most pixels around it look like a wall, inside the part of the scene that no card covers.
    fn is_wall(&self, at: At) -> bool {
        let is_free = super::is_free(at, self.picture.page_size());
        let around = (-1..=1).flat_map(|x| (-1..=1).map(move |y| (x, y)));
        let walls =
            around.filter(|(x, y)| self.picture.shows_wall(at.x + f64::from(*x), at.y + f64::from(*y)));
        is_free && walls.count() >= 8
    }

    fn is_apart(&self, at: At) -> bool {
        let far =
            |others: &[At], apart: f64| others.iter().all(|it| (it.x - at.x).hypot(it.y - at.y) >= apart);
        far(&self.given, APART_PX) && far(&self.nodes, BESIDE_NODES_PX)
    }
}

impl Iterator for WallTargets {
    type Item = At;

    fn next(&mut self) -> Option<At> {
        for _ in 0..self.nodes.len() {
            let node = self.nodes[self.next_node % self.nodes.len()];
            self.next_node += 1;
            if let Some(target) = self.beside(node) {
                self.given.push(target);
                return Some(target);
            }
        }
        None
    }
}
