//! Finds the axis of a file that points up.

use clap::ValueEnum;
use mapping::virtual_viewpoint::{Axis, ViewpointConfig, find_up_axis};
use serde::Serialize;
use std::fmt;

/// An axis and its direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
pub enum Up {
    /// The axis along the normals of the floors.
    #[value(name = "auto")]
    #[serde(rename = "auto")]
    Found,
    #[value(name = "x")]
    #[serde(rename = "x")]
    X,
    #[value(name = "y")]
    #[serde(rename = "y")]
    Y,
    #[value(name = "z")]
    #[serde(rename = "z")]
    Z,
    /// The negative x axis.
    #[value(name = "-x")]
    #[serde(rename = "-x")]
    MinusX,
    /// The negative y axis.
    #[value(name = "-y")]
    #[serde(rename = "-y")]
    MinusY,
    /// The negative z axis.
    #[value(name = "-z")]
    #[serde(rename = "-z")]
    MinusZ,
}

impl Up {
    /// The axis; for [`Up::Found`] the one along the normals of the floors. Floors do not distinguish up from down, so the positive axis is
    /// taken.
    pub fn found(self, thinned: &[[f32; 3]]) -> Self {
        match self {
            Self::Found => match find_up_axis(thinned, &ViewpointConfig::default()) {
                Axis::X => Self::X,
                Axis::Y => Self::Y,
                Axis::Z => Self::Z,
            },
            known => known,
        }
    }

    /// Turns points so that z points up.
    pub fn turn(self, xyz: &mut [[f32; 3]]) {
        let turned: fn([f32; 3]) -> [f32; 3] = match self {
            Self::Found | Self::Z => return,
            Self::X => |[x, y, z]| [y, z, x],
            Self::Y => |[x, y, z]| [x, -z, y],
            Self::MinusX => |[x, y, z]| [-y, z, -x],
            Self::MinusY => |[x, y, z]| [x, z, -y],
            Self::MinusZ => |[x, y, z]| [x, -y, -z],
        };
        for point in xyz {
            *point = turned(*point);
        }
    }
}

impl fmt::Display for Up {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = self.to_possible_value();
        out.write_str(value.as_ref().map_or("auto", |value| value.get_name()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_turn_is_a_rotation_that_puts_its_axis_up() {
        for (up, axis) in [
            (Up::X, [1.0, 0.0, 0.0]),
            (Up::Y, [0.0, 1.0, 0.0]),
            (Up::Z, [0.0, 0.0, 1.0]),
            (Up::MinusX, [-1.0, 0.0, 0.0]),
            (Up::MinusY, [0.0, -1.0, 0.0]),
            (Up::MinusZ, [0.0, 0.0, -1.0]),
        ] {
            let mut points = [axis, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            up.turn(&mut points);
            assert_eq!(points[0], [0.0, 0.0, 1.0], "{up}");
            let [_, a, b, c] = points;
            let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
            assert_eq!(cross, c, "{up} mirrors");
        }
    }
}
