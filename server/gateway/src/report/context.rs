//! What all parts of a report need: the site with its names, its clock, the files, and when the report is made. Names are cut to a length that fits a line.

use super::rows::Attempt;
use super::{format, texts};
use api::SiteState;
use missions::SiteZone;
use site_model::{
    Alert, AlertCause, InspectionPointId, LocalDateTime, MissionId, NodeId, Object, ReadingLimits,
    RouteActionPlace, RunCause, SceneChange, Site, TaskId, TaskPlace, Utc, describe_action,
};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vocab::legible;

/// Greatest distance in the plan at which an object is said to be near a place, metres. Chosen: a robot that stands there sees it.
const MAX_NEAR_M: f64 = 8.0;

/// What all parts of a report need.
pub(super) struct ReportContext {
    state: Arc<SiteState>,
    data_dir: PathBuf,
    zone: SiteZone,
    zone_name: String,
    made: Utc,
}

impl ReportContext {
    /// `made`: when the report is made.
    pub(super) fn new(state: Arc<SiteState>, data_dir: &Path, made: Utc) -> Self {
        let name = state.site.settings().map(|settings| settings.time_zone.clone());
        let known = name.and_then(|name| Some((SiteZone::new(&name).ok()?, name)));
        let (zone, zone_name) = known.unwrap_or_else(|| (SiteZone::utc(), "UTC".to_owned()));
        Self { state, data_dir: data_dir.to_owned(), zone, zone_name, made }
    }

    pub(super) fn site(&self) -> &Site {
        &self.state.site
    }

    /// Number of edits of the site.
    pub(super) fn site_revision(&self) -> u64 {
        self.state.revision
    }

    pub(super) fn data_dir(&self) -> &Path {
        &self.data_dir
    }

    pub(super) fn made(&self) -> Utc {
        self.made
    }

    /// The site's clock at an instant.
    pub(super) fn local(&self, at: Utc) -> LocalDateTime {
        self.zone.to_local(at)
    }

    /// Name of the site's time zone, with its offset at an instant.
    pub(super) fn zone_at(&self, at: Utc) -> String {
        texts::zone(&self.zone_name, &format::utc_offset(self.zone.offset_minutes(at)))
    }

    pub(super) fn site_name(&self) -> String {
        let name = self.site().settings().map(|settings| settings.name.as_str());
        legible_name(name.filter(|name| !name.is_empty()).unwrap_or(texts::UNNAMED_SITE))
    }

    pub(super) fn mission_name(&self, mission: MissionId) -> String {
        legible_name(self.site().mission(mission).map_or(texts::DELETED_MISSION, |mission| &mission.name))
    }

    /// What led to a run.
    pub(super) fn cause(&self, cause: Option<&RunCause>) -> String {
        match cause {
            None => texts::NOT_KNOWN.to_owned(),
            Some(RunCause::Command(_)) => texts::CAUSE_PERSON.to_owned(),
            Some(RunCause::Account { account, .. }) => legible_name(account),
            Some(RunCause::Schedule { schedule, slot }) => {
                let name = self.site().schedule(*schedule).map(|schedule| legible_name(&schedule.name));
                texts::cause_schedule(name.as_deref(), &format::time(*slot))
            }
            Some(RunCause::Monitor(monitor)) => {
                let name = self.site().monitors().find(|known| known.id == *monitor);
                texts::cause_monitor(name.map(|monitor| legible_name(&monitor.name)).as_deref())
            }
        }
    }

    /// Name of what an attempt belongs to: the place of a task, or the edge or zone of an action on the way.
    pub(super) fn place_of(&self, mission: MissionId, attempt: &Attempt) -> String {
        if let Some(place) = attempt.place {
            return self.route_place(place);
        }
        let moves_robot =
            attempt.action.as_deref().and_then(describe_action).is_some_and(|action| action.moves_robot);
        if attempt.node.is_none() && moves_robot {
            return self.action_of(attempt);
        }
        let point = attempt.task.and_then(|task| self.point_of_task(mission, task));
        let point = point.and_then(|point| Some(self.site().inspection_point(point)?.name.as_str()));
        let node = || attempt.node.and_then(|node| self.node_name(node));
        legible_name(point.or_else(node).unwrap_or(texts::DELETED_PLACE))
    }

