//! Checks the parameters of actions against their JSON Schemas: those of the actions that the platform comes with, and those that the robot offers.

use super::fields::{FieldProblem, part};
use super::parse;
use crate::texts;
use api::{Event, OfferedAction, Platform, RobotBody};
use jsonschema::Validator;
use jsonschema::error::ValidationErrorKind;
use serde_json::{Map, Value};
use site_model::{ACTION_CATALOGUE, Change, Edit, Site};
use std::collections::BTreeMap;
use vocab::CameraHead;

/// Schemas of the parameters of all actions that are known.
pub(crate) struct ActionSchemas {
    head: CameraHead,
    offered: Vec<OfferedAction>,
    /// By the name of the action.
    validators: BTreeMap<String, Validator>,
}

impl Default for ActionSchemas {
    fn default() -> Self {
        Self::new(CameraHead::COMMON, Vec::new())
    }
}

impl ActionSchemas {
    /// Of the actions that the platform comes with, on a robot with this camera head, and of those that are offered now. An offered action of the same name counts
    /// instead. The parameters of an action whose schema cannot be read are not checked.
    fn new(head: CameraHead, offered: Vec<OfferedAction>) -> Self {
        let validator = |schema: &str| jsonschema::validator_for(&serde_json::from_str(schema).ok()?).ok();
        let catalogue = ACTION_CATALOGUE.iter().map(|action| (action.name, action.parameter_schema(&head)));
        let of_robot = offered.iter().map(|action| (&*action.name, action.parameter_schema.clone()));
        let validators = catalogue.chain(of_robot).map(|(name, schema)| {
            let validator = validator(&schema);
            if validator.is_none() {
                tracing::warn!(
                    "the parameters of the action {name} are not checked: its schema cannot be read"
                );
            }
            (name.to_owned(), validator)
        });
        // The later entry of a name counts.
        let by_name: BTreeMap<String, Option<Validator>> = validators.collect();
        let validators =
            by_name.into_iter().filter_map(|(name, validator)| Some((name, validator?))).collect();
        Self { head, offered, validators }
    }

    /// The schemas after an event of the core; none if they stay as they are.
    pub(crate) fn after(&self, event: &Event) -> Option<Self> {
        match event {
            Event::Actions(offered) => Some(Self::new(self.head, offered.clone())),
            Event::Platform(Platform { body: Some(RobotBody { camera_head, .. }), .. })
                if *camera_head != self.head =>
            {
                Some(Self::new(*camera_head, self.offered.clone()))
            }
            _ => None,
        }
    }

    /// What the schemas do not permit of the parameters of all actions in a document. Linear in the document.
    pub(super) fn problems(&self, document: &Value) -> Vec<FieldProblem> {
        self.collect_from(document, |_| true)
    }

    /// Why an edit that came over the socket is refused, one sentence. People fill forms in step by step, so a parameter that is missing is no reason, and neither is what the
    /// site already has.
    pub(crate) fn refusal(&self, edit: &Edit, site: Option<&Site>) -> Option<String> {
        let is_wrong = |error: &ValidationErrorKind| !matches!(error, ValidationErrorKind::Required { .. });
        edit.changes.iter().find_map(|change| {
            let Change::Put { object, .. } = change else { return None };
            let found = self.collect_from(&parse::document(object), is_wrong);
            let first = || found.first().cloned();
            let known = site.and_then(|site| site.get(object.id()));
            let before = || known.map(|known| self.collect_from(&parse::document(&known.object), is_wrong));
            let problem = first().filter(|_| before().is_none_or(|before| before != found))?;
            let id = object.id().to_string();
            Some(texts::object_with_wrong_parameter(&id, &problem.pointer, &problem.detail))
        })
    }

    fn collect_from(
        &self,
        document: &Value,
        counts: impl Fn(&ValidationErrorKind) -> bool,
    ) -> Vec<FieldProblem> {
        let mut found = Vec::new();
        self.collect(document, &mut String::new(), &counts, &mut found);
        found
    }

    fn collect(
        &self,
        value: &Value,
        pointer: &mut String,
        counts: &impl Fn(&ValidationErrorKind) -> bool,
        found: &mut Vec<FieldProblem>,
    ) {
        let mut descend = |key: &str, value: &Value| {
            let length = pointer.len();
            pointer.push_str(&part(key));
            self.collect(value, pointer, counts, found);
            pointer.truncate(length);
        };
        match value {
            Value::Object(fields) => match fields.get("action").and_then(Value::as_str) {
                Some(action) => self.check(action, fields.get("parameters"), pointer, counts, found),
                None => fields.iter().for_each(|(key, value)| descend(key, value)),
            },
            Value::Array(items) => {
                items.iter().enumerate().for_each(|(index, item)| descend(&index.to_string(), item));
            }
            _ => {}
        }
    }

