//! A part of a picture that is looked at: zoomed by wheel and pinch, moved by a drag. Pictures side by side share it.

use egui::{Pos2, Rect, Response, Ui, Vec2, pos2, vec2};

/// Parameters of the magnification of a picture.
pub(super) struct PictureZoomConfig {
    /// Greatest magnification of the whole picture. Chosen: single pixels are seen by then.
    pub(super) max_factor: f32,
    /// Magnification of one press of a button. Chosen: two presses are a little more than twice.
    pub(super) step_factor: f32,
    /// Logarithm of the magnification of one point of the wheel. Chosen: a notch of 50 points magnifies by a fifth.
    pub(super) wheel_log_factor: f32,
}

pub(super) const ZOOM: PictureZoomConfig =
    PictureZoomConfig { max_factor: 16.0, step_factor: 1.5, wheel_log_factor: 0.004 };

/// The part of a picture that is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PictureView {
    /// 1 shows the whole picture.
    pub(super) zoom: f32,
    /// The point of the picture in the middle, as shares of its width and height.
    pub(super) centre: Vec2,
}

impl Default for PictureView {
    fn default() -> Self {
        Self { zoom: 1.0, centre: Vec2::splat(0.5) }
    }
}

impl PictureView {
    /// Where a picture of `size` lies if its view fills `pane`.
    pub(crate) fn picture_rect(&self, pane: Rect, size: Vec2) -> Rect {
        let shown = size * (self.zoom * (pane.size() / size).min_elem());
        Rect::from_min_size(pane.center() - self.centre * shown, shown)
    }

    /// Magnifies, so that the point of the picture at `at` stays there.
    pub(super) fn zoom_by(&mut self, factor: f32, at: Pos2, pane: Rect, size: Vec2) {
        let before = self.picture_rect(pane, size);
        let share = (at - before.min) / before.size();
        self.zoom = (self.zoom * factor).clamp(1.0, ZOOM.max_factor);
        let after = self.picture_rect(pane, size);
        self.centre += share - (at - after.min) / after.size();
        self.keep_inside(pane, size);
    }

    /// Follows wheel, pinch and drag over a pane.
    pub(super) fn follow(&mut self, ui: &Ui, response: &Response, pane: Rect, size: Vec2) {
        if response.double_clicked() {
            *self = Self::default();
        }
        if response.dragged() {
            self.centre -= response.drag_delta() / self.picture_rect(pane, size).size();
            self.keep_inside(pane, size);
        }
        let Some(at) = response.hover_pos() else { return };
        let (wheel, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
        let factor = pinch * (wheel * ZOOM.wheel_log_factor).exp();
        if factor != 1.0 {
            self.zoom_by(factor, at, pane, size);
        }
    }

    /// No empty stripe beside a picture that is larger than the pane; in the middle otherwise.
    fn keep_inside(&mut self, pane: Rect, size: Vec2) {
        let shown = self.picture_rect(pane, size).size();
        let keep = |centre: f32, pane: f32, shown: f32| {
            let half = (0.5 * pane / shown).min(0.5);
            centre.clamp(half, 1.0 - half)
        };
        self.centre =
            vec2(keep(self.centre.x, pane.width(), shown.x), keep(self.centre.y, pane.height(), shown.y));
    }
}

/// The pixel of a picture at a point, if there is one.
pub(super) fn pixel_at(at: Pos2, picture: Rect, size: [usize; 2]) -> Option<[usize; 2]> {
    let share = (at - picture.min) / picture.size();
    let is_inside = (0.0..1.0).contains(&share.x) && (0.0..1.0).contains(&share.y);
    is_inside.then(|| [(share.x * size[0] as f32) as usize, (share.y * size[1] as f32) as usize])
}

/// The middle of a pixel.
pub(super) fn middle_of([column, row]: [usize; 2], picture: Rect, size: [usize; 2]) -> Pos2 {
    let share = |pixel: usize, pixels: usize| (pixel as f32 + 0.5) / pixels.max(1) as f32;
    pos2(
        picture.left() + share(column, size[0]) * picture.width(),
        picture.top() + share(row, size[1]) * picture.height(),
    )
}

/// Where a place in a picture is on the screen. Pixels count from the top left; the middle of the first one is 0, 0.
pub(crate) fn place_of_px(px: [f64; 2], picture: Rect, size_px: [u32; 2]) -> Pos2 {
    let share = |axis: usize| ((px[axis] + 0.5) / f64::from(size_px[axis].max(1))) as f32;
    picture.lerp_inside(vec2(share(0), share(1)))
}

/// The inverse of [`place_of_px`].
pub(crate) fn px_at(at: Pos2, picture: Rect, size_px: [u32; 2]) -> [f64; 2] {
    let share = (at - picture.min) / picture.size();
    let px = |share: f32, size: u32| f64::from(share) * f64::from(size) - 0.5;
    [px(share.x, size_px[0]), px(share.y, size_px[1])]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Vec2 = Vec2::new(640.0, 480.0);

    fn pane() -> Rect {
        Rect::from_min_size(pos2(100.0, 50.0), vec2(800.0, 480.0))
    }

    #[test]
    fn the_point_under_the_pointer_stays_there_and_the_picture_covers_the_pane() {
        let mut view = PictureView::default();
        assert_eq!(view.picture_rect(pane(), SIZE).size(), SIZE, "as large as the pane is high");
        let at = pos2(600.0, 200.0);
        let before = pixel_at(at, view.picture_rect(pane(), SIZE), [640, 480]).unwrap();
        view.zoom_by(4.0, at, pane(), SIZE);
        assert_eq!(pixel_at(at, view.picture_rect(pane(), SIZE), [640, 480]), Some(before));
        view.centre = vec2(-3.0, 9.0);
        view.keep_inside(pane(), SIZE);
        assert!(view.picture_rect(pane(), SIZE).contains_rect(pane()));
        view.zoom_by(0.01, at, pane(), SIZE);
        assert_eq!(view, PictureView::default());
        let picture = view.picture_rect(pane(), SIZE);
        assert_eq!(pixel_at(middle_of([3, 7], picture, [640, 480]), picture, [640, 480]), Some([3, 7]));
        assert_eq!(pixel_at(pos2(0.0, 0.0), picture, [640, 480]), None);
        let px = px_at(place_of_px([3.25, 7.0], picture, [640, 480]), picture, [640, 480]);
        assert!((px[0] - 3.25).abs() < 1e-3 && (px[1] - 7.0).abs() < 1e-3, "{px:?}");
    }
}
