//! What an argument of a command has to be.

/// An argument that is no pose on a dock.
pub const DOCK_EXPECTED: &str = "expected X,Y,Z,HEADING: metres and degrees, such as 0,0,0,90";

/// An argument that is no length of a robot.
pub const ROBOT_LENGTH_EXPECTED: &str = "expected a length of more than 0 and at most 10 metres";

/// A word that is not a number.
pub fn not_a_number(text: &str) -> String {
    format!("'{text}' is not a number")
}

pub const NUMBER_EXPECTED: &str = "a number is expected";

pub const SHARE_EXPECTED: &str = "a number from 0 to 1 is expected";

pub const POSITIVE_EXPECTED: &str = "it must be greater than 0";

pub const METRES_EXPECTED: &str = "a number of metres is expected";

pub const POSITIVE_METRES_EXPECTED: &str = "give 0 or more metres";

pub const PIXEL_SIZE_EXPECTED: &str = "give 0.001 to 100 metres";

pub const HEIGHTS_EXPECTED: &str = "give two heights in metres, the lower first, such as 0.2,2.5";

pub const SPACING_EXPECTED: &str = "0.5 to 20 m are possible";

pub const FIELD_OF_VIEW_EXPECTED: &str = "two angles are expected, the lower first, like -16,15";

pub const POSE_EXPECTED: &str = "X,Y,Z,YAW is expected: metres and degrees";

pub const FINITE_EXPECTED: &str = "finite numbers are expected";

pub const ROBOT_EXPECTED: &str = "a robot is sim:SITE or replay:FILE";

/// An argument that is no time.
pub const MINUTES_EXPECTED: &str = "expected a number of minutes, at least 0.01";
