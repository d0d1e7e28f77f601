//! Changes between two images of one fixed depth camera.
//!
//! A [`DepthImage`] has a point, or none, for each pixel. [`detect_depth_changes`] compares two of them:
//!
//! 1. `support`: the dominant plane, such as a table, gives the direction up;
//! 2. `differing`: a point has changed if the other image looked through its place, beyond the noise of the range, which grows with the square of the range;
//! 3. `segments`: changed points that are connected are one object; `concavity` and `colour` part objects that touch each other;
//! 4. `UprightBox`: the place, size and heading of an object on the plane;
//! 5. `moves`: an object that is gone from one place and one of its size and colour that is new at another are one that was moved.

mod camera;
mod colour;
mod concavity;
mod config;
mod detect;
mod differing;
mod image;
mod normals;
mod segments;
mod support;

pub use config::{ColourHistogramConfig, DepthChangesConfig};
pub use detect::{DepthChanges, detect_depth_changes};
pub use image::{DepthImage, DepthImageError};
