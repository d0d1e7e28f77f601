//! The time steps of the simulation. The body moves in ticks of 0.625 ms; ticks make up blocks of 10 ms, the unit in which the
//! simulator advances; blocks make up sweeps of the LiDAR.

/// IMU samples per second.
pub const IMU_HZ: u32 = 400;
/// LiDAR sweeps per second.
pub const SWEEP_HZ: u32 = 10;

/// Ticks of the body in one block.
pub(crate) const TICKS_PER_BLOCK: usize = 16;
/// Ticks of the body from one IMU sample to the next.
pub(crate) const TICKS_PER_IMU: isize = 4;
/// Duration of a tick, nanoseconds.
pub(crate) const TICK_NANOS: i64 = 625_000;
/// Duration of a tick, seconds.
pub(crate) const TICK_SECONDS: f64 = TICK_NANOS as f64 * 1e-9;
/// Duration of a block, nanoseconds.
pub(crate) const BLOCK_NANOS: i64 = TICK_NANOS * TICKS_PER_BLOCK as i64;
/// Duration of a block, seconds.
pub(crate) const BLOCK_SECONDS: f64 = BLOCK_NANOS as f64 * 1e-9;
/// Blocks in one sweep of the LiDAR.
pub(crate) const BLOCKS_PER_SWEEP: i64 = 1_000_000_000 / SWEEP_HZ as i64 / BLOCK_NANOS;

const _: () = assert!(IMU_HZ as i64 * TICK_NANOS * TICKS_PER_IMU as i64 == 1_000_000_000);
