//! The actions `dock` and `undock`: they move the robot to where they end, so their tasks have no place of their own.

use crate::{ActionRequest, DockId, Parameter};
use uuid::Uuid;

/// Parameter of `dock`: the id of the dock. Without it the nearest one that can be reached counts.
pub const DOCK_PARAMETER: &str = "dock";
/// Parameter of `dock`: the charge that the robot waits for, percent. Without it the robot goes on as soon as it is charged.
pub const CHARGE_PARAMETER: &str = "charge_until_percent";

/// What a request asks for that moves the robot by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DockAction {
    /// Into a dock, until the charging current flows, and for as long as it takes to charge.
    Dock {
        /// Which dock; none: the nearest one that can be reached. A text that is no id gives the nil id, which no dock has.
        dock: Option<DockId>,
        /// The charge that the robot waits for, 0 to 1; none: it does not wait.
        charge_until: Option<f64>,
    },
    /// Out of the dock, if the robot is in one.
    Undock,
}

impl DockAction {
    /// What this request asks for; none if its action is done at a place.
    pub fn of(request: &ActionRequest) -> Option<Self> {
        match request.action.as_str() {
            "dock" => {
                let dock = match request.parameters.get(DOCK_PARAMETER) {
                    None => None,
                    Some(Parameter::Text(text)) => Some(DockId(text.parse::<Uuid>().unwrap_or_default())),
                    Some(_) => Some(DockId(Uuid::nil())),
                };
                let percent = match request.parameters.get(CHARGE_PARAMETER) {
                    Some(Parameter::Number(percent)) => Some(*percent),
                    Some(Parameter::Integer(percent)) => Some(*percent as f64),
                    _ => None,
                };
                let charge_until =
                    percent.filter(|percent| percent.is_finite()).map(|it| (it / 100.0).clamp(0.0, 1.0));
                Some(Self::Dock { dock, charge_until })
            }
            "undock" => Some(Self::Undock),
            _ => None,
        }
    }

    /// The dock that it names.
    pub fn dock(self) -> Option<DockId> {
        match self {
            Self::Dock { dock, .. } => dock,
            Self::Undock => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        ACTION_CATALOGUE, Dock, EditId, Mission, MissionEnd, MissionId, NodeId, Object, ObjectId, Parameters,
        ProblemKind, Site, Task, TaskId, TaskOrder, TaskPlace, ValidationConfig,
    };

    fn request(action: &str, parameters: impl Into<Parameters>) -> ActionRequest {
        ActionRequest { action: action.to_owned(), parameters: parameters.into() }
    }

    #[test]
    fn the_actions_that_move_the_robot_are_those_that_are_read_here() {
        for action in ACTION_CATALOGUE {
            let read = DockAction::of(&request(action.name, []));
            assert_eq!(read.is_some(), action.moves_robot, "{}", action.name);
        }
    }

    #[test]
    fn parameters_name_the_dock_and_the_charge() {
        let id = DockId(Uuid::from_u128(7));
        let with = |name: &str, value| request("dock", [(name.to_owned(), value)]);
        let dock = |request: &ActionRequest| DockAction::of(request).and_then(DockAction::dock);
        assert_eq!(dock(&with(DOCK_PARAMETER, Parameter::Text(id.to_string()))), Some(id));
        assert_eq!(
            dock(&with(DOCK_PARAMETER, Parameter::Text("no id".to_owned()))),
            Some(DockId(Uuid::nil()))
        );
        assert_eq!(dock(&request("dock", [])), None);
        let charge = |value| match DockAction::of(&with(CHARGE_PARAMETER, value)) {
            Some(DockAction::Dock { charge_until, .. }) => charge_until,
            other => panic!("{other:?}"),
        };
        assert_eq!(charge(Parameter::Integer(80)), Some(0.8));
        assert_eq!(charge(Parameter::Number(250.0)), Some(1.0), "no more than full");
        assert_eq!(charge(Parameter::Text("full".to_owned())), None);
    }

    /// The problems of a mission with one task at this place, in a site with dock 7.
    fn problems(place: TaskPlace) -> Vec<ProblemKind> {
        let mut site = Site::default();
        let mut put = |object| {
            let edit = site.put(EditId(Uuid::nil()), object);
            site.apply(&edit, edit.id).expect("new");
        };
        let (id, node) = (MissionId(Uuid::from_u128(1)), NodeId(Uuid::from_u128(2)));
        let (on_unreachable, on_action_failure) = Default::default();
        let task = Task { id: TaskId(Uuid::from_u128(3)), place, on_unreachable, on_action_failure };
        put(Object::Mission(Mission {
            id,
            name: "Round".to_owned(),
            tasks: vec![task],
            order: TaskOrder::AsListed,
            order_constraints: Vec::new(),
            end: MissionEnd::Stay,
        }));
        let dock = DockId(Uuid::from_u128(7));
        put(Object::Dock(Dock { id: dock, name: "Dock".to_owned(), node, approach: node }));
        let needing = site.missions_that_need(ObjectId::Dock(dock));
        let names_it = site.missions().any(|it| it.tasks[0].place.object() == Some(ObjectId::Dock(dock)));
        assert_eq!(needing.contains(&id), names_it, "deleting the dock lists the mission");
        let found = site.problems(&ValidationConfig::default());
        found.into_iter().filter(|it| it.object == ObjectId::Mission(id)).map(|it| it.kind).collect()
    }

    #[test]
    fn docking_has_no_place_of_its_own_needs_its_dock_and_is_done_in_tasks_only() {
        let dock = |number: u128| {
            let id = Parameter::Text(Uuid::from_u128(number).to_string());
            TaskPlace::ByAction { request: request("dock", [(DOCK_PARAMETER.to_owned(), id)]) }
        };
        for place in [dock(7), TaskPlace::ByAction { request: request("dock", []) }] {
            assert_eq!(problems(place), []);
        }
        let missing = ObjectId::Dock(DockId(Uuid::from_u128(8)));
        assert!(
            matches!(problems(dock(8))[..], [ProblemKind::TaskMissing { object, .. }] if object == missing)
        );
        let is_of_action = |found: &[ProblemKind]| matches!(found, [ProblemKind::OutOfRange { field, .. }, ..] if field == "action");
        let photo = TaskPlace::ByAction { request: request("photo", []) };
        assert!(is_of_action(&problems(photo)), "a photo needs a place");
        let (node, request) = (NodeId(Uuid::from_u128(2)), Some(request("undock", [])));
        assert!(
            is_of_action(&problems(TaskPlace::Node { node, request })),
            "the robot is moved away from there"
        );
    }
}
