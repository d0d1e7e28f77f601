//! Edits of zones as operators make them: each a step of undo.

use super::{SiteEdit, SiteFeature};
use crate::texts;
use site_model::{Object, Zone, ZoneEffect, ZoneId};
use std::collections::BTreeSet;

/// Parameters of a zone that is drawn.
struct NewZoneConfig {
    /// Heights of a zone that is drawn while one floor alone is shown, metres: from this far below its lowest node to this far above its highest one. Poses of nodes are
    /// those of the base, so the range has the whole robot and its stairs' first steps, and no other floor.
    floor_range_m: [f64; 2],
    /// Shortest side of an area that is drawn, metres. Chosen: two columns of the ground; less is a click.
    min_side_m: f64,
}

const CONFIG: NewZoneConfig = NewZoneConfig { floor_range_m: [1.0, 1.5], min_side_m: 0.2 };

impl SiteFeature {
    /// All zones, by name.
    pub fn zones(&self) -> Vec<&Zone> {
        let mut zones: Vec<&Zone> = self.site().into_iter().flat_map(|site| site.zones()).collect();
        zones.sort_by(|a, b| a.name.cmp(&b.name).then(a.id.cmp(&b.id)));
        zones
    }

    /// The zone of this id.
    pub fn zone(&self, id: ZoneId) -> Option<&Zone> {
        self.site()?.zones().find(|zone| zone.id == id)
    }

    /// A new zone that the robot does not enter, by its corners, m, map frame. While one floor alone is shown, it holds there only.
    pub fn adding_zone(&self, corners_m: Vec<[f64; 2]>) -> (ZoneId, SiteEdit) {
        let id = ZoneId(self.new_id(0));
        let zone = Zone {
            id,
            name: self.free_zone_name(),
            corners_m,
            height_m: self.shown_floor().and_then(|floor| self.floor_heights_m(floor)),
            effect: ZoneEffect::KeepOut,
            daily: None,
        };
        (id, SiteEdit { put: vec![Object::Zone(zone)], removed: Vec::new() })
    }

    /// A zone after a change; nothing if that leaves it as it is.
    pub fn changing_zone(&self, id: ZoneId, change: impl FnOnce(&mut Zone)) -> SiteEdit {
        let mut edit = SiteEdit::default();
        if let Some(zone) = self.zone(id) {
            let mut changed = zone.clone();
            change(&mut changed);
            if changed != *zone {
                edit.put.push(Object::Zone(changed));
            }
        }
        edit
    }

    /// Heights at which a zone holds on this floor alone, m, map frame; `None` without a node there.
    pub fn floor_heights_m(&self, floor: i32) -> Option<[f64; 2]> {
        let nodes = self.site()?.nodes().filter(|node| node.floor == floor);
        let heights = nodes.map(|node| node.map_from_node.position.z);
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), height| {
            (low.min(height), high.max(height))
        });
        let [below, above] = CONFIG.floor_range_m;
        (low <= high).then_some([low - below, high + above])
    }

    /// Whether a zone is shown: it holds at the heights of the floor that is shown.
    pub fn is_zone_shown(&self, zone: &Zone) -> bool {
        let (Some([low, high]), Some([from, to])) = (self.shown_heights_m(), zone.height_m) else {
            return true;
        };
        from <= high && low <= to
    }

    /// Height of the base at the node that is nearest to the middle of an area, m, map frame, among those at heights in which a zone of it holds. None without nodes.
    pub fn base_height_in_m(&self, corners_m: &[[f64; 2]], height_m: Option<[f64; 2]>) -> Option<f64> {
        let [x, y] = middle_of(corners_m);
        let holds_at = |z: f64| height_m.is_none_or(|[low, high]| (low..=high).contains(&z));
        let positions = self.shown_nodes().map(|node| node.map_from_node.position);
        let nearest = positions
            .filter(|at| holds_at(at.z))
            .min_by(|a, b| (a.x - x).hypot(a.y - y).total_cmp(&(b.x - x).hypot(b.y - y)));
        nearest.map(|at| at.z).or(height_m.map(|[low, _]| low))
    }

    /// The first of the names `Zone 1`, `Zone 2` and so on that no zone has.
    fn free_zone_name(&self) -> String {
        let names: BTreeSet<&str> = self.zones().iter().map(|zone| zone.name.as_str()).collect();
        let free = (1..).map(texts::zone_name).find(|name| !names.contains(name.as_str()));
        free.unwrap_or_default()
    }
}

