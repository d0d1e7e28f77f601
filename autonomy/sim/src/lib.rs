//! The simulator: industrial sites, a walking robot with its sensors, people, and faults on schedule.
//!
//! Everything is seeded and clockless: the same configuration, commands and number of blocks give the same bytes. It never
//! sees the stack. How it is cut: `site` builds places out of `shape`s, `bvh` and `packed` cast rays at them; `walker`,
//! `gait` and `smooth` make up the `body`'s trajectory; `lidar`, `imu`, `legs` and `battery` observe it; `route` walks it
//! for recordings; `simulator` runs all of it in blocks of 10 ms.

mod battery;
mod body;
mod bvh;
mod faults;
mod gait;
mod imu;
mod legs;
mod lidar;
mod packed;
mod people;
mod route;
mod shape;
mod simulator;
mod site;
mod smooth;
#[cfg(test)]
mod tests;
mod walker;

pub use body::STANDING_HEIGHT;
pub use bvh::Bvh;
pub use faults::Fault;
pub use imu::GRAVITY;
pub use lidar::{FULL_COLUMNS, RINGS, SWEEP_HZ};
pub use packed::{LANES, Lane, NOTHING, Packet};
pub use route::{Route, RouteWalker, Start};
pub use shape::{Clearance, Material, Shape, Solid};
pub use simulator::{SimConfig, SimEvent, Simulator, Truth};
pub use site::{Dock, Site, SiteName, UnknownSite};

/// IMU samples a second.
pub const IMU_HZ: u32 = 400;

/// Steps of the body within one block, the unit of [`Simulator::advance`].
const TICKS_PER_BLOCK: usize = 16;
const TICKS_PER_IMU: isize = 4;
const TICK_NANOS: i64 = 625_000;
const TICK_SECONDS: f64 = TICK_NANOS as f64 * 1e-9;
const BLOCK_NANOS: i64 = TICK_NANOS * TICKS_PER_BLOCK as i64;
const BLOCK_SECONDS: f64 = BLOCK_NANOS as f64 * 1e-9;
const BLOCKS_PER_SWEEP: i64 = 1_000_000_000 / SWEEP_HZ as i64 / BLOCK_NANOS;
