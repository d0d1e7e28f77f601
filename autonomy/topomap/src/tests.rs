//! Tests on drawn sites.

use crate::{
    BlockedBy, FloorBuilder, FollowConfig, GeneratedMap, MapMotion, RobotShape, TopomapConfig, TopomapInput,
    generate,
};
use geometry::{Isometry, Rotation, Vector3};
use proptest::prelude::*;
use site_model::{
    ActionRequest, Change, EditId, InspectionPoint, InspectionPointId, Node, NodeKind, Object, Site,
    SiteSettings, TravelDirection, Traversal, ValidationConfig, Zone, ZoneEffect, ZoneId,
};
use std::collections::{BTreeMap, BTreeSet};
use uuid::Uuid;
use vocab::{KeyframeId, MapId, Span, Stamp};

/// Distance between the points of drawn surfaces, metres.
const POINT_M: f64 = 0.05;

/// A drawn site: points of its surfaces, and the walk of a robot.
#[derive(Clone, Default)]
struct Drawn {
    /// Seen after the walk.
    points: Vec<[f32; 3]>,
    /// Seen before the walk.
    earlier: Vec<[f32; 3]>,
    /// Seen after the walk for five seconds.
    brief: Vec<[f32; 3]>,
    path: Vec<Isometry>,
    docks: Vec<Isometry>,
}

impl Drawn {
    /// A level surface.
    fn floor(mut self, from: [f64; 2], to: [f64; 2], z: f64) -> Self {
        for i in 0..=((to[0] - from[0]) / POINT_M) as usize {
            for j in 0..=((to[1] - from[1]) / POINT_M) as usize {
                let at = [from[0] + i as f64 * POINT_M, from[1] + j as f64 * POINT_M, z];
                self.points.push(at.map(|c| c as f32));
            }
        }
        self
    }

    /// A wall of a height above `z`.
    fn wall(mut self, from: [f64; 2], to: [f64; 2], z: f64, height: f64) -> Self {
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        let steps = (length / POINT_M).ceil().max(1.0) as usize;
        for i in 0..=steps {
            let share = i as f64 / steps as f64;
            for j in 0..=(height / POINT_M) as usize {
                let at = [
                    from[0] + (to[0] - from[0]) * share,
                    from[1] + (to[1] - from[1]) * share,
                    z + j as f64 * POINT_M,
                ];
                self.points.push(at.map(|c| c as f32));
            }
        }
        self
    }

    /// The four sides of a box on the floor.
    fn block(self, from: [f64; 2], to: [f64; 2], height: f64) -> Self {
        self.wall(from, [to[0], from[1]], 0.0, height)
            .wall([to[0], from[1]], to, 0.0, height)
            .wall(to, [from[0], to[1]], 0.0, height)
            .wall([from[0], to[1]], from, 0.0, height)
    }

    /// A walk over these places of the feet.
    fn walk(mut self, places: &[[f64; 3]]) -> Self {
        for pair in places.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(Vector3::from);
            let yaw = (b.y - a.y).atan2(b.x - a.x);
            let steps = ((b - a).norm() / 0.1).ceil().max(1.0) as usize;
            for step in 0..=steps {
                let feet = a.lerp(&b, step as f64 / steps as f64);
                self.path.push(base_at(&feet, yaw));
            }
        }
        self
    }

    fn keyframes(&self) -> Vec<(KeyframeId, Isometry)> {
        let path =
            if self.path.is_empty() { vec![base_at(&Vector3::zeros(), 0.0)] } else { self.path.clone() };
        (0..).map(KeyframeId).zip(path.into_iter().step_by(10)).collect()
    }

    fn generate(&self) -> GeneratedMap {
        let config = TopomapConfig::default();
        let robot = ROBOT;
        // The drawn site is larger than the range of a keyframe.
        let config = TopomapConfig { max_range_m: 1e3, ..config };
        let mut floor = FloorBuilder::new(robot, config);
        floor.insert(Stamp::EPOCH, &Isometry::identity(), &self.earlier);
        for (points, seen_s) in [(&self.points, [0.0, 60.0]), (&self.brief, [0.0, 5.0])] {
            for second in seen_s {
                floor.insert(Stamp::from_secs_f64(1e6 + second), &Isometry::identity(), points);
            }
        }
        let path: Vec<(Stamp, Isometry)> = self
            .path
            .iter()
            .enumerate()
            .map(|(second, pose)| (Stamp::from_secs_f64(1.0 + second as f64), *pose))
            .collect();
        let keyframes = self.keyframes();
        let input = TopomapInput { map: MAP, keyframes: &keyframes, path: &path, docks: &self.docks, robot };
        generate(&input, floor, &config)
    }
}

