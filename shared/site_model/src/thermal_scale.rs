//! How temperatures are shown in colours and stored in pictures: the same on the robot, which makes the picture of a result, and in the client, which colours it
//! anew to compare two visits.

/// The scale of thermal pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThermalScale;

impl ThermalScale {
    /// Colours from the coldest to the warmest pixel (black, violet, red, orange, yellow, white), each red, green and blue, 0 to 255.
    pub const PALETTE: [[f32; 3]; 6] = [
        [0.0, 0.0, 20.0],
        [86.0, 0.0, 140.0],
        [200.0, 30.0, 80.0],
        [245.0, 120.0, 10.0],
        [255.0, 210.0, 50.0],
        [255.0, 255.0, 240.0],
    ];
    /// Least range of temperatures that the palette spans, kelvin, so that noise does not look like a pattern.
    pub const MIN_SPAN_K: f64 = 5.0;
    /// 0 degrees Celsius, kelvin.
    pub const ZERO_CELSIUS_K: f64 = 273.15;
    /// Steps of a stored temperature for each kelvin above absolute zero: the linear format of radiometric cameras.
    pub const STEPS_PER_K: f64 = 100.0;
}
