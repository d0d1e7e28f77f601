//! Finds all problems of a site. Logarithmic in the site for each reference, so n log n in all.

use crate::{
    Alert, AlertState, Dock, DockAction, Edge, EdgeCost, GaugeDial, InspectionPoint, Mission, MissionEnd,
    Monitor, MonitorCondition, MonitorResponse, Node, NodeId, NodeKind, Object, ObjectId, OrientedBox,
    ProblemKind, Recurrence, ReviewState, SceneChange, SceneChangeKind, Schedule, Site, SiteProblem, TaskId,
    TaskPlace, Traversal, Zone, ZoneEffect, describe_action, find_order_cycle,
};
use std::collections::{BTreeMap, BTreeSet};
use std::mem::{Discriminant, discriminant};
use vocab::Span;

/// Ranges of numbers that people enter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValidationConfig {
    /// Greatest speed of an edge or zone, m/s. Chosen: twice that of the fastest legged inspection robots.
    pub max_speed_m_s: f64,
    /// Smallest tolerance of a position, metres. Chosen: half the accuracy of localisation.
    pub min_tolerance_m: f64,
    /// Smallest tolerance of a heading, radians: half a degree. Chosen: below the heading that legs keep.
    pub min_tolerance_rad: f64,
    /// Shortest interval of a schedule. Chosen: the clock of schedules goes by minutes.
    pub min_interval: Span,
}

impl Default for ValidationConfig {
    fn default() -> Self {
        Self {
            max_speed_m_s: 4.0,
            min_tolerance_m: 0.01,
            min_tolerance_rad: 0.0087,
            min_interval: Span::from_millis(60_000),
        }
    }
}

impl Site {
    /// All problems, in the order of the objects. Empty: the site can be used as it is.
    pub fn problems(&self, config: &ValidationConfig) -> Vec<SiteProblem> {
        let mut finder = ProblemFinder { site: self, config, ends: Ends::default(), found: Vec::new() };
        finder.ends = Ends::of(self);
        finder.find();
        finder.found
    }
}

/// The nodes at which edges begin and end.
#[derive(Default)]
struct Ends {
    left: BTreeSet<NodeId>,
    reached: BTreeSet<NodeId>,
}

impl Ends {
    /// Of the edges that routes may use.
    fn of(site: &Site) -> Self {
        let usable = || site.edges().filter(|edge| edge.is_enabled);
        Self {
            left: usable().map(|edge| edge.from).collect(),
            reached: usable().map(|edge| edge.to).collect(),
        }
    }
}

struct ProblemFinder<'a> {
    site: &'a Site,
    config: &'a ValidationConfig,
    ends: Ends,
    found: Vec<SiteProblem>,
}