const MAP: MapId = MapId(Uuid::from_u128(7));

/// A robot for tests.
pub(crate) const ROBOT: RobotShape =
    RobotShape { radius_m: 0.38, standing_height_m: 0.55, clearance_m: 0.95, step_m: 0.22 };

fn base_at(feet: &Vector3, yaw: f64) -> Isometry {
    let base = feet + Vector3::z() * ROBOT.standing_height_m;
    Isometry::from_parts(base.into(), Rotation::from_euler_angles(0.0, 0.0, yaw))
}

/// Edges of one direction, as positions of their ends.
fn lines(made: &GeneratedMap) -> Vec<(Vector3, Vector3, Traversal)> {
    let position: BTreeMap<_, _> = made
        .nodes
        .iter()
        .map(|node| (node.id, geometry::vec_from_plain(node.map_from_node.position)))
        .collect();
    let forward = made.edges.iter().filter(|edge| edge.from < edge.to);
    forward.map(|edge| (position[&edge.from], position[&edge.to], edge.traversal.clone())).collect()
}

/// Distance from a place of the base to the nearest edge, metres.
fn distance_to_edges(made: &GeneratedMap, at: &Vector3) -> f64 {
    let distance = |(a, b, _): &(Vector3, Vector3, Traversal)| {
        let span = b - a;
        let share = ((at - a).dot(&span) / span.norm_squared()).clamp(0.0, 1.0);
        (at - a - span * share).norm()
    };
    lines(made).iter().map(distance).fold(f64::INFINITY, f64::min)
}

/// What has to hold of every map.
fn check_laws(drawn: &Drawn, made: &GeneratedMap) {
    let pairs: BTreeSet<_> = made.edges.iter().map(|edge| (edge.from, edge.to)).collect();
    assert_eq!(pairs.len(), made.edges.len(), "no edge is there twice");
    assert!(pairs.iter().all(|(a, b)| a != b && pairs.contains(&(*b, *a))), "every edge has its reverse");
    let mut site = Site::default();
    let settings =
        SiteSettings { name: "Drawn".to_owned(), time_zone: "Europe/London".to_owned(), map: None };
    let named = site.put(EditId(Uuid::from_u128(1)), Object::Settings(settings));
    site.apply(&named, EditId(Uuid::from_u128(3))).expect("applied");
    let edit = made.replacement(&site, MAP, EditId(Uuid::from_u128(2))).edit;
    site.apply(&edit, EditId(Uuid::from_u128(3))).expect("applied");
    assert_eq!(site.problems(&ValidationConfig::default()), []);
    let far = |pose: &Isometry| (pose.translation.vector - drawn.path[0].translation.vector).norm();
    let has_walked = drawn.path.iter().map(far).fold(0.0, f64::max) > 2.0;
    if made.blocked.is_empty() && has_walked {
        assert!(made.pieces <= 1, "{} pieces", made.pieces);
        for pose in &drawn.path {
            let distance_m = distance_to_edges(made, &pose.translation.vector);
            assert!(distance_m < 3.0, "{distance_m} m at {:?}", pose.translation.vector);
        }
    }
    // Once more, with the points in another order.
    let mut shuffled = drawn.clone();
    shuffled.points.reverse();
    assert_eq!(shuffled.generate(), *made);
}

