//! Missions among people on every site: mapped by a walk along the site's short route, with a graph along that walk, and scored by the truth.

use crate::day::{Day, FIRST};
use crate::mission_tests::{DOCK, MISSION, RUN, node, until_ended};
use geometry::{Isometry, Rotation, Vector3, isometry_from_pose, pose_from_isometry, vec_from_plain};
use messages::{CommandKind, LedgerEvent, LocalisationState, PriorMap};
use nalgebra::Point3;
use sim::{CameraConfig, RouteFollower, SimulatedSite, SiteName, Start};
use site_model::{
    ActionRequest, Dock, Edge, EdgeId, EditId, FailurePolicy, InspectionPoint, InspectionPointId, Mission,
    MissionCommandKind, MissionEnd, MissionEventKind, Node, NodeKind, Object, Parameter, PoseTolerance,
    RunState, Site, SiteSettings, StartMode, Task, TaskFailure, TaskId, TaskOrder, TaskPlace, TaskStep,
    Traversal,
};
use std::sync::Arc;
use uuid::Uuid;
use vocab::SessionId;

/// People on the site during a mission.
const PEOPLE: u32 = 4;
/// The shortest distance between nodes along the walk, metres.
const NODE_SPACING_M: f64 = 1.5;
/// An edge that rises by more than this is stairs, metres: half a step and less.
const STAIRS_RISE_M: f64 = 0.05;
/// The approach of a dock is this far in front of it, metres.
const APPROACH_M: f64 = 1.8;
/// The bars: position of the robot, heading, and target off the picture's centre.
const MAX_POSITION_ERROR_M: f64 = 0.1;
const MAX_HEADING_ERROR_RAD: f64 = 0.0524;
const MAX_OFF_CENTRE: f64 = 0.05;

/// A site that was mapped.
struct MappedSite {
    site: Arc<SimulatedSite>,
    prior_map: Arc<PriorMap>,
    site_from_map: Isometry,
    /// Poses of the base along the walk.
    map_from_walked: Vec<Isometry>,
}

/// Something to photograph from a node.
struct Target {
    site_from_node: Isometry,
    site_m: Vector3,
    map_m: Vector3,
    zoom: f64,
}

fn truth(day: &mut Day) -> Isometry {
    isometry_from_pose(&day.lockstep.simulator().truth().site_from_base).expect("the truth is a pose")
}

fn estimate(day: &Day) -> Isometry {
    isometry_from_pose(&day.estimate).expect("the estimate is a pose")
}

fn heading_of(pose: &Isometry) -> f64 {
    let ahead = pose.rotation * Vector3::x();
    ahead.y.atan2(ahead.x)
}

impl MappedSite {
    /// Walks the short route by sight.
    fn new(name: SiteName) -> Self {
        let site = Arc::new(SimulatedSite::new(name));
        let route = site.route("short").expect("every site has it").clone();
        let session = Some(SessionId(Uuid::from_u128(1)));
        let mut day = Day::on(Arc::clone(&site), 0, route.start, 3, session);
        day.run(1.0);
        let site_from_map = truth(&mut day) * estimate(&day).inverse();
        let mut map_from_walked = vec![estimate(&day)];
        let mut walker = RouteFollower::new(route);
        while let Some(drive) = walker.drive(&day.lockstep.simulator().truth()) {
            if drive.velocity != vocab::Twist::default() {
                day.command(CommandKind::Teleoperate(drive.velocity));
            }
            day.run(0.1);
            let now = estimate(&day);
            let last = map_from_walked.last().expect("it begins with the start");
            if (now.translation.vector - last.translation.vector).norm() >= NODE_SPACING_M {
                map_from_walked.push(now);
            }
        }
        day.finish(FIRST);
        let prior_map = Arc::clone(day.lockstep.map(FIRST).expect("it was saved"));
        Self { site, prior_map, site_from_map, map_from_walked }
    }

