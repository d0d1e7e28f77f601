//! Finds the field that is meant: by a parser's error, by a problem of the site, by an unknown name. Fields are named by JSON pointers (RFC 6901).

use serde::Serialize;
use serde_json::Value;
use serde_path_to_error::Segment;
use site_model::{Object, ProblemKind, SiteProblem};

/// What is wrong with one field of a document.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct FieldProblem {
    /// JSON pointer of the field in the document; empty for the whole of it.
    pub(crate) pointer: String,
    /// What is wrong, one sentence.
    pub(crate) detail: String,
}

impl FieldProblem {
    pub(crate) fn new(pointer: impl Into<String>, detail: impl Into<String>) -> Self {
        Self { pointer: pointer.into(), detail: detail.into() }
    }

    /// The same field in a document that holds this one at `prefix`.
    pub(crate) fn below(mut self, prefix: &str) -> Self {
        self.pointer.insert_str(0, prefix);
        self
    }
}

/// `key` as a part of a pointer.
pub(crate) fn part(key: &str) -> String {
    format!("/{}", key.replace('~', "~0").replace('/', "~1"))
}

/// The field at which a parser failed.
pub(crate) fn parse_problem(error: &serde_path_to_error::Error<serde_json::Error>) -> FieldProblem {
    let mut pointer = String::new();
    for segment in error.path() {
        match segment {
            Segment::Seq { index } => pointer.push_str(&part(&index.to_string())),
            Segment::Map { key } => pointer.push_str(&part(key)),
            Segment::Enum { variant } => pointer.push_str(&part(variant)),
            Segment::Unknown => {}
        }
    }
    let detail = error.inner().to_string();
    // A missing field is not on the path, and one that means nothing not always.
    let named = |said: &str| detail.strip_prefix(said).and_then(|rest| rest.split('`').next()).map(part);
    let unknown = named("unknown field `").filter(|name| !pointer.ends_with(name.as_str()));
    if let Some(name) = named("missing field `").or(unknown) {
        pointer.push_str(&name);
    }
    FieldProblem { pointer, detail }
}

/// Fields of a document that mean nothing. `understood` is the document as the program writes it.
pub(crate) fn unknown_fields(document: &Value, understood: &Value) -> Vec<FieldProblem> {
    let mut found = Vec::new();
    collect_unknown(document, understood, &mut String::new(), &mut found);
    found
}

fn collect_unknown(
    document: &Value,
    understood: &Value,
    pointer: &mut String,
    found: &mut Vec<FieldProblem>,
) {
    let mut descend = |key: &str, value: &Value, understood: Option<&Value>| {
        let length = pointer.len();
        pointer.push_str(&part(key));
        match understood {
            Some(understood) => collect_unknown(value, understood, pointer, found),
            None => found.push(FieldProblem::new(pointer.clone(), crate::texts::UNKNOWN_FIELD)),
        }
        pointer.truncate(length);
    };
    match (document, understood) {
        (Value::Object(fields), Value::Object(known)) => {
            fields.iter().for_each(|(key, value)| descend(key, value, known.get(key)));
        }
        // Sets are written in another order, so their members are not compared by place. They hold no objects.
        (Value::Array(items), Value::Array(known)) if items.len() == known.len() => {
            for (index, (item, known)) in items.iter().zip(known).enumerate() {
                descend(&index.to_string(), item, Some(known));
            }
        }
        _ => {}
    }
}