fn hall() -> Drawn {
    Drawn::default().floor([-10.0, -10.0], [30.0, 20.0], 0.0)
}

/// A place on the floor of the hall.
fn at(x: f64, y: f64) -> [f64; 3] {
    [x, y, 0.0]
}

#[test]
fn a_walk_round_a_corner_and_back_is_one_path_with_a_node_at_the_corner() {
    let drawn = hall().walk(&[at(0.0, 0.0), at(9.0, 0.0), at(9.0, 9.0), at(9.3, 0.4), at(0.0, 0.5)]);
    let made = drawn.generate();
    check_laws(&drawn, &made);
    assert_eq!((made.nodes.len(), made.edges.len()), (3, 4), "{:?}", lines(&made));
    let corner = Vector3::new(9.0, 0.0, 0.55);
    let is_corner =
        |node: &Node| (geometry::vec_from_plain(node.map_from_node.position) - corner).norm() < 1.0;
    assert!(made.nodes.iter().any(is_corner), "{:?}", lines(&made));
    assert!(made.edges.iter().all(|edge| edge.traversal == Traversal::Walk && edge.corridor.left_m > 0.9));
}

#[test]
fn long_paths_have_nodes_at_regular_distances() {
    let drawn = hall().walk(&[at(-6.0, 0.0), at(24.0, 0.0)]);
    let made = drawn.generate();
    check_laws(&drawn, &made);
    let mut lengths: Vec<f64> = lines(&made).iter().map(|(a, b, _)| (a - b).norm()).collect();
    lengths.sort_by(f64::total_cmp);
    assert_eq!(lengths.len(), 3);
    assert!(lengths[0] > 8.0 && lengths[2] < 12.0, "{lengths:?}");
}

#[test]
fn paths_that_cross_share_a_junction() {
    let drawn = hall().walk(&[at(0.0, 0.0), at(16.0, 0.0), at(16.0, 12.0), at(8.0, 12.0), at(8.0, -8.0)]);
    let made = drawn.generate();
    check_laws(&drawn, &made);
    let degree = |id| made.edges.iter().filter(|edge| edge.from == id).count();
    let junctions: Vec<_> = made.nodes.iter().filter(|node| degree(node.id) == 4).collect();
    assert_eq!(junctions.len(), 1, "{:?}", lines(&made));
    let place = geometry::vec_from_plain(junctions[0].map_from_node.position);
    assert!((place.xy() - nalgebra::Vector2::new(8.0, 0.0)).norm() < 1.5, "{place:?}");
    assert_eq!(junctions[0].name, "Junction 1");
}

#[test]
fn what_stands_in_a_walked_path_blocks_it() {
    let walk = [at(0.0, 0.0), at(10.0, 0.0)];
    let drawn = hall().walk(&walk).wall([5.0, -3.0], [5.0, 3.0], 0.0, 1.5);
    let made = drawn.generate();
    check_laws(&drawn, &made);
    assert_eq!(made.pieces, 2);
    assert_eq!(made.blocked.len(), 1, "{:?}", made.blocked);
    assert!((made.blocked[0].to_m.x - 5.0).abs() < 1.0, "{:?}", made.blocked);
    assert_eq!(made.blocked[0].by, BlockedBy::Obstacle);
    // One point is noise, and what lies under the feet or hangs above the robot is no obstacle.
    let mut free =
        hall().walk(&walk).wall([5.0, -3.0], [5.0, 3.0], 0.0, 0.1).wall([6.0, -3.0], [6.0, 3.0], 1.3, 1.0);
    free.points.push([3.0, 0.0, 0.5]);
    let made = free.generate();
    check_laws(&free, &made);
    assert_eq!((made.blocked.len(), made.pieces, made.edges.len()), (0, 1, 2));
    // What was there before the robot passed is gone, such as a door that was opened.
    let mut opened = hall().walk(&walk);
    opened.earlier = Drawn::default().wall([5.0, -0.2], [5.0, 0.2], 0.0, 1.5).points;
    let made = opened.generate();
    check_laws(&opened, &made);
    assert_eq!((made.blocked.len(), made.pieces, made.edges.len()), (0, 1, 2));
    // So is somebody who stood there for a moment after it had passed, ...
    let brief = Drawn::default().wall([5.0, -0.2], [5.0, 0.2], 0.0, 1.5).points;
    let made = Drawn { brief: brief.clone(), ..hall().walk(&walk) }.generate();
    assert_eq!((made.blocked.len(), made.pieces, made.edges.len()), (0, 1, 2));
    // ... and not a box that was put there.
    let mut boxed = hall().walk(&walk);
    boxed.points.extend(brief);
    assert_eq!(boxed.generate().pieces, 2);
}

