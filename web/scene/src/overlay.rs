//! What is drawn on top of the points, as the caller gives it, and its translation into segments and marks.

use crate::lines::{Mark, Segment, Stroke, circle, push_polyline};
use crate::loops::{LoopEdge, push_loops};
use crate::robot::RobotState;
use crate::view::{Colour, Palette};
use glam::DVec3;

/// Trajectories come with every scan; steps shorter than this (metres) cannot be seen.
const TRAJECTORY_STEP: f64 = 0.05;
/// Graph and trajectory are drawn this far above their poses' feet, metres, so that they do not sink into the floor.
const LIFT: DVec3 = DVec3::new(0.0, 0.0, 0.05);

/// What a marker looks like.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shape {
    /// A place.
    #[default]
    Disc,
    /// An inspection point.
    Diamond,
    /// A dock.
    Square,
    /// A direction; points along [`Marker::ahead`].
    Arrow,
    /// Around something.
    Ring,
}

/// A sign of constant size on the screen at a place in the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marker {
    /// What [`crate::Hit::Marker`] says when it is picked; none cannot be picked.
    pub id: Option<u64>,
    /// Metres, map frame.
    pub position: DVec3,
    /// Direction of an arrow, map frame; zero for upright.
    pub ahead: DVec3,
    /// What it looks like.
    pub shape: Shape,
    /// Logical pixels.
    pub radius: f32,
    /// Inside.
    pub fill: Colour,
    /// Around it.
    pub rim: Colour,
}

/// A line through the map.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline {
    /// Metres, map frame.
    pub points: Vec<DVec3>,
    /// Of the whole line.
    pub colour: Colour,
    /// Logical pixels.
    pub width: f32,
    /// Length of a dash and its gap, metres; 0 for a solid line.
    pub dash: f32,
}

/// A node of the pose graph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// What [`crate::Hit::Node`] says when it is picked.
    pub number: u32,
    /// Metres, map frame.
    pub position: DVec3,
    /// From 0, known well, to 1, known vaguely: from [`Palette::node`] to [`Palette::doubtful`].
    pub doubt: f32,
}

/// Everything on top of the points.
#[derive(Clone, Debug, Default)]
pub(crate) struct Overlay {
    pub(crate) trajectory: Vec<DVec3>,
    pub(crate) nodes: Vec<Node>,
    pub(crate) edges: Vec<[DVec3; 2]>,
    pub(crate) robot: Option<RobotState>,
    pub(crate) goal: Option<DVec3>,
    pub(crate) path: Vec<DVec3>,
    pub(crate) lines: Vec<Polyline>,
    pub(crate) markers: Vec<Marker>,
    /// Number of the node that is selected.
    pub(crate) selected_node: Option<u32>,
    pub(crate) loops: Vec<LoopEdge>,
    /// Numbers of two nodes that stand out together, the older first.
    pub(crate) pair: Option<[u32; 2]>,
}

impl Overlay {
    /// Segments and marks in the order in which they are drawn.
    pub(crate) fn build(&self, palette: &Palette) -> (Vec<Segment>, Vec<Mark>) {
        let mut segments = Vec::new();
        let mut marks = Vec::new();
        self.push_graph(palette, &mut segments, &mut marks);
        let trail = Stroke { colour: palette.trajectory, width: 2.5, behind: 0.25, dash: 0.0 };
        push_polyline(&mut segments, &lifted(&self.trajectory), trail, TRAJECTORY_STEP);
        for line in &self.lines {
            let stroke = Stroke { colour: line.colour, width: line.width, behind: 0.25, dash: line.dash };
            push_polyline(&mut segments, &line.points, stroke, 0.0);
        }
        self.push_goal(palette, &mut segments, &mut marks);
        self.push_robot(palette, &mut segments, &mut marks);
        marks.extend(self.markers.iter().filter(|m| m.position.is_finite()).map(mark_of));
        (segments, marks)
    }