    /// The graph along the walk, with a mission of one photo on the way and one where the walk ended.
    fn with_mission(&self) -> (Site, Vec<Target>) {
        let mut site = Site::default();
        let mut put = |object| {
            let id = EditId(Uuid::nil());
            let edit = site.put(id, object);
            assert!(site.apply(&edit, id).is_ok(), "{edit:?}");
        };
        put(Object::Settings(SiteSettings {
            name: "Site".to_owned(),
            time_zone: "Europe/London".to_owned(),
            map: Some(FIRST),
        }));
        let dock = &self.site.docks()[0];
        let at = vec_from_plain(dock.position) + Vector3::z() * sim::STANDING_HEIGHT;
        let rotation = Rotation::from_euler_angles(0.0, 0.0, dock.yaw);
        let map_from_dock = self.site_from_map.inverse() * Isometry::from_parts(at.into(), rotation);
        let approach = map_from_dock * nalgebra::Translation3::new(APPROACH_M, 0.0, 0.0);
        let is_beyond = |pose: &&Isometry| (map_from_dock.inverse() * *pose).translation.x > APPROACH_M + 0.5;
        let beyond: Vec<Isometry> =
            self.map_from_walked.iter().skip_while(|pose| !is_beyond(pose)).copied().collect();
        // Flights of stairs are one edge: a place from which it rises or falls to both sides is no node.
        let rises =
            |a: usize, b: usize| (beyond[b].translation.z - beyond[a].translation.z).abs() > STAIRS_RISE_M;
        let is_on_stairs =
            |at: usize| at > 0 && at + 1 < beyond.len() && rises(at - 1, at) && rises(at, at + 1);
        let walked: Vec<Isometry> =
            (0..beyond.len()).filter(|at| !is_on_stairs(*at)).map(|at| beyond[at]).collect();
        let inspected = [walked.len() / 2, walked.len() - 1];
        let mut nodes = vec![(NodeKind::Dock, map_from_dock), (NodeKind::DockApproach, approach)];
        nodes.extend(walked.iter().enumerate().map(|(index, pose)| {
            let kind = if inspected.contains(&index) { NodeKind::Inspection } else { NodeKind::Waypoint };
            (kind, *pose)
        }));
        for (number, (kind, pose)) in (1..).zip(&nodes) {
            let turned = Rotation::from_euler_angles(0.0, 0.0, heading_of(pose));
            put(Object::Node(Node {
                id: node(number),
                name: format!("N{number}"),
                kind: *kind,
                map_from_node: pose_from_isometry(&Isometry::from_parts(pose.translation, turned)),
                anchor: None,
                tolerance: PoseTolerance::default(),
                influence_area_m: Vec::new(),
                floor: 0,
                tags: [].into(),
                properties: [].into(),
            }));
        }
        for (number, pair) in (1..).zip(nodes.windows(2)) {
            let rise_m = pair[1].1.translation.z - pair[0].1.translation.z;
            let traversal = match number {
                1 => Traversal::Dock,
                _ if rise_m.abs() > STAIRS_RISE_M => Traversal::Stairs,
                _ => Traversal::Walk,
            };
            for (from, to) in [(number, number + 1), (number + 1, number)] {
                let walk = Edge::walk(EdgeId(Uuid::from_u128(from * 1_000 + to)), node(from), node(to));
                put(Object::Edge(Edge { traversal: traversal.clone(), ..walk }));
            }
        }
        put(Object::Dock(Dock { id: DOCK, name: "Dock".to_owned(), node: node(1), approach: node(2) }));
        let (mut tasks, mut targets) = (Vec::new(), Vec::new());
        for (number, index) in (0_u128..).zip(inspected) {
            let target = self.target_from(&walked[index]);
            let point = InspectionPointId(Uuid::from_u128(200 + number));
            let parameters = [("zoom".to_owned(), Parameter::Number(target.zoom))].into();
            put(Object::InspectionPoint(InspectionPoint {
                id: point,
                name: format!("P{number}"),
                asset: None,
                node: node(index as u128 + 3),
                target_m: geometry::vec_to_plain(&target.map_m),
                request: ActionRequest { action: "photo".to_owned(), parameters },
                limits: None,
                gauge: None,
            }));
            tasks.push(Task {
                id: TaskId(Uuid::from_u128(100 + number)),
                place: TaskPlace::InspectionPoint(point),
                on_unreachable: FailurePolicy::default(),
                on_action_failure: FailurePolicy::default(),
            });
            targets.push(target);
        }
        put(Object::Mission(Mission {
            id: MISSION,
            name: "Round".to_owned(),
            tasks,
            order: TaskOrder::AsListed,
            order_constraints: Vec::new(),
            end: MissionEnd::NearestDock,
        }));
        (site, targets)
    }