#[test]
fn no_edge_cuts_the_corner_of_an_obstacle() {
    let drawn = hall().block([2.0, 1.0], [8.0, 5.0], 2.0).walk(&[
        at(0.0, 0.0),
        at(9.0, 0.2),
        at(9.0, 6.0),
        at(0.0, 6.0),
        at(0.9, 0.0),
    ]);
    let made = drawn.generate();
    check_laws(&drawn, &made);
    for (a, b, _) in lines(&made) {
        for step in 0..=100 {
            let on_line = a.lerp(&b, f64::from(step) / 100.0);
            let dx = (2.0 - on_line.x).max(on_line.x - 8.0).max(0.0);
            let dy = (1.0 - on_line.y).max(on_line.y - 5.0).max(0.0);
            assert!(dx.hypot(dy) > 0.38, "{on_line:?}");
        }
    }
}

#[test]
fn a_doorway_that_is_narrower_than_the_turning_circle_is_a_path_where_it_was_walked() {
    // A wall has two faces.
    let room = |width: f64| {
        let walls = [5.0, 5.1].into_iter().fold(hall(), |drawn, x| {
            drawn.wall([x, -10.0], [x, -width / 2.0], 0.0, 2.0).wall([x, width / 2.0], [x, 20.0], 0.0, 2.0)
        });
        walls.walk(&[at(0.0, 0.0), at(10.0, 0.0)])
    };
    let made = room(0.72).generate();
    assert_eq!(made.pieces, 1, "{:?}", made.blocked);
    let narrow = made.edges.iter().map(|edge| edge.corridor.left_m).fold(f64::INFINITY, f64::min);
    assert!(narrow < 0.01, "{narrow}");
    assert_eq!(room(0.4).generate().pieces, 2, "the body does not fit");
}

/// Two storeys, joined by twelve steps.
fn two_storeys() -> Drawn {
    let (rise, run) = (0.17, 0.28);
    let mut drawn = Drawn::default().floor([-2.0, -4.0], [3.0, 4.0], 0.0);
    for step in 0..12 {
        let x = 3.0 + f64::from(step) * run;
        let z = f64::from(step + 1) * rise;
        drawn = drawn.floor([x, -0.7], [x + run, 0.7], z).wall([x, -0.7], [x, 0.7], z - rise, rise);
    }
    let (end, top) = (3.0 + 12.0 * run, 12.0 * rise);
    drawn = drawn.floor([end, -4.0], [end + 8.0, 4.0], top);
    drawn.walk(&[
        at(0.0, 0.0),
        at(2.9, 0.0),
        [end + 0.1, 0.0, top],
        [end + 6.0, 0.0, top],
        [end + 6.0, 3.0, top],
    ])
}

