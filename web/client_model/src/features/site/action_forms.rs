//! The fields of the forms of actions, read from the JSON Schemas of their parameters, and what is wrong with their values.

use api::OfferedAction;
use serde_json::Value;
use site_model::{ACTION_CATALOGUE, ActionRequest, Parameter, Parameters};
use std::collections::BTreeMap;
use std::sync::Arc;
use vocab::CameraHead;

/// A field of a form.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterField {
    /// Name of the parameter.
    pub name: String,
    /// Caption.
    pub title: String,
    /// Hint; empty if there is none.
    pub description: String,
    /// Unit of the value, such as `s`; empty if it has none.
    pub unit: String,
    /// What it holds.
    pub kind: ParameterKind,
    /// Whether the action cannot be called without it.
    pub is_required: bool,
    /// What is used if it is not given.
    pub default: Option<Parameter>,
}

/// What a field holds.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterKind {
    /// A number from the first to the second.
    Number(f64, f64),
    /// A whole number from the first to the second.
    Integer(f64, f64),
    /// Text with at least and at most this number of characters.
    Text(usize, usize),
    /// Yes or no.
    Bool,
    /// One of these texts.
    Choice(Vec<String>),
    /// The id of a dock of the site.
    Dock,
}

/// What is wrong with the value of a field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterProblem {
    /// It is needed and not given.
    Missing,
    /// It is of another type.
    WrongType,
    /// It is not within the range, both in the unit of the field.
    OutOfRange(f64, f64),
    /// It has more characters than this.
    TooLong(usize),
    /// It is none of the choices.
    NotListed,
}

/// The forms of all actions whose schema is known: those of the platform, with the limits of the robot's camera head, and those that the robot offers. An offered action of
/// the same name counts instead, as on the robot.
#[derive(Clone, Debug, PartialEq)]
pub struct ActionForms {
    head: CameraHead,
    offered: Vec<OfferedAction>,
    fields: BTreeMap<String, Vec<Arc<ParameterField>>>,
}

impl Default for ActionForms {
    fn default() -> Self {
        Self::new(CameraHead::COMMON, Vec::new())
    }
}

impl ActionForms {
    /// For a robot with this camera head that offers these actions.
    pub(super) fn new(head: CameraHead, offered: Vec<OfferedAction>) -> Self {
        let catalogue =
            ACTION_CATALOGUE.iter().map(|action| (action.name.to_owned(), action.parameter_schema(&head)));
        let of_robot = offered.iter().map(|action| (action.name.clone(), action.parameter_schema.clone()));
        // The later entry of a name counts.
        let all = catalogue.chain(of_robot).map(|(name, schema)| (name, fields_of_schema(&schema)));
        let fields = all.collect();
        Self { head, offered, fields }
    }

    /// The head of the robot's cameras.
    pub fn camera_head(&self) -> CameraHead {
        self.head
    }

    /// The actions that the robot offers.
    pub fn offered(&self) -> &[OfferedAction] {
        &self.offered
    }

    /// The fields of an action's form; none if its schema is not known.
    pub fn fields(&self, action: &str) -> &[Arc<ParameterField>] {
        self.fields.get(action).map_or(&[], Vec::as_slice)
    }

    /// The first field whose value is wrong, and what is wrong with it.
    pub fn problem(&self, request: &ActionRequest) -> Option<(Arc<ParameterField>, ParameterProblem)> {
        let problem =
            |field: &Arc<ParameterField>| Some((Arc::clone(field), field.problem(&request.parameters)?));
        self.fields(&request.action).iter().find_map(problem)
    }
}

impl ParameterField {
    /// What is wrong with its value among these.
    pub fn problem(&self, parameters: &Parameters) -> Option<ParameterProblem> {
        let Some(value) = parameters.get(&self.name) else {
            return self.is_required.then_some(ParameterProblem::Missing);
        };
        match (&self.kind, value) {
            (ParameterKind::Number(min, max), Parameter::Number(number)) => out_of_range(*number, *min, *max),
            (
                ParameterKind::Number(min, max) | ParameterKind::Integer(min, max),
                Parameter::Integer(number),
            ) => out_of_range(*number as f64, *min, *max),
            (ParameterKind::Text(min, max), Parameter::Text(text)) => {
                let count = text.trim().chars().count();
                if count < *min {
                    Some(ParameterProblem::Missing)
                } else {
                    (count > *max).then_some(ParameterProblem::TooLong(*max))
                }
            }
            (ParameterKind::Bool, Parameter::Bool(_)) => None,
            (ParameterKind::Choice(choices), Parameter::Text(text)) => {
                (!choices.contains(text)).then_some(ParameterProblem::NotListed)
            }
            // Whether the site has it, the plan of the mission says.
            (ParameterKind::Dock, Parameter::Text(_)) => None,
            _ => Some(ParameterProblem::WrongType),
        }
    }
}

fn out_of_range(number: f64, min: f64, max: f64) -> Option<ParameterProblem> {
    (!(min..=max).contains(&number)).then_some(ParameterProblem::OutOfRange(min, max))
}

