//! LiDAR sweeps on their way into the stack and into recordings.
//!
//! Before the step ([`ScanPreparation`]), every sweep is moved onto the grid of the sensor, 4 mm of range and 0.001° of direction, and while the
//! robot stands, each sweep keeps some of its columns only. After the step, a recording holds exactly the sweep that the stack saw, as a range
//! image of about one byte a point ([`encode`], [`decode`]). Sweeps that are not on the grid cannot be encoded; recordings keep them as they are.

mod error;
mod grid;
mod predictor;
mod preparation;
mod range_image;
mod standstill;
mod symbols;
mod texts;
mod thinning;

pub use error::RangeImageError;
pub use grid::{RANGE_STEP_UM, quantise};
pub use preparation::{PreparationConfig, ScanPreparation};
pub use range_image::{decode, encode};
pub use standstill::{StandstillConfig, StandstillDetector};
pub use thinning::thin;

#[cfg(test)]
mod tests;