    fn check(
        &self,
        action: &str,
        parameters: Option<&Value>,
        pointer: &str,
        counts: &impl Fn(&ValidationErrorKind) -> bool,
        found: &mut Vec<FieldProblem>,
    ) {
        let Some(validator) = self.validators.get(action) else { return };
        let none = Value::Object(Map::new());
        for error in validator.iter_errors(parameters.unwrap_or(&none)) {
            if counts(error.kind()) {
                let place = format!("{pointer}/parameters{}", error.instance_path());
                found.push(FieldProblem::new(place, texts::wrong_parameter(action, &error)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;
    use site_model::{ActionRequest, EditId, InspectionPoint, InspectionPointId, NodeId, Object, Parameter};
    use uuid::Uuid;
    use vocab::{Span, Vec3};

    fn pointers(document: &Value) -> Vec<String> {
        let schemas = ActionSchemas::default();
        schemas.problems(document).into_iter().map(|problem| problem.pointer).collect()
    }

    fn request(action: &str, parameters: Value) -> Value {
        json!({ "name": "Gauge", "request": { "action": action, "parameters": parameters } })
    }

    fn sniff(schema: &str) -> OfferedAction {
        OfferedAction {
            name: "sniff".to_owned(),
            title: "Sniff".to_owned(),
            parameter_schema: schema.to_owned(),
            expected: Span::from_millis(1_000),
            expected_energy_j: 0,
            is_idempotent: true,
        }
    }

    /// With an action of the robot of this schema.
    fn offering(schema: &str) -> ActionSchemas {
        ActionSchemas::default().after(&Event::Actions(vec![sniff(schema)])).expect("they change")
    }

    const SNIFF_SCHEMA: &str = r#"{ "type": "object", "properties": { "gas": { "type": "string" } }, "required": ["gas"], "additionalProperties": false }"#;

    #[test]
    fn every_action_of_the_platform_has_a_schema_that_can_be_checked() {
        let schemas = ActionSchemas::default();
        assert!(ACTION_CATALOGUE.iter().all(|action| schemas.validators.contains_key(action.name)));
    }

    #[test]
    fn each_wrong_parameter_is_named_wherever_its_action_stands() {
        assert!(pointers(&request("photo", json!({ "zoom": 2 }))).is_empty());
        assert!(pointers(&json!({ "request": { "action": "photo" } })).is_empty());
        assert_eq!(pointers(&request("photo", json!({ "zoom": "far" }))), ["/request/parameters/zoom"]);
        assert_eq!(
            pointers(&request("wait", json!({ "duration_s": -1 }))),
            ["/request/parameters/duration_s"]
        );
        // What is missing or unknown is said of all parameters.
        assert_eq!(pointers(&json!({ "request": { "action": "message" } })), ["/request/parameters"]);
        assert_eq!(pointers(&request("photo", json!({ "zom": 2 }))), ["/request/parameters"]);
        let wait = json!({ "action": "wait", "parameters": { "duration_s": "x" } });
        let mission = json!({ "tasks": [{ "place": { "node": { "request": wait } } }] });
        assert_eq!(pointers(&mission), ["/tasks/0/place/node/request/parameters/duration_s"]);
        // Nobody offers this one.
        assert!(pointers(&request("sniff", json!({ "action": "photo", "zoom": "far" }))).is_empty());
    }

    #[test]
    fn parameters_of_an_action_that_the_robot_offers_are_checked_against_its_schema() {
        let schemas = offering(SNIFF_SCHEMA);
        assert!(schemas.problems(&request("sniff", json!({ "gas": "CO" }))).is_empty());
        let found = schemas.problems(&request("sniff", json!({ "gas": 3 })));
        assert_eq!(found[0].pointer, "/request/parameters/gas");
        assert_eq!(schemas.problems(&request("photo", json!({ "zoom": "far" }))).len(), 1, "others too");
        // A schema that is none says nothing.
        let broken = offering("{");
        assert!(broken.problems(&request("sniff", json!({ "gas": 3 }))).is_empty());
    }

    #[test]
    fn an_aim_is_checked_against_the_reach_of_the_robots_own_camera_head() {
        let aim = request("photo", json!({ "pan_rad": 2.0, "zoom": 3 }));
        let platform = |camera_head| {
            let body = RobotBody {
                footprint_radius_m: 0.3,
                clearance_height_m: 0.8,
                standing_height_m: 0.5,
                step_height_m: 0.2,
                camera_head,
            };
            Event::Platform(Platform { body: Some(body), ..Platform::default() })
        };
        let common = offering(SNIFF_SCHEMA);
        assert!(common.problems(&aim).is_empty());
        assert!(common.after(&platform(CameraHead::COMMON)).is_none(), "nothing changes");
        let head = CameraHead { pan_max_rad: 1.5, zoom_max: 2.0, ..CameraHead::COMMON };
        let short = common.after(&platform(head)).expect("another head");
        let pointers: Vec<String> = short.problems(&aim).into_iter().map(|problem| problem.pointer).collect();
        assert_eq!(pointers, ["/request/parameters/pan_rad", "/request/parameters/zoom"]);
        assert_eq!(short.problems(&request("sniff", json!({ "gas": 3 }))).len(), 1, "what is offered stays");
    }

    #[test]
    fn over_the_socket_wrong_values_are_refused_and_missing_ones_are_not() {
        let schemas = offering(SNIFF_SCHEMA);
        let point = |name: &str, parameters: Vec<(&str, Parameter)>| {
            let parameters = parameters.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
            Object::InspectionPoint(InspectionPoint {
                id: InspectionPointId(Uuid::from_u128(1)),
                name: name.to_owned(),
                asset: None,
                node: NodeId(Uuid::from_u128(2)),
                target_m: Vec3::default(),
                request: ActionRequest { action: "sniff".to_owned(), parameters },
                limits: None,
                gauge: None,
            })
        };
        let put = |object| Edit {
            id: EditId(Uuid::from_u128(3)),
            changes: vec![Change::Put { base: None, object }],
        };
        let mut site = Site::default();
        assert_eq!(schemas.refusal(&put(point("Vent", vec![])), Some(&site)), None, "it is filled in later");
        let wrong = put(point("Vent", vec![("gas", Parameter::Integer(3))]));
        let refusal = schemas.refusal(&wrong, Some(&site)).expect("no text");
        assert!(refusal.contains("/request/parameters/gas"), "{refusal}");
        // An object that was stored before its action was known can still be renamed.
        site.apply(&wrong, EditId(Uuid::from_u128(4))).expect("of this state");
        let renamed = put(point("Vent 2", vec![("gas", Parameter::Integer(3))]));
        assert_eq!(schemas.refusal(&renamed, Some(&site)), None);
    }
}
