//! Parameters of the comparison of depth images.

use crate::BoxFitConfig;

/// Parameters of [`crate::detect_depth_changes`].
///
/// docs/benchmarks/changes.md says what the results were when the values were changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthChangesConfig {
    /// Standard deviation of a range at 1 m, metres; it grows with the square of the range. Source: Khoshelham and Elberink, *Accuracy and Resolution of Kinect Depth Data
    /// for Indoor Mapping Applications*, 2012.
    pub noise_at_1_m_m: f64,
    /// Ranges that differ by less than this number of standard deviations are of the same surface. Chosen: six, because an image has 300,000 pixels and its ranges come in
    /// steps of two standard deviations.
    pub same_surface_sigmas: f64,
    /// Ranges that differ by less than this are of the same surface, metres: calibration and temperature move surfaces near the camera by some millimetres. With 0.006 to
    /// 0.02 m all objects of docs/benchmarks/changes.md are found, with at most one wrong place in each set.
    pub min_same_surface_m: f64,
    /// The ray of a pixel is compared with those this number of pixels around it, because the edges of things flicker by a pixel. With 0, 2 and 3 all objects of
    /// docs/benchmarks/changes.md are found.
    pub edge_px: usize,
    /// The points of an object are at least this far above the plane, metres: below, they cannot be told from it. Chosen: as [`Self::min_same_surface_m`]. With 0.005 and
    /// 0.015 m the results of docs/benchmarks/changes.md were the same.
    pub min_height_m: f64,
    /// Points of an object are at most this number of pixels apart in the image. Chosen: a pixel without a return does not part an object. With 1 and 3 the results of
    /// docs/benchmarks/changes.md were the same.
    pub gap_px: usize,
    /// Neighbouring points of an object differ in depth by less than this and three standard deviations of both, metres. Chosen: things nearer to each other are parted
    /// by their bend and colour. With 0.006 to 0.02 m the results of docs/benchmarks/changes.md were the same.
    pub gap_m: f64,
    /// Area of the changed points of an object, seen by the camera, square metres: half of an object of 4 cm x 2 cm. With half and three times the area the results of
    /// docs/benchmarks/changes.md were the same.
    pub min_area_m2: f64,
    /// An object is at least this large along its second longest side, metres. Chosen: the width of the smallest object that is to be found. With 0.01 and 0.03 m the
    /// results of docs/benchmarks/changes.md were the same.
    pub min_size_m: f64,
    /// Share of the pixels of an object, of those that are comparable, that have to show a change. Chosen: the majority. With 0.3 three wrong places are named in the
    /// other pairs of docs/benchmarks/changes.md, with 0.7 none.
    pub min_changed_share: f64,
    /// The lower end of an object that is nearer to the plane than this stands on it, metres. Chosen: three times [`Self::min_height_m`]. With 0.015 and 0.05 m the
    /// results of docs/benchmarks/changes.md were the same.
    pub stands_within_m: f64,
    /// Number of points of which the plane is found; more do not make it better. Chosen: the time of the search is this number times [`Self::support_trials`].
    pub support_points: usize,
    /// Number of planes through three points that are tried. A plane with 15 % of the points is found with a probability of 74 % by 400, one with 25 % with 99.8 %.
    /// Chosen: more trials take longer in proportion.
    pub support_trials: usize,
    /// The plane holds at least this share of the points. Chosen: a table or floor that fills less of the image is no support to stand on.
    pub min_support_share: f64,
    /// Normals are fitted to the points within this number of pixels. Chosen: 49 pixels, of which the noise averages out. With 2 and 4 the results of
    /// docs/benchmarks/changes.md were the same.
    pub normal_px: usize,
    /// The bend of a surface is measured between points at this number of pixels from each other: twice [`Self::normal_px`], so that the windows of their normals hardly overlap.
    pub bend_px: usize,
    /// A surface that bends inwards by more than this angle may be the border of two objects, radians. Chosen: 25 degrees, because the inside of a bowl bends by 10 degrees
    /// over [`Self::bend_px`].
    pub min_bend_rad: f64,
    /// Two parts whose colours overlap by more than this (Bhattacharyya coefficient) are one object although the surface bends inwards between them, such as the handle
    /// of a pot. Source: docs/benchmarks/changes.md: parts of one thing overlap by 0.78 to 0.94, those of two things by 0.62 to 0.69.
    pub same_colour_overlap: f64,
    /// An object that was moved looks like itself: least overlap of the colours (Bhattacharyya coefficient) at both places. Less than [`Self::same_colour_overlap`], because
    /// another side may be seen, in other light. Chosen as a round number: with 0.3 and 0.7 the results of docs/benchmarks/changes.md were the same.
    pub moved_colour_overlap: f64,
    /// An object that was moved has its size: largest difference of its two longer sides as a share of the larger one. Of a turned object other sides are seen. Chosen as
    /// a round number: with 0.15 and 0.35 the results of docs/benchmarks/changes.md were the same.
    pub moved_size_share: f64,
    /// How boxes are fitted.
    pub box_fit: BoxFitConfig,
    /// Cameras whose rays differ by more than this are different ones, pixels. Chosen: twice the error of a fit that is accepted for each of them, 1 pixel.
    pub max_camera_difference_px: f64,
    /// Points in the window of a normal, of the 49 that it has, from which on it is fitted. Chosen: twice the three that a plane needs.
    pub min_normal_points: usize,
    /// Times that the plane is fitted to the points on it. Chosen: each fit changes which points are on it, so one is not enough. Each costs a pass over
    /// [`Self::support_points`].
    pub support_refits: usize,
    /// How colours are compared.
    pub colours: ColourHistogramConfig,
}

