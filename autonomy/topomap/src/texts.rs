//! Names of generated objects, for people.

pub(crate) fn waypoint(number: usize) -> String {
    format!("Waypoint {number}")
}

pub(crate) fn junction(number: usize) -> String {
    format!("Junction {number}")
}

pub(crate) fn portal(number: usize) -> String {
    format!("Stairs end {number}")
}

pub(crate) fn dock(number: usize) -> String {
    format!("Dock {number}")
}

pub(crate) fn on_dock(number: usize) -> String {
    format!("On dock {number}")
}

pub(crate) fn before_dock(number: usize) -> String {
    format!("Before dock {number}")
}
