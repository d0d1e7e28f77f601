//! Boxes of what has changed between visits, over the scene.

use crate::vector::vector;
use client_model::Model;
use glam::DVec3;
use scene::{Colour, Polyline};
use site_model::{OrientedBox, SceneChangeKind};

/// What appeared, and what was moved to its place.
const APPEARED: Colour = [222, 60, 48, 255];
/// What is gone.
const REMOVED: Colour = [150, 176, 208, 255];
/// Of the points of the earlier and of the later visit.
pub(crate) const COLOURS: [Colour; 2] = [REMOVED, APPEARED];
/// Width of the lines, logical px.
const WIDTH_PX: f32 = 2.0;

/// Adds the boxes of all changes that somebody still has to see, in the map on the screen; a line from and to for those that were moved.
pub(crate) fn add(model: &Model, lines: &mut Vec<Polyline>) {
    let Some(site) = model.site.site().filter(|_| panels::shows_changes(model)) else { return };
    let map = model.saved_map_on_screen();
    for change in site.scene_changes() {
        if map != Some(change.map) || change.review.is_settled() {
            continue;
        }
        let [earlier, later] = model.changes_view.shown().visits();
        let (from, to) = match &change.kind {
            SceneChangeKind::Appeared => (None, Some(&change.place)),
            SceneChangeKind::Removed => (Some(&change.place), None),
            SceneChangeKind::Moved { from } => (Some(from), Some(&change.place)),
        };
        if let Some(from) = from.filter(|_| earlier) {
            add_box(lines, from, REMOVED);
        }
        if let Some(to) = to.filter(|_| later) {
            add_box(lines, to, APPEARED);
        }
        if let (Some(from), Some(to), true) = (from, to, earlier && later) {
            add_line(lines, vec![vector(from.centre_m), vector(to.centre_m)], APPEARED);
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