#[test]
fn stairs_are_stairs_edges_between_two_floors() {
    let drawn = two_storeys();
    let made = drawn.generate();
    check_laws(&drawn, &made);
    let stairs: Vec<_> = made.edges.iter().filter(|edge| edge.traversal == Traversal::Stairs).collect();
    assert_eq!(stairs.len(), 2, "{:?}", lines(&made));
    assert!(stairs.iter().all(|edge| edge.direction == TravelDirection::Forward));
    let node = |id| made.nodes.iter().find(|node| node.id == id).expect("a node");
    let [low, high] = if node(stairs[0].from).floor == 0 {
        [node(stairs[0].from), node(stairs[0].to)]
    } else {
        [node(stairs[0].to), node(stairs[0].from)]
    };
    assert_eq!((low.floor, high.floor), (0, 1));
    assert!(low.kind == NodeKind::Portal && high.kind == NodeKind::Portal);
    let (low, high) = (low.map_from_node.position, high.map_from_node.position);
    assert!((low.x - 2.5).abs() < 0.4 && (high.x - 6.9).abs() < 0.4, "{low:?} {high:?}");
    assert!((high.z - low.z - 2.04).abs() < 0.15, "{low:?} {high:?}");
}

#[test]
fn corridors_end_at_walls_and_at_ledges() {
    let drawn = Drawn::default()
        .floor([-2.0, -0.9], [12.0, 5.0], 0.0)
        .wall([-2.0, 1.0], [12.0, 1.0], 0.0, 1.5)
        .walk(&[at(0.0, 0.0), at(9.0, 0.0)]);
    let made = drawn.generate();
    check_laws(&drawn, &made);
    for edge in &made.edges {
        let (wall, ledge) = match edge.from < edge.to {
            _ if is_eastward(&made, edge) => (edge.corridor.left_m, edge.corridor.right_m),
            _ => (edge.corridor.right_m, edge.corridor.left_m),
        };
        assert!((wall - 0.62).abs() < 0.08, "{wall}");
        assert!((0.4..0.95).contains(&ledge), "{ledge}");
    }
}

fn is_eastward(made: &GeneratedMap, edge: &site_model::Edge) -> bool {
    let x = |id| made.nodes.iter().find(|node| node.id == id).map(|node| node.map_from_node.position.x);
    x(edge.to) > x(edge.from)
}

#[test]
fn a_dock_has_an_approach_that_is_joined_to_the_path() {
    let mut drawn =
        hall().block([-0.9, -0.3], [-0.5, 0.3], 0.6).walk(&[at(0.0, 0.0), at(6.0, 0.0), at(6.0, 8.0)]);
    drawn.docks.push(base_at(&Vector3::zeros(), 0.0));
    // Nobody has been at this one, and the robot stands on it with its back to the path.
    drawn = drawn.block([1.7, 6.8], [2.3, 7.2], 0.6);
    drawn.docks.push(base_at(&Vector3::new(2.0, 6.0, 0.0), std::f64::consts::FRAC_PI_2));
    let made = drawn.generate();
    check_laws(&drawn, &made);
    assert_eq!(made.docks.len(), 2, "{:?}", lines(&made));
    let node = |id| made.nodes.iter().find(|node| node.id == id).expect("a node");
    let positions = made.docks.iter().map(|dock| {
        let (on, before) = (node(dock.node), node(dock.approach));
        assert!(on.kind == NodeKind::Dock && before.kind == NodeKind::DockApproach);
        assert_eq!(on.map_from_node.orientation, before.map_from_node.orientation);
        before.map_from_node.position
    });
    let positions: Vec<_> = positions.collect();
    assert!((positions[0].x - 1.0).abs() < 0.01 && (positions[1].y - 5.0).abs() < 0.01, "{positions:?}");
    let onto: Vec<_> = made.edges.iter().filter(|edge| edge.traversal == Traversal::Dock).collect();
    assert_eq!(onto.len(), 2);
    let direction =
        |dock: usize| onto.iter().find(|edge| edge.to == made.docks[dock].node).map(|edge| edge.direction);
    assert_eq!(direction(0), Some(TravelDirection::Backward), "the path is ahead of the docked robot");
    assert_eq!(direction(1), Some(TravelDirection::Forward));
}

