//! Docks of saved maps. A robot that is charged while it knows its place learns where a dock is; one that is charged and does not know its
//! place looks at the docks first. Contacts tell what no LiDAR does where a site repeats itself.

use geometry::{Isometry, isometry_from_pose, pose_from_isometry};
use messages::{BatteryState, PlaceInMap};
use std::sync::Arc;
use vocab::{MapId, Span, Stamp};

/// A place is a dock once the robot has stood there and been charged, knowing it, for so long.
const LEARNT_AFTER: Span = Span::from_millis(3_000);
/// Docks of one map are farther apart than this, metres: what is nearer is the same one, moved.
const APART: f64 = 1.0;
/// Moved by less than this it stays where it is, metres.
const MOVED: f64 = 0.05;
/// Docks kept at most, the newest; a site has a handful for each of its maps.
const KEPT: usize = 256;

/// What is known of docks, and whether the robot is at one.
#[derive(Debug)]
pub(crate) struct Docks {
    known: Arc<[PlaceInMap]>,
    charging: bool,
    /// Since when it has been charged and has known its place, and where that was.
    since: Option<(Stamp, MapId, Isometry)>,
}

impl Docks {
    /// Those known before.
    pub fn new(known: &[PlaceInMap]) -> Self {
        Self { known: known.into(), charging: false, since: None }
    }

    /// All of them.
    pub fn known(&self) -> &Arc<[PlaceInMap]> {
        &self.known
    }

    /// The battery has spoken.
    pub fn hear(&mut self, battery: &BatteryState) {
        self.charging = battery.charging;
    }

    /// Takes down where the robot is in a map, if it knows; says whether there is a new dock, or a known one elsewhere.
    pub fn note(&mut self, at: Stamp, place: Option<(MapId, Isometry)>) -> bool {
        let Some((map, map_from_base)) = place.filter(|_| self.charging) else {
            self.since = None;
            return false;
        };
        // A full battery may say so for a while when it has left its dock.
        let has_stood = |(_, before, place): &(Stamp, MapId, Isometry)| {
            let moved = (place.translation.vector - map_from_base.translation.vector).norm();
            *before == map && moved <= MOVED
        };
        let (since, ..) =
            *self.since.insert(self.since.filter(has_stood).unwrap_or((at, map, map_from_base)));
        at - since >= LEARNT_AFTER && self.learn(map, &map_from_base)
    }

    fn learn(&mut self, map: MapId, map_from_base: &Isometry) -> bool {
        let away = |dock: &PlaceInMap| {
            let known = isometry_from_pose(&dock.map_from_base)?;
            (dock.map == map).then(|| (known.translation.vector - map_from_base.translation.vector).norm())
        };
        let nearest = self.known.iter().filter_map(away).fold(f64::INFINITY, f64::min);
        if nearest <= MOVED {
            return false;
        }
        let others = self.known.iter().filter(|dock| away(dock).is_none_or(|metres| metres > APART));
        let new = PlaceInMap { map, map_from_base: pose_from_isometry(map_from_base) };
        let mut known: Vec<PlaceInMap> = others.copied().chain([new]).collect();
        known.drain(..known.len().saturating_sub(KEPT));
        self.known = known.into();
        true
    }

    /// Whether the robot is charged, and docks of a map are known.
    pub fn is_at_one_of(&self, map: MapId) -> bool {
        self.charging && self.known.iter().any(|dock| dock.map == map)
    }

    /// Where the robot may be in a map if it is at a dock of that; none if it is at no dock, or nobody knows one.
    pub fn candidates(&self, map: MapId) -> Vec<Isometry> {
        let of_map = self.known.iter().filter(|dock| self.charging && dock.map == map);
        of_map.filter_map(|dock| isometry_from_pose(&dock.map_from_base)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use uuid::Uuid;

    const MAP: MapId = MapId(Uuid::from_u128(1));
    const OTHER: MapId = MapId(Uuid::from_u128(2));

    fn charged(charging: bool) -> BatteryState {
        BatteryState { charging, ..BatteryState::default() }
    }

    fn after(docks: &mut Docks, seconds: i64, map: MapId, x: f64) -> bool {
        docks.note(Stamp::from_parts(seconds, 0), Some((map, Isometry::translation(x, 0.0, 0.5))))
    }

    #[test]
    fn a_dock_is_where_the_robot_was_charged_for_a_while_and_knew_its_place() {
        let mut docks = Docks::new(&[]);
        assert!(!after(&mut docks, 0, MAP, 1.0) && !after(&mut docks, 9, MAP, 1.0), "not charged");
        docks.hear(&charged(true));
        assert!(!after(&mut docks, 10, MAP, 1.0), "just arrived");
        assert!(!docks.note(Stamp::from_parts(11, 0), None), "lost");
        assert!(!after(&mut docks, 14, MAP, 1.0), "just found");
        assert!(after(&mut docks, 17, MAP, 1.0));
        assert!(!after(&mut docks, 18, MAP, 1.02), "the same");
        for step in 0..10 {
            assert!(!after(&mut docks, 20 + step, MAP, 2.0 + step as f64), "it walks");
        }
        assert_eq!(docks.candidates(MAP), [Isometry::translation(1.0, 0.0, 0.5)]);
        assert_eq!(docks.candidates(OTHER), []);
        docks.hear(&charged(false));
        assert_eq!(docks.candidates(MAP), [], "it is elsewhere");
    }

    #[test]
    fn a_dock_that_was_moved_is_one_and_docks_of_other_maps_stay() {
        let mut docks = Docks::new(&[]);
        docks.hear(&charged(true));
        for (seconds, map, x) in [(0, MAP, 1.0), (10, OTHER, 1.0), (20, MAP, 1.4), (30, MAP, 9.0)] {
            after(&mut docks, seconds, map, x);
            assert!(after(&mut docks, seconds + 5, map, x));
            docks.note(Stamp::from_parts(seconds + 6, 0), None);
        }
        let places = |map| docks.candidates(map).iter().map(|dock| dock.translation.x).collect::<Vec<_>>();
        assert_eq!(places(MAP), [1.4, 9.0]);
        assert_eq!(places(OTHER), [1.0]);
        assert_eq!(Docks::new(docks.known()).known(), docks.known());
    }
}