/// The field of an object that has a problem. `document` is the object as JSON, without the name of its kind.
pub(crate) fn site_problem(object: &Object, document: &Value, problem: &SiteProblem) -> FieldProblem {
    let pointer = match &problem.kind {
        ProblemKind::OutOfRange { field, .. } => pointer_of_number(object, field),
        ProblemKind::Missing(missing) => find_text(document, &missing.uuid().to_string()),
        ProblemKind::TaskMissing { task, object } => {
            let task = find_text(document, &task.to_string()).and_then(|id| parent(&id));
            task.and_then(|task| {
                let below = find_text(document.pointer(&task)?, &object.uuid().to_string())?;
                Some(task + &below)
            })
        }
        ProblemKind::SameTask(task) => find_last_text(document, &task.to_string()),
        ProblemKind::OrderConstraintMissing(task) => find_last_text(document, &task.to_string()),
        ProblemKind::OrderConstraintsCircular => Some("/order_constraints".to_owned()),
        ProblemKind::EdgeToItself => Some("/to".to_owned()),
        ProblemKind::NotAnArea => Some(match object {
            Object::Node(_) => "/influence_area_m".to_owned(),
            _ => "/corners_m".to_owned(),
        }),
        ProblemKind::NoAction => find_blank_action(document),
        _ => None,
    };
    FieldProblem::new(pointer.unwrap_or_default(), format!("{}.", problem.kind))
}

/// Validation names numbers by their last part.
fn pointer_of_number(object: &Object, field: &str) -> Option<String> {
    use site_model::MonitorCondition;
    Some(match (object, field) {
        (Object::Node(_), "along_m" | "across_m" | "yaw_rad") => format!("/tolerance/{field}"),
        (Object::Edge(_), "left_m" | "right_m") => format!("/corridor/{field}"),
        (Object::Edge(_), "cost") => "/cost/fixed".to_owned(),
        (Object::Schedule(_), "interval") => "/recurrence/every/interval".to_owned(),
        (Object::Monitor(monitor), "release") => match monitor.condition {
            MonitorCondition::Below { .. } => "/condition/below/release".to_owned(),
            _ => "/condition/above/release".to_owned(),
        },
        (Object::SceneChange(_), "size_m") => "/place/size_m".to_owned(),
        (Object::SceneChange(_), "probability") => "/physical_object/probability".to_owned(),
        (Object::SceneChange(_), "reason") => "/review/dismissed/reason".to_owned(),
        (Object::Alert(_), "remark") => "/state/closed/remark".to_owned(),
        (Object::Monitor(_), "silent") => "/condition/silent".to_owned(),
        (_, field) => format!("/{}", field.replace('.', "/")),
    })
}

fn parent(pointer: &str) -> Option<String> {
    pointer.rsplit_once('/').map(|(parent, _)| parent.to_owned())
}

/// The first place with this text, other than the document's own id.
fn find_text(document: &Value, text: &str) -> Option<String> {
    places(document, &|_, value| value.as_str() == Some(text)).into_iter().find(|place| place != "/id")
}

fn find_last_text(document: &Value, text: &str) -> Option<String> {
    places(document, &|_, value| value.as_str() == Some(text)).pop()
}

fn find_blank_action(document: &Value) -> Option<String> {
    let is_blank = |key: &str, value: &Value| {
        matches!(key, "action" | "name") && value.as_str().is_some_and(|name| name.trim().is_empty())
    };
    places(document, &is_blank).into_iter().find(|place| place != "/name")
}

/// Pointers of all values that `is_wanted`, in the order of the document.
fn places(document: &Value, is_wanted: &dyn Fn(&str, &Value) -> bool) -> Vec<String> {
    fn collect(
        value: &Value,
        key: &str,
        pointer: &str,
        is_wanted: &dyn Fn(&str, &Value) -> bool,
        found: &mut Vec<String>,
    ) {
        if is_wanted(key, value) {
            found.push(pointer.to_owned());
        }
        match value {
            Value::Object(fields) => {
                for (key, value) in fields {
                    collect(value, key, &format!("{pointer}{}", part(key)), is_wanted, found);
                }
            }
            Value::Array(items) => {
                for (index, item) in items.iter().enumerate() {
                    collect(item, "", &format!("{pointer}/{index}"), is_wanted, found);
                }
            }
            _ => {}
        }
    }
    let mut found = Vec::new();
    collect(document, "", "", is_wanted, &mut found);
    found
}
