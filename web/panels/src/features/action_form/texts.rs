//! Texts of the forms of actions, by key.

use client_model::ParameterProblem;
use site_model::describe_action;

pub(super) const YES: &str = "Yes";
pub(super) const NO: &str = "No";
pub(crate) const NEAREST_DOCK: &str = "Nearest dock";
pub(crate) const DELETED_DOCK: &str = "Deleted dock";

/// What an action is called.
pub(crate) fn action_title(name: &str) -> String {
    describe_action(name).map_or_else(|| name.to_owned(), |action| action.title.to_owned())
}

/// Caption of a field with its unit.
pub(super) fn caption(title: &str, unit: &str) -> String {
    if unit.is_empty() { title.to_owned() } else { format!("{title}, {unit}") }
}

/// What is wrong with the value of a field, with its shown unit and scale.
pub(crate) fn parameter_problem(title: &str, unit: &str, scale: f64, problem: ParameterProblem) -> String {
    let space = if unit.is_empty() { "" } else { "\u{a0}" };
    match problem {
        ParameterProblem::Missing => format!("{title} is missing."),
        ParameterProblem::WrongType => format!("{title} is not of the right kind."),
        ParameterProblem::OutOfRange(min, max) if max.is_infinite() => {
            format!("{title} must be at least {}{space}{unit}.", number(min * scale))
        }
        ParameterProblem::OutOfRange(min, max) => {
            format!("{title} must be from {} to {}{space}{unit}.", number(min * scale), number(max * scale))
        }
        ParameterProblem::TooLong(max) => format!("{title} may have {max} characters at most."),
        ParameterProblem::NotListed => format!("{title} is none of the choices."),
    }
}

/// A number with the digits that it needs, two after the point at most.
pub(super) fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
