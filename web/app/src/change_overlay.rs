//! Boxes of what has changed between visits, over the scene.

use crate::vector::vector;
use client_model::Model;
use glam::DVec3;
use scene::{Colour, Polyline};
use site_model::{OrientedBox, ReviewState, SceneChangeKind};

/// What appeared, and what was moved to its place.
const APPEARED: Colour = [222, 60, 48, 255];
/// What is gone.
const REMOVED: Colour = [150, 176, 208, 255];
/// Width of the lines, logical px.
const WIDTH_PX: f32 = 2.0;

/// Adds the boxes of all changes that were not dismissed, in the map on the screen; a line from and to for those that were moved.
pub(crate) fn add(model: &Model, lines: &mut Vec<Polyline>) {
    let Some(site) = model.site.site().filter(|_| panels::shows_changes(model)) else { return };
    let map = model.saved_map_on_screen();
    for change in site.scene_changes() {
        if map != Some(change.map) || matches!(change.review, ReviewState::Dismissed { .. }) {
            continue;
        }
        match &change.kind {
            SceneChangeKind::Appeared => add_box(lines, &change.place, APPEARED),
            SceneChangeKind::Removed => add_box(lines, &change.place, REMOVED),
            SceneChangeKind::Moved { from } => {
                add_box(lines, from, REMOVED);
                add_box(lines, &change.place, APPEARED);
                add_line(lines, vec![vector(from.centre_m), vector(change.place.centre_m)], APPEARED);
            }
        }
    }
}

/// The edges of a box: once round its lower end, up, once round its upper end; and the three edges that are left.
fn add_box(lines: &mut Vec<Polyline>, place: &OrientedBox, colour: Colour) {
    let (sine, cosine) = place.yaw_rad.sin_cos();
    let [along, across, up] = place.size_m.map(|side| side / 2.0);
    let corner = |number: usize, above: f64| {
        let (x, y) = [(along, across), (-along, across), (-along, -across), (along, -across)][number % 4];
        vector(place.centre_m) + DVec3::new(cosine * x - sine * y, sine * x + cosine * y, above * up)
    };
    let round = [-1.0, 1.0].into_iter().flat_map(|above| (0..5).map(move |number| (number, above)));
    add_line(lines, round.map(|(number, above)| corner(number, above)).collect(), colour);
    for number in 1..4 {
        add_line(lines, vec![corner(number, -1.0), corner(number, 1.0)], colour);
    }
}

fn add_line(lines: &mut Vec<Polyline>, points: Vec<DVec3>, colour: Colour) {
    lines.push(Polyline { points, colour, width: WIDTH_PX, dash: 0.0 });
}
