//! Collects the points of a survey while a file is read.

use super::coordinate_offset::CoordinateOffset;

/// A cloud that is being read. The first points wait until there are enough to decide on the offset.
#[derive(Debug)]
pub(super) struct PointCollector<'a> {
    coordinate_offset: &'a mut CoordinateOffset,
    first: Vec<([f64; 3], f32)>,
    xyz: Vec<[f32; 3]>,
    intensity: Vec<f32>,
    unusable: usize,
}

impl<'a> PointCollector<'a> {
    /// An empty cloud. The offset may be decided already.
    pub fn new(coordinate_offset: &'a mut CoordinateOffset) -> Self {
        Self { coordinate_offset, first: Vec::new(), xyz: Vec::new(), intensity: Vec::new(), unusable: 0 }
    }

    /// Counts a point that has no position.
    pub fn skip(&mut self) {
        self.unusable += 1;
    }

    /// Adds a point, metres, with its intensity in the file's units.
    pub fn add(&mut self, point: [f64; 3], intensity: f32) {
        if !point.iter().all(|coordinate| coordinate.is_finite()) {
            self.unusable += 1;
            return;
        }
        if self.coordinate_offset.is_decided() && self.first.is_empty() {
            self.put(point, intensity);
            return;
        }
        self.first.push((point, intensity));
        if self.coordinate_offset.is_enough(self.first.len()) {
            self.flush_first();
        }
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