impl ProblemFinder<'_> {
    fn find(&mut self) {
        if self.site.get(ObjectId::Settings).is_none() && self.site.objects().len() > 0 {
            self.add(ObjectId::Settings, ProblemKind::NoSettings);
        }
        let mut names: BTreeMap<(usize, &str), ObjectId> = BTreeMap::new();
        let mut kinds: Vec<Discriminant<Object>> = Vec::new();
        let mut joined: BTreeMap<(NodeId, NodeId), ObjectId> = BTreeMap::new();
        let site = self.site;
        for versioned in site.objects() {
            let (id, object) = (versioned.object.id(), &versioned.object);
            if let Some(name) = object.name() {
                let kind = discriminant(object);
                let kind = kinds.iter().position(|known| *known == kind).unwrap_or_else(|| {
                    kinds.push(kind);
                    kinds.len() - 1
                });
                if name.trim().is_empty() {
                    self.add(id, ProblemKind::NoName);
                } else if let Some(other) = names.insert((kind, name.trim()), id) {
                    self.add(id, ProblemKind::SameName(other));
                }
            }
            match object {
                Object::Settings(_) | Object::Asset(_) => {}
                Object::Node(node) => self.check_node(id, node),
                Object::Edge(edge) => {
                    if let Some(other) = joined.insert((edge.from, edge.to), id) {
                        self.add(id, ProblemKind::SameEdge(other));
                    }
                    self.check_edge(id, edge);
                }
                Object::EdgeBlock(block) => self.check_exists(id, ObjectId::Edge(block.edge)),
                Object::Zone(zone) => self.check_zone(id, zone),
                Object::Dock(dock) => self.check_dock(id, dock),
                Object::InspectionPoint(point) => self.check_inspection_point(id, point),
                Object::Mission(mission) => self.check_mission(id, mission),
                Object::Schedule(schedule) => self.check_schedule(id, schedule),
                Object::Monitor(monitor) => self.check_monitor(id, monitor),
                Object::SceneChange(change) => self.check_scene_change(id, change),
                Object::Alert(alert) => self.check_alert(id, alert),
                Object::MutexHold(hold) => {
                    for (field, name) in [("group", &hold.group), ("holder", &hold.holder)] {
                        self.check_range(id, field, !name.trim().is_empty(), || "a name".to_owned());
                    }
                }
            }
        }
    }

    fn check_scene_change(&mut self, id: ObjectId, change: &SceneChange) {
        let is_size = |place: &OrientedBox| place.size_m.iter().all(|side| *side > 0.0);
        let from = match &change.kind {
            SceneChangeKind::Moved { from } => is_size(from),
            SceneChangeKind::Appeared | SceneChangeKind::Removed => true,
        };
        self.check_range(id, "size_m", from && is_size(&change.place), || "greater than 0 m".to_owned());
        let is_share = (0.0..=1.0).contains(&change.confidence);
        self.check_range(id, "confidence", is_share, || "from 0 to 1".to_owned());
        let is_share = change.physical_object.is_none_or(|object| (0.0..=1.0).contains(&object.probability));
        self.check_range(id, "probability", is_share, || "from 0 to 1".to_owned());
        if let ReviewState::Dismissed { reason } = &change.review {
            self.check_range(id, "reason", !reason.trim().is_empty(), || "a text".to_owned());
        }
    }

    fn check_alert(&mut self, id: ObjectId, alert: &Alert) {
        self.check_range(id, "times_raised", alert.times_raised > 0, || "at least 1".to_owned());
        if let AlertState::Closed { remark, .. } = &alert.state {
            self.check_range(id, "remark", !remark.trim().is_empty(), || "a text".to_owned());
        }
    }

    fn check_node(&mut self, id: ObjectId, node: &Node) {
        let tolerance = &node.tolerance;
        let min_m = self.config.min_tolerance_m;
        for (field, value) in [("along_m", tolerance.along_m), ("across_m", tolerance.across_m)] {
            self.check_range(id, field, value >= min_m, || format!("at least {min_m} m"));
        }
        let min_rad = self.config.min_tolerance_rad;
        self.check_range(id, "yaw_rad", tolerance.yaw_rad >= min_rad, || format!("at least {min_rad} rad"));
        if !node.influence_area_m.is_empty() && !is_area(&node.influence_area_m) {
            self.add(id, ProblemKind::NotAnArea);
        }
    }

    fn check_edge(&mut self, id: ObjectId, edge: &Edge) {
        for node in [edge.from, edge.to] {
            self.check_exists(id, ObjectId::Node(node));
        }
        if edge.from == edge.to {
            self.add(id, ProblemKind::EdgeToItself);
        }
        self.check_speed(id, "max_speed_m_s", edge.max_speed_m_s);
        if let EdgeCost::Fixed(cost_s) = edge.cost {
            self.check_range(id, "cost", cost_s >= 0.0, || "at least 0 s".to_owned());
        }
        for (field, value) in [("left_m", edge.corridor.left_m), ("right_m", edge.corridor.right_m)] {
            self.check_range(id, field, value >= 0.0, || "at least 0 m".to_owned());
        }
        for request in edge.on_enter.iter().chain(&edge.during).chain(&edge.on_leave) {
            self.check_action(id, &request.action);
        }
        if let Traversal::Action { name, .. } = &edge.traversal {
            self.check_action(id, name);
        }
    }

    fn check_zone(&mut self, id: ObjectId, zone: &Zone) {
        if !is_area(&zone.corners_m) {
            self.add(id, ProblemKind::NotAnArea);
        }
        if let Some([low, high]) = zone.height_m {
            self.check_range(id, "height_m", low < high, || "a smaller and a greater height".to_owned());
        }
        match &zone.effect {
            ZoneEffect::KeepOut => {}
            ZoneEffect::SpeedLimit(speed) => self.check_speed(id, "effect.speed_limit", Some(*speed)),
            ZoneEffect::Penalty(factor) => {
                self.check_range(id, "effect.penalty", *factor >= 1.0, || "at least 1".to_owned());
            }
            ZoneEffect::Action(request) => self.check_action(id, &request.action),
        }
        if let Some([from, until]) = zone.daily {
            let is_valid = from.is_valid() && until.is_valid() && from != until;
            self.check_range(id, "daily", is_valid, || "two different times from 00:00 to 23:59".to_owned());
        }
    }

    fn check_dock(&mut self, id: ObjectId, dock: &Dock) {
        for (node, kind) in [(dock.node, NodeKind::Dock), (dock.approach, NodeKind::DockApproach)] {
            self.check_exists(id, ObjectId::Node(node));
            if self.site.node(node).is_some_and(|node| node.kind != kind) {
                self.add(id, ProblemKind::WrongNodeKind(node));
            }
        }
        self.check_reachable(id, dock.approach);
    }

    fn check_inspection_point(&mut self, id: ObjectId, point: &InspectionPoint) {
        self.check_exists(id, ObjectId::Node(point.node));
        if let Some(asset) = point.asset {
            self.check_exists(id, ObjectId::Asset(asset));
        }
        self.check_action(id, &point.request.action);
        if let Some(limits) = &point.limits
            && let (Some(min), Some(max)) = (limits.min, limits.max)
        {
            self.check_range(id, "limits", min < max, || "a smaller and a greater value".to_owned());
        }
        if let Some(Err(missing)) = point.gauge.as_ref().map(GaugeDial::check) {
            self.check_range(id, "gauge", false, || format!("a dial with {missing}"));
        }
        self.check_reachable(id, point.node);
    }

    fn check_mission(&mut self, id: ObjectId, mission: &Mission) {
        if mission.tasks.is_empty() {
            self.add(id, ProblemKind::NoTasks);
        }
        let mut tasks = BTreeSet::new();
        for task in &mission.tasks {
            if !tasks.insert(task.id) {
                self.add(id, ProblemKind::SameTask(task.id));
            }
            match &task.place {
                TaskPlace::InspectionPoint(_) => {}
                TaskPlace::Node { request, .. } => {
                    request.iter().for_each(|request| self.check_action(id, &request.action));
                }
                TaskPlace::ByAction { request } => {
                    let is_known = DockAction::of(request).is_some();
                    self.check_range(id, "action", is_known, || "one that moves the robot".to_owned());
                }
            }
            let missing = task.place.object().filter(|object| self.site.get(*object).is_none());
            if let Some(object) = missing {
                self.add(id, ProblemKind::TaskMissing { task: task.id, object });
            }
        }
        let is_missing = |task: &&TaskId| !tasks.contains(*task);
        let missing: BTreeSet<_> = mission.order_constraints.iter().flatten().filter(is_missing).collect();
        for task in missing {
            self.add(id, ProblemKind::OrderConstraintMissing(*task));
        }
        if find_order_cycle(&mission.order_constraints).is_some() {
            self.add(id, ProblemKind::OrderConstraintsCircular);
        }
        if let MissionEnd::Node(node) = mission.end {
            self.check_exists(id, ObjectId::Node(node));
        }
    }

    fn check_schedule(&mut self, id: ObjectId, schedule: &Schedule) {
        self.check_exists(id, ObjectId::Mission(schedule.mission));
        let is_grace_valid = schedule.grace >= Span::ZERO;
        self.check_range(id, "grace", is_grace_valid, || "at least 0".to_owned());
        let check_start = |finder: &mut Self, is_valid| {
            finder.check_range(id, "recurrence", is_valid, || "days and times that exist".to_owned());
        };
        match &schedule.recurrence {
            Recurrence::Once(at) => check_start(self, at.is_valid()),
            Recurrence::Weekly { days, times, first_day, last_day } => {
                let is_valid = times.iter().all(|time| time.is_valid())
                    && first_day.is_valid()
                    && last_day.is_none_or(|day| day.is_valid());
                check_start(self, is_valid);
                if days.is_empty() || times.is_empty() || last_day.is_some_and(|last| last < *first_day) {
                    self.add(id, ProblemKind::NeverDue);
                }
            }
            Recurrence::Every { first, interval } => {
                check_start(self, first.is_valid());
                let min_s = self.config.min_interval.secs_f64();
                let is_valid = *interval >= self.config.min_interval;
                self.check_range(id, "interval", is_valid, || format!("at least {min_s} s"));
            }
            // The rule itself is parsed where slots are computed.
            Recurrence::Rule { first, rule } => {
                check_start(self, first.is_valid());
                if rule.trim().is_empty() {
                    self.add(id, ProblemKind::NeverDue);
                }
            }
        }
    }

    fn check_monitor(&mut self, id: ObjectId, monitor: &Monitor) {
        match monitor.condition {
            MonitorCondition::Below { threshold, release } => {
                let is_valid = release >= threshold;
                self.check_range(id, "release", is_valid, || format!("at least {threshold}"));
            }
            MonitorCondition::Above { threshold, release } => {
                let is_valid = release <= threshold;
                self.check_range(id, "release", is_valid, || format!("at most {threshold}"));
            }
            MonitorCondition::Silent(span) => {
                self.check_range(id, "silent", span > Span::ZERO, || "more than 0".to_owned());
            }
        }
        self.check_range(id, "hold", monitor.hold >= Span::ZERO, || "at least 0".to_owned());
        if let MonitorResponse::Interrupt { mission, .. } = monitor.response {
            self.check_exists(id, ObjectId::Mission(mission));
        }
    }

    fn check_exists(&mut self, id: ObjectId, needed: ObjectId) {
        if self.site.get(needed).is_none() {
            self.add(id, ProblemKind::Missing(needed));
        }
    }

    fn check_reachable(&mut self, id: ObjectId, node: NodeId) {
        if self.site.node(node).is_none() {
            return;
        }
        if !self.ends.reached.contains(&node) {
            self.add(id, ProblemKind::NoEdgeTo(node));
        }
        if !self.ends.left.contains(&node) {
            self.add(id, ProblemKind::NoEdgeFrom(node));
        }
    }

    fn check_speed(&mut self, id: ObjectId, field: &str, speed_m_s: Option<f64>) {
        let max = self.config.max_speed_m_s;
        let is_valid = speed_m_s.is_none_or(|speed| speed > 0.0 && speed <= max);
        self.check_range(id, field, is_valid, || format!("more than 0 and at most {max} m/s"));
    }

    fn check_action(&mut self, id: ObjectId, action: &str) {
        if action.trim().is_empty() {
            self.add(id, ProblemKind::NoAction);
        }
        let moves_robot = describe_action(action).is_some_and(|known| known.moves_robot);
        self.check_range(id, "action", !moves_robot, || "one that is done at a place".to_owned());
    }

    fn check_range(&mut self, id: ObjectId, field: &str, is_valid: bool, permitted: impl Fn() -> String) {
        if !is_valid {
            let field = field.to_owned();
            self.add(id, ProblemKind::OutOfRange { field, permitted: permitted() });
        }
    }

    fn add(&mut self, object: ObjectId, kind: ProblemKind) {
        self.found.push(SiteProblem { object, kind });
    }
}

/// Whether corners in their order enclose an area: three or more, and no two sides cross. Quadratic in the corners.
fn is_area(corners: &[[f64; 2]]) -> bool {
    let count = corners.len();
    if count < 3 {
        return false;
    }
    let side = |index: usize| (corners[index], corners[(index + 1) % count]);
    let doubled_area: f64 = (0..count)
        .map(|index| {
            let (a, b) = side(index);
            a[0] * b[1] - b[0] * a[1]
        })
        .sum();
    let crosses = (0..count).any(|first| {
        // Sides that share a corner do not count.
        (first + 2..count).any(|second| (second + 1) % count != first && do_cross(side(first), side(second)))
    });
    doubled_area != 0.0 && !crosses
}

/// Whether two line segments cross in a point inside both.
fn do_cross((a, b): ([f64; 2], [f64; 2]), (c, d): ([f64; 2], [f64; 2])) -> bool {
    let turn =
        |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    turn(a, b, c) * turn(a, b, d) < 0.0 && turn(c, d, a) * turn(c, d, b) < 0.0
}
