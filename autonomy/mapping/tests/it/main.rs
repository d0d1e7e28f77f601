//! Loop finding on simulated walks with estimated odometry, compared with the ground truth.

mod support;
mod twins;
