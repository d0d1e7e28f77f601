//! The odometry as a whole: on simulated walks with truth, on real recordings, and on broken input.

mod faulty;
mod recorded;
mod simulated;
mod support;
