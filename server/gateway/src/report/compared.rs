//! A photo that differs from an earlier one of its inspection point: both beside each other, with a frame round each change.

use super::context::ReportContext;
use super::file_view::{FileView, OpenedPicture, open};
use super::format;
use super::html::Html;
use super::rows::{ResultContent, ResultRow};
use super::texts;
use crate::runs::CoreQueries;
use api::{Query, QueryReply, StoredResult};
use site_model::{AlignedPictures, PictureComparison, PictureComparisonOutcome, ReportFile, Utc};
use std::fmt::Write;
use std::io;

/// Distance of a frame from its change, pixels of the picture.
const FRAME_GAP_PX: f64 = 6.0;

/// A photo with changes.
pub(super) struct ComparedPhoto {
    aligned: AlignedPictures,
    /// The earlier photo, and when it was taken.
    before: Option<(ReportFile, Utc)>,
}

impl ComparedPhoto {
    /// The changes of the photo of a result; none if it has none.
    ///
    /// # Errors
    /// When the core fails.
    pub(super) fn of(
        core: &dyn CoreQueries,
        stored: &StoredResult,
        row: &ResultRow,
    ) -> io::Result<Option<Self>> {
        let Some(PictureComparison { before, outcome: PictureComparisonOutcome::Aligned(aligned) }) =
            comparison(stored)
        else {
            return Ok(None);
        };
        if aligned.changes.is_empty() {
            return Ok(None);
        }
        let mut found = None;
        if let Some(point) = row.point {
            let query = Query::PointResults { point, before: before.checked_add(1), limit: 1 };
            if let QueryReply::Results(results) = core.ask(query)? {
                found = results.into_iter().find(|result| result.number == before);
            }
        }
        let before = found.and_then(|stored| {
            let row = ResultRow::of(&stored);
            let ResultContent::Report(report) = row.content else { return None };
            let file = report.files.into_iter().find(|file| file.media_type.starts_with("image/"))?;
            Some((file, row.at))
        });
        Ok(Some(Self { aligned, before }))
    }

    /// The sentence above both.
    pub(super) fn sentence(&self) -> String {
        texts::changed_photo(self.aligned.changes.len(), self.aligned.residual_px)
    }

    /// Writes the earlier photo, if it is there.
    pub(super) fn write_before(
        &self,
        html: &mut Html<'_>,
        cx: &ReportContext,
        place: &str,
    ) -> io::Result<()> {
        let Some((file, at)) = &self.before else { return Ok(()) };
        let FileView::Picture(picture) = open(cx.data_dir(), file) else { return Ok(()) };
        let at = format::short_date_and_time(cx.local(*at));
        let corners = self.aligned.changes.iter().map(|change| {
            let [[left, top], [right, bottom]] = [change.min_px, change.max_px].map(|px| px.map(f64::from));
            [[left, top], [right, top], [right, bottom], [left, bottom]]
        });
        let frames = frames(corners);
        write_framed(html, picture, (self.aligned.before_size_px, &frames), &texts::photo_before(place, &at))
    }

    /// Writes the photo itself.
    pub(super) fn write_after(
        &self,
        html: &mut Html<'_>,
        picture: OpenedPicture,
        caption: &str,
    ) -> io::Result<()> {
        let corners = self.aligned.changes.iter().filter_map(|change| self.aligned.corners_after(change));
        write_framed(html, picture, (self.aligned.after_size_px, &frames(corners)), caption)
    }
}

/// How a photo differs from an earlier one; none if it was not compared.
pub(super) fn comparison(stored: &StoredResult) -> Option<PictureComparison> {
    serde_json::from_str(stored.comparison.as_ref()?).ok()
}

/// A path round all changes. The middle of the first pixel is half a pixel from the edges of the picture.
fn frames(corners: impl Iterator<Item = [[f64; 2]; 4]>) -> String {
    let mut path = String::new();
    for corners in corners {
        let edge = |axis: usize, pick: fn(f64, f64) -> f64| {
            corners.iter().map(|corner| corner[axis] + 0.5).reduce(pick).unwrap_or_default()
        };
        let [left, top] = [0, 1].map(|axis| edge(axis, f64::min) - FRAME_GAP_PX);
        let [right, bottom] = [0, 1].map(|axis| edge(axis, f64::max) + FRAME_GAP_PX);
        // Writing into a string does not fail.
        let _ = write!(path, "M{left:.1} {top:.1} H{right:.1} V{bottom:.1} H{left:.1} Z ");
    }
    path
}

fn write_framed(
    html: &mut Html<'_>,
    picture: OpenedPicture,
    ([columns, rows], frames): ([u32; 2], &str),
    caption: &str,
) -> io::Result<()> {
    html.markup("<figure><svg class=\"framed\" viewBox=\"0 0 ")?;
    html.text(&format!("{columns} {rows}"))?;
    html.markup("\" role=\"img\" aria-label=\"")?;
    html.text(caption)?;
    html.markup("\"><image width=\"100%\" height=\"100%\" href=\"")?;
    picture.write_address(html)?;
    html.markup("\"></image>\n")?;
    for class in ["beside", "frame"] {
        html.markup("<path class=\"")?;
        html.markup(class)?;
        html.markup("\" d=\"")?;
        html.text(frames)?;
        html.markup("\"></path>\n")?;
    }
    html.markup("</svg>\n")?;
    html.element("figcaption", "", caption)?;
    html.close("figure")
}
