//! Nodes and loops of the pose graph. Accepted loops are drawn as lines, the others as dashed lines.

use crate::overlay_instances::{LineInstance, Stroke, lifted, push_polyline};
use crate::view::{Colour, Palette};
use glam::DVec3;

/// A node of the pose graph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseNode {
    /// Reported by [`crate::Hit::PoseNode`] when it is picked.
    pub number: u32,
    /// Position, m, map frame.
    pub position: DVec3,
    /// From 0 (certain, [`Palette::node`]) to 1 (uncertain, [`Palette::uncertain`]).
    pub uncertainty: f32,
}

/// State of a loop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum LoopState {
    /// Rejected: not an edge of the graph.
    Rejected,
    /// Undecided: it waits for loops that are consistent with it.
    Open,
    /// An edge of the graph.
    #[default]
    Closed,
}

/// A loop between two nodes of the graph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopEdge {
    /// Numbers of its nodes, the older first; reported by [`crate::Hit::Loop`] when it is picked.
    pub nodes: [u32; 2],
    /// Their positions, m, map frame.
    pub ends: [DVec3; 2],
    /// State, which selects colour and dashes.
    pub state: LoopState,
}

/// Length of a dash with its gap, m.
const DASH_M: f32 = 0.3;

/// Appends the lines of all loops, accepted ones on top. The loop between `selected` nodes is above them all and has a rim; a pair
/// without a loop gets a dashed line.
pub(crate) fn push_loops(
    segments: &mut Vec<LineInstance>,
    loops: &[LoopEdge],
    selected: Option<[PoseNode; 2]>,
    palette: &Palette,
) {
    for state in [LoopState::Rejected, LoopState::Open, LoopState::Closed] {
        for edge in loops.iter().filter(|edge| edge.state == state) {
            push_polyline(segments, &lifted(&edge.ends), stroke(state, palette), 0.0);
        }
    }
    let Some(nodes) = selected else { return };
    let own = loops.iter().find(|edge| edge.nodes == nodes.map(|node| node.number));
    let of_state = own.map_or(proposed(palette), |edge| stroke(edge.state, palette));
    let solid = |colour: Colour| [colour[0], colour[1], colour[2], 255];
    let line = Stroke { width: 4.5, behind: 0.75, colour: solid(of_state.colour), ..of_state };
    let rim = Stroke { width: 8.0, colour: solid(palette.outline), dash: 0.0, ..line };
    let ends = lifted(&nodes.map(|node| node.position));
    push_polyline(segments, &ends, rim, 0.0);
    push_polyline(segments, &ends, line, 0.0);
}

fn stroke(state: LoopState, palette: &Palette) -> Stroke {
    let dash = DASH_M;
    match state {
        LoopState::Closed => Stroke { colour: palette.loop_closed, width: 2.5, behind: 0.4, dash: 0.0 },
        LoopState::Open => Stroke { colour: palette.loop_open, width: 2.0, behind: 0.25, dash },
        LoopState::Rejected => Stroke { colour: palette.loop_rejected, width: 1.5, behind: 0.15, dash },
    }
}

/// A pair of nodes that has no loop yet.
fn proposed(palette: &Palette) -> Stroke {
    Stroke { colour: palette.accent, width: 3.0, behind: 0.5, dash: DASH_M }
}
