//! Positions of keyframes in a grid, to find the nearest one without a look at all of them.

use messages::GraphNode;
use std::collections::HashMap;
use vocab::{KeyframeId, Vec3};

/// Parameters of [`KeyframeGrid`].
#[derive(Clone, Copy, Debug, PartialEq)]
struct KeyframeGridConfig {
    /// Edge of a cell, metres. Keyframes are about a metre apart along a walk, so a cell of a walk holds some two.
    cell_m: f64,
    /// Cells round that of a position that are searched before all keyframes are. Chosen: 4 to 6 m; most positions that are asked lie on or beside the walk.
    max_rings: i64,
}

impl Default for KeyframeGridConfig {
    fn default() -> Self {
        Self { cell_m: 2.0, max_rings: 2 }
    }
}

/// Positions of keyframes, map frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct KeyframeGrid {
    positions: HashMap<KeyframeId, Vec3>,
    cells: HashMap<[i64; 3], Vec<KeyframeId>>,
}

impl KeyframeGrid {
    /// Adds keyframes, and moves those that it holds. Linear in their number.
    pub fn update(&mut self, nodes: &[GraphNode]) {
        for node in nodes {
            let position = node.map_from_keyframe.position;
            if let Some(before) = self.positions.insert(node.id, position)
                && let Some(cell) = self.cells.get_mut(&cell_of(before))
            {
                cell.retain(|keyframe| *keyframe != node.id);
            }
            self.cells.entry(cell_of(position)).or_default().push(node.id);
        }
    }

    /// The keyframe nearest to a position; of several that are equally near, the first. None if there are no keyframes. Constant time at up to 4 m from
    /// the nearest keyframe, linear in the keyframes beyond.
    pub fn nearest(&self, at: Vec3) -> Option<KeyframeId> {
        let config = KeyframeGridConfig::default();
        let centre = cell_of(at);
        let mut found: Option<(f64, KeyframeId)> = None;
        for ring in 0..=config.max_rings {
            let keyframes = ring_cells(centre, ring).filter_map(|cell| self.cells.get(&cell)).flatten();
            found = nearer(found, self.nearest_of(at, keyframes));
            // Cells beyond this ring are at least that far away.
            let searched_m = ring as f64 * config.cell_m;
            if let Some((squared_distance_m2, keyframe)) = found
                && squared_distance_m2 < searched_m * searched_m
            {
                return Some(keyframe);
            }
        }
        self.nearest_of(at, self.positions.keys()).map(|(_, keyframe)| keyframe)
    }

    /// The nearest of some keyframes, with the square of its distance.
    fn nearest_of<'a>(
        &self,
        at: Vec3,
        keyframes: impl Iterator<Item = &'a KeyframeId>,
    ) -> Option<(f64, KeyframeId)> {
        keyframes
            .filter_map(|keyframe| Some((squared_distance(*self.positions.get(keyframe)?, at), *keyframe)))
            .fold(None, |found, next| nearer(found, Some(next)))
    }
}

fn nearer(a: Option<(f64, KeyframeId)>, b: Option<(f64, KeyframeId)>) -> Option<(f64, KeyframeId)> {
    [a, b].into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
}

fn squared_distance(a: Vec3, b: Vec3) -> f64 {
    let [x, y, z] = [a.x - b.x, a.y - b.y, a.z - b.z];
    x * x + y * y + z * z
}

/// Positions that are not finite share cells with others; their distances are still right.
fn cell_of(position: Vec3) -> [i64; 3] {
    let cell_m = KeyframeGridConfig::default().cell_m;
    [position.x, position.y, position.z].map(|c| (c / cell_m).floor() as i64)
}

/// The cells whose greatest offset from a cell along an axis is `ring`.
fn ring_cells(centre: [i64; 3], ring: i64) -> impl Iterator<Item = [i64; 3]> {
    let offsets = move || -ring..=ring;
    offsets()
        .flat_map(move |x| offsets().flat_map(move |y| offsets().map(move |z| [x, y, z])))
        .filter(move |offset| offset.iter().any(|o| o.abs() == ring))
        .map(move |[x, y, z]| {
            [centre[0].saturating_add(x), centre[1].saturating_add(y), centre[2].saturating_add(z)]
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use vocab::{Pose, Stamp};

    fn node(id: u32, position: Vec3) -> GraphNode {
        let map_from_keyframe = Pose { position, ..Pose::IDENTITY };
        GraphNode { id: KeyframeId(id), stamp: Stamp::from_nanos(0), map_from_keyframe }
    }

    /// Spread over 40 m x 30 m x 4 m by a low-discrepancy sequence.
    fn position(index: u32) -> Vec3 {
        let along = |ratio: f64, length_m: f64| (f64::from(index) * ratio).fract() * length_m - 10.0;
        Vec3::new(along(0.754_877_67, 40.0), along(0.569_840_29, 30.0), along(0.430_159_71, 4.0))
    }

    #[test]
    fn the_nearest_keyframe_is_that_of_a_search_among_all_also_after_they_moved() {
        let mut nodes: Vec<GraphNode> = (0..150).map(|id| node(id, position(id))).collect();
        let mut grid = KeyframeGrid::default();
        grid.update(&nodes);
        for id in (0..150).step_by(3) {
            nodes[id as usize] = node(id, position(id + 1_000));
            grid.update(&nodes[id as usize..=id as usize]);
        }
        for index in 2_000..3_000 {
            let mut at = position(index);
            if index % 10 == 0 {
                at.x += 60.0;
            }
            let distance_m2 = |node: &&GraphNode| squared_distance(node.map_from_keyframe.position, at);
            let expected = nodes.iter().min_by(|a, b| distance_m2(a).total_cmp(&distance_m2(b)));
            assert_eq!(grid.nearest(at), expected.map(|node| node.id), "{at:?}");
        }
    }

    #[test]
    fn positions_that_are_not_finite_do_no_harm() {
        let mut grid = KeyframeGrid::default();
        assert_eq!(grid.nearest(Vec3::default()), None);
        grid.update(&[node(0, Vec3::new(f64::INFINITY, f64::NAN, 0.0)), node(1, Vec3::new(1.0, 0.0, 0.0))]);
        assert_eq!(grid.nearest(Vec3::default()), Some(KeyframeId(1)));
        assert!(grid.nearest(Vec3::new(f64::NAN, f64::NEG_INFINITY, 0.0)).is_some());
    }
}
