//! Charging docks as solids, and when their contacts touch.
//!
//! A dock stands behind a robot that looks along its heading. It is a cabinet with two guide rails on the floor. On the cabinet stands a marker that a LiDAR
//! recognises: two plates that form a ridge towards the robot, like the bow of a ship. Seen from above, in the frame of the docked base (x away from the dock):
//!
//! ```text
//!   (-0.802, 0.35) \                    left plate, 30° from the y axis
//!                   > (-0.60, 0)        ridge          -> x, the docked base at (0, 0)
//!  (-0.802, -0.35) /                    right plate
//! ```

use super::SimulatedSite;
use super::plan::SimulatedDock;
use crate::shape::{Material, Shape, Solid};
use geometry::{Isometry, Rotation, Vector3, vec_from_plain};
use nalgebra::Translation3;
use std::f64::consts::{FRAC_PI_2, PI};

/// Distance from the middle of the docked base to the ridge of the marker, metres.
const RIDGE_M: f64 = 0.60;
/// Half the width of the marker, metres.
const HALF_WIDTH_M: f64 = 0.35;
/// Angle between a plate and the front of the dock.
const PLATE_ANGLE_RAD: f64 = PI / 6.0;
/// Thickness of the plates, metres.
const PLATE_THICKNESS_M: f64 = 0.02;
/// Height of the cabinet, metres. The plates begin here.
const CABINET_HEIGHT_M: f64 = 0.75;
/// Height of the plates, metres. A LiDAR that is 0.8 m above the floor sees them from 0.6 m to beyond 4 m.
const PLATE_HEIGHT_M: f64 = 0.35;

/// The contacts touch within this horizontal distance from the pose of the docked base, metres.
const CONTACT_DISTANCE_M: f64 = 0.03;
/// And within this difference of heading, radians: 3 degrees.
const CONTACT_HEADING_RAD: f64 = 0.0524;
/// A robot that is farther from the dock has given up its attempt to dock, metres.
const RELEASE_DISTANCE_M: f64 = 0.25;

/// The solids of a dock.
pub(super) fn solids(dock: &SimulatedDock) -> Vec<Solid> {
    let site_from_dock = site_from_dock(dock);
    let part = |center: [f64; 3], size: [f64; 3], yaw: f64, material| {
        let shape = Shape::OrientedBox {
            center: center.into(),
            half: Vector3::from(size) / 2.0,
            site_from_box: Rotation::from_euler_angles(0.0, 0.0, yaw),
        };
        Solid { shape: shape.transformed(&site_from_dock), material }
    };
    let mut solids = vec![part(
        [-0.75, 0.0, CABINET_HEIGHT_M / 2.0],
        [0.25, 0.9, CABINET_HEIGHT_M],
        0.0,
        Material::WhiteSheet,
    )];
    for side in [-1.0, 1.0] {
        solids.push(part([0.0, 0.38 * side, 0.025], [1.0, 0.06, 0.05], 0.0, Material::DarkPaint));
        // The front of the plate goes through the ridge.
        let along = Vector3::new(-PLATE_ANGLE_RAD.sin(), side * PLATE_ANGLE_RAD.cos(), 0.0);
        let front = Vector3::new(PLATE_ANGLE_RAD.cos(), side * PLATE_ANGLE_RAD.sin(), 0.0);
        let length = HALF_WIDTH_M / PLATE_ANGLE_RAD.cos();
        let middle = Vector3::new(-RIDGE_M, 0.0, CABINET_HEIGHT_M + PLATE_HEIGHT_M / 2.0)
            + along * (length / 2.0)
            - front * (PLATE_THICKNESS_M / 2.0);
        let size = [length, PLATE_THICKNESS_M, PLATE_HEIGHT_M];
        let yaw = side * (FRAC_PI_2 + PLATE_ANGLE_RAD);
        solids.push(part([middle.x, middle.y, middle.z], size, yaw, Material::Reflector));
    }
    solids
}

fn site_from_dock(dock: &SimulatedDock) -> Isometry {
    let heading = Rotation::from_euler_angles(0.0, 0.0, dock.yaw);
    Isometry::from_parts(Translation3::from(vec_from_plain(dock.position)), heading)
}

/// Horizontal distance (metres) and difference of heading (radians) from the pose in which a robot is docked.
fn offset(dock: &SimulatedDock, site_from_base: &Isometry) -> (f64, f64) {
    let dock_from_base = site_from_dock(dock).inverse() * site_from_base;
    let ahead = dock_from_base.rotation * Vector3::x();
    (dock_from_base.translation.vector.xy().norm(), ahead.y.atan2(ahead.x).abs())
}

fn is_on_floor_of(dock: &SimulatedDock, site_from_base: &Isometry) -> bool {
    (0.0..1.0).contains(&(site_from_base.translation.vector.z - dock.position.z))
}

impl SimulatedSite {
    /// The dock whose contacts a base touches, by its number.
    pub(crate) fn dock_in_contact(&self, site_from_base: &Isometry) -> Option<usize> {
        self.docks().iter().position(|dock| {
            let (distance_m, heading_rad) = offset(dock, site_from_base);
            distance_m <= CONTACT_DISTANCE_M
                && heading_rad <= CONTACT_HEADING_RAD
                && is_on_floor_of(dock, site_from_base)
        })
    }

    /// Whether a base is so near to that dock that it may be making contact.
    pub(crate) fn is_docking(&self, dock: usize, site_from_base: &Isometry) -> bool {
        let is_near = |dock: &SimulatedDock| {
            offset(dock, site_from_base).0 <= RELEASE_DISTANCE_M && is_on_floor_of(dock, site_from_base)
        };
        self.docks().get(dock).is_some_and(is_near)
    }

    /// The site with a dock that somebody has pushed: `forward_m` and `left_m` as a docked robot looks, then turned by `turn_rad` about the place of the robot.
    /// Routes begin where the dock was.
    pub fn with_moved_dock(&self, dock: usize, forward_m: f64, left_m: f64, turn_rad: f64) -> Self {
        self.with_docks(|docks| {
            if let Some(moved) = docks.get_mut(dock) {
                let (sin, cos) = moved.yaw.sin_cos();
                moved.position.x += forward_m * cos - left_m * sin;
                moved.position.y += forward_m * sin + left_m * cos;
                moved.yaw += turn_rad;
            }
        })
    }

    /// The site without a dock. A robot that starts at the first dock starts at another one then.
    pub fn without_dock(&self, dock: usize) -> Self {
        self.with_docks(|docks| {
            if dock < docks.len() {
                docks.remove(dock);
            }
        })
    }

    /// The site with one dock more.
    pub fn with_dock(&self, dock: SimulatedDock) -> Self {
        self.with_docks(|docks| docks.push(dock))
    }

    fn with_docks(&self, change: impl FnOnce(&mut Vec<SimulatedDock>)) -> Self {
        let mut plan = self.plan.clone();
        change(&mut plan.docks);
        Self { walkable: self.walkable.clone(), ..Self::from_plan(self.name.clone(), plan) }
    }
}
