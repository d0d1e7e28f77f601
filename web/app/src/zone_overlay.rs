//! Zones in the scene: their outline on the floor, hatched where the robot keeps out, and handles of the one that is selected.

use crate::graph_overlay::{GraphOverlay, GraphTarget, marker, solid};
use crate::graph_preview::GraphPreview;
use client_model::{Model, Selection, middle_of};
use egui::Color32;
use glam::{DVec2, DVec3};
use panels::theme::Tokens;
use scene::{Marker, MarkerShape, Polyline};
use site_model::{Zone, ZoneEffect, ZoneId};

/// Parameters of the drawing of zones.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ZoneOverlayConfig {
    /// Height of outlines above the floor, m, below that of edges. Chosen: 4 cm below them, so that edges are drawn over zones.
    height_m: f64,
    /// Width of an outline, logical px. Chosen: a little less than an edge (3 px).
    line_width_px: f32,
    /// Distance between the lines of a hatching, m. That of a large zone is greater, see `max_hatch_lines`. Chosen: a zone of 2 m has five lines.
    hatch_m: f64,
    /// Width of these lines, logical px. Chosen: the floor stays visible.
    hatch_width_px: f32,
    /// Greatest number of these lines. Chosen: a zone then costs as much to draw as a few edges; closer lines would fill it.
    max_hatch_lines: u32,
    /// Radius of the handle of a corner, and of the one in the middle of a side, logical px. Chosen: seen as a handle; it is picked within a touch target.
    corner_radius_px: f32,
    /// Radius of the handle in the middle of a side, logical px. Chosen: smaller than [`Self::corner_radius_px`], so that both are told apart.
    side_radius_px: f32,
    /// Length of a dash of a limit of speed, with its gap, m. Chosen: a side of 2 m has five.
    dash_m: f32,
}

const CONFIG: ZoneOverlayConfig = ZoneOverlayConfig {
    height_m: 0.08,
    line_width_px: 2.5,
    hatch_m: 0.4,
    hatch_width_px: 1.0,
    max_hatch_lines: 120,
    corner_radius_px: 9.0,
    side_radius_px: 6.0,
    dash_m: 0.4,
};

/// Adds the zones that are shown, and the one that is drawn.
pub(crate) fn add(overlay: &mut GraphOverlay, model: &Model, preview: &GraphPreview) {
    if !model.is_site_on_screen() {
        return;
    }
    let tokens = &Tokens::of(model.view_settings().theme);
    for zone in model.site.zones().into_iter().filter(|zone| model.site.is_zone_shown(zone)) {
        let dragged = preview.zone.as_ref().filter(|dragged| dragged.zone == Some(zone.id));
        let corners = dragged.map_or(&zone.corners_m, |dragged| &dragged.corners_m);
        let z = floor_m(model, zone) + CONFIG.height_m;
        let is_selected = model.selection() == Some(Selection::Zone(zone.id));
        add_area(overlay, corners, z, (&zone.effect, is_selected), tokens);
        add_handles(overlay, zone.id, corners, z, is_selected, tokens);
    }
    if let Some(drawn) = preview.zone.as_ref().filter(|drawn| drawn.zone.is_none()) {
        let z = drawn.floor_m + CONFIG.height_m;
        add_area(overlay, &drawn.corners_m, z, (&ZoneEffect::KeepOut, true), tokens);
    }
}

/// Height of the floor in a zone, m, map frame.
pub(crate) fn floor_m(model: &Model, zone: &Zone) -> f64 {
    let base_m = model.site.base_height_in_m(&zone.corners_m, zone.height_m);
    base_m.map_or(0.0, |base_m| base_m - model.platform.standing_height_m())
}

/// Colour by which the effect of a zone is told. Its name and hatching tell it too.
fn colour_of(effect: &ZoneEffect, tokens: &Tokens) -> Color32 {
    match effect {
        ZoneEffect::KeepOut => tokens.bad,
        ZoneEffect::SpeedLimit(_) => tokens.warn,
        ZoneEffect::Penalty(_) | ZoneEffect::Action(_) => tokens.accent,
    }
}

fn add_area(
    overlay: &mut GraphOverlay,
    corners_m: &[[f64; 2]],
    z: f64,
    (effect, is_selected): (&ZoneEffect, bool),
    tokens: &Tokens,
) {
    let colour = solid(colour_of(effect, tokens));
    let mut outline: Vec<DVec3> = corners_m.iter().map(|[x, y]| DVec3::new(*x, *y, z)).collect();
    outline.extend(outline.first().copied());
    let dash = if matches!(effect, ZoneEffect::SpeedLimit(_)) { CONFIG.dash_m } else { 0.0 };
    let width = if is_selected { 1.6 * CONFIG.line_width_px } else { CONFIG.line_width_px };
    overlay.lines.push(Polyline { points: outline, colour, width, dash });
    if matches!(effect, ZoneEffect::KeepOut) {
        let width = CONFIG.hatch_width_px;
        let corners: Vec<DVec2> = corners_m.iter().map(|corner| DVec2::from_array(*corner)).collect();
        let lines = scene::hatching(&corners, CONFIG.hatch_m, CONFIG.max_hatch_lines).into_iter();
        let lines = lines.map(|ends| ends.map(|at| at.extend(z)).to_vec());
        overlay.lines.extend(lines.map(|points| Polyline { points, colour, width, dash: 0.0 }));
    }
}

/// A marker in the middle, and on the zone that is selected one on each corner and side.
fn add_handles(
    overlay: &mut GraphOverlay,
    zone: ZoneId,
    corners_m: &[[f64; 2]],
    z: f64,
    is_selected: bool,
    tokens: &Tokens,
) {
    let fill = if is_selected { tokens.accent } else { tokens.card };
    let rim = if tokens.dark { tokens.text } else { tokens.ground };
    let [x, y] = middle_of(corners_m);
    let middle = marker(DVec3::new(x, y, z), MarkerShape::Square, CONFIG.corner_radius_px, fill, rim);
    overlay.push(middle, GraphTarget::Object(Selection::Zone(zone)));
    if !is_selected {
        return;
    }
    for (index, [x, y]) in corners_m.iter().enumerate() {
        let at = DVec3::new(*x, *y, z);
        let corner = marker(at, MarkerShape::Disc, CONFIG.corner_radius_px, tokens.accent, rim);
        overlay.push(corner, GraphTarget::ZoneCorner(zone, index));
        let [next_x, next_y] = corners_m[(index + 1) % corners_m.len()];
        let middle = at.midpoint(DVec3::new(next_x, next_y, z));
        let side: Marker =
            marker(middle, MarkerShape::Ring, CONFIG.side_radius_px, tokens.accent, tokens.accent);
        overlay.push(side, GraphTarget::ZoneSide(zone, index));
    }
}
