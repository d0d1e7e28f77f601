//! The route of the mission that is edited, or else the one that the robot follows, as lines and markers over the scene. Where the robot follows one, arrows on the other
//! edges show its policy: from each node the edge that leads on to where it goes.

use crate::vector::vector;
use client_model::{Model, PlannedStop};
use glam::DVec3;
use panels::SceneLabel;
use panels::theme::Tokens;
use scene::{Colour, Marker, MarkerShape, Polyline};
use site_model::{NodeId, Site};
use std::collections::{BTreeMap, BTreeSet};

/// Parameters of the overlay.
#[derive(Clone, Copy, Debug)]
struct MissionOverlayConfig {
    /// Height above the floor, m: over the edges of the topological map. Chosen: 4 cm above them (0.12 m).
    height_m: f64,
    /// Radius of a stop, logical px. Chosen: larger than a node (8 px), because it has a number.
    stop_radius_px: f32,
    /// Width of the route, logical px. Chosen: wider than an edge (3 px), which it covers.
    line_width_px: f32,
    /// Radius of an arrow on an edge, logical px. Chosen: its point is told from its sides.
    arrow_radius_px: f32,
}

const CONFIG: MissionOverlayConfig =
    MissionOverlayConfig { height_m: 0.16, stop_radius_px: 10.0, line_width_px: 5.0, arrow_radius_px: 9.0 };

/// Lines and markers of the route.
#[derive(Default)]
pub(crate) struct MissionOverlay {
    pub(crate) lines: Vec<Polyline>,
    pub(crate) markers: Vec<Marker>,
}

impl MissionOverlay {
    /// Of the mission that is edited, on its screen; on the others of the route that the robot follows. Nothing while the site belongs to another map than the one on
    /// the screen.
    pub(crate) fn of(model: &Model) -> Self {
        let mut overlay = Self::default();
        let tokens = Tokens::of(model.view_settings().theme);
        let Some((site, plan)) = panels::shown_mission(model) else {
            if let Some(site) = model.site.site().filter(|_| model.is_site_on_screen()) {
                let route = model.runs.route_nodes(site);
                overlay.add_route(model, site, &route, &tokens);
                overlay.add_arrows(model, site, &route, &tokens);
            }
            return overlay;
        };
        for route in plan.stops.iter().map(|stop| &stop.route).chain([&plan.end.route]) {
            overlay.add_route(model, site, route, &tokens);
        }
        for stop in &plan.stops {
            let Some(position) = stop.node.and_then(|node| place(model, site, node)) else { continue };
            overlay.markers.push(Marker {
                id: None,
                position,
                ahead: DVec3::ZERO,
                shape: MarkerShape::Disc,
                radius: CONFIG.stop_radius_px,
                fill: solid(if stop.problem.is_some() { tokens.bad } else { tokens.accent }),
                rim: solid(tokens.ground),
            });
        }
        overlay
    }

    /// Arrows on the edges of the route, in its colour, and on the other edges of the policy, in yellow.
    fn add_arrows(&mut self, model: &Model, site: &Site, route: &[NodeId], tokens: &Tokens) {
        let on_route: BTreeSet<[NodeId; 2]> = route.windows(2).map(|step| [step[0], step[1]]).collect();
        let others = model.runs.policy().iter().filter(|step| !on_route.contains(*step));
        let steps = others.map(|step| (step, tokens.warn));
        for (step, colour) in steps.chain(on_route.iter().map(|step| (step, tokens.accent))) {
            let [Some(from), Some(to)] = step.map(|node| place(model, site, node)) else { continue };
            self.markers.push(Marker {
                id: None,
                position: from.midpoint(to),
                ahead: to - from,
                shape: MarkerShape::Arrow,
                radius: CONFIG.arrow_radius_px,
                fill: solid(colour),
                rim: solid(tokens.ground),
            });
        }
    }

    /// A line over these nodes.
    fn add_route(&mut self, model: &Model, site: &Site, route: &[NodeId], tokens: &Tokens) {
        let points: Vec<DVec3> = route.iter().filter_map(|node| place(model, site, *node)).collect();
        if points.len() > 1 {
            let colour = solid(tokens.accent);
            self.lines.push(Polyline { points, colour, width: CONFIG.line_width_px, dash: 0.0 });
        }
    }
}

/// Numbers of the stops, one label for all at a node.
pub(crate) fn stop_labels(
    model: &Model,
    project: &impl Fn(DVec3) -> Option<(egui::Pos2, f64)>,
    labels: &mut Vec<SceneLabel>,
) {
    let Some((site, plan)) = panels::shown_mission(model) else { return };
    let mut at_nodes: BTreeMap<NodeId, Vec<(usize, &PlannedStop)>> = BTreeMap::new();
    for (number, stop) in (1..).zip(&plan.stops) {
        if let Some(node) = stop.node {
            at_nodes.entry(node).or_default().push((number, stop));
        }
    }
    for (node, stops) in at_nodes {
        if let Some((at, _)) = place(model, site, node).and_then(project) {
            let numbers: Vec<usize> = stops.iter().map(|(number, _)| *number).collect();
            let name = site.node(node).map_or("", |node| node.name.as_str());
            labels.push(SceneLabel::mission_stop(at, &numbers, name));
        }
    }
}

/// The nodes that have such a label.
pub(crate) fn stop_nodes(model: &Model) -> BTreeSet<NodeId> {
    let stops = panels::shown_mission(model).into_iter().flat_map(|(_, plan)| &plan.stops);
    stops.filter_map(|stop| stop.node).collect()
}

/// Where a node is drawn.
fn place(model: &Model, site: &Site, node: NodeId) -> Option<DVec3> {
    let base = vector(site.node(node)?.map_from_node.position);
    Some(base - DVec3::Z * (model.platform.standing_height_m() - CONFIG.height_m))
}

fn solid(colour: egui::Color32) -> Colour {
    [colour.r(), colour.g(), colour.b(), 255]
}
