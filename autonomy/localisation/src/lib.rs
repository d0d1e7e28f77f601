//! Keeping the robot's pose in a known map, and knowing how far it can be believed.
//!
//! A [`Guide`] is what the known map says of the site: its surfaces, and what its keyframes saw through. A [`Tracker`] carries the
//! pose from scan to scan by odometry's motion, corrects it by fitting each scan to those surfaces, and asks the keyframes' sight
//! whether the scan can have been taken there at all: a person or a rack that was moved contradicts a little of what they saw, a wrong
//! place most of it. `docs/maths/localisation.md` has the method and its numbers.

mod bits;
mod guide;
mod outline;
mod relocalise;
mod tell_apart;
mod thin;
mod tiles;
mod tracker;
mod trust;

pub use guide::{Guide, Sightings};
pub use relocalise::{Atlas, Hypothesis, Standing, is_same_place, standing};
pub use thin::Thinner;
pub use tiles::TiledSurfaces;
pub use tracker::{Fix, Scan, Tracker};
pub use trust::{Doubt, Evidence, Trust};
