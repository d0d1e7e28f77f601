//! The ground truth as a file, for scorers only: one line for each step.

use rustix::time::{ClockId, clock_gettime};
use sim::Simulator;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::Path;

/// The first line of the file.
const HEADER: &str = "robot_time_ns,monotonic_ns,x_m,y_m,z_m,qw,qx,qy,qz,vx_m_s,vy_m_s,vz_m_s,wx_rad_s,wy_rad_s,wz_rad_s,walking\n";

/// Appends to the file.
pub(super) struct TruthLog {
    /// `None` after an error, which was reported.
    file: Option<File>,
}

impl TruthLog {
    pub(super) fn open(path: &Path) -> io::Result<Self> {
        let mut file = OpenOptions::new().append(true).create(true).open(path)?;
        if file.metadata()?.len() == 0 {
            file.write_all(HEADER.as_bytes())?;
        }
        Ok(Self { file: Some(file) })
    }

    /// Writes the present state: the pose of the base in the site, its velocity in its own frame, and whether the legs move.
    pub(super) fn append(&mut self, simulator: &Simulator) {
        let Some(file) = &mut self.file else {
            return;
        };
        let truth = simulator.truth();
        let (pose, velocity) = (truth.site_from_base, truth.velocity);
        let (p, q, v, w) = (pose.position, pose.orientation, velocity.linear, velocity.angular);
        let numbers = [p.x, p.y, p.z, q.w, q.x, q.y, q.z, v.x, v.y, v.z, w.x, w.y, w.z];
        let mut line = format!("{},{}", truth.stamp.nanos(), monotonic_ns());
        for number in numbers {
            line.push_str(&format!(",{number:.6}"));
        }
        line.push_str(if simulator.is_walking() { ",1\n" } else { ",0\n" });
        if let Err(error) = file.write_all(line.as_bytes()) {
            tracing::error!("the ground truth is not written any more: {error}");
            self.file = None;
        }
    }
}

/// This computer's monotonic clock, which all its processes share.
fn monotonic_ns() -> i64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec * 1_000_000_000 + now.tv_nsec
}