/// Corners of the rectangle that a drag draws between two opposite ones, with its sides along and across a heading, rad. None where a side is so short that it is a slip of
/// the hand.
pub fn drawn_area(yaw_rad: f64, from_m: [f64; 2], to_m: [f64; 2]) -> Vec<[f64; 2]> {
    let (sin, cos) = yaw_rad.sin_cos();
    let by = [to_m[0] - from_m[0], to_m[1] - from_m[1]];
    let (ahead, aside) = (by[0] * cos + by[1] * sin, by[1] * cos - by[0] * sin);
    if ahead.abs() < CONFIG.min_side_m || aside.abs() < CONFIG.min_side_m {
        return Vec::new();
    }
    let along = [ahead * cos, ahead * sin];
    let [second, last] = [1.0, -1.0].map(|sign: f64| {
        let from = if sign > 0.0 { from_m } else { to_m };
        [from[0] + sign * along[0], from[1] + sign * along[1]]
    });
    vec![from_m, second, to_m, last]
}

/// Mean of the corners of an area; zero without any.
pub fn middle_of(corners_m: &[[f64; 2]]) -> [f64; 2] {
    let count = corners_m.len().max(1) as f64;
    let sum = corners_m.iter().fold([0.0, 0.0], |[x, y], corner| [x + corner[0], y + corner[1]]);
    [sum[0] / count, sum[1] / count]
}

#[cfg(test)]
mod tests {
    use super::super::tests::Robot;
    use super::drawn_area;
    use crate::testing::TestClient;
    use crate::{ClientCommand, Selection, SiteEdit};
    use site_model::{ObjectId, ZoneEffect};
    use vocab::{MapId, Vec3};

    const CORNERS: [[f64; 2]; 4] = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]];

    #[test]
    fn an_area_is_drawn_along_the_heading_of_the_camera_and_a_slip_of_the_hand_draws_none() {
        let corners = drawn_area(std::f64::consts::FRAC_PI_4, [0.0, 0.0], [2.0, 0.0]);
        for (corner, wanted) in corners.iter().zip([[0.0, 0.0], [1.0, 1.0], [2.0, 0.0], [1.0, -1.0]]) {
            assert!((corner[0] - wanted[0]).hypot(corner[1] - wanted[1]) < 1e-9, "{corners:?}");
        }
        assert_eq!(corners.len(), 4);
        assert!(drawn_area(0.0, [0.0, 0.0], [2.0, 0.1]).is_empty());
    }

    fn client_with_floors(robot: &Robot) -> TestClient {
        let mut client = TestClient::with_site(robot);
        for (x, z, floor) in [(1.0, 0.5, 0), (1.0, 4.5, 1)] {
            let map = MapId(uuid::Uuid::from_u128(3));
            let (node, edit) = client.model.site.adding_node(Vec3::new(x, 0.0, z), map, None);
            client.command(ClientCommand::EditSite(edit));
            let edit = client.model.site.changing_node(node, |node| node.floor = floor);
            client.command(ClientCommand::EditSite(edit));
        }
        client
    }

    #[test]
    fn a_zone_holds_on_the_floor_that_is_shown_and_is_changed_deleted_and_taken_back() {
        let robot = Robot::default();
        let mut client = client_with_floors(&robot);
        let (zone, edit) = client.model.site.adding_zone(CORNERS.to_vec());
        client.command(ClientCommand::EditSite(edit));
        let of_site = client.model.site.zone(zone).cloned().unwrap();
        assert_eq!((of_site.name.as_str(), of_site.height_m), ("Zone 1", None), "all floors are shown");

        client.command(ClientCommand::ShowFloor(Some(1)));
        let (upper, edit) = client.model.site.adding_zone(CORNERS.to_vec());
        client.command(ClientCommand::EditSite(edit));
        let of_floor = client.model.site.zone(upper).cloned().unwrap();
        assert_eq!((of_floor.name.as_str(), of_floor.height_m), ("Zone 2", Some([3.5, 6.0])));
        assert!(client.model.site.is_zone_shown(&of_floor));
        assert_eq!(client.model.site.base_height_in_m(&CORNERS, of_floor.height_m), Some(4.5));
        client.command(ClientCommand::ShowFloor(Some(0)));
        assert!(!client.model.site.is_zone_shown(&of_floor), "it is of the other floor");

        let slow = |zone: &mut site_model::Zone| zone.effect = ZoneEffect::SpeedLimit(0.3);
        client.command(ClientCommand::EditSite(client.model.site.changing_zone(upper, slow)));
        assert_eq!(client.model.site.changing_zone(upper, slow), SiteEdit::default(), "it is so already");
        let selection = Some(Selection::Zone(upper));
        let removal = client.model.site.removing_selected(selection, &Default::default()).unwrap();
        assert_eq!(removal.removed, [ObjectId::Zone(upper)]);
        client.command(ClientCommand::EditSite(removal));
        assert_eq!(client.model.site.zones().len(), 1);
        client.command(ClientCommand::Undo);
        client.command(ClientCommand::Undo);
        assert_eq!(client.model.site.zone(upper).map(|zone| &zone.effect), Some(&ZoneEffect::KeepOut));
    }
}
