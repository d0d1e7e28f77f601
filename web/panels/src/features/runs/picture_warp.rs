//! An earlier picture as a later one sees it, and frames round what has changed between both.

use super::picture_view::place_of_px;
use crate::theme::Tokens;
use egui::{Color32, Mesh, Pos2, Rect, Ui, pos2, vec2};
use site_model::{AlignedPictures, PictureChange};

/// Cells along each side of the mesh of a picture. Chosen: within a cell a picture is drawn without perspective; a test says that this moves no pixel by more than half a one.
const CELLS: usize = 24;
/// Distance of a frame from what it surrounds, points.
const FRAME_GAP: f32 = 5.0;
/// Shortest side of a frame, points. Chosen: a small change is found with the eye.
const MIN_FRAME: f32 = 26.0;

/// Frames round what has changed, in the pixels of the picture on which they are drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ChangeFrames {
    /// Corners of each change.
    corners_px: Vec<[[f64; 2]; 4]>,
    /// Columns and rows of the picture.
    size_px: [u32; 2],
}

impl ChangeFrames {
    /// In the later picture.
    pub(crate) fn after(aligned: &AlignedPictures) -> Self {
        let corners = aligned.changes.iter().filter_map(|change| aligned.corners_after(change));
        Self { corners_px: corners.collect(), size_px: aligned.after_size_px }
    }

    /// In the earlier picture, as it was taken.
    pub(crate) fn before(aligned: &AlignedPictures) -> Self {
        let corners = |change: &PictureChange| {
            let [[left, top], [right, bottom]] = [change.min_px, change.max_px].map(|px| px.map(f64::from));
            [[left, top], [right, top], [right, bottom], [left, bottom]]
        };
        Self { corners_px: aligned.changes.iter().map(corners).collect(), size_px: aligned.before_size_px }
    }

    /// Draws them over a picture that is shown at a place.
    pub(super) fn paint(&self, ui: &Ui, tokens: &Tokens, clip: Rect, shown: Rect) {
        let painter = ui.painter_at(clip);
        for corners in &self.corners_px {
            let places = corners.map(|px| place_of_px(px, shown, self.size_px));
            let whole = Rect::from_points(&places).expand(FRAME_GAP);
            let frame = Rect::from_center_size(whole.center(), whole.size().max(vec2(MIN_FRAME, MIN_FRAME)));
            for (width, colour) in [(4.5, Color32::from_black_alpha(190)), (2.0, tokens.warn)] {
                painter.rect_stroke(frame, 5.0, (width, colour), egui::StrokeKind::Middle);
            }
        }
    }
}

/// Draws an earlier picture where the later one, which is shown at a place, has it.
pub(super) fn paint_warped(
    ui: &Ui,
    texture: egui::TextureId,
    aligned: &AlignedPictures,
    shown: Rect,
    clip: Rect,
) {
    let mut mesh = Mesh::with_texture(texture);
    let places = vertices(aligned).map(|(share, px)| {
        let place = px.map(|px| place_of_px(px, shown, aligned.after_size_px));
        (pos2(share[0], share[1]), place)
    });
    let places: Vec<(Pos2, Option<Pos2>)> = places.collect();
    for (uv, place) in &places {
        mesh.vertices.push(egui::epaint::Vertex {
            pos: place.unwrap_or(shown.min),
            uv: *uv,
            color: Color32::WHITE,
        });
    }
    let across = CELLS + 1;
    for (row, column) in (0..CELLS).flat_map(|row| (0..CELLS).map(move |column| (row, column))) {
        let at = row * across + column;
        let cell = [at, at + 1, at + across, at + across + 1];
        // What is not ahead of the later camera has no place.
        if cell.iter().all(|vertex| places[*vertex].1.is_some()) {
            let [a, b, c, d] = cell.map(|vertex| vertex as u32);
            mesh.add_triangle(a, b, c);
            mesh.add_triangle(b, d, c);
        }
    }
    ui.painter_at(clip.intersect(shown)).add(mesh);
}

/// Corners of the cells, row by row: as shares of the earlier picture, and where they are in the later one, pixels.
fn vertices(aligned: &AlignedPictures) -> impl Iterator<Item = ([f32; 2], Option<[f64; 2]>)> {
    let of = |row: usize, column: usize| {
        let share = [column, row].map(|at| at as f64 / CELLS as f64);
        let px = [0, 1].map(|axis| share[axis] * f64::from(aligned.before_size_px[axis]) - 0.5);
        (share.map(|share| share as f32), aligned.map(px))
    };
    (0..=CELLS).flat_map(move |row| (0..=CELLS).map(move |column| of(row, column)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 640 x 480 pixels, displaced, turned by 3 degrees and seen from 20 degrees aside, at a field of view of 40 degrees.
    fn seen_from_aside() -> AlignedPictures {
        AlignedPictures {
            after_from_before: [[0.94, -0.052, 31.0], [0.052, 1.0, -12.0], [-3.9e-4, 2.0e-5, 1.0]],
            residual_px: 0.2,
            before_size_px: [640, 480],
            after_size_px: [640, 480],
            changes: Vec::new(),
        }
    }

    #[test]
    fn a_picture_that_is_drawn_in_triangles_is_right_within_half_a_pixel() {
        let aligned = seen_from_aside();
        let vertices: Vec<_> = vertices(&aligned).collect();
        let across = CELLS + 1;
        let mut worst = 0.0_f64;
        for (row, column) in
            (0..480).step_by(3).flat_map(|row| (0..640).step_by(3).map(move |column| (row, column)))
        {
            let px = [f64::from(column), f64::from(row)];
            let at =
                [0, 1].map(|axis| (px[axis] + 0.5) / f64::from(aligned.before_size_px[axis]) * CELLS as f64);
            let cell = at.map(|at| (at.floor() as usize).min(CELLS - 1));
            let [right, down] = [0, 1].map(|axis| at[axis] - cell[axis] as f64);
            let corner = |dx: usize, dy: usize| {
                vertices[(cell[1] + dy) * across + cell[0] + dx].1.expect("ahead of the camera")
            };
            // The two triangles of a cell meet on the line from its top right to its bottom left.
            let (origin, along_x, along_y, [x, y]) = if right + down <= 1.0 {
                (corner(0, 0), corner(1, 0), corner(0, 1), [right, down])
            } else {
                (corner(1, 1), corner(0, 1), corner(1, 0), [1.0 - right, 1.0 - down])
            };
            let drawn = [0, 1].map(|axis| {
                origin[axis] + x * (along_x[axis] - origin[axis]) + y * (along_y[axis] - origin[axis])
            });
            let exact = aligned.map(px).expect("ahead of the camera");
            worst = worst.max((drawn[0] - exact[0]).hypot(drawn[1] - exact[1]));
        }
        assert!(worst < 0.5, "{worst:.3} pixels");
        assert!(worst > 0.01, "the triangles are tested: {worst:.3} pixels");
    }

    #[test]
    fn frames_are_where_each_picture_has_the_change() {
        let change = PictureChange { min_px: [100, 50], max_px: [119, 69], area_px: 300, strength: 0.9 };
        let aligned = AlignedPictures {
            after_from_before: [[1.0, 0.0, 8.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            changes: vec![change],
            ..seen_from_aside()
        };
        assert_eq!(ChangeFrames::before(&aligned).corners_px[0][0], [100.0, 50.0]);
        assert_eq!(ChangeFrames::after(&aligned).corners_px[0][2], [127.5, 69.5]);
    }
}
