//! A picture, thermal picture or spectrum in a place of the screen, with its caption. Several in a row share the part that is looked at, the scale of temperatures
//! and the axis of counts, so that they compare.

use super::picture_paint::{paint_marker, paint_needle, paint_picture, paint_scale, show_note};
use super::picture_view::{PictureView, middle_of, pixel_at, place_of_px};
use super::picture_warp::{ChangeFrames, paint_warped};
use super::{spectrum, texts};
use crate::Width;
use crate::feature_panel::PanelContext;
use crate::result_files::ResultFile;
use crate::theme::{self, GAP, Weight, font};
use crate::thermal::{Scale, ThermalPicture};
use crate::widgets;
use client_model::ResultFileKind;
use egui::{Align2, Color32, Pos2, Rect, Response, Sense, Ui, Vec2, pos2, vec2};
use site_model::{ActionReport, AlignedPictures, ReportFile};

/// Width of the scale of a thermal picture with its labels, points.
const SCALE_WIDTH: f32 = 72.0;
/// Height of the line above a picture, points.
const CAPTION_HEIGHT: f32 = 28.0;

/// One of the pictures that are shown.
pub(crate) struct Pane {
    pub(crate) file: ReportFile,
    pub(crate) kind: ResultFileKind,
    /// What stands above it.
    pub(crate) caption: String,
    /// The needle of a gauge that was read in it.
    pub(crate) needle: Option<ReadNeedle>,
    /// How it is drawn as a later picture sees it; none: as it was taken.
    pub(crate) aligned: Option<AlignedPictures>,
    /// Frames round what has changed, in pixels of the picture as it is drawn: aligned or as it was taken.
    pub(crate) changes: Option<ChangeFrames>,
}

/// A needle in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ReadNeedle {
    /// Where it turns and where it ends, pixels.
    ends_px: [[f64; 2]; 2],
    /// Columns and rows of the picture.
    size_px: [u32; 2],
}

impl ReadNeedle {
    /// The needle that was read in the picture of a report.
    pub(crate) fn of(report: &ActionReport) -> Option<Self> {
        let (gauge, camera) = (report.gauge.as_ref()?, report.camera.as_ref()?);
        Some(Self { ends_px: gauge.needle_px?, size_px: camera.size_px })
    }
}

impl Pane {
    /// Where the axis and the tip of the needle are, if the picture is shown at a place.
    fn needle_ends(&self, shown: Rect) -> Option<[Pos2; 2]> {
        let ReadNeedle { ends_px, size_px } = self.needle?;
        let Some(aligned) = &self.aligned else {
            return Some(ends_px.map(|px| place_of_px(px, shown, size_px)));
        };
        let [axis, tip] = ends_px.map(|px| Some(place_of_px(aligned.map(px)?, shown, aligned.after_size_px)));
        axis.zip(tip).map(<[Pos2; 2]>::from)
    }
}

/// What all panes share.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct CommonAxes {
    /// The scale of thermal pictures, so that equal colours are equal temperatures.
    scale: Option<Scale>,
    /// The greatest number of events in a channel of a spectrum.
    highest: u32,
}

impl CommonAxes {
    /// Of those of these panes whose files were fetched.
    pub(crate) fn of<'a>(cx: &mut PanelContext<'_>, panes: impl IntoIterator<Item = &'a Pane>) -> Self {
        let mut axes = Self::default();
        for pane in panes {
            match cx.files.get(pane.file.blob, pane.kind) {
                ResultFile::Thermal(picture) => {
                    let scale = picture.scale();
                    axes.scale = Some(axes.scale.map_or(scale, |known| known.of_both(scale)));
                }
                ResultFile::Spectrum(found) => axes.highest = axes.highest.max(spectrum::highest(found)),
                _ => {}
            }
        }
        axes
    }

    /// The scale in which a thermal picture is shown: its own if it shares none.
    pub(crate) fn scale_of(&self, picture: &ThermalPicture) -> Scale {
        self.scale.unwrap_or_else(|| picture.scale())
    }
}

/// Shows a pane with its caption. Wheel, pinch and drag change the part that is looked at.
pub(crate) fn show_pane(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    pane: &Pane,
    place: Rect,
    axes: CommonAxes,
    view: &mut PictureView,
) {
    let (line, rect) = split_caption(place);
    show_caption(ui, cx, line, &pane.caption);
    let response = ui.interact(rect, ui.scope_id().with(("pane", pane.file.blob.0)), Sense::click_and_drag());
    paint_ground(ui, cx, rect);
    follow(ui, cx, pane, rect, &response, view);
    let Some(read) = paint_pane(ui, cx, pane, rect, axes, view, response.hover_pos()) else { return };
    let at = pos2(rect.right() - 16.0, line.center().y);
    let small = font(theme::BODY, Weight::Regular);
    ui.painter().text(at, Align2::RIGHT_CENTER, &read.total, small, cx.tokens.dim);
    widgets::status_node(&response, texts::SPECTRUM, &read.value());
}

/// The line of the caption, and the place below it.
pub(crate) fn split_caption(place: Rect) -> (Rect, Rect) {
    place.split_top_bottom_at_y(place.top() + CAPTION_HEIGHT)
}

/// What stands above a picture.
pub(crate) fn show_caption(ui: &Ui, cx: &PanelContext<'_>, line: Rect, caption: &str) {
    let style = (theme::BODY, Weight::Medium);
    crate::paint::line_at(ui, line.left_center(), line.width(), caption, style, cx.tokens.text);
}