/// Parameters of the histogram of the colours of a part of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColourHistogramConfig {
    /// Cells of the share of red, and as many of the share of green. Chosen: the whole histogram has 256 cells then, few against the hundreds of pixels of a part.
    pub share_cells: usize,
    /// Cells of the brightness. Fewer than of the shares, because light and shadow change the brightness. Chosen: half as many.
    pub brightness_cells: usize,
    /// Shares of red and green above this are in the last cell: two thirds of the brightness in one of three colours is a strong colour. Chosen: the cells below are
    /// finer then, because most surfaces are near grey.
    pub max_share: f64,
}

impl Default for ColourHistogramConfig {
    fn default() -> Self {
        Self { share_cells: 8, brightness_cells: 4, max_share: 2.0 / 3.0 }
    }
}

impl Default for DepthChangesConfig {
    fn default() -> Self {
        Self {
            noise_at_1_m_m: 0.001425,
            same_surface_sigmas: 6.0,
            min_same_surface_m: 0.01,
            edge_px: 1,
            min_height_m: 0.01,
            gap_px: 2,
            gap_m: 0.01,
            min_area_m2: 4e-4,
            min_size_m: 0.02,
            min_changed_share: 0.5,
            stands_within_m: 0.03,
            support_points: 5_000,
            support_trials: 400,
            min_support_share: 0.15,
            normal_px: 3,
            bend_px: 6,
            min_bend_rad: 0.436,
            same_colour_overlap: 0.73,
            moved_colour_overlap: 0.5,
            moved_size_share: 0.25,
            box_fit: BoxFitConfig { on_side_m: 0.003, trimmed_height_share: 0.01, ..BoxFitConfig::default() },
            max_camera_difference_px: 2.0,
            min_normal_points: 6,
            support_refits: 3,
            colours: ColourHistogramConfig::default(),
        }
    }
}

impl DepthChangesConfig {
    /// Standard deviation of a range, metres.
    pub(crate) fn noise_m(&self, range_m: f64) -> f64 {
        self.noise_at_1_m_m * range_m * range_m
    }

    /// Difference of range up to which two points are of the same surface, metres (docs/maths/changes.md, equation 4).
    pub(crate) fn same_surface_m(&self, range_m: f64) -> f64 {
        (self.same_surface_sigmas * self.noise_m(range_m)).max(self.min_same_surface_m)
    }
}
