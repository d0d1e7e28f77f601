//! The overlay on top of the points: graph, trajectory, path, robot and markers, and its translation into line and marker instances.

use crate::overlay_instances::{
    ALWAYS_VISIBLE, LIFT, LineInstance, MarkerInstance, Stroke, circle, lifted, push_polyline,
};
use crate::pose_graph::{LoopEdge, PoseNode, push_loops};
use crate::projection::CameraProjection;
use crate::robot::RobotState;
use crate::view::{Colour, Palette, View};
use glam::DVec3;

/// Parameters of the overlay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OverlayConfig {
    /// Shortest drawn step of a trajectory, m. Every scan adds a point; shorter steps cannot be seen. Chosen: half of the distance between the kept positions.
    pub(crate) min_trajectory_step_m: f64,
    /// Length of the robot's mesh, m, before it is scaled to the robot: from the head to the hind legs. Source: the mesh.
    pub(crate) robot_length_m: f64,
    /// Shortest length of the robot's mesh on the screen, logical px. Below it a marker with the robot's heading takes its place. About
    /// 48 px are needed to recognise the front of the mesh.
    pub(crate) min_robot_px: f64,
    /// Radius of that marker, logical px. Chosen: it is three quarters as wide as the mesh was, 36 px.
    pub(crate) robot_marker_radius_px: f32,
}

impl Default for OverlayConfig {
    fn default() -> Self {
        Self {
            min_trajectory_step_m: 0.05,
            robot_length_m: 0.9,
            min_robot_px: 48.0,
            robot_marker_radius_px: 18.0,
        }
    }
}

impl OverlayConfig {
    /// Whether the robot's mesh is large enough on the screen; else its marker is drawn.
    pub(crate) fn is_mesh_visible(
        &self,
        robot: &RobotState,
        view: &View,
        projection: &CameraProjection,
    ) -> bool {
        let depth = projection.depth(robot.position);
        let length_px = self.robot_length_m * robot.scale() * projection.focal_px() / depth;
        // The marker's shader decides by the same ratio.
        depth <= 0.0 || length_px >= self.min_robot_px * f64::from(view.pixels_per_point)
    }
}

/// Shape of a marker.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MarkerShape {
    /// A position without direction.
    #[default]
    Disc,
    /// An inspection point.
    Diamond,
    /// A dock.
    Square,
    /// A direction: an arrow head along [`Marker::ahead`].
    Arrow,
    /// A circle around a position.
    Ring,
    /// A disc with a point along [`Marker::ahead`]: a position and a heading.
    Heading,
}

/// A marker of constant size on the screen at a position in the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marker {
    /// Reported by [`crate::Hit::Marker`] when it is picked; a marker without id cannot be picked.
    pub id: Option<u64>,
    /// Position, m, map frame.
    pub position: DVec3,
    /// Direction of an arrow, map frame; zero for upright.
    pub ahead: DVec3,
    /// Shape.
    pub shape: MarkerShape,
    /// Radius, logical px.
    pub radius: f32,
    /// Colour of its inside.
    pub fill: Colour,
    /// Colour of its rim.
    pub rim: Colour,
}

/// A line through the map.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline {
    /// Vertices, m, map frame.
    pub points: Vec<DVec3>,
    /// Colour of the whole line.
    pub colour: Colour,
    /// Width, logical px.
    pub width: f32,
    /// Length of a dash with its gap, m; 0 for a solid line.
    pub dash: f32,
}

/// Content of the overlay.
#[derive(Clone, Debug, Default)]
pub(crate) struct Overlay {
    pub(crate) trajectory: Vec<DVec3>,
    pub(crate) nodes: Vec<PoseNode>,
    pub(crate) edges: Vec<[DVec3; 2]>,
    pub(crate) robot: Option<RobotState>,
    pub(crate) goal: Option<DVec3>,
    pub(crate) path: Vec<DVec3>,
    pub(crate) lines: Vec<Polyline>,
    pub(crate) markers: Vec<Marker>,
    /// Number of the selected node.
    pub(crate) selected_node: Option<u32>,
    pub(crate) loops: Vec<LoopEdge>,
    /// Numbers of two highlighted nodes, the older first.
    pub(crate) pair: Option<[u32; 2]>,
}

impl Overlay {
    /// Line segments and markers in drawing order.
    pub(crate) fn build(
        &self,
        config: &OverlayConfig,
        palette: &Palette,
    ) -> (Vec<LineInstance>, Vec<MarkerInstance>) {
        let mut segments = Vec::new();
        let mut markers = Vec::new();
        self.push_graph(palette, &mut segments, &mut markers);
        let trajectory = Stroke { colour: palette.trajectory, width: 2.5, behind: 0.25, dash: 0.0 };
        push_polyline(&mut segments, &lifted(&self.trajectory), trajectory, config.min_trajectory_step_m);
        for line in &self.lines {
            let stroke = Stroke { colour: line.colour, width: line.width, behind: 0.25, dash: line.dash };
            push_polyline(&mut segments, &line.points, stroke, 0.0);
        }
        self.push_goal(palette, &mut segments, &mut markers);
        self.push_robot(config, palette, &mut segments, &mut markers);
        markers.extend(self.markers.iter().filter(|m| m.position.is_finite()).map(instance_of));
        (segments, markers)
    }