/// Two rooms with a door of 0.9 m, and a table.
fn survey() -> Drawn {
    Drawn::default()
        .floor([0.0, 0.0], [16.0, 8.0], 0.0)
        .block([0.0, 0.0], [16.0, 8.0], 2.4)
        .wall([8.0, 0.0], [8.0, 3.13], 0.0, 2.4)
        .wall([8.0, 4.03], [8.0, 8.0], 0.0, 2.4)
        .block([11.0, 2.0], [13.0, 6.0], 0.8)
}

#[test]
fn a_survey_that_nobody_walked_gets_paths_over_its_whole_floor() {
    let drawn = survey();
    let made = drawn.generate();
    check_laws(&drawn, &made);
    assert_eq!((made.pieces, made.blocked.len()), (1, 0), "{:?}", made.blocked);
    for x in [1.0, 4.0, 7.0, 9.5, 12.0, 15.0] {
        for y in [1.0, 7.0] {
            let distance_m = distance_to_edges(&made, &Vector3::new(x, y, 0.55));
            assert!(distance_m < 3.0, "{distance_m} m at {x}, {y}: {:?}", lines(&made));
        }
    }
    for (a, b, _) in lines(&made) {
        for step in 0..=50 {
            let on_line = a.lerp(&b, f64::from(step) / 50.0);
            let dx = (11.0 - on_line.x).max(on_line.x - 13.0).max(0.0);
            let dy = (2.0 - on_line.y).max(on_line.y - 6.0).max(0.0);
            assert!(dx.hypot(dy) > 0.36, "{on_line:?}");
        }
    }
}

#[test]
fn ceilings_of_a_survey_are_no_floor_also_where_the_floor_below_is_hidden() {
    // A hall, and the ceiling of a part behind a wall, whose floor no scanner has seen.
    let hall = || Drawn::default().floor([0.0, 0.0], [16.0, 8.0], 0.0).floor([0.0, 0.0], [16.0, 8.0], 5.0);
    let alone = hall().generate();
    let made = hall().floor([0.0, 9.0], [16.0, 14.0], 5.0).generate();
    assert_eq!((made.pieces, made.nodes.len()), (1, alone.nodes.len()), "{:?}", lines(&made));
    assert!(made.nodes.iter().all(|node| node.map_from_node.position.z < 1.0));
    // A floor with a ceiling of its own is a storey.
    let storeys = hall().floor([0.0, 0.0], [16.0, 8.0], 8.0).generate();
    assert_eq!(storeys.pieces, 2, "{:?}", lines(&storeys));
}

/// Keyframes with their times.
fn timed(keyframes: &[(KeyframeId, Isometry)]) -> Vec<(Stamp, Isometry)> {
    let time = |id: &KeyframeId| Stamp::from_parts(100 + i64::from(id.0), 7);
    keyframes.iter().map(|(id, pose)| (time(id), *pose)).collect()
}

/// The site of a generated map.
fn site_of(made: &GeneratedMap) -> Site {
    let mut site = Site::default();
    let edit = made.replacement(&site, MapId(Uuid::from_u128(1)), EditId(Uuid::from_u128(2))).edit;
    site.apply(&edit, EditId(Uuid::from_u128(3))).expect("of this state");
    site
}

fn put(site: &mut Site, object: Object) {
    let edit = site.put(EditId(Uuid::from_u128(4)), object);
    site.apply(&edit, EditId(Uuid::from_u128(5))).expect("of this state");
}

fn plain(node: &Node) -> Isometry {
    geometry::isometry_from_pose(&node.map_from_node).expect("a pose")
}

