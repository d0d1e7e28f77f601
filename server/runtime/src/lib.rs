//! The robot's core as a process. It orders inputs, records them, steps the stack, executes its effects, and publishes state to the gateway.
//!
//! | thread | does | waits for |
//! | --- | --- | --- |
//! | the link's own | sensors in, drive commands out | the robot's clock |
//! | `control` | the control loop: one input at a time through the stack | arrivals, commands, finished jobs |
//! | `ledger` | writes what must be on disk before a command is answered: stops of motion | the loop |
//! | `sessions` | writes the journal of the mapping session, from which it is recovered after a crash | the loop |
//! | `recorder` | writes every input to the recording | the loop |
//! | `disk` | saves and reads maps, writes keyframe clouds; renames, deletes and restores maps | the loop, a client |
//! | `compute` | jobs that compute: comparisons, searches, relocalisation, map quality; prepares maps that were read | the loop, `disk` |
//! | `actions` | actions that the stack calls: asks the robot for them, and stores what they gather | the loop, the robot |
//! | `publisher` | tiles, live scans, state for clients | the loop |
//! | `imports` | maps of uploaded files, made by another process | a client |
//! | `scene-changes` | has runs of missions compared with earlier ones by another process | the loop |
//! | `accounts` | who may use the platform: checks passwords, publishes sessions and tokens that are valid | a client, the ledger |
//! | `gateway-accept`, `-read`, `-write` | one gateway at a time on a Unix socket | the gateway |
//!
//! All of them are watched (crate `watchdog`): when one panics or hangs, the process ends and its supervisor starts it again.
//!
//! The control loop never waits for a disk, a client or a network. Each queue documents what may be lost and how that is reported.

mod access;
mod actions;
mod clock;
mod control_loop;
mod convert;
mod core;
mod example;
mod gateway_link;
mod gateway_queue;
mod gauges;
mod imports;
mod incidents;
mod interrupted_sessions;
mod jobs;
mod lease_arbiter;
mod ledger;
mod live_map;
mod mailbox;
mod map_list;
mod map_usage;
mod new_normal;
mod node_following;
mod picture_comparisons;
mod picture_queue;
mod platform;
mod pose_persistence;
mod publisher;
mod recording;
mod run_clouds;
mod scene_changes;
mod session_journal;
mod start_error;
mod state_publisher;
mod state_snapshot;
mod stored_data;
mod stored_data_check;
#[cfg(test)]
mod testing;
mod texts;
mod threads;
mod tile_recovery;
mod topomap_generation;

pub use crate::access::{AccessMode, audit_texts};
pub use crate::core::{Core, CoreConfig, RobotRestart};
pub use clock::set_clock_offset;
pub use jobs::known_map;
pub use recording::RecordingTarget;
pub use scene_changes::{Baseline, BaselineConfig, find_baseline, note_comparison};
pub use start_error::StartError;
pub use threads::{CONTROL_THREAD, THREAD_LIMITS, ThreadLimits};
