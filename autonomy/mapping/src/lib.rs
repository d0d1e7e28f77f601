//! From odometry to a map: which scans become keyframes, the pose graph between them, the walked trajectory, and the places
//! where the walk came back to itself.
//!
//! A [`Session`] keeps poses only (about 1 kB a keyframe and 76 B a scan, 10 MB at most); full clouds go to its owner. A [`LoopFinder`] keeps a
//! small cloud of every keyframe (about 34 kB in all) and finds loops in four steps: `scan_context` and `places` recognise,
//! `candidates` chooses, `verify` registers, `consistency` decides. On known ground it ties the robot to old keyframes instead
//! (`visits`). `charts` finds one finished map in another. `dynamics` tells people from the site.
//! `vantage` makes keyframes of clouds that no robot has walked. `docs/maths/loops.md` has the method and its numbers.

pub mod candidates;
mod charts;
pub mod clique;
pub mod consistency;
pub mod drift;
pub mod dynamics;
mod floors;
mod loops;
mod odometer;
pub mod patch;
mod place;
pub mod places;
mod quality;
pub mod scan_context;
mod session;
pub mod submap;
#[cfg(test)]
mod testing;
mod trail;
mod uncertain;
pub mod vantage;
mod verify;
mod visits;

pub use charts::{Chart, Joint, Unrelated};
pub use consistency::{Decision, Jury, Trust, Verdict};
pub use loops::{LoopConfig, LoopFinder, NewKeyframe, OldKeyframe};
pub use odometer::Odometer;
pub use place::{ORIGINS, PLACE_VERSION, Place, PlaceParts};
pub use points::range_image;
pub use quality::{PlaceToWalk, Quality, WhyWalk};
pub use session::{Edge, KeyframePolicy, Node, ScanPose, Session, Step, Stretch, Waypoint, unit};
pub use uncertain::Uncertain;
pub use verify::{Compared, Comparison, Evidence, Flaw, Gates, Source, Task, Verified, compare, verify};
pub use visits::{Ground, Tie, Tied, Visit};