#[test]
fn a_site_follows_the_keyframes_of_its_map() {
    let drawn = hall().walk(&[at(0.0, 0.0), at(12.0, 0.0), at(12.0, 9.0)]);
    let made = drawn.generate();
    let mut site = site_of(&made);
    let before = timed(&drawn.keyframes());
    let (next, edit) = (MapId(Uuid::from_u128(8)), EditId(Uuid::from_u128(9)));
    // A person has moved the last node, which has lost its keyframe; something is looked at from it, beside a zone.
    let last = made.nodes.iter().max_by(|a, b| plain(a).translation.y.total_cmp(&plain(b).translation.y));
    let moved_by_hand = Node { anchor: None, ..last.expect("a node").clone() };
    put(&mut site, Object::Node(moved_by_hand.clone()));
    let target = plain(&moved_by_hand).translation.vector + Vector3::new(2.0, 0.0, 0.5);
    put(
        &mut site,
        Object::InspectionPoint(InspectionPoint {
            id: InspectionPointId(Uuid::from_u128(30)),
            name: "Gauge".to_owned(),
            asset: None,
            node: moved_by_hand.id,
            target_m: geometry::vec_to_plain(&target),
            request: ActionRequest { action: "photo".to_owned(), parameters: Default::default() },
            limits: None,
            gauge: None,
        }),
    );
    let corner = Vector3::new(11.0, 7.0, 0.0);
    put(
        &mut site,
        Object::Zone(Zone {
            id: ZoneId(Uuid::from_u128(31)),
            name: "Pit".to_owned(),
            corners_m: vec![[corner.x, corner.y], [13.0, 7.0], [13.0, 9.0]],
            height_m: None,
            effect: ZoneEffect::KeepOut,
            daily: None,
        }),
    );
    let same = MapMotion::between(&before, &before, FollowConfig::default()).expect("the same map");
    let same = same.edit(&site, next, edit);
    assert_eq!((same.moved_nodes, same.edit.changes.len()), (0, 1), "nothing but the map of the site");
    // Keyframes from the corner on are turned about it, as a loop closure does.
    let turn = Isometry::translation(12.0, 0.0, 0.0)
        * Isometry::from_parts(Vector3::zeros().into(), Rotation::from_euler_angles(0.0, 0.0, 0.1))
        * Isometry::translation(-12.0, 0.0, 0.0);
    let turned = |(stamp, pose): &(Stamp, Isometry)| {
        (*stamp, if pose.translation.vector.y > 1.0 { turn * pose } else { *pose })
    };
    let after: Vec<_> = before.iter().map(turned).collect();
    let motion = MapMotion::between(&before, &after, FollowConfig::default()).expect("a version of it");
    let following = motion.edit(&site, next, edit);
    assert!(following.moved_nodes > 0 && following.moved_nodes < made.nodes.len());
    let applied = site.apply(&following.edit, edit).expect("of this state");
    assert_eq!(site.settings().and_then(|settings| settings.map), Some(next));
    for node in &made.nodes {
        let now = plain(site.node(node.id).expect("the same node"));
        let (stays, moves) = (plain(node).inverse() * now, (turn * plain(node)).inverse() * now);
        let error_m = stays.translation.vector.norm().min(moves.translation.vector.norm());
        assert!(error_m < 1e-9, "{} {now}", node.name);
    }
    let now = plain(site.node(moved_by_hand.id).expect("a node"));
    assert!(((turn * plain(&moved_by_hand)).inverse() * now).translation.vector.norm() < 1e-9);
    assert!(following.max_distance_m > 0.5);
    let point = site.inspection_point(InspectionPointId(Uuid::from_u128(30))).expect("a point");
    let wanted = turn * nalgebra::Point3::from(target);
    assert!((geometry::vec_from_plain(point.target_m) - wanted.coords).norm() < 1e-9);
    let zone = site.zones().next().expect("a zone");
    let wanted = turn * nalgebra::Point3::from(corner);
    assert!((zone.corners_m[0][0] - wanted.x).hypot(zone.corners_m[0][1] - wanted.y) < 1e-9);
    // One edit, which can be taken back.
    site.apply(&applied.inverse, EditId(Uuid::from_u128(10))).expect("of this state");
    assert_eq!(site.node(moved_by_hand.id), Some(&moved_by_hand));
}