/// The ground behind a picture.
pub(crate) fn paint_ground(ui: &Ui, cx: &PanelContext<'_>, rect: Rect) {
    let ground = if cx.tokens.dark { Color32::from_gray(8) } else { cx.tokens.ground };
    ui.painter().rect_filled(rect, f32::from(theme::BUTTON_RADIUS), ground);
}

/// Lets wheel, pinch and drag over a pane change the part that is looked at. A spectrum has no such part.
pub(crate) fn follow(
    ui: &Ui,
    cx: &mut PanelContext<'_>,
    pane: &Pane,
    rect: Rect,
    response: &Response,
    view: &mut PictureView,
) {
    let (size, rect) = match cx.files.get(pane.file.blob, pane.kind) {
        ResultFile::Picture(texture) => (texture.size_vec2(), rect),
        ResultFile::Thermal(picture) => (size_of(picture), split_scale(rect).0),
        ResultFile::Spectrum(_) | ResultFile::Loading | ResultFile::Failed(_) => return,
    };
    view.follow(ui, response, rect, size);
}

/// What is read in a spectrum.
pub(crate) struct SpectrumReading {
    /// Counts and live time.
    total: String,
    /// At the pointer.
    here: Option<String>,
}

impl SpectrumReading {
    fn value(&self) -> String {
        self.here.as_ref().map_or_else(|| self.total.clone(), |here| format!("{} · {here}", self.total))
    }
}

/// Paints what a pane shows into a place. `pointer`: where something is read. Returns what is read in a spectrum.
pub(crate) fn paint_pane(
    ui: &Ui,
    cx: &mut PanelContext<'_>,
    pane: &Pane,
    rect: Rect,
    axes: CommonAxes,
    view: &PictureView,
    pointer: Option<Pos2>,
) -> Option<SpectrumReading> {
    let tokens = cx.tokens;
    match cx.files.get(pane.file.blob, pane.kind) {
        ResultFile::Loading => show_note(ui, tokens, rect, texts::FETCHING_FILE),
        ResultFile::Failed(sentence) => show_note(ui, tokens, rect, &sentence.clone()),
        ResultFile::Picture(texture) => {
            let shown = match &pane.aligned {
                None => {
                    let shown = view.picture_rect(rect, texture.size_vec2());
                    paint_picture(ui, texture.id(), shown, rect);
                    shown
                }
                Some(aligned) => {
                    let [columns, rows] = aligned.after_size_px;
                    let shown = view.picture_rect(rect, vec2(columns as f32, rows as f32));
                    paint_warped(ui, texture.id(), aligned, shown, rect);
                    shown
                }
            };
            if let Some([axis, tip]) = pane.needle_ends(shown) {
                paint_needle(ui, tokens, rect, [axis, tip]);
            }
            if let Some(changes) = &pane.changes {
                changes.paint(ui, tokens, rect, shown);
            }
        }
        ResultFile::Thermal(picture) => {
            let scale = axes.scale_of(picture);
            let texture = picture.texture(ui.ctx(), scale);
            let (rect, side) = split_scale(rect);
            let shown = view.picture_rect(rect, texture.size_vec2());
            paint_picture(ui, texture.id(), shown, rect);
            let read = paint_temperatures(ui, picture, rect, shown, pointer);
            paint_scale(ui, tokens, side.shrink2(vec2(8.0, 16.0)), scale, read);
        }
        ResultFile::Spectrum(found) => {
            let highest = axes.highest.max(spectrum::highest(found));
            let here = spectrum::paint(ui, tokens, rect, found, highest, pointer);
            let total = texts::spectrum_total(spectrum::total(found), found.live_time_s);
            return Some(SpectrumReading { total, here });
        }
    }
    None
}

/// Marks the warmest pixel and the one at the pointer. Returns the temperature of the last one, degrees Celsius.
fn paint_temperatures(
    ui: &Ui,
    picture: &ThermalPicture,
    rect: Rect,
    shown: Rect,
    pointer: Option<Pos2>,
) -> Option<f64> {
    let pixel = pointer.filter(|at| rect.contains(*at)).and_then(|at| pixel_at(at, shown, picture.size()));
    let mut read = None;
    for (pixel, what) in [(picture.warmest(), texts::WARMEST), (pixel, texts::HERE)] {
        let Some((pixel, celsius)) = pixel.and_then(|it| Some((it, picture.at(it[0], it[1])?))) else {
            continue;
        };
        let at = middle_of(pixel, shown, picture.size());
        paint_marker(ui, rect, at, &texts::marker(what, celsius));
        read = Some(celsius);
    }
    read
}

/// The places of a thermal picture and of its scale.
fn split_scale(rect: Rect) -> (Rect, Rect) {
    rect.split_left_right_at_x(rect.right() - SCALE_WIDTH)
}

fn size_of(picture: &ThermalPicture) -> Vec2 {
    let [columns, rows] = picture.size();
    vec2(columns as f32, rows as f32)
}

/// Places for two pictures: beside each other, or on narrow windows below each other.
pub(crate) fn halves(rect: Rect, width: Width) -> [Rect; 2] {
    let half = 0.5 * GAP;
    if width == Width::Narrow {
        let (a, b) = rect.split_top_bottom_at_fraction(0.5);
        [a.with_max_y(a.bottom() - half), b.with_min_y(b.top() + half)]
    } else {
        let (a, b) = rect.split_left_right_at_fraction(0.5);
        [a.with_max_x(a.right() - half), b.with_min_x(b.left() + half)]
    }
}
