//! From odometry to a map: which scans become keyframes, the pose graph between them, and the walked trajectory.
//!
//! Clouds are not kept here: the owner of a [`Session`] sends them on when a keyframe is made, so memory grows with
//! the number of poses only (about 1 kB a keyframe and 64 B a scan).

mod odometer;
mod session;

pub use odometer::Odometer;
pub use session::{Edge, KeyframePolicy, Node, ScanPose, Session, Stretch};
