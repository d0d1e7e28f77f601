//! Clicks on the screen that edits the site, while one of its tools is on: see [`GraphTool`].

use crate::camera_inset;
use crate::scene_sync::SceneSync;
use client_model::{ClientCommand, GraphTool, Model, Selection};
use glam::DVec3;
use scene::View;
use site_model::NodeId;
use vocab::Vec3;

/// Parameters of clicks on the graph.
struct GraphClickConfig {
    /// Nodes from which a new inspection point may be looked at are tried up to this number, the best first. Chosen: each try draws a small picture, and what is hidden
    /// from eight places is hidden from most.
    max_viewpoints: usize,
}

const CONFIG: GraphClickConfig = GraphClickConfig { max_viewpoints: 8 };

/// What was clicked.
pub(crate) struct GraphClick {
    /// The object of the site.
    pub(crate) hit: Option<Selection>,
    /// The place on the floor, m, map frame.
    pub(crate) floor: Option<DVec3>,
    /// The point of the map, m, map frame.
    pub(crate) point: Option<DVec3>,
}

impl GraphClick {
    /// Does what the tool does with it. `view`: of the scene.
    pub(crate) fn edit(
        &self,
        tool: GraphTool,
        model: &Model,
        scene: &SceneSync,
        view: &View,
        out: &mut Vec<ClientCommand>,
    ) {
        let selected = model.selected_nodes();
        match (tool, self.hit) {
            (GraphTool::AddInspectionPoints | GraphTool::PickTarget, _) => {
                let Some(target) = self.point.map(|point| Vec3::from(point.to_array())) else { return };
                if tool == GraphTool::PickTarget {
                    pick_target(target, model, out);
                } else if let Some(node) = viewpoint(target, model, scene, view) {
                    let (point, edit) = model.site.adding_inspection_point(node, target);
                    out.push(ClientCommand::EditSite(edit));
                    out.push(ClientCommand::Select(Some(Selection::InspectionPoint(point))));
                }
            }
            // A zone is drawn by a drag.
            (GraphTool::DrawZone, hit) => out.push(ClientCommand::Select(hit)),
            (_, Some(Selection::Node(node))) => {
                out.extend(model.site.clicking_node(tool, node, &selected));
            }
            (GraphTool::AddNodes, _) => {
                let Some((map, floor)) = model.saved_map_on_screen().zip(self.floor) else { return };
                let position = Vec3::new(floor.x, floor.y, floor.z + model.platform.standing_height_m());
                let from = selected.first().copied().filter(|_| selected.len() == 1);
                let (node, edit) = model.site.adding_node(position, map, from);
                out.push(ClientCommand::EditSite(edit));
                out.push(ClientCommand::Select(Some(Selection::Node(node))));
            }
            (GraphTool::SelectSeveral, _) => out.push(ClientCommand::Select(None)),
            (GraphTool::Connect, _) => {}
        }
    }
}

/// Another target of the inspection point that is selected.
fn pick_target(target: Vec3, model: &Model, out: &mut Vec<ClientCommand>) {
    if let Some(edit) = model.site.retargeting(model.selection(), target) {
        out.push(ClientCommand::EditSite(edit));
        out.push(ClientCommand::UseGraphTool(None));
    }
}

/// The best node from which nothing stands in the way of the target; if there is none, the best node.
fn viewpoint(target: Vec3, model: &Model, scene: &SceneSync, view: &View) -> Option<NodeId> {
    let nodes = model.site.viewpoints(target);
    let site = model.site.site()?;
    let sees = |node: &&NodeId| {
        site.node(**node).is_some_and(|node| {
            let sight = model.site.sight_from(node, target, 1.0);
            sight.is_tilt_possible && camera_inset::is_free(&sight, view, scene)
        })
    };
    nodes.iter().take(CONFIG.max_viewpoints).find(sees).or(nodes.first()).copied()
}
