//! Docks of known maps. If a localised robot is charged, the pose of its dock is stored. If a robot without a pose is charged, the docks are tried
//! first. The charging contact thus decides between poses that look alike, which a LiDAR cannot do.

use geometry::{Isometry, isometry_from_pose, pose_from_isometry};
use vocab::{MapId, Pose, Span, Stamp};

/// Parameters of [`DockRegistry`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DockRegistryConfig {
    /// A dock is learnt where the robot has been charged and has known its pose for this time. Chosen: longer than the current of contacts that only touch for a moment.
    pub learning_time: Span,
    /// A new dock this near to a known one is that dock, moved, metres. Chosen: less than the distance of two docks side by side, and more than a dock is pushed.
    pub min_separation_m: f64,
    /// A robot that moves farther while it is charged is not at a dock, and a dock that moves less is not learnt again, metres. Chosen: a little more than contacts allow
    /// for, 3 cm.
    pub position_tolerance_m: f64,
    /// Number of docks kept, the newest; a site has a handful for each of its maps. Chosen: far more than that, so that it only bounds the memory.
    pub max_docks: usize,
}

impl Default for DockRegistryConfig {
    fn default() -> Self {
        Self {
            learning_time: Span::from_millis(3_000),
            min_separation_m: 1.0,
            position_tolerance_m: 0.05,
            max_docks: 256,
        }
    }
}

/// A dock of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapDock {
    /// The map.
    pub map: MapId,
    /// Pose of the base at the dock.
    pub map_from_base: Pose,
}

/// The known docks, and whether the robot is at one.
#[derive(Debug)]
pub struct DockRegistry {
    config: DockRegistryConfig,
    docks: Vec<MapDock>,
    is_charging: bool,
    /// Start of charging at a known pose, and that pose.
    charging_pose: Option<(Stamp, MapId, Isometry)>,
}

impl DockRegistry {
    /// A registry of these docks.
    pub fn new(config: DockRegistryConfig, docks: Vec<MapDock>) -> Self {
        Self { config, docks, is_charging: false, charging_pose: None }
    }

    /// All docks, the oldest first.
    pub fn docks(&self) -> &[MapDock] {
        &self.docks
    }

    /// Whether the battery is charged now.
    pub fn set_charging(&mut self, is_charging: bool) {
        self.is_charging = is_charging;
    }

    /// Updates by the robot's pose in a map, if it is known. Returns whether a dock was learnt or moved.
    pub fn update(&mut self, at: Stamp, pose: Option<(MapId, Isometry)>) -> bool {
        let Some((map, map_from_base)) = pose.filter(|_| self.is_charging) else {
            self.charging_pose = None;
            return false;
        };
        // A full battery may report for a while that it is charged, although the robot has left the dock.
        let stands_still = |(_, before, pose): &(Stamp, MapId, Isometry)| {
            let moved_m = (pose.translation.vector - map_from_base.translation.vector).norm();
            *before == map && moved_m <= self.config.position_tolerance_m
        };
        let since = self.charging_pose.filter(stands_still).unwrap_or((at, map, map_from_base));
        self.charging_pose = Some(since);
        at - since.0 >= self.config.learning_time && self.learn(map, &map_from_base)
    }

    fn learn(&mut self, map: MapId, map_from_base: &Isometry) -> bool {
        let distance_m = |dock: &MapDock| {
            let pose = isometry_from_pose(&dock.map_from_base)?;
            (dock.map == map).then(|| (pose.translation.vector - map_from_base.translation.vector).norm())
        };
        let nearest_m = self.docks.iter().filter_map(distance_m).fold(f64::INFINITY, f64::min);
        if nearest_m <= self.config.position_tolerance_m {
            return false;
        }
        let min_separation_m = self.config.min_separation_m;
        self.docks.retain(|dock| distance_m(dock).is_none_or(|distance_m| distance_m > min_separation_m));
        self.docks.push(MapDock { map, map_from_base: pose_from_isometry(map_from_base) });
        self.docks.drain(..self.docks.len().saturating_sub(self.config.max_docks));
        true
    }

    /// Poses of the base at the docks of a map while the robot is charged; none while it is not.
    pub fn possible_poses(&self, map: MapId) -> Vec<Isometry> {
        let of_map = self.docks.iter().filter(|dock| self.is_charging && dock.map == map);
        of_map.filter_map(|dock| isometry_from_pose(&dock.map_from_base)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAP: MapId = MapId(uuid::Uuid::from_u128(1));
    const OTHER: MapId = MapId(uuid::Uuid::from_u128(2));

    fn registry() -> DockRegistry {
        DockRegistry::new(DockRegistryConfig::default(), Vec::new())
    }

    fn update(docks: &mut DockRegistry, seconds: i64, map: MapId, x: f64) -> bool {
        docks.update(Stamp::from_parts(seconds, 0), Some((map, Isometry::translation(x, 0.0, 0.5))))
    }

    #[test]
    fn a_dock_is_learnt_where_the_robot_was_charged_for_a_while_at_a_known_pose() {
        let mut docks = registry();
        assert!(!update(&mut docks, 0, MAP, 1.0) && !update(&mut docks, 9, MAP, 1.0), "not charged");
        docks.set_charging(true);
        assert!(!update(&mut docks, 10, MAP, 1.0), "just arrived");
        assert!(!docks.update(Stamp::from_parts(11, 0), None), "lost");
        assert!(!update(&mut docks, 14, MAP, 1.0), "just found");
        assert!(update(&mut docks, 17, MAP, 1.0));
        assert!(!update(&mut docks, 18, MAP, 1.02), "the same");
        for step in 0..10 {
            assert!(!update(&mut docks, 20 + step, MAP, 2.0 + step as f64), "it walks");
        }
        assert_eq!(docks.possible_poses(MAP), [Isometry::translation(1.0, 0.0, 0.5)]);
        assert_eq!(docks.possible_poses(OTHER), []);
        docks.set_charging(false);
        assert_eq!(docks.possible_poses(MAP), [], "it is elsewhere");
    }

    #[test]
    fn a_moved_dock_replaces_itself_and_docks_of_other_maps_stay() {
        let mut docks = registry();
        docks.set_charging(true);
        for (seconds, map, x) in [(0, MAP, 1.0), (10, OTHER, 1.0), (20, MAP, 1.4), (30, MAP, 9.0)] {
            update(&mut docks, seconds, map, x);
            assert!(update(&mut docks, seconds + 5, map, x));
            docks.update(Stamp::from_parts(seconds + 6, 0), None);
        }
        let positions =
            |map| docks.possible_poses(map).iter().map(|dock| dock.translation.x).collect::<Vec<_>>();
        assert_eq!(positions(MAP), [1.4, 9.0]);
        assert_eq!(positions(OTHER), [1.0]);
    }

    #[test]
    fn the_oldest_docks_are_dropped() {
        let config = DockRegistryConfig { max_docks: 2, ..DockRegistryConfig::default() };
        let mut docks = DockRegistry::new(config, Vec::new());
        docks.set_charging(true);
        for number in 0..3 {
            update(&mut docks, 10 * number, MAP, 5.0 * number as f64);
            assert!(update(&mut docks, 10 * number + 5, MAP, 5.0 * number as f64));
        }
        assert_eq!(docks.docks().len(), 2);
        assert_eq!(docks.docks()[0].map_from_base.position.x, 5.0);
    }
}