    fn push_graph(
        &self,
        palette: &Palette,
        segments: &mut Vec<LineInstance>,
        markers: &mut Vec<MarkerInstance>,
    ) {
        let stroke = Stroke { colour: palette.edge, width: 2.0, behind: 0.25, dash: 0.0 };
        for edge in &self.edges {
            push_polyline(segments, &lifted(edge), stroke, 0.0);
        }
        let number =
            |n: u32| self.nodes.iter().find(|node| node.number == n && node.position.is_finite()).copied();
        let pair = self.pair.and_then(|[older, newer]| Some([number(older)?, number(newer)?]));
        push_loops(segments, &self.loops, pair, palette);
        // Highlighted nodes are drawn last, over their neighbours.
        let is_highlighted = |number: u32| self.pair.is_some_and(|pair| pair.contains(&number));
        let finite = || self.nodes.iter().filter(|node| node.position.is_finite());
        let (others, pair_nodes) = (
            finite().filter(|node| !is_highlighted(node.number)),
            finite().filter(|node| is_highlighted(node.number)),
        );
        for node in others.chain(pair_nodes) {
            let of_pair = pair.and_then(|pair| pair.iter().position(|end| end.number == node.number));
            let selected = self.selected_node == Some(node.number) || of_pair.is_some();
            let chosen = of_pair.map_or(palette.accent, |newer| palette.pair[newer]);
            markers.push(MarkerInstance {
                centre: (node.position + LIFT).as_vec3().to_array(),
                ahead: [0.0; 3],
                fill: if selected {
                    chosen
                } else {
                    between(palette.node, palette.uncertain, node.uncertainty)
                },
                rim: palette.outline,
                radius_max: if selected { 10.0 } else { 6.5 },
                radius_min: if selected { 7.0 } else { 2.5 },
                radius_world: 0.16,
                shape: shape_number(MarkerShape::Disc),
                behind: 0.25,
                visible_px: ALWAYS_VISIBLE,
            });
        }
    }

    fn push_goal(
        &self,
        palette: &Palette,
        segments: &mut Vec<LineInstance>,
        markers: &mut Vec<MarkerInstance>,
    ) {
        let path = Stroke { colour: palette.accent, width: 5.0, behind: 0.35, dash: 0.0 };
        push_polyline(segments, &lifted(&self.path), path, 0.0);
        let Some(goal) = self.goal.filter(|g| g.is_finite()) else {
            return;
        };
        let ring = Stroke { width: 2.5, ..path };
        push_polyline(segments, &circle(goal + LIFT, 0.35), ring, 0.0);
        // A pin of 0.9 m height, which is visible from far away and over racks.
        let top = goal + DVec3::new(0.0, 0.0, 0.9);
        push_polyline(segments, &[goal, top], ring, 0.0);
        markers.push(MarkerInstance {
            centre: top.as_vec3().to_array(),
            ahead: [0.0; 3],
            fill: palette.accent,
            rim: palette.node,
            radius_max: 11.0,
            radius_min: 7.0,
            radius_world: 0.14,
            shape: shape_number(MarkerShape::Diamond),
            behind: 0.6,
            visible_px: ALWAYS_VISIBLE,
        });
    }

    fn push_robot(
        &self,
        config: &OverlayConfig,
        palette: &Palette,
        segments: &mut Vec<LineInstance>,
        markers: &mut Vec<MarkerInstance>,
    ) {
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
        // The arrow is drawn with the mesh. The marker with the heading replaces both.
        const ARROW_RADIUS_M: f32 = 0.17;
        let least_px_per_m = (config.min_robot_px / config.robot_length_m) as f32;
        markers.push(MarkerInstance {
            centre: (feet + ahead * (robot.ring_radius() + 0.22)).as_vec3().to_array(),
            ahead: ahead.as_vec3().to_array(),
            fill: colour,
            rim: palette.outline,
            radius_max: 14.0,
            radius_min: 5.0,
            radius_world: ARROW_RADIUS_M,
            shape: shape_number(MarkerShape::Arrow),
            behind: 0.5,
            visible_px: [ARROW_RADIUS_M * least_px_per_m, ALWAYS_VISIBLE[1]],
        });
        let half_length_m = (0.5 * config.robot_length_m) as f32;
        markers.push(MarkerInstance {
            centre: robot.position.as_vec3().to_array(),
            ahead: ahead.as_vec3().to_array(),
            fill: colour,
            rim: palette.outline,
            radius_max: config.robot_marker_radius_px,
            radius_min: config.robot_marker_radius_px,
            radius_world: half_length_m,
            shape: shape_number(MarkerShape::Heading),
            behind: 0.75,
            visible_px: [0.0, half_length_m * least_px_per_m],
        });
    }
}

/// Mixes two colours; `share` is clamped to 0..=1.
fn between(from: Colour, to: Colour, share: f32) -> Colour {
    let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 1.0 };
    std::array::from_fn(|i| {
        (f32::from(from[i]) + (f32::from(to[i]) - f32::from(from[i])) * share).round() as u8
    })
}

fn instance_of(marker: &Marker) -> MarkerInstance {
    MarkerInstance {
        centre: marker.position.as_vec3().to_array(),
        ahead: marker.ahead.as_vec3().to_array(),
        fill: marker.fill,
        rim: marker.rim,
        radius_max: marker.radius,
        radius_min: marker.radius,
        radius_world: 0.0,
        shape: shape_number(marker.shape),
        behind: 0.4,
        visible_px: ALWAYS_VISIBLE,
    }
}

/// Number of a shape in `edge_distance` of overlay.wgsl.
fn shape_number(shape: MarkerShape) -> f32 {
    match shape {
        MarkerShape::Disc => 0.0,
        MarkerShape::Diamond => 1.0,
        MarkerShape::Square => 2.0,
        MarkerShape::Arrow => 3.0,
        MarkerShape::Ring => 4.0,
        MarkerShape::Heading => 5.0,
    }
}
