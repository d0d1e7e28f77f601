//! The robot's core as a process. It orders inputs, records them, steps the stack, executes its effects, and publishes state to the gateway.
//!
//! | thread | does | waits for |
//! | --- | --- | --- |
//! | the link's own | sensors in, drive commands out | the robot's clock |
//! | `core` | the control loop: one input at a time through the stack | arrivals, commands, finished jobs |
//! | `recorder` | writes every input before it can matter to anyone else | the loop |
//! | `disk` | saves and reads maps, writes keyframe clouds | the loop |
//! | `compute` | verifies loops, compares revisits, relocalises | the loop |
//! | `publisher` | tiles, live scans, state for clients | the loop |
//! | `imports` | maps of files that clients sent, in a process of their own | a client |
//! | `gateway-accept`, `-read`, `-write` | one gateway at a time on a Unix socket | the gateway |
//!
//! Nothing here makes the control loop wait for a disk, a client or a network. Each queue says what may be lost and how that is reported.

mod clock;
mod control_loop;
mod convert;
mod core;
mod gateway_link;
mod imports;
mod jobs;
mod live_map;
mod mailbox;
mod place_keeper;
mod platform;
mod publisher;
mod recording;
mod state_publisher;

pub use crate::core::{Core, CoreConfig, StartError};
pub use jobs::known_map;
pub use recording::RecordingTarget;
