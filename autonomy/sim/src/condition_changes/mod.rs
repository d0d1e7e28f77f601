//! Changes of the condition of a site: what can change, changes that are asked for, and random ones. What changed is truth for scorers only.
//!
//! - `error`: why a change cannot be made;
//! - `scripted`: changes that are asked for;
//! - `random`: changes that are drawn.

mod error;
mod random;
mod scripted;

pub use error::ConditionChangeError;
pub use random::ConditionChangesConfig;

use crate::camera::{CameraScene, Face};
use crate::site::SimulatedSite;
use std::sync::Arc;
use vocab::Vec3;

/// What of a site can be out of its usual condition, besides its floors and surfaces. Site frame, metres.
#[derive(Clone, Debug, PartialEq)]
pub struct ChangeableThings {
    /// A point on the hinge of each door leaf.
    pub doors: Vec<Vec3>,
    /// The gauges on its walls.
    pub gauges: Vec<ChangeableGauge>,
    /// Its lamps.
    pub lamps: Vec<Vec3>,
}

/// A gauge on a wall.
#[derive(Clone, Debug, PartialEq)]
pub struct ChangeableGauge {
    /// Its tag.
    pub tag: String,
    /// Where it hangs, site frame, metres.
    pub place: Vec3,
    /// Unit of its scale.
    pub unit: &'static str,
    /// Values at the beginning and at the end of its scale.
    pub scale: [f64; 2],
}

/// A number of a change to five decimals, so that files show it in full.
fn rounded(number: f64) -> f64 {
    // Zero without a sign.
    (number * 1e5).round() / 1e5 + 0.0
}

impl SimulatedSite {
    /// What of the usual site can change. Finds lamps and gauges, as [`CameraScene::new`] does.
    pub fn changeable_things(&self) -> ChangeableThings {
        let scene = CameraScene::new(Arc::new(self.usual().clone()));
        let gauges = scene.fixtures().iter().filter_map(|fixture| {
            let Face::Gauge { unit, min, max, .. } = fixture.face else { return None };
            let place = geometry::vec_to_plain(&fixture.site_from_plate.translation.vector);
            Some(ChangeableGauge { tag: fixture.tag.clone(), place, unit, scale: [min, max] })
        });
        ChangeableThings { doors: self.door_hinges(), gauges: gauges.collect(), lamps: scene.lamps() }
    }
}