    fn push_graph(&self, palette: &Palette, segments: &mut Vec<Segment>, marks: &mut Vec<Mark>) {
        let stroke = Stroke { colour: palette.edge, width: 2.0, behind: 0.25, dash: 0.0 };
        for edge in &self.edges {
            push_polyline(segments, &lifted(edge), stroke, 0.0);
        }
        let number =
            |n: u32| self.nodes.iter().find(|node| node.number == n && node.position.is_finite()).copied();
        let pair = self.pair.and_then(|[older, newer]| Some([number(older)?, number(newer)?]));
        push_loops(segments, &self.loops, pair, palette);
        // What stands out is drawn last, over its neighbours.
        let stands_out = |number: u32| self.pair.is_some_and(|pair| pair.contains(&number));
        let finite = || self.nodes.iter().filter(|node| node.position.is_finite());
        let (others, pair_nodes) = (
            finite().filter(|node| !stands_out(node.number)),
            finite().filter(|node| stands_out(node.number)),
        );
        for node in others.chain(pair_nodes) {
            let of_pair = pair.and_then(|pair| pair.iter().position(|end| end.number == node.number));
            let selected = self.selected_node == Some(node.number) || of_pair.is_some();
            let chosen = of_pair.map_or(palette.accent, |newer| palette.pair[newer]);
            marks.push(Mark {
                centre: (node.position + LIFT).as_vec3().to_array(),
                ahead: [0.0; 3],
                fill: if selected { chosen } else { between(palette.node, palette.doubtful, node.doubt) },
                rim: palette.outline,
                radius_max: if selected { 10.0 } else { 6.5 },
                radius_min: if selected { 7.0 } else { 2.5 },
                radius_world: 0.16,
                shape: shape_number(Shape::Disc),
                behind: 0.25,
            });
        }
    }

    fn push_goal(&self, palette: &Palette, segments: &mut Vec<Segment>, marks: &mut Vec<Mark>) {
        let way = Stroke { colour: palette.accent, width: 5.0, behind: 0.35, dash: 0.0 };
        push_polyline(segments, &lifted(&self.path), way, 0.0);
        let Some(goal) = self.goal.filter(|g| g.is_finite()) else {
            return;
        };
        let ring = Stroke { width: 2.5, ..way };
        push_polyline(segments, &circle(goal + LIFT, 0.35), ring, 0.0);
        // A pin: visible from afar and over racks.
        let top = goal + DVec3::new(0.0, 0.0, 0.9);
        push_polyline(segments, &[goal, top], ring, 0.0);
        marks.push(Mark {
            centre: top.as_vec3().to_array(),
            ahead: [0.0; 3],
            fill: palette.accent,
            rim: palette.node,
            radius_max: 11.0,
            radius_min: 7.0,
            radius_world: 0.14,
            shape: shape_number(Shape::Diamond),
            behind: 0.6,
        });
    }

    fn push_robot(&self, palette: &Palette, segments: &mut Vec<Segment>, marks: &mut Vec<Mark>) {
        let Some(robot) = self.robot.filter(|r| r.is_finite()) else {
            return;
        };
        let colour = if robot.ok { palette.robot } else { palette.bad };
        let feet = robot.feet() + DVec3::new(0.0, 0.0, 0.02);
        let ring = Stroke { colour, width: 2.0, behind: 0.4, dash: if robot.ok { 0.0 } else { 0.25 } };
        push_polyline(segments, &circle(feet, robot.ring_radius()), ring, 0.0);
        if robot.selected {
            let halo = Stroke { colour: palette.accent, width: 3.0, dash: 0.0, ..ring };
            push_polyline(segments, &circle(feet, robot.ring_radius() + 0.12), halo, 0.0);
        }
        let ahead = robot.ahead();
        marks.push(Mark {
            centre: (feet + ahead * (robot.ring_radius() + 0.22)).as_vec3().to_array(),
            ahead: ahead.as_vec3().to_array(),
            fill: colour,
            rim: palette.outline,
            radius_max: 14.0,
            radius_min: 5.0,
            radius_world: 0.17,
            shape: shape_number(Shape::Arrow),
            behind: 0.5,
        });
    }
}

pub(crate) fn lifted(points: &[DVec3]) -> Vec<DVec3> {
    points.iter().map(|p| *p + LIFT).collect()
}

/// From one colour to another, clamped to 0..=1.
fn between(from: Colour, to: Colour, share: f32) -> Colour {
    let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 1.0 };
    std::array::from_fn(|i| {
        (f32::from(from[i]) + (f32::from(to[i]) - f32::from(from[i])) * share).round() as u8
    })
}

fn mark_of(marker: &Marker) -> Mark {
    Mark {
        centre: marker.position.as_vec3().to_array(),
        ahead: marker.ahead.as_vec3().to_array(),
        fill: marker.fill,
        rim: marker.rim,
        radius_max: marker.radius,
        radius_min: marker.radius,
        radius_world: 0.0,
        shape: shape_number(marker.shape),
        behind: 0.4,
    }
}

/// As `edge_distance` of overlay.wgsl counts them.
fn shape_number(shape: Shape) -> f32 {
    match shape {
        Shape::Disc => 0.0,
        Shape::Diamond => 1.0,
        Shape::Square => 2.0,
        Shape::Arrow => 3.0,
        Shape::Ring => 4.0,
    }
}
