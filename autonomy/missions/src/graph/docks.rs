//! In which dock a charged robot is, and whether that dock stands where the map has it.

use crate::poses::{floor_distance_m, heading_rad, turn_between_rad};
use site_model::{DockId, Site};
use vocab::Pose;

/// Parameters of [`docked_at`] and [`DockOffset::is_elsewhere`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DockConfig {
    /// Distance from the node of a dock within which a robot that is charged is in that dock, metres. More than the error of localisation, less than the
    /// distance of two docks side by side. Chosen between them: docks stand a metre apart or more.
    pub max_distance_m: f64,
    /// Distance of a docked robot from the node of its dock from which on the dock counts as moved, metres. Twice the error of localisation. Chosen for an error of 5 cm.
    pub min_moved_m: f64,
    /// The same for its heading, radians. Chosen: 6 degrees, within which the robot still enters from the same node.
    pub min_turned_rad: f64,
}

impl Default for DockConfig {
    fn default() -> Self {
        Self { max_distance_m: 0.5, min_moved_m: 0.1, min_turned_rad: 0.1 }
    }
}

/// The dock in which a robot that is charged stands: the nearest one, if it is near enough. The base in the map. Linear in the docks.
pub fn docked_at(site: &Site, map_from_base: &Pose, config: &DockConfig) -> Option<DockId> {
    let near = site.docks().filter_map(|dock| {
        let distance_m = floor_distance_m(&site.node(dock.node)?.map_from_node, map_from_base);
        (distance_m <= config.max_distance_m).then_some((distance_m, dock.id))
    });
    near.min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, dock)| dock)
}

/// How far a docked robot is from where the map has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DockOffset {
    /// On the floor, metres.
    pub distance_m: f64,
    /// Difference of heading, radians, 0 to π.
    pub turned_rad: f64,
}

impl DockOffset {
    /// Of a robot in this dock; none if the site has no such dock or its node is missing. The base in the map.
    pub fn new(site: &Site, dock: DockId, map_from_base: &Pose) -> Option<Self> {
        let dock = site.docks().find(|known| known.id == dock)?;
        let map_from_node = site.node(dock.node)?.map_from_node;
        Some(Self {
            distance_m: floor_distance_m(&map_from_node, map_from_base),
            turned_rad: turn_between_rad(heading_rad(&map_from_node), heading_rad(map_from_base)).abs(),
        })
    }

    /// Whether the dock has been moved.
    pub fn is_elsewhere(&self, config: &DockConfig) -> bool {
        self.distance_m > config.min_moved_m || self.turned_rad > config.min_turned_rad
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::poses::turned;
    use crate::testing::SiteBuilder;
    use uuid::Uuid;
    use vocab::Vec3;

    fn at(x: f64, y: f64) -> Pose {
        Pose { position: Vec3::new(x, y, 0.0), ..Pose::IDENTITY }
    }

    /// Docks 91 and 92, 0.8 m beside each other.
    fn site() -> Site {
        let mut builder = SiteBuilder::new();
        builder.node(1, 0.0, 0.0).node(2, 0.0, 0.8).node(3, 1.0, 0.0).dock(91, 1, 3).dock(92, 2, 3);
        builder.site()
    }

    #[test]
    fn a_charged_robot_is_in_the_nearest_dock_that_is_near_enough() {
        let (site, config) = (site(), DockConfig::default());
        let dock = |x, y| docked_at(&site, &at(x, y), &config).map(|dock| dock.0.as_u128());
        assert_eq!([dock(0.1, 0.3), dock(0.1, 0.5), dock(0.6, 0.4)], [Some(91), Some(92), None]);
    }

    #[test]
    fn a_dock_is_elsewhere_when_it_was_moved_or_turned() {
        let (site, config) = (site(), DockConfig::default());
        let offset = |pose: Pose| {
            DockOffset::new(&site, DockId(Uuid::from_u128(91)), &pose).unwrap_or_else(|| panic!("no dock"))
        };
        assert!(!offset(turned(&at(0.06, 0.06), -0.09)).is_elsewhere(&config));
        let moved = offset(at(0.06, -0.09));
        assert!(moved.is_elsewhere(&config) && (moved.distance_m - 0.06_f64.hypot(0.09)).abs() < 1e-12);
        let turned = offset(turned(&at(0.0, 0.0), -0.12));
        assert!(turned.is_elsewhere(&config) && (turned.turned_rad - 0.12).abs() < 1e-12);
        assert_eq!(DockOffset::new(&site, DockId(Uuid::from_u128(93)), &at(0.0, 0.0)), None);
    }
}
