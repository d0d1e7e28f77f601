//! Things that go wrong on purpose, at set times.

use geometry::Vector3;
use vocab::{Span, Vec3};

/// Something wrong from one moment to another, both counted from the start of the simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// The LiDAR is covered: its sweeps arrive on time and hold no points.
    BlindLidar {
        /// First moment.
        from: Span,
        /// End, exclusive.
        until: Span,
    },
    /// The LiDAR says nothing at all.
    SilentLidar {
        /// First moment.
        from: Span,
        /// End, exclusive.
        until: Span,
    },
    /// The IMU says nothing at all.
    SilentImu {
        /// First moment.
        from: Span,
        /// End, exclusive.
        until: Span,
    },
    /// The legs report motion that is not there.
    LegSlip {
        /// First moment.
        from: Span,
        /// End, exclusive.
        until: Span,
        /// Added to the reported velocity of the base, m/s in its own frame.
        velocity: Vec3,
    },
}

/// All faults of a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Faults(Vec<Fault>);

impl Faults {
    pub(crate) fn new(faults: Vec<Fault>) -> Self {
        Self(faults)
    }

    pub(crate) fn add(&mut self, fault: Fault) {
        self.0.push(fault);
    }

    /// Drops everything that is scheduled or going on.
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    pub(crate) fn lidar_blind(&self, at: Span) -> bool {
        self.0.iter().any(|f| matches!(f, Fault::BlindLidar { from, until } if (*from..*until).contains(&at)))
    }

    pub(crate) fn lidar_silent(&self, at: Span) -> bool {
        self.0
            .iter()
            .any(|f| matches!(f, Fault::SilentLidar { from, until } if (*from..*until).contains(&at)))
    }

    pub(crate) fn imu_silent(&self, at: Span) -> bool {
        self.0.iter().any(|f| matches!(f, Fault::SilentImu { from, until } if (*from..*until).contains(&at)))
    }

    pub(crate) fn leg_slip(&self, at: Span) -> Vector3 {
        let slips = self.0.iter().filter_map(|fault| match fault {
            Fault::LegSlip { from, until, velocity } if (*from..*until).contains(&at) => Some(velocity),
            _ => None,
        });
        slips.fold(Vector3::zeros(), |sum, velocity| sum + geometry::vec_from_plain(*velocity))
    }
}
