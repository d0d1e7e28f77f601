//! The description of a site from which it is built.

use super::loose_objects::LooseObject;
use crate::route::{SiteRoute, Start};
use crate::shape::Solid;
use geometry::Vector3;
use std::ops::Range;
use vocab::Vec3;

/// A charging dock. Its solids stand behind the docked robot (`dock.rs`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimulatedDock {
    /// Position of the docked robot, on the ground, site frame, metres.
    pub position: Vec3,
    /// Heading of the docked robot, radians.
    pub yaw: f64,
}

/// A door leaf that may swing.
#[derive(Clone, Debug)]
pub(super) struct DoorLeaf {
    /// Its solids.
    pub(super) solids: Range<usize>,
    /// A point on its hinge, site frame, metres.
    pub(super) hinge: Vector3,
}

/// The contents of a site.
#[derive(Clone, Debug, Default)]
pub(super) struct SitePlan {
    /// All solids but those of the docks and of the loose objects.
    pub(super) solids: Vec<Solid>,
    pub(super) docks: Vec<SimulatedDock>,
    /// Start of the robot where there is no dock.
    pub(super) start: Option<Start>,
    /// Corners of the ground plan, counter-clockwise, metres.
    pub(super) outline: Vec<[f64; 2]>,
    pub(super) routes: Vec<SiteRoute>,
    /// Closed paths of people, at the feet, metres.
    pub(super) pedestrian_paths: Vec<Vec<Vector3>>,
    /// The solids of each piece of furniture.
    pub(super) furniture: Vec<Range<usize>>,
    pub(super) door_leaves: Vec<DoorLeaf>,
    pub(super) loose_objects: Vec<LooseObject>,
}