    /// A spot of a solid that the camera sees from a node, shown 0.8 m wide.
    fn target_from(&self, map_from_node: &Isometry) -> Target {
        let upright =
            Rotation::from_euler_angles(0.0, 0.0, heading_of(&(self.site_from_map * map_from_node)));
        let position = (self.site_from_map * map_from_node).translation;
        let site_from_node = Isometry::from_parts(position, upright);
        let cameras = CameraConfig::default();
        let head = site_from_node * Point3::from(cameras.base_from_head_m);
        let (site_m, distance_m) = (0..16_u8)
            .find_map(|step| {
                let pan_rad = if step % 2 == 0 { 0.15 } else { -0.15 } * f64::from(step);
                let direction = upright * Vector3::new(pan_rad.cos(), pan_rad.sin(), 0.1).normalize();
                let (distance_m, _) = self.site.cast_ray(&head.coords, &direction, 10.0)?;
                (distance_m > 0.8).then(|| (head.coords + direction * distance_m, distance_m))
            })
            .expect("something is within 10 m");
        let view_m = 2.0 * distance_m * (0.5 * cameras.field_of_view_rad).tan();
        let map_m = self.site_from_map.inverse_transform_point(&Point3::from(site_m)).coords;
        Target { site_from_node, site_m, map_m, zoom: (view_m / 0.8).clamp(1.0, cameras.zoom_max) }
    }

    /// A mission from the dock and back to it, among people.
    fn check_mission(&self, seed: u64) {
        let dock = &self.site.docks()[0];
        let start = Start { position: dock.position, yaw: dock.yaw };
        let mut day = Day::on(Arc::clone(&self.site), PEOPLE, start, seed, None);
        let (site, targets) = self.with_mission();
        day.lockstep.keep_map(Arc::clone(&self.prior_map));
        day.command(CommandKind::Localise { map: FIRST, at: None });
        day.lockstep.give_site(site);
        let localised = LocalisationState::Localised { map: FIRST, degradation: None };
        for _ in 0..300 {
            day.run(0.1);
            if day.localisation == localised {
                break;
            }
        }
        assert_eq!(day.localisation, localised, "seed {seed}");
        day.run(1.0);
        day.command(CommandKind::Mission(MissionCommandKind::Start {
            run: RUN,
            mission: MISSION,
            mode: StartMode::Now,
        }));
        let outcome = until_ended(&mut day, 600);
        assert_eq!(outcome, Some(RunState::Succeeded), "seed {seed}: {:?} {:?}", day.notices, failures(&day));
        assert_eq!(day.lockstep.calls().len(), targets.len(), "seed {seed}");
        for ((call, estimated), target) in
            day.lockstep.calls().iter().zip(&day.estimates_of_calls).zip(&targets)
        {
            let site_from_base = isometry_from_pose(&call.truth.site_from_base).expect("a pose");
            let error = target.site_from_node.inverse() * site_from_base;
            let (distance_m, heading_rad) = (error.translation.vector.xy().norm(), heading_of(&error).abs());
            assert!(distance_m < MAX_POSITION_ERROR_M, "seed {seed}: {distance_m} m");
            assert!(heading_rad < MAX_HEADING_ERROR_RAD, "seed {seed}: {heading_rad} rad");
            let map_from_base = isometry_from_pose(estimated).expect("a pose");
            let off =
                sim::off_centre(&site_from_base, &map_from_base, &target.map_m, &target.site_m, target.zoom);
            assert!(
                off.is_some_and(|off| off < MAX_OFF_CENTRE),
                "seed {seed}: {off:?} of the picture off its centre"
            );
        }
        assert_eq!(day.route.docked, Some(DOCK), "seed {seed}");
        let contacts = day.lockstep.simulator().take_contacts();
        let touched: Vec<_> = contacts.iter().filter(|contact| contact.is_by_robot).collect();
        assert!(touched.is_empty(), "seed {seed}: {touched:?}");
    }
}

/// What the ledger says of failed tasks.
fn failures(day: &Day) -> Vec<TaskFailure> {
    let failed = day.lockstep.rows().iter().filter_map(|row| match row {
        LedgerEvent::Mission(event) => match &event.kind {
            MissionEventKind::Task { step: TaskStep::Failed(failure), .. } => Some(failure.clone()),
            _ => None,
        },
        _ => None,
    });
    failed.collect()
}

fn check(name: SiteName) {
    let mapped = MappedSite::new(name);
    for seed in [61, 62] {
        mapped.check_mission(seed);
    }
}

#[test]
fn missions_among_people_meet_the_bars_in_the_hall() {
    check(SiteName::B1);
}

#[test]
fn missions_among_people_meet_the_bars_in_the_ring() {
    check(SiteName::Torus);
}

#[test]
fn missions_among_people_meet_the_bars_over_stairs() {
    check(SiteName::Plant);
}

#[test]
fn missions_among_people_meet_the_bars_in_rooms_that_look_alike() {
    check(SiteName::Twins);
}
