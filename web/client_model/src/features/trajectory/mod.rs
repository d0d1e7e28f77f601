//! The path that the robot travelled: keyframes, which loop closures may move, then the estimates since the last keyframe.

use super::Feature;
use crate::shared::{Context, SliceChange};
use api::{Estimate, GraphNode};
use vocab::{Stamp, Vec3};

/// How densely estimates are kept.
#[derive(Clone, Copy, Debug)]
struct TrajectoryConfig {
    /// Distance between two kept positions, metres. Chosen: less is not visible at the width of the line.
    spacing_m: f64,
    /// Positions kept since the last keyframe: at 0.1 m apart, 500 m of walking. Chosen: longer than any walk between two keyframes; the rest comes with the graph.
    max_positions: usize,
}

impl Default for TrajectoryConfig {
    fn default() -> Self {
        Self { spacing_m: 0.1, max_positions: 5_000 }
    }
}

/// Positions of the base since the last keyframe, oldest first, map frame.
#[derive(Clone, Debug, Default)]
pub struct Trajectory {
    tail: Vec<(Stamp, Vec3)>,
    revision: u64,
    config: TrajectoryConfig,
}

impl Trajectory {
    /// Grows with every change.
    pub(crate) fn revision(&self) -> u64 {
        self.revision
    }

    /// The keyframes, then the positions since the last of them. Map frame, metres.
    pub(crate) fn positions<'a>(
        &'a self,
        keyframes: &'a [GraphNode],
    ) -> impl Iterator<Item = Vec3> + use<'a> {
        keyframes
            .iter()
            .map(|node| node.map_from_keyframe.position)
            .chain(self.tail.iter().map(|&(_, position)| position))
    }

    fn extend(&mut self, estimate: &Estimate) {
        let position = estimate.map_from_base.position;
        if !position.is_finite() {
            return;
        }
        if let Some(&(stamp, last)) = self.tail.last() {
            let moved_m = (position.x - last.x).hypot(position.y - last.y).hypot(position.z - last.z);
            if moved_m < self.config.spacing_m || estimate.stamp < stamp {
                return;
            }
        }
        if self.tail.len() >= self.config.max_positions {
            self.tail.drain(..self.config.max_positions / 10);
        }
        self.tail.push((estimate.stamp, position));
        self.revision += 1;
    }

    /// Removes positions that keyframes cover: those of the keyframes are corrected by loop closures.
    fn anchor(&mut self, nodes: &[GraphNode]) {
        if let Some(last) = nodes.last() {
            self.tail.retain(|&(stamp, _)| stamp > last.stamp);
        }
        self.revision += 1;
    }

    fn clear(&mut self) {
        self.tail.clear();
        self.revision += 1;
    }
}

impl Feature for Trajectory {
    fn on_event(&mut self, event: &api::Event, cx: &mut Context<'_>) {
        match event {
            api::Event::Estimate(estimate) => self.extend(estimate),
            api::Event::Graph(graph) => self.anchor(&graph.nodes),
            // Changes that do not apply bring no keyframes that could take the place of positions.
            api::Event::GraphChanged(changed)
                if changed.revision == cx.shared.map_views.live().graph.revision =>
            {
                self.anchor(&changed.nodes);
            }
            _ => {}
        }
    }

    fn on_change(&mut self, change: &SliceChange, _cx: &mut Context<'_>) {
        if matches!(change, SliceChange::SessionChanged | SliceChange::FrameChanged) {
            self.clear();
        }
    }
}

#[cfg(test)]
mod tests;
