//! Collects the points of a survey while a file is read.

use super::coordinate_offset::CoordinateOffset;
use crate::{FormatError, SurveyLimits, texts};

/// Points without a position that are read for each usable one of the limit. They take no memory, but damaged compressed data can hold any number of
/// them, which takes time.
const MAX_RECORDS_PER_POINT: usize = 8;

/// A cloud that is being read. The first points wait until there are enough to decide on the offset.
#[derive(Debug)]
pub(super) struct PointCollector<'a> {
    coordinate_offset: &'a mut CoordinateOffset,
    first: Vec<([f64; 3], f32)>,
    xyz: Vec<[f32; 3]>,
    intensity: Vec<f32>,
    unusable: usize,
    /// Usable points that may still be added.
    points_left: usize,
    /// Points that may still be added or skipped.
    records_left: usize,
    limits: SurveyLimits,
}

impl<'a> PointCollector<'a> {
    /// An empty cloud beside `points` others of the same survey. The offset may be decided already.
    pub fn new(coordinate_offset: &'a mut CoordinateOffset, limits: SurveyLimits, points: usize) -> Self {
        Self {
            coordinate_offset,
            first: Vec::new(),
            xyz: Vec::new(),
            intensity: Vec::new(),
            unusable: 0,
            points_left: limits.points.saturating_sub(points),
            records_left: limits.points.saturating_mul(MAX_RECORDS_PER_POINT),
            limits,
        }
    }

    /// Reserves memory for as many points as the file states. The statement must have been checked against the bytes of the file.
    pub fn reserve(&mut self, points: u64) {
        let points = usize::try_from(points).unwrap_or(usize::MAX).min(self.points_left);
        self.xyz.reserve_exact(points);
        self.intensity.reserve_exact(points);
    }

    /// Counts a point that has no position.
    ///
    /// # Errors
    /// When there are far more of them than usable points may be.
    pub fn skip(&mut self) -> Result<(), FormatError> {
        self.unusable += 1;
        self.records_left = self.records_left.checked_sub(1).ok_or_else(|| self.too_many())?;
        Ok(())
    }

    fn too_many(&self) -> FormatError {
        let what = texts::too_many_points(self.limits.points);
        FormatError::Unsupported { what, remedy: texts::MAKE_SURVEY_SMALLER }
    }

    /// Adds a point, metres, with its intensity in the file's units.
    ///
    /// # Errors
    /// When the survey has more points than its limit.
    pub fn add(&mut self, point: [f64; 3], intensity: f32) -> Result<(), FormatError> {
        if !point.iter().all(|coordinate| coordinate.is_finite()) {
            return self.skip();
        }
        self.points_left = self.points_left.checked_sub(1).ok_or_else(|| self.too_many())?;
        if self.coordinate_offset.is_decided() && self.first.is_empty() {
            self.put(point, intensity);
            return Ok(());
        }
        self.first.push((point, intensity));
        if self.coordinate_offset.is_enough(self.first.len()) {
            self.flush_first();
        }
        Ok(())
    }

    fn put(&mut self, point: [f64; 3], intensity: f32) {
        let offset = self.coordinate_offset.offset();
        let point: [f32; 3] = std::array::from_fn(|axis| (point[axis] - offset[axis]) as f32);
        // Markers of missing values are often beyond single precision.
        if !point.iter().all(|coordinate| coordinate.is_finite()) {
            self.unusable += 1;
            return;
        }
        self.xyz.push(point);
        self.intensity.push(intensity);
    }

    fn flush_first(&mut self) {
        let first = std::mem::take(&mut self.first);
        let places: Vec<[f64; 3]> = first.iter().map(|(point, _)| *point).collect();
        self.coordinate_offset.decide(&places);
        for (point, intensity) in first {
            self.put(point, intensity);
        }
    }

    /// The points less the offset, their intensities if any is not zero, and the number of points left out.
    pub fn finish(mut self) -> (Vec<[f32; 3]>, Vec<f32>, usize) {
        self.flush_first();
        if self.intensity.iter().all(|intensity| *intensity == 0.0) {
            self.intensity = Vec::new();
        }
        (self.xyz, self.intensity, self.unusable)
    }
}
