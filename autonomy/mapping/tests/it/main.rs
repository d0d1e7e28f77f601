//! Loop finding on the simulator's walks, through odometry, judged by the truth.

mod support;
mod twins;
