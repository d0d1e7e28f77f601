//! What is typed into the fields of a form, and what becomes of it.

use super::*;
use client_model::ParameterProblem;

fn field(unit: &str, kind: ParameterKind) -> ParameterField {
    ParameterField {
        name: "value".into(),
        title: "Value".into(),
        description: String::new(),
        unit: unit.into(),
        kind,
        is_required: false,
        default: None,
    }
}

#[test]
fn people_see_degrees_where_the_robot_counts_radians() {
    let tilt = field("rad", ParameterKind::Number(-1.0, 1.0));
    let (unit, scale) = shown_unit(&tilt);
    assert_eq!(unit, "°");
    let Ok(Some(Parameter::Number(value))) = parse("30", &tilt, scale) else { panic!("30 is a number") };
    assert!((value - 30_f64.to_radians()).abs() < 1e-12, "{value}");
    assert_eq!(shown(&Parameter::Number(value), scale), "30");
    let seconds = field("s", ParameterKind::Number(0.0, 60.0));
    assert_eq!(shown_unit(&seconds), ("s", 1.0));
}

#[test]
fn numbers_may_have_a_comma_and_an_empty_field_means_the_default() {
    let seconds = field("s", ParameterKind::Number(0.0, 60.0));
    assert_eq!(parse(" 2,5 ", &seconds, 1.0), Ok(Some(Parameter::Number(2.5))));
    assert_eq!(parse("3", &seconds, 1.0), Ok(Some(Parameter::Integer(3))));
    assert_eq!(parse("  ", &seconds, 1.0), Ok(None));
    assert_eq!(parse("soon", &seconds, 1.0), Err(ParameterProblem::WrongType));
    let count = field("", ParameterKind::Integer(0.0, 9.0));
    assert_eq!(parse("2.5", &count, 1.0), Err(ParameterProblem::WrongType));
    let text = field("", ParameterKind::Text(0, 20));
    assert_eq!(parse(" valve 3 ", &text, 1.0), Ok(Some(Parameter::Text("valve 3".into()))));
}

#[test]
fn a_problem_is_told_in_the_shown_unit() {
    let sentence = parameter_problem(
        "Tilt",
        "°",
        180.0 / std::f64::consts::PI,
        ParameterProblem::OutOfRange(-0.698_131_7, 1.396_263_4),
    );
    assert_eq!(sentence, "Tilt must be from -40 to 80\u{a0}°.");
    assert_eq!(texts::caption("Tilt", "°"), "Tilt, °");
    assert_eq!(texts::number(1.5), "1.5");
    assert_eq!(texts::number(2.0), "2");
}

#[test]
fn what_was_typed_belongs_to_one_form() {
    let (mine, other) = (Id::unique("mine"), Id::unique("other"));
    let mut typed = TypedParameters::default();
    typed.0.insert((mine.value(), "value".into()), "1".into());
    typed.0.insert((other.value(), "value".into()), "2".into());
    typed.keep_only(mine);
    assert_eq!(typed.0.into_values().collect::<Vec<_>>(), ["1"]);
}