#[test]
fn in_a_merged_map_keyframes_have_other_numbers_and_other_maps_are_told_apart() {
    let drawn = hall().walk(&[at(0.0, 0.0), at(12.0, 0.0), at(12.0, 9.0)]);
    let (made, before) = (drawn.generate(), timed(&drawn.keyframes()));
    let site = site_of(&made);
    let others = (0..100).map(|number| (Stamp::from_parts(number, 0), Isometry::identity()));
    let merged: Vec<_> = others.chain(before.iter().copied()).collect();
    let motion = MapMotion::between(&before, &merged, FollowConfig::default()).expect("a version of it");
    let edit = motion.edit(&site, MapId(Uuid::from_u128(8)), EditId(Uuid::from_u128(9))).edit;
    let nodes = edit.changes.iter().filter_map(|change| match change {
        Change::Put { object: Object::Node(node), .. } => Some(node),
        _ => None,
    });
    let numbers: BTreeMap<_, _> =
        nodes.map(|node| (node.id, node.anchor.expect("an anchor").keyframe.0)).collect();
    assert_eq!(numbers.len(), made.nodes.len());
    for node in &made.nodes {
        assert_eq!(numbers[&node.id], node.anchor.expect("an anchor").keyframe.0 + 100);
        assert_eq!(plain(site.node(node.id).expect("a node")), plain(node));
    }
    let another: Vec<_> = before.iter().map(|(stamp, pose)| (*stamp + Span::from_millis(1), *pose)).collect();
    assert!(MapMotion::between(&before, &another, FollowConfig::default()).is_none(), "other times");
    let elsewhere = (0..).zip(&before).map(|(number, (stamp, pose))| {
        (*stamp, Isometry::translation(f64::from(number % 3), 0.0, 0.0) * pose)
    });
    let elsewhere: Vec<_> = elsewhere.collect();
    assert!(MapMotion::between(&before, &elsewhere, FollowConfig::default()).is_none(), "another walk");
    assert!(MapMotion::between(&before, &[], FollowConfig::default()).is_none());
}

#[test]
fn nothing_gives_nothing() {
    assert_eq!(Drawn::default().generate(), GeneratedMap::default());
    let made = Drawn::default().walk(&[at(0.0, 0.0), at(0.2, 0.0)]).generate();
    assert!(made.edges.is_empty());
    let mut wrong = hall();
    wrong.points.extend([[f32::NAN; 3], [f32::INFINITY, 0.0, 0.0], [3e38; 3]]);
    wrong = wrong.walk(&[at(0.0, 0.0), at(5.0, 0.0)]);
    check_laws(&wrong, &wrong.generate());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    /// Walks along aisles between boxes, in any order, with any offset in the aisle.
    #[test]
    fn laws_hold_for_any_walk_between_boxes(
        turns in proptest::collection::vec((0..4_u8, 0..4_u8, -0.5..0.5_f64, -0.5..0.5_f64), 2..12)
    ) {
        let mut drawn = hall();
        for column in 0..3 {
            for row in 0..3 {
                let (x, y) = (f64::from(column) * 6.0 + 1.5, f64::from(row) * 6.0 + 1.5 - 9.0);
                drawn = drawn.block([x, y], [x + 3.0, y + 3.0], 1.8);
            }
        }
        // Aisles are at multiples of 6 m. The walk goes along x first, then along y.
        let mut places = Vec::new();
        let mut last = [0.0, -9.0];
        for (column, row, dx, dy) in turns {
            let next = [f64::from(column) * 6.0 + dx, f64::from(row) * 6.0 - 9.0 + dy];
            places.extend([at(last[0], last[1]), at(next[0], last[1])]);
            last = next;
        }
        places.push(at(last[0], last[1]));
        let drawn = drawn.walk(&places);
        let made = drawn.generate();
        check_laws(&drawn, &made);
        prop_assert!(made.blocked.is_empty(), "{:?}", made.blocked);
    }
}
