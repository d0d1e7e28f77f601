//! Checks the parameters of actions against the JSON Schemas of the actions that the platform comes with.

use super::fields::{FieldProblem, part};
use crate::texts;
use jsonschema::Validator;
use serde_json::{Map, Value};
use site_model::ACTION_CATALOGUE;
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// Validators of parameters by the name of the action.
static VALIDATORS: LazyLock<BTreeMap<&'static str, Validator>> = LazyLock::new(|| {
    let validator = |schema| jsonschema::validator_for(&serde_json::from_str(schema).ok()?).ok();
    // A test checks that each has one.
    ACTION_CATALOGUE
        .iter()
        .filter_map(|action| Some((action.name, validator(action.parameter_schema)?)))
        .collect()
});

/// What the schemas do not permit of the parameters of all actions in a document. Those of actions of the robot alone are not known here. Linear
/// in the document.
pub(super) fn parameter_problems(document: &Value) -> Vec<FieldProblem> {
    let mut found = Vec::new();
    collect(document, &mut String::new(), &mut found);
    found
}

fn collect(value: &Value, pointer: &mut String, found: &mut Vec<FieldProblem>) {
    let mut descend = |key: &str, value: &Value| {
        let length = pointer.len();
        pointer.push_str(&part(key));
        collect(value, pointer, found);
        pointer.truncate(length);
    };
    match value {
        Value::Object(fields) => match fields.get("action").and_then(Value::as_str) {
            Some(action) => check(action, fields.get("parameters"), pointer, found),
            None => fields.iter().for_each(|(key, value)| descend(key, value)),
        },
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(index, item)| descend(&index.to_string(), item));
        }
        _ => {}
    }
}

fn check(action: &str, parameters: Option<&Value>, pointer: &str, found: &mut Vec<FieldProblem>) {
    let Some(validator) = VALIDATORS.get(action) else { return };
    let none = Value::Object(Map::new());
    for error in validator.iter_errors(parameters.unwrap_or(&none)) {
        let place = format!("{pointer}/parameters{}", error.instance_path());
        found.push(FieldProblem::new(place, texts::wrong_parameter(action, &error)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn pointers(document: &Value) -> Vec<String> {
        parameter_problems(document).into_iter().map(|problem| problem.pointer).collect()
    }

    #[test]
    fn every_action_of_the_platform_has_a_schema_that_can_be_checked() {
        assert!(ACTION_CATALOGUE.iter().all(|action| VALIDATORS.contains_key(action.name)));
    }

    #[test]
    fn each_wrong_parameter_is_named_wherever_its_action_stands() {
        let request = |action: &str, parameters: Value| json!({ "action": action, "parameters": parameters });
        let point = |request: Value| json!({ "name": "Gauge", "request": request });
        assert!(pointers(&point(request("photo", json!({ "zoom": 2 })))).is_empty());
        assert!(pointers(&point(json!({ "action": "photo" }))).is_empty());
        assert_eq!(
            pointers(&point(request("photo", json!({ "zoom": "far" })))),
            ["/request/parameters/zoom"]
        );
        assert_eq!(
            pointers(&point(request("wait", json!({ "duration_s": -1 })))),
            ["/request/parameters/duration_s"]
        );
        // What is missing or unknown is said of all parameters.
        assert_eq!(pointers(&point(json!({ "action": "message" }))), ["/request/parameters"]);
        assert_eq!(pointers(&point(request("photo", json!({ "zom": 2 })))), ["/request/parameters"]);
        let mission = json!({ "tasks": [{ "place": { "node": { "request": request("wait", json!({ "duration_s": "x" })) } } }] });
        assert_eq!(pointers(&mission), ["/tasks/0/place/node/request/parameters/duration_s"]);
        // The robot knows its own actions.
        assert!(pointers(&point(request("sniff", json!({ "action": "photo", "zoom": "far" })))).is_empty());
    }
}