    /// What is done in an attempt.
    pub(super) fn action_of(&self, attempt: &Attempt) -> String {
        match &attempt.action {
            None => texts::VISIT.to_owned(),
            Some(action) => {
                describe_action(action).map_or_else(|| legible_name(action), |it| it.title.to_owned())
            }
        }
    }

    /// Limits of the readings at an inspection point.
    pub(super) fn limits(&self, point: Option<InspectionPointId>) -> Option<&ReadingLimits> {
        self.site().inspection_point(point?)?.limits.as_ref()
    }

    /// Where an object is that has changed.
    pub(super) fn change_place(&self, change: &SceneChange) -> String {
        let at = change.place.centre_m;
        let distance_m = |x: f64, y: f64| (x - at.x).hypot(y - at.y);
        let nodes = self.site().nodes().map(|node| (node.map_from_node.position, &node.name));
        let points = self.site().objects().filter_map(|versioned| match &versioned.object {
            Object::InspectionPoint(point) => Some((point.target_m, &point.name)),
            _ => None,
        });
        let near = nodes.chain(points).map(|(place, name)| (distance_m(place.x, place.y), name));
        let nearest =
            near.filter(|(distance_m, _)| *distance_m <= MAX_NEAR_M).min_by(|a, b| a.0.total_cmp(&b.0));
        texts::change_place(nearest.map(|(_, name)| legible_name(name)).as_deref(), at.x, at.y)
    }

    /// Where an alert is: its inspection point, the place of its task, or that of its change of the scene.
    pub(super) fn alert_place(&self, alert: &Alert) -> String {
        match &alert.cause {
            AlertCause::SceneChange(change) => {
                let found = self.site().scene_changes().find(|known| known.id == *change);
                found.map_or_else(|| texts::DELETED_PLACE.to_owned(), |change| self.change_place(change))
            }
            AlertCause::ByHand { point: None } => String::new(),
            cause => {
                let of_task = |mission: MissionId, task| self.point_of_task(mission, task);
                let point = cause.point().or_else(|| match cause {
                    AlertCause::TaskFailed { mission, task, .. } => of_task((*mission)?, *task),
                    _ => None,
                });
                let point = point.and_then(|point| self.site().inspection_point(point));
                let mission = || match cause {
                    AlertCause::TaskFailed { mission: Some(mission), .. } => self.mission_name(*mission),
                    _ => texts::DELETED_PLACE.to_owned(),
                };
                point.map_or_else(mission, |point| legible_name(&point.name))
            }
        }
    }

    fn point_of_task(&self, mission: MissionId, task: TaskId) -> Option<InspectionPointId> {
        match self.site().mission(mission)?.tasks.iter().find(|listed| listed.id == task)?.place {
            TaskPlace::InspectionPoint(point) => Some(point),
            TaskPlace::Node { .. } | TaskPlace::ByAction { .. } => None,
        }
    }

    fn route_place(&self, place: RouteActionPlace) -> String {
        match place {
            RouteActionPlace::Edge { edge, stage, .. } => {
                let edge = self.site().edge(edge);
                let ends = edge.and_then(|edge| self.node_name(edge.from).zip(self.node_name(edge.to)));
                let name =
                    |(from, to)| missions::place_on_edge((&legible_name(from), &legible_name(to)), stage);
                ends.map_or_else(|| texts::DELETED_EDGE.to_owned(), name)
            }
            RouteActionPlace::Zone(zone) => {
                let zone = self.site().zones().find(|known| known.id == zone);
                legible_name(zone.map_or(texts::DELETED_ZONE, |zone| &zone.name))
            }
        }
    }

    fn node_name(&self, node: NodeId) -> Option<&str> {
        self.site().node(node).map(|node| node.name.as_str())
    }
}

/// A name from outside as it is shown.
pub(super) fn legible_name(name: &str) -> String {
    legible(name, texts::MAX_NAME_CHARS)
}
