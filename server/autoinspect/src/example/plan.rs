//! The objects of the example: those of the topological map, inspection points, a mission of all of them in the shortest order, and a schedule.

use super::inspection::InspectedSite;
use crate::failure::Failure;
use crate::{summaries, texts};
use missions::{RouteConditions, RouteConfig, RouteGraph, TourConfig, order_tasks};
use site_model::{
    EditId, FailurePolicy, LocalDate, LocalTime, Mission, MissionEnd, MissionId, Object, Recurrence,
    Schedule, ScheduleId, Site, SiteSettings, Task, TaskId, TaskOrder, TaskPlace, Weekday,
};
use topomap::GeneratedMap;
use uuid::Uuid;
use vocab::MapId;

/// Start times of the mission on weekdays.
const TIMES: [LocalTime; 2] = [LocalTime { hour: 11, minute: 0 }, LocalTime { hour: 15, minute: 0 }];
/// Days of the schedule.
const DAYS: [Weekday; 5] =
    [Weekday::Monday, Weekday::Tuesday, Weekday::Wednesday, Weekday::Thursday, Weekday::Friday];

/// What the schedule needs to know of the calendar.
#[derive(Clone, Debug)]
pub struct Calendar {
    /// Time zone of the site.
    pub time_zone: String,
    /// The first day of the schedule.
    pub today: LocalDate,
}

/// What an id is of: the high half of it, beside the map.
#[derive(Clone, Copy)]
enum IdOf {
    InspectionPoint = 1,
    Task,
    Mission,
    Schedule,
}

/// All objects that the site gets.
pub fn objects(
    name: &str,
    map: MapId,
    made: &GeneratedMap,
    inspected: &InspectedSite<'_>,
    calendar: &Calendar,
) -> Result<Vec<Object>, Failure> {
    let settings =
        SiteSettings { name: name.to_owned(), time_zone: calendar.time_zone.clone(), map: Some(map) };
    let mut objects = vec![Object::Settings(settings)];
    objects.extend(made.objects());
    let points = inspected.points(&made.nodes, |number| id(map, IdOf::InspectionPoint, number));
    if points.is_empty() {
        return Err(Failure::failed(texts::EXAMPLE_SEES_NOTHING));
    }
    let task = |(number, point): (u32, &site_model::InspectionPoint)| Task {
        id: TaskId(id(map, IdOf::Task, number)),
        place: TaskPlace::InspectionPoint(point.id),
        on_unreachable: FailurePolicy::default(),
        on_action_failure: FailurePolicy::default(),
    };
    let mission = Mission {
        id: MissionId(id(map, IdOf::Mission, 0)),
        name: summaries::EXAMPLE_MISSION.to_owned(),
        tasks: (0..).zip(&points).map(task).collect(),
        order: TaskOrder::Shortest { keep_first: false, keep_last: false },
        order_constraints: Vec::new(),
        end: MissionEnd::NearestDock,
    };
    objects.extend(points.into_iter().map(Object::InspectionPoint));
    let mission = in_shortest_order(&objects, mission)?;
    let recurrence = Recurrence::Weekly {
        days: DAYS.into(),
        times: TIMES.to_vec(),
        first_day: calendar.today,
        last_day: None,
    };
    let schedule = ScheduleId(id(map, IdOf::Schedule, 0));
    let schedule = Schedule::new(schedule, "Weekdays".to_owned(), mission.id, recurrence);
    objects.extend([Object::Mission(mission), Object::Schedule(schedule)]);
    Ok(objects)
}

/// The mission with its tasks listed in the shortest order from the dock, as an operator gets them who accepts the proposal.
fn in_shortest_order(objects: &[Object], mut mission: Mission) -> Result<Mission, Failure> {
    let mut site = Site::default();
    for object in objects {
        let edit = site.put(EditId(Uuid::nil()), object.clone());
        site.apply(&edit, edit.id).map_err(Failure::failed)?;
    }
    let graph = RouteGraph::new(&site, &RouteConditions::default(), &RouteConfig::default());
    let dock = site.docks().next().map(|dock| dock.node);
    let start = dock.or_else(|| site.nodes().next().map(|node| node.id));
    if let Some(start) = start {
        let order = order_tasks(&site, &graph, &mission, start, &TourConfig::default()).order;
        mission.tasks.sort_by_key(|task| order.iter().position(|id| *id == task.id));
    }
    mission.order = TaskOrder::AsListed;
    Ok(mission)
}

/// An id that follows from the map, so that the same walk gives the same site.
fn id(map: MapId, of: IdOf, number: u32) -> Uuid {
    let bits = map.0.as_u128() ^ ((of as u128) << 96) ^ (u128::from(number + 1) << 64);
    uuid::Builder::from_random_bytes(bits.to_be_bytes()).into_uuid()
}
