//! Chooses scans by the distance between them.

use geometry::Isometry;

/// Parameters of a [`DistanceTrigger`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceTriggerConfig {
    /// Distance between scans that are compared with the map, metres. Closer scans see the same surfaces. Chosen: the distance of keyframes.
    pub distance_m: f64,
}

impl Default for DistanceTriggerConfig {
    fn default() -> Self {
        Self { distance_m: 1.0 }
    }
}

/// Chooses scans that are [`DistanceTriggerConfig::distance_m`] apart.
#[derive(Debug, Default)]
pub struct DistanceTrigger {
    config: DistanceTriggerConfig,
    last: Option<Isometry>,
}

impl DistanceTrigger {
    /// Whether a scan at this pose is chosen.
    pub fn is_due(&mut self, pose: &Isometry) -> bool {
        let step = |last: &Isometry| (last.translation.vector - pose.translation.vector).norm();
        let due = self.last.as_ref().is_none_or(|last| step(last) >= self.config.distance_m);
        if due {
            self.last = Some(*pose);
        }
        due
    }
}
