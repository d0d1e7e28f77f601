//! Errors of sites that are given as models.

use std::fmt;
use vocab::{MAX_SHOWN_NAME_CHARS, legible};

fn shown(part: &str) -> String {
    legible(part, MAX_SHOWN_NAME_CHARS)
}

/// Why a model is no site. Each is one sentence; the reader of the file adds its name.
#[derive(Clone, Debug, PartialEq)]
pub enum BuildingModelError {
    /// It has no triangles with an area.
    NoTriangles,
    /// It has more triangles than the limit.
    TooManyTriangles {
        /// Their number.
        count: usize,
        /// The limit.
        limit: usize,
    },
    /// A corner is not a number, or infinite.
    NotFinite {
        /// Name of the part.
        part: String,
    },
    /// A corner is too far from the origin.
    TooFar {
        /// Name of the part.
        part: String,
        /// The limit along each axis, metres.
        limit_m: f64,
    },
    /// A dock or a start is not on a floor.
    InTheAir {
        /// What it is.
        what: String,
        /// Its position, metres.
        at: [f64; 3],
    },
    /// A path, a route or the outline has too few corners.
    FewCorners {
        /// What it is.
        what: String,
        /// The least number.
        least: usize,
    },
    /// There is neither dock nor start, and no floor on which the robot has room.
    NoFreeFloor,
}

impl fmt::Display for BuildingModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoTriangles => write!(f, "it has no triangles: export the building as meshes"),
            Self::TooManyTriangles { count, limit } => {
                write!(f, "it has {count} triangles, and at most {limit} are read: simplify its meshes")
            }
            Self::NotFinite { part } => {
                write!(f, "a corner of \"{}\" is not a finite number: export it again", shown(part))
            }
            Self::TooFar { part, limit_m } => write!(
                f,
                "a corner of \"{}\" is farther than {limit_m} m from the origin: move the building to the origin, and check its unit",
                shown(part)
            ),
            Self::InTheAir { what, at: [x, y, z] } => write!(
                f,
                "{what} at [{x}, {y}, {z}] has no floor within 0.3 m below or above it: correct its position (metres, z up)"
            ),
            Self::FewCorners { what, least } => {
                write!(f, "{what} has too few corners: at least {least} are needed")
            }
            Self::NoFreeFloor => write!(
                f,
                "the robot has room on none of its floors: check its unit and which axis is up, or name a start"
            ),
        }
    }
}

impl std::error::Error for BuildingModelError {}
