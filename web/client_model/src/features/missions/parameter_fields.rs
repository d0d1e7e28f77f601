//! The fields of the form of an action, read from the JSON Schema of its parameters, and what is wrong with their values.

use serde_json::Value;
use site_model::{ACTION_CATALOGUE, ActionRequest, Parameter, Parameters};
use std::collections::BTreeMap;
use std::sync::LazyLock;

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

static FIELDS: LazyLock<BTreeMap<&'static str, Vec<ParameterField>>> = LazyLock::new(|| {
    ACTION_CATALOGUE.iter().map(|action| (action.name, fields_of_schema(action.parameter_schema))).collect()
});

/// The fields of an action's form; none if the platform does not come with the action, because its schema is not known then.
pub fn parameter_fields(action: &str) -> &'static [ParameterField] {
    FIELDS.get(action).map_or(&[], Vec::as_slice)
}

/// The first field whose value is wrong, and what is wrong with it.
pub fn parameter_problem(request: &ActionRequest) -> Option<(&'static ParameterField, ParameterProblem)> {
    let problem = |field: &'static ParameterField| Some((field, field.problem(&request.parameters)?));
    parameter_fields(&request.action).iter().find_map(problem)
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
            _ => Some(ParameterProblem::WrongType),
        }
    }
}

fn out_of_range(number: f64, min: f64, max: f64) -> Option<ParameterProblem> {
    (!(min..=max).contains(&number)).then_some(ParameterProblem::OutOfRange(min, max))
}

/// The fields of a schema of one object with plain properties. Properties that are set by the platform, or of other types, have none.
fn fields_of_schema(schema: &str) -> Vec<ParameterField> {
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
        Some(ParameterField {
            name: name.clone(),
            title: text(&property["title"]),
            description: text(&property["description"]),
            unit: text(&property["unit"]),
            kind: kind_of(property)?,
            is_required: required(name),
            default: parameter_of(&property["default"]),
        })
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
