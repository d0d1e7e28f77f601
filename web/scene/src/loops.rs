//! Loops of the pose graph as the caller gives them, and how they are drawn: closed ones as lines, the others as dashes.

use crate::lines::{Segment, Stroke, push_polyline};
use crate::overlay::{Node, lifted};
use crate::view::{Colour, Palette};
use glam::DVec3;

/// What became of a loop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum LoopState {
    /// It is no loop.
    Rejected,
    /// It waits for others to agree with it.
    Open,
    /// It is an edge of the graph.
    #[default]
    Closed,
}

/// A loop between two nodes of the graph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopEdge {
    /// Numbers of its nodes, the older first: what [`crate::Hit::Loop`] says when it is picked.
    pub nodes: [u32; 2],
    /// Where they are, metres, map frame.
    pub ends: [DVec3; 2],
    /// What became of it.
    pub state: LoopState,
}

/// Dash and gap together, metres.
const DASH: f64 = 0.3;

/// Appends the lines of all loops: those that matter most on top, the one between `selected` nodes above all and with a
/// rim; where there is none yet, a dashed line of its own.
pub(crate) fn push_loops(
    segments: &mut Vec<Segment>,
    loops: &[LoopEdge],
    selected: Option<[Node; 2]>,
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
    let dash = DASH as f32;
    match state {
        LoopState::Closed => Stroke { colour: palette.loop_closed, width: 2.5, behind: 0.4, dash: 0.0 },
        LoopState::Open => Stroke { colour: palette.loop_open, width: 2.0, behind: 0.25, dash },
        LoopState::Rejected => Stroke { colour: palette.loop_rejected, width: 1.5, behind: 0.15, dash },
    }
}

/// A pair that nobody has looked at.
fn proposed(palette: &Palette) -> Stroke {
    Stroke { colour: palette.accent, width: 3.0, behind: 0.5, dash: DASH as f32 }
}
