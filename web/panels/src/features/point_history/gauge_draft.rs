//! What is marked and entered of a gauge before it is saved, and the dial that follows from it.

use site_model::{DialDirection, GaugeDial, GaugeDialError, InspectionPointId, ReportFile};
use std::f64::consts::TAU;

/// The marks in the order in which they are asked for, by their accessible names. A scale that is a full turn has the first two only.
pub(super) const MARKS: [&str; 4] =
    ["Centre of the scale", "Lower end of the scale", "Middle of the scale", "Upper end of the scale"];

/// Points of the drawn scale.
const ARC_POINTS: usize = 49;

/// A gauge that is being described.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct GaugeDraft {
    pub(super) point: InspectionPointId,
    /// The photo in which it is described.
    pub(super) file: ReportFile,
    /// Columns and rows of the photo; none until it is fetched, if the report does not say it.
    pub(super) size_px: Option<[u32; 2]>,
    marks: [Option<[f64; 2]>; 4],
    pub(super) is_full_turn: bool,
    pub(super) direction: DialDirection,
    /// Values at both ends of the scale.
    pub(super) range: [Option<f64>; 2],
    /// Empty until one is chosen.
    pub(super) unit: String,
}

/// What is missing before it can be saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Missing {
    Marks,
    Values,
    Of(GaugeDialError),
}

impl GaugeDraft {
    /// Nothing is marked yet. Values and unit are those of the description that there is.
    pub(super) fn new(
        point: InspectionPointId,
        file: ReportFile,
        size_px: Option<[u32; 2]>,
        known: Option<&GaugeDial>,
    ) -> Self {
        Self {
            point,
            file,
            size_px,
            marks: [None; 4],
            is_full_turn: known.is_some_and(|dial| dial.end_px.is_none()),
            direction: known.map(|dial| dial.direction).unwrap_or_default(),
            range: known.map_or([None; 2], |dial| dial.range.map(Some)),
            unit: known.map(|dial| dial.unit.clone()).unwrap_or_default(),
        }
    }

    /// The description that there is, in its own photo.
    pub(super) fn of(point: InspectionPointId, file: ReportFile, dial: &GaugeDial) -> Self {
        let marks = [Some(dial.centre_px), Some(dial.start_px), dial.middle_px, dial.end_px];
        Self { marks, ..Self::new(point, file, Some(dial.size_px), Some(dial)) }
    }

    /// Where a mark is, pixels. A scale that is a full turn has no upper end.
    pub(super) fn mark(&self, index: usize) -> Option<[f64; 2]> {
        self.marks[index].filter(|_| index < self.mark_count())
    }

    /// Puts a mark to a pixel, or to the nearest in the photo.
    pub(super) fn set_mark(&mut self, index: usize, px: [f64; 2]) {
        let size_px = self.size_px.unwrap_or([u32::MAX; 2]);
        let inside = |axis: usize| px[axis].clamp(-0.5, f64::from(size_px[axis]) - 0.5);
        self.marks[index] = Some([inside(0), inside(1)]);
    }

    /// The mark that is missing next.
    pub(super) fn next_mark(&self) -> Option<usize> {
        (0..self.mark_count()).find(|index| self.marks[*index].is_none())
    }

    pub(super) fn clear_marks(&mut self) {
        self.marks = [None; 4];
    }

    fn mark_count(&self) -> usize {
        if self.is_full_turn { 2 } else { 4 }
    }

    /// The dial, or what is missing.
    pub(super) fn dial(&self) -> Result<GaugeDial, Missing> {
        let (Some(centre_px), Some(start_px), Some(size_px)) = (self.mark(0), self.mark(1), self.size_px)
        else {
            return Err(Missing::Marks);
        };
        if self.next_mark().is_some() {
            return Err(Missing::Marks);
        }
        let [Some(low), Some(high)] = self.range else { return Err(Missing::Values) };
        let dial = GaugeDial {
            picture: self.file.blob,
            size_px,
            centre_px,
            start_px,
            middle_px: self.mark(2),
            end_px: self.mark(3),
            direction: self.direction,
            range: [low, high],
            unit: self.unit.clone(),
        };
        dial.check().map_err(Missing::Of)?;
        Ok(dial)
    }

