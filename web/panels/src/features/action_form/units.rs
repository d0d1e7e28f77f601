//! Units of parameters: robots count angles in radians, people in degrees.

use client_model::ParameterField;

/// The unit in which the value of a field is shown, and the factor from its own.
pub(crate) fn shown_unit(field: &ParameterField) -> (&str, f64) {
    match field.unit.as_str() {
        "rad" => ("°", 180.0 / std::f64::consts::PI),
        "percent" => ("%", 1.0),
        unit => (unit, 1.0),
    }
}
