//! The simulator: industrial sites, a walking robot with its sensors, people, and faults at set times.
//!
//! Everything is seeded and clockless: the same configuration and the same commands give the same bytes. The simulator never
//! sees the stack. The modules, from the lowest to the highest:
//!
//! - `timing`: the time steps that all others share;
//! - `shape`, `ray_packet`, `bvh`: solids, and rays cast at them;
//! - `site`: places built of solids, with docks, routes and the paths of people;
//! - `low_pass`, `gait`, `locomotion`, `body`: the robot's trajectory;
//! - `lidar`, `imu`, `legs`, `battery`: the sensors that observe the body; `dock_contact`: when a dock charges; `people`: walking people;
//! - `contacts`: where the body touches solids and people, for scorers;
//! - `camera`: pictures in visible light and of temperatures, taken on request;
//! - `instruments`: temperature and humidity of the air, and gamma spectra, read on request;
//! - `faults`: sensor faults and their times;
//! - `random_changes`: loose objects that change between two visits of a site;
//! - `condition_changes`: doors at other angles, leaks, gauges and lamps that are out of order;
//! - `simulator`: the whole simulation in blocks of 10 ms; `route_follower` drives it along a route for recordings.

mod battery;
mod body;
mod bvh;
mod camera;
mod condition_changes;
mod contacts;
mod dock_contact;
mod faults;
mod gait;
mod ground_truth;
mod imu;
mod instruments;
mod legs;
mod lidar;
mod locomotion;
mod low_pass;
mod people;
mod random_changes;
mod ray_packet;
mod route;
mod route_follower;
mod shape;
mod simulator;
mod site;
#[cfg(test)]
mod tests;
mod timing;

pub use body::STANDING_HEIGHT;
pub use bvh::Bvh;
pub use camera::{
    CameraConfig, CameraImage, CameraScene, CameraSnapshot, Face, Fixture, Intrinsics, SimulatedQuantity,
    ThermalImage, off_centre,
};
pub use condition_changes::{
    ChangeableGauge, ChangeableThings, ConditionChangeError, ConditionChangesConfig,
};
pub use contacts::{Contact, ContactWith};
pub use faults::ScheduledFault;
pub use ground_truth::GroundTruth;
pub use instruments::{
    AirReading, GammaConfig, GammaField, GammaLine, GammaSource, InstrumentEnvironment, InstrumentSnapshot,
    Nuclide,
};
pub use lidar::{FULL_COLUMNS, RINGS};
pub use random_changes::LooseObjectsConfig;
pub use ray_packet::{LANES, Lane, NO_HIT, RayPacket};
pub use route::{SiteRoute, Start};
pub use route_follower::RouteFollower;
pub use shape::{Clearance, Material, Shape, Solid, UnknownMaterial};
pub use simulator::{SimConfig, SimEvent, Simulator};
pub use site::{
    BuildingModel, BuildingModelConfig, BuildingModelError, ConditionChange, Leak, Liquid, LooseObject,
    Mobility, ModelPart, ModelTriangle, ObjectChange, SimulatedDock, SimulatedSite, SiteName,
    TessellationConfig, UnknownSite,
};
pub use timing::{IMU_HZ, SWEEP_HZ};
