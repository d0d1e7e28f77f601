//! The way the robot came: keyframes, which loop closures may move, then what was seen of it since the last one.

use api::{Estimate, Graph, GraphNode};
use vocab::{Stamp, Vec3};

/// Positions of the base in the map, oldest first.
#[derive(Clone, Debug, Default)]
pub struct Trajectory {
    tail: Vec<(Stamp, Vec3)>,
    revision: u64,
}

const SPACING_M: f64 = 0.1;
/// Kept without keyframes: 500 m of walk.
const TAIL_MAX: usize = 5_000;

impl Trajectory {
    /// Grows with every change.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// The whole way: the session's keyframes, then the positions since the last of them. Map frame, metres.
    pub(crate) fn positions<'a>(&'a self, keyframes: &'a [GraphNode]) -> impl Iterator<Item = Vec3> + 'a {
        keyframes
            .iter()
            .map(|node| node.map_from_keyframe.position)
            .chain(self.tail.iter().map(|&(_, at)| at))
    }

    pub(crate) fn extend(&mut self, estimate: &Estimate) {
        let at = estimate.map_from_base.position;
        if !at.is_finite() {
            return;
        }
        if let Some(&(stamp, last)) = self.tail.last() {
            let moved = (at.x - last.x).hypot(at.y - last.y).hypot(at.z - last.z);
            if moved < SPACING_M || estimate.stamp < stamp {
                return;
            }
        }
        if self.tail.len() >= TAIL_MAX {
            self.tail.drain(..TAIL_MAX / 10);
        }
        self.tail.push((estimate.stamp, at));
        self.revision += 1;
    }

    /// The graph changed: what its keyframes tell is dropped here, so that corrections are seen.
    pub(crate) fn anchor(&mut self, graph: &Graph) {
        if let Some(last) = graph.nodes.last() {
            self.tail.retain(|&(stamp, _)| stamp > last.stamp);
        }
        self.revision += 1;
    }

    pub(crate) fn clear(&mut self) {
        self.tail.clear();
        self.revision += 1;
    }
}
