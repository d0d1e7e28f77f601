//! Parameters of the reading of gauges.

/// Parameters of [`crate::read_gauge`].
///
/// docs/benchmarks/gauges.md says what the results were when the values were changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaugeConfig {
    /// A dial with a smaller scale is not read, pixels. At 12 pixels a hundredth of a turn is 0.75 pixels at the tip. Chosen: below, half a pixel of error is more than a
    /// hundredth of a turn.
    pub min_radius_px: f64,
    /// The face is what is seen between this share of the radius and the scale: the hub is left out. Chosen as a round number: with 0.1 and 0.4 the results of
    /// docs/benchmarks/gauges.md were the same.
    pub face_inner_share: f64,
    /// Below this share of the brightness of the face, colours are noise and count less. Chosen as a round number: with 0.2 and 0.5 the results of
    /// docs/benchmarks/gauges.md were the same.
    pub dim_share: f64,
    /// A needle differs from the face by at least this in the shares of red and green of its brightness. Chosen as a round number: with 0.03 and 0.08 the results of
    /// docs/benchmarks/gauges.md were the same.
    pub min_colour_contrast: f64,
    /// A dark needle is darker than the face by at least this share: the face is 1.5 times as bright. Chosen: with 0.45 one reading less of docs/benchmarks/gauges.md is
    /// within 0.2.
    pub min_dark_contrast: f64,
    /// A light needle is lighter than the face by at least this share: 1.5 times as bright. Chosen: the same ratio. With 0.3 and 0.8 the results of
    /// docs/benchmarks/gauges.md were the same.
    pub min_light_contrast: f64,
    /// Evidence on more than this share of the dial is no needle. Chosen: half. With 0.35 and 0.65 the results of docs/benchmarks/gauges.md were the same.
    pub max_area_share: f64,
    /// Number of rays round the axis: half a degree. Chosen: finer than the error of a dial. With 360 and 1,440 the results of docs/benchmarks/gauges.md were the same.
    pub rays: usize,
    /// The run of a needle is looked for from this share of the radius on: hubs have holes and screws. With 0.1 and 0.3 the results of docs/benchmarks/gauges.md were the
    /// same.
    pub run_from_share: f64,
    /// The run of a needle begins before this share of the radius. Chosen: digits and ticks begin farther out. With 0.3 and 0.5 the results of docs/benchmarks/gauges.md
    /// were the same.
    pub run_start_share: f64,
    /// A gap in the run of a needle is at most this share of the radius: reflections and print on it. Source: docs/benchmarks/gauges.md: of 61 dials, 0.03 and 0.1 read
    /// one and three fewer within 0.2.
    pub gap_share: f64,
    /// Rays whose run is at least this share of the longest one are those of the tip. Chosen: a little less than the tip of a needle that is a pixel shorter. With 0.88
    /// and 0.97 the results of docs/benchmarks/gauges.md were the same.
    pub tip_share: f64,
    /// The direction is measured from this share of the length of the needle to [`Self::outer_to_share`]: near the axis an error of the axis turns it more. Chosen: with
    /// 0.4 one reading less of docs/benchmarks/gauges.md is within 0.2.
    pub outer_from_share: f64,
    /// The tip itself is left out, because it is a pixel wide. Chosen: with 0.9 one reading less of docs/benchmarks/gauges.md is within 0.2.
    pub outer_to_share: f64,
    /// Directions farther from the needle than this are not part of it, radians: a wedge is 40 degrees wide near the axis. Chosen: with 0.5 and 1.0 one reading less of
    /// docs/benchmarks/gauges.md is within 0.2.
    pub other_direction_rad: f64,
    /// Noise of the evidence on the face that every camera has. Chosen: 2 % of the brightness, five steps of 256. Without it, a face without any noise would make every
    /// needle certain.
    pub noise_floor: f64,
    /// Ratio of the strength of the needle to the noise of the face at which the evidence counts half. Chosen as a round number: with 3 and 12 the results of
    /// docs/benchmarks/gauges.md were the same.
    pub half_signal: f64,
    /// Evidence with a smaller ratio of the strength of the needle to the noise of the face is not used. Chosen as a round number: with 2 and 6 the results of
    /// docs/benchmarks/gauges.md were the same.
    pub min_signal: f64,
    /// A needle that reaches farther than this share of the radius runs into the ring of the dial or a tick, and counts half. Chosen: 5 %, for the error of a radius that
    /// a person has given.
    pub max_length_share: f64,
    /// Least quality of a reading, 0 to 1: length of the needle times its distinctness times its contrast. Source: docs/benchmarks/gauges.md: with 0.15 three of 61
    /// readings are unsure instead of one; with 0.05 none, and one is off by more than 0.2.
    pub min_quality: f64,
    /// Another needle of at least this share of the best quality makes the reading unsure, if it points elsewhere by [`Self::rival_direction_rad`]. Chosen: with 0.5 one
    /// reading more of docs/benchmarks/gauges.md is unsure.
    pub rival_share: f64,
    /// Difference of direction from which two needles are different ones, radians. Chosen: 20 degrees, half the width of a wedge near the axis.
    pub rival_direction_rad: f64,
    /// Error of the edges of the needle in a picture, pixels: half of one, as an image of any camera is.
    pub edge_error_px: f64,
    /// Error of the given centre and ends of the scale, radians: 1 degree, as found by hand. Chosen: what a person misses who marks a dial of a hundred pixels by a
    /// pixel.
    pub dial_error_rad: f64,
    /// A reading with a larger uncertainty is unsure, as a share of the range of a full turn. Chosen: readings are wanted within 2 % (docs/benchmarks/gauges.md), and a
    /// standard deviation of more says nothing of that.
    pub max_uncertainty_share: f64,
    /// A needle beyond an end of its scale by less than this shows the end, radians: needles rest on their pins. Chosen: 6 degrees; more would hide a needle that points
    /// elsewhere.
    pub beyond_end_rad: f64,
    /// Rays reach this share of the radius: needles that are longer than their scale are not expected. Chosen: a little more than [`Self::max_length_share`], so that it
    /// can be exceeded.
    pub reach_share: f64,
    /// A dial that is seen from the side is resampled up to this share of its radius. Chosen: a little more than [`Self::reach_share`].
    pub frontal_share: f64,
    /// The mark in the middle of a scale is off the line that both ends let expect by at most this share of the radius. Chosen: what a hand misses and a lens bends is far less, and
    /// a mark at another number is farther off.
    pub max_middle_error_share: f64,
    /// The cosine of half the sweep of a scale that is seen from the side stays this far from 1 and -1: sweeps of 23 to 337 degrees. Chosen: beyond, both ends are nearly on one
    /// line with the middle, and a pixel of error there is several across it.
    pub min_sweep_margin: f64,
}

impl Default for GaugeConfig {
    fn default() -> Self {
        Self {
            min_radius_px: 12.0,
            face_inner_share: 0.25,
            dim_share: 0.35,
            min_colour_contrast: 0.05,
            min_dark_contrast: 0.33,
            min_light_contrast: 0.5,
            max_area_share: 0.5,
            rays: 720,
            run_from_share: 0.2,
            run_start_share: 0.4,
            gap_share: 0.06,
            tip_share: 0.93,
            outer_from_share: 0.6,
            outer_to_share: 0.97,
            other_direction_rad: 0.7,
            noise_floor: 0.02,
            half_signal: 6.0,
            min_signal: 4.0,
            max_length_share: 1.05,
            min_quality: 0.1,
            rival_share: 0.75,
            rival_direction_rad: 0.35,
            edge_error_px: 0.5,
            dial_error_rad: 0.0175,
            max_uncertainty_share: 0.03,
            beyond_end_rad: 0.1,
            reach_share: 1.1,
            frontal_share: 1.2,
            max_middle_error_share: 0.2,
            min_sweep_margin: 0.02,
        }
    }
}
