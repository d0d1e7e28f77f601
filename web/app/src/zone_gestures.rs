//! Drags of zones: a new one from corner to corner, a corner, or the whole of one.

use crate::gesture_context::GestureContext;
use crate::graph_overlay::GraphTarget;
use crate::graph_preview::{GraphPreview, ZonePreview};
use crate::zone_overlay;
use client_model::{ClientCommand, GraphTool, Selection, SiteFeature, drawn_area};
use egui::Pos2;
use glam::DVec2;
use scene::CameraProjection;
use site_model::ZoneId;

/// A zone that is dragged.
pub(crate) struct ZoneDrag {
    grip: ZoneGrip,
    /// The corners before, m, map frame. With a new corner if one is drawn out of a side.
    corners_m: Vec<[f64; 2]>,
    /// Height of the floor, m, map frame.
    floor_m: f64,
    /// Where the drag began, m, map frame.
    from: DVec2,
}

/// What of a zone is dragged.
#[derive(Clone, Copy)]
enum ZoneGrip {
    /// A new one.
    New,
    /// A corner, by its place in the list.
    Corner(ZoneId, usize),
    /// All of it.
    Whole(ZoneId),
}

impl ZoneDrag {
    /// What a drag that was pressed here drags of zones. `tool`: the one that is on.
    pub(crate) fn begin(
        cx: &GestureContext<'_>,
        pressed: Pos2,
        target: Option<GraphTarget>,
        tool: Option<GraphTool>,
        out: &mut Vec<ClientCommand>,
    ) -> Option<Self> {
        if tool == Some(GraphTool::DrawZone) {
            // What is pressed may be the top of a wall; the zone begins on the floor behind it.
            let pointed = (cx.floor_at)(pressed)?;
            let base_m = cx.model.site.base_height_in_m(&[pointed.truncate().to_array()], None);
            let standing_height_m = cx.model.platform.standing_height_m();
            let floor_m = base_m.map_or(pointed.z, |base_m| base_m - standing_height_m);
            let (corners_m, from) = (Vec::new(), on_plane(cx, pressed, floor_m)?);
            return Some(Self { grip: ZoneGrip::New, corners_m, floor_m, from });
        }
        let (zone, new_corner, grip) = match target? {
            GraphTarget::ZoneCorner(zone, index) => (zone, None, ZoneGrip::Corner(zone, index)),
            GraphTarget::ZoneSide(zone, index) => (zone, Some(index + 1), ZoneGrip::Corner(zone, index + 1)),
            GraphTarget::Object(Selection::Zone(zone)) => (zone, None, ZoneGrip::Whole(zone)),
            GraphTarget::Object(_) | GraphTarget::Heading(_) => return None,
        };
        let dragged = cx.model.site.zone(zone)?;
        let floor_m = zone_overlay::floor_m(cx.model, dragged);
        let from = on_plane(cx, pressed, floor_m)?;
        let mut corners_m = dragged.corners_m.clone();
        if let Some(index) = new_corner.filter(|index| *index <= corners_m.len()) {
            corners_m.insert(index, from.to_array());
        }
        out.push(ClientCommand::Select(Some(Selection::Zone(zone))));
        Some(Self { grip, corners_m, floor_m, from })
    }

    /// The zone as it would be with the pointer here.
    pub(crate) fn update(&self, cx: &GestureContext<'_>, pointer: Option<Pos2>, preview: &mut GraphPreview) {
        let to = pointer.and_then(|at| on_plane(cx, at, self.floor_m)).unwrap_or(self.from);
        let mut corners_m = self.corners_m.clone();
        let zone = match self.grip {
            ZoneGrip::New => {
                corners_m = drawn_area(cx.view.camera.yaw, self.from.to_array(), to.to_array());
                None
            }
            ZoneGrip::Corner(zone, index) => {
                if let Some(corner) = corners_m.get_mut(index) {
                    *corner = to.to_array();
                }
                Some(zone)
            }
            ZoneGrip::Whole(zone) => {
                let by = to - self.from;
                for corner in &mut corners_m {
                    *corner = (DVec2::from_array(*corner) + by).to_array();
                }
                Some(zone)
            }
        };
        preview.zone = Some(ZonePreview { zone, corners_m, floor_m: self.floor_m });
    }
}

/// The edit of a zone that was let go.
pub(crate) fn end(site: &SiteFeature, preview: &ZonePreview, out: &mut Vec<ClientCommand>) {
    let corners_m = preview.corners_m.clone();
    match preview.zone {
        Some(zone) => {
            let edit = site.changing_zone(zone, |zone| zone.corners_m = corners_m);
            if !edit.put.is_empty() {
                out.push(ClientCommand::EditSite(edit));
            }
        }
        None if corners_m.is_empty() => {}
        None => add(site, corners_m, out),
    }
}

/// A new zone, which is then selected. The tool has done its work.
fn add(site: &SiteFeature, corners_m: Vec<[f64; 2]>, out: &mut Vec<ClientCommand>) {
    let (zone, edit) = site.adding_zone(corners_m);
    out.push(ClientCommand::EditSite(edit));
    out.push(ClientCommand::UseGraphTool(None));
    out.push(ClientCommand::Select(Some(Selection::Zone(zone))));
}

/// Where a place on the screen is on the floor, m, map frame; `None` too far away.
fn on_plane(cx: &GestureContext<'_>, at: Pos2, floor_m: f64) -> Option<DVec2> {
    let projection = CameraProjection::new(cx.view.camera, cx.view.viewport_px);
    let to = projection.ray((cx.pixel)(at)).at_height(floor_m)?;
    (to.distance(projection.camera_position()) < cx.max_distance_m).then(|| to.truncate())
}