    /// The scale as it is read, from its lower to its upper end, pixels; empty until all is marked, and while the marks are no scale. With its middle it may be an ellipse: it goes
    /// through all marks (docs/maths/gauges.md). Of a full turn it is a circle.
    pub(super) fn arc_px(&self) -> Vec<[f64; 2]> {
        let (Some(centre), Some(start), None) = (self.mark(0), self.mark(1), self.next_mark()) else {
            return Vec::new();
        };
        let from_centre = |px: [f64; 2]| [px[0] - centre[0], px[1] - centre[1]];
        let start = from_centre(start);
        // Where a step of a radius to the right and up goes, and the angle from up to each end.
        let (right, up, half) = match self.mark(2).zip(self.mark(3)) {
            None => ([start[1], -start[0]], [-start[0], -start[1]], 0.5 * TAU),
            Some((middle, end)) => {
                let (up, end) = (from_centre(middle), from_centre(end));
                let sum = [start[0] + end[0], start[1] + end[1]];
                let half =
                    ((sum[0] * up[0] + sum[1] * up[1]) / (2.0 * (up[0] * up[0] + up[1] * up[1]))).acos();
                let across = 2.0 * half.sin();
                ([(end[0] - start[0]) / across, (end[1] - start[1]) / across], up, half)
            }
        };
        let at = |step: usize| {
            let angle = half * (2.0 * step as f64 / (ARC_POINTS - 1) as f64 - 1.0);
            [0, 1].map(|axis| centre[axis] + angle.sin() * right[axis] + angle.cos() * up[axis])
        };
        let arc: Vec<[f64; 2]> = (0..ARC_POINTS).map(at).collect();
        if arc.iter().flatten().all(|px| px.is_finite()) { arc } else { Vec::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use uuid::Uuid;
    use vocab::BlobHash;

    /// A circle with a sweep of 270 degrees.
    const MARKED_PX: [[f64; 2]; 4] = [[320.0, 240.0], [280.0, 280.0], [320.0, 183.4], [360.0, 280.0]];

    fn draft() -> GaugeDraft {
        let file = ReportFile {
            name: "photo.jpg".to_owned(),
            media_type: "image/jpeg".to_owned(),
            blob: BlobHash([3; 32]),
            bytes: 5,
        };
        GaugeDraft::new(InspectionPointId(Uuid::from_u128(1)), file, Some([640, 480]), None)
    }

    #[test]
    fn what_is_missing_is_asked_for_in_turn_until_there_is_a_dial() {
        let mut draft = draft();
        for (index, px) in MARKED_PX.into_iter().enumerate() {
            assert_eq!((draft.next_mark(), draft.dial()), (Some(index), Err(Missing::Marks)));
            draft.set_mark(index, px);
        }
        assert_eq!((draft.next_mark(), draft.dial()), (None, Err(Missing::Values)));
        draft.range = [Some(0.0), Some(6.0)];
        assert_eq!(draft.dial(), Err(Missing::Of(GaugeDialError::NoUnit)));
        draft.unit = "bar".to_owned();
        let dial = draft.dial().expect("complete");
        assert_eq!((dial.middle_px, dial.end_px), (Some([320.0, 183.4]), Some([360.0, 280.0])));
        assert_eq!(GaugeDraft::of(draft.point, draft.file.clone(), &dial), draft, "it can be changed later");
        // A full turn ends where it begins.
        draft.is_full_turn = true;
        assert_eq!(draft.dial().expect("complete").end_px, None);
    }

    #[test]
    fn the_drawn_scale_goes_through_all_marks_and_marks_stay_in_the_photo() {
        let mut draft = draft();
        for (index, px) in MARKED_PX.into_iter().enumerate() {
            draft.set_mark(index, px);
        }
        let is_near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < 2.0;
        let arc = draft.arc_px();
        assert!(is_near(arc[0], MARKED_PX[1]) && is_near(arc[ARC_POINTS - 1], MARKED_PX[3]), "{arc:?}");
        assert!(arc.iter().any(|px| is_near(*px, MARKED_PX[2])), "{arc:?}");
        // Seen from the side.
        draft.set_mark(1, [295.0, 280.0]);
        draft.set_mark(3, [345.0, 280.0]);
        let widest = draft.arc_px().into_iter().map(|px| (px[0] - 320.0).abs()).fold(0.0, f64::max);
        assert!((30.0..40.0).contains(&widest), "{widest}");
        draft.is_full_turn = true;
        assert!(draft.arc_px().iter().all(|px| ((px[0] - 320.0).hypot(px[1] - 240.0) - 47.2).abs() < 0.1));
        draft.set_mark(0, [-20.0, 900.0]);
        assert_eq!(draft.mark(0), Some([-0.5, 479.5]));
        draft.clear_marks();
        assert!(draft.arc_px().is_empty());
    }
}