/// The fields of a schema of one object with plain properties. Properties that are set by the platform, or of other types, have none.
fn fields_of_schema(schema: &str) -> Vec<Arc<ParameterField>> {
    let Ok(schema) = serde_json::from_str::<Value>(schema) else { return Vec::new() };
    let required = |name: &str| {
        schema["required"].as_array().is_some_and(|names| names.iter().any(|it| it.as_str() == Some(name)))
    };
    let Some(properties) = schema["properties"].as_object() else { return Vec::new() };
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let field = |(name, property): (&String, &Value)| {
        if property["readOnly"] == Value::Bool(true) {
            return None;
        }
        Some(Arc::new(ParameterField {
            name: name.clone(),
            title: text(&property["title"]),
            description: text(&property["description"]),
            unit: text(&property["unit"]),
            kind: kind_of(property)?,
            is_required: required(name),
            default: parameter_of(&property["default"]),
        }))
    };
    properties.iter().filter_map(field).collect()
}

fn kind_of(property: &Value) -> Option<ParameterKind> {
    let number = |key: &str, without: f64| property[key].as_f64().unwrap_or(without);
    let length = |key: &str, without: usize| property[key].as_u64().map_or(without, |length| length as usize);
    if let Some(choices) = property["enum"].as_array() {
        let texts = choices.iter().filter_map(|choice| Some(choice.as_str()?.to_owned()));
        return Some(ParameterKind::Choice(texts.collect()));
    }
    let (min, max) = (number("minimum", f64::NEG_INFINITY), number("maximum", f64::INFINITY));
    match property["type"].as_str()? {
        "number" => Some(ParameterKind::Number(min, max)),
        "integer" => Some(ParameterKind::Integer(min, max)),
        "string" if property["object"] == "dock" => Some(ParameterKind::Dock),
        "string" => Some(ParameterKind::Text(length("minLength", 0), length("maxLength", usize::MAX))),
        "boolean" => Some(ParameterKind::Bool),
        _ => None,
    }
}

fn parameter_of(value: &Value) -> Option<Parameter> {
    match value {
        Value::Bool(yes) => Some(Parameter::Bool(*yes)),
        Value::Number(number) => {
            number.as_i64().map(Parameter::Integer).or_else(|| number.as_f64().map(Parameter::Number))
        }
        Value::String(text) => Some(Parameter::Text(text.clone())),
        Value::Null | Value::Array(_) | Value::Object(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vocab::Span;

    #[test]
    fn forms_have_the_fields_of_the_schema_and_find_what_is_wrong() {
        let forms = ActionForms::default();
        let photo = forms.fields("photo");
        assert_eq!(
            photo.iter().map(|field| field.name.as_str()).collect::<Vec<_>>(),
            ["pan_rad", "tilt_rad", "zoom"]
        );
        let zoom = &photo[2];
        assert_eq!(
            (&zoom.kind, &zoom.default),
            (&ParameterKind::Number(1.0, 20.0), &Some(Parameter::Integer(1)))
        );
        let with = |value| Parameters::from([("zoom".to_owned(), value)]);
        assert_eq!(zoom.problem(&Parameters::new()), None);
        assert_eq!(zoom.problem(&with(Parameter::Integer(20))), None);
        assert_eq!(
            zoom.problem(&with(Parameter::Number(20.5))),
            Some(ParameterProblem::OutOfRange(1.0, 20.0))
        );
        assert_eq!(
            zoom.problem(&with(Parameter::Number(f64::NAN))),
            Some(ParameterProblem::OutOfRange(1.0, 20.0))
        );
        assert_eq!(zoom.problem(&with(Parameter::Text("2".to_owned()))), Some(ParameterProblem::WrongType));
        let text = &forms.fields("message")[0];
        let with = |value: &str| Parameters::from([("text".to_owned(), Parameter::Text(value.to_owned()))]);
        assert_eq!(text.problem(&with("  ")), Some(ParameterProblem::Missing));
        assert_eq!(text.problem(&with(&"x".repeat(201))), Some(ParameterProblem::TooLong(200)));
        assert_eq!(text.problem(&with("The door is open.")), None);
        assert!(forms.fields("unknown").is_empty());
    }

    #[test]
    fn forms_have_the_limits_of_the_robots_camera_head_and_the_actions_that_it_offers() {
        let head = CameraHead { pan_max_rad: 1.5, zoom_max: 4.0, ..CameraHead::COMMON };
        let offered = |name: &str| OfferedAction {
            name: name.to_owned(),
            title: name.to_owned(),
            parameter_schema: r#"{ "type": "object", "properties": { "gas": { "type": "string" } } }"#
                .to_owned(),
            expected: Span::from_millis(1_000),
            expected_energy_j: 0,
            is_idempotent: true,
        };
        let forms = ActionForms::new(head, vec![offered("sniff"), offered("thermal_photo")]);
        let photo = forms.fields("photo");
        assert_eq!(photo[0].kind, ParameterKind::Number(-1.5, 1.5));
        assert_eq!(photo[2].kind, ParameterKind::Number(1.0, 4.0));
        let names =
            |action: &str| forms.fields(action).iter().map(|field| field.name.clone()).collect::<Vec<_>>();
        assert_eq!(names("sniff"), ["gas"]);
        assert_eq!(names("thermal_photo"), ["gas"], "that of the robot counts");
        let too_far = Parameters::from([("pan_rad".to_owned(), Parameter::Number(2.0))]);
        let request = ActionRequest { action: "photo".to_owned(), parameters: too_far };
        let (field, problem) = forms.problem(&request).expect("out of reach");
        assert_eq!((&*field.name, problem), ("pan_rad", ParameterProblem::OutOfRange(-1.5, 1.5)));
    }
}
