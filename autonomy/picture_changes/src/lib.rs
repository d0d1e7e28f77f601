//! Compares two pictures of one thing: aligns them, and finds what has changed between them, whatever the light.
//!
//! [`align_pictures`] finds the mapping of a plane from the earlier picture to the later one, coarse to fine:
//!
//! 1. `homography`: what the poses of the camera predict ([`Homography::predicted`]);
//! 2. `image`, `levels`: pictures at several resolutions, normalised so that gain and shading do not matter;
//! 3. `search`: the displacement at which the coarsest levels agree;
//! 4. `warp`, `refine`: Gauss-Newton with up to eight parameters, as many as the picture holds;
//! 5. `blocks`: what displacement is left, block by block: the residual.
//!
//! [`find_picture_changes`] then compares them pixel by pixel:
//!
//! 1. `light`: logarithms of the light of red, green and blue, without the difference of the light of both pictures;
//! 2. `tolerance`: which displacements explain a difference, because the residual is large there or something is before or behind the plane;
//! 3. `changes`: what is left is a change of colour, or darker or brighter than shadows make it;
//! 4. `regions`: changed pixels that belong together.
//!
//! [`mapped_dial`] and [`mapped_marks`] take the description of a gauge from one picture to the other. Everything is a pure function: the same input gives the same bits. The method is in
//! docs/maths/picture-changes.md.

mod align;
mod blocks;
mod changes;
mod config;
mod dial;
mod homography;
mod image;
mod levels;
mod light;
mod refine;
mod regions;
mod search;
mod tolerance;
mod warp;

#[cfg(test)]
mod tests;

pub use align::{PictureAlignment, PictureAlignmentError, align_pictures};
pub use changes::find_picture_changes;
pub use config::{PictureAlignmentConfig, PictureChangesConfig};
pub use dial::{mapped_dial, mapped_marks};
pub use homography::{Homography, PosedCamera};
pub use regions::ChangedRegion;
pub use warp::WarpModel;
