//! Faults of sensors at set times.

use geometry::Vector3;
use vocab::{Span, Vec3};

/// A fault with its beginning and its end, both counted from the start of the simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ScheduledFault {
    /// The LiDAR is covered: its sweeps arrive on time and hold no points.
    BlindLidar {
        /// Beginning.
        from: Span,
        /// End, exclusive.
        until: Span,
    },
    /// The LiDAR sends nothing.
    SilentLidar {
        /// Beginning.
        from: Span,
        /// End, exclusive.
        until: Span,
    },
    /// The IMU sends nothing.
    SilentImu {
        /// Beginning.
        from: Span,
        /// End, exclusive.
        until: Span,
    },
    /// The leg odometry reports motion that does not happen.
    LegSlip {
        /// Beginning.
        from: Span,
        /// End, exclusive.
        until: Span,
        /// Added to the reported velocity of the base, m/s in its own frame.
        velocity: Vec3,
    },
}

/// The faults of a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct FaultSchedule(Vec<ScheduledFault>);

impl FaultSchedule {
    pub(crate) fn new(faults: Vec<ScheduledFault>) -> Self {
        Self(faults)
    }

    pub(crate) fn add(&mut self, fault: ScheduledFault) {
        self.0.push(fault);
    }

    /// Removes all faults, present and future.
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    pub(crate) fn is_lidar_blind(&self, at: Span) -> bool {
        self.0
            .iter()
            .any(|f| matches!(f, ScheduledFault::BlindLidar { from, until } if (*from..*until).contains(&at)))
    }

    pub(crate) fn is_lidar_silent(&self, at: Span) -> bool {
        self.0.iter().any(
            |f| matches!(f, ScheduledFault::SilentLidar { from, until } if (*from..*until).contains(&at)),
        )
    }

    pub(crate) fn is_imu_silent(&self, at: Span) -> bool {
        self.0
            .iter()
            .any(|f| matches!(f, ScheduledFault::SilentImu { from, until } if (*from..*until).contains(&at)))
    }

    pub(crate) fn leg_slip_velocity(&self, at: Span) -> Vector3 {
        let slips = self.0.iter().filter_map(|fault| match fault {
            ScheduledFault::LegSlip { from, until, velocity } if (*from..*until).contains(&at) => {
                Some(velocity)
            }
            _ => None,
        });
        slips.fold(Vector3::zeros(), |sum, velocity| sum + geometry::vec_from_plain(*velocity))
    }
}
