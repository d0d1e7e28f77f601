//! What changed at a site between two visits: objects that appeared, were removed or were moved.
//!
//! A [`Visit`] is what a LiDAR or depth camera saw: views, each with the place of the sensor and its points in the frame of the map. [`detect_changes`] compares two of them:
//!
//! 1. `alignment`: the views of the later visit are aligned with the surfaces of the earlier one, and what is left of the errors of their poses is measured;
//! 2. `surfaces`: a point with a surface of the other visit near it has not changed;
//! 3. `ray_image`: a point has changed only if rays of the other visit went through its place. Where the other visit never looked, nothing is known, and nothing is reported;
//! 4. `clusters`: changed points near each other are one object (`differences` does 2 to 5 for each of the two visits);
//! 5. `upright_box`: the place, size and heading of an object, down to the ground it stands on;
//! 6. `turned`: a thing of which parts are gone and new, or which stands free as before with another heading, was turned where it stands (`standing`, `heading`, `circle`);
//! 7. `moves`: an object that is gone from one place and one of its shape and size that is new at another are one that was moved, with a probability.
//!
//! [`AcceptedChanges`] are those that people call the new normal: what a map loses and gains by them.
//! [`find_recurrences`] says which of the changes that were found are known already from earlier comparisons, and [`identify_objects`] of which known thing a change is, so that a thing has a history over many visits.
//! [`detect_depth_changes`] compares two images of one depth camera that did not move, pixel by pixel (`depth`).
//!
//! Everything is a pure function: the same input gives the same bits. Source of the idea: Rowell and others, *LiSTA: Geometric Object-Based Change Detection in Cluttered
//! Environments*, 2024. Differences: rays instead of volumes say what was free, and objects get boxes.

mod accepted;
mod alignment;
mod circle;
mod clusters;
mod columns;
mod config;
mod depth;
mod detect;
mod differences;
mod directions;
mod heading;
mod join;
mod known_objects;
mod moves;
mod passing;
mod penetration;
mod ray_image;
mod recurrence;
#[cfg(test)]
mod room;
mod side;
#[cfg(test)]
mod site_tests;
mod size_likelihood;
mod standing;
mod surfaces;
mod turned;
mod upright_box;
mod visit;

pub use accepted::{AcceptedChanges, AcceptedChangesConfig, BroughtPoint};
pub use config::{AlignmentConfig, BoxFitConfig, ChangesConfig};
pub use depth::{
    ColourHistogramConfig, DepthChanges, DepthChangesConfig, DepthImage, DepthImageError,
    detect_depth_changes,
};
pub use detect::{Change, ChangedObject, Changes, detect_changes, detect_changes_with, shipped_descriptor};
pub use join::{InTurn, Join};
pub use known_objects::{Identification, IdentityConfig, KnownObject, ObjectSighting, identify_objects};
pub use recurrence::{ObservedChange, RecurrenceConfig, find_recurrences, is_undone_by};
pub use size_likelihood::SizeLikelihoodConfig;
pub use upright_box::UprightBox;
pub use visit::{SensorView, Visit};
