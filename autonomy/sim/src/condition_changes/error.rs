//! Why a change of the condition of a site cannot be made.

use crate::site::conditions::HINGE_WITHIN_M;
use std::fmt;
use vocab::{MAX_SHOWN_NAME_CHARS, legible};

/// Characters of a list of tags that a sentence shows, at most.
const MAX_SHOWN_CHARS: usize = 200;

/// A change that cannot be made. Its text is one sentence: what is wrong, and what to do.
#[derive(Clone, Debug, PartialEq)]
pub enum ConditionChangeError {
    /// No door has its hinge there.
    NoDoor {
        /// The point, metres.
        at: [f64; 3],
    },
    /// No lamp is there.
    NoLamp {
        /// The point, metres.
        at: [f64; 3],
        /// Greatest distance of the lamp, metres.
        within_m: f64,
    },
    /// No gauge has that tag.
    NoGauge {
        /// The tag.
        tag: String,
        /// The tags that there are.
        known: Vec<String>,
    },
    /// No floor is there for a puddle, or no surface for a spot.
    NoSurface {
        /// The point, metres.
        at: [f64; 3],
    },
    /// A number is not within its limits.
    OutOfRange {
        /// What it is, with its unit.
        what: &'static str,
        /// Its limits.
        limits: [f64; 2],
    },
    /// The same thing is changed twice.
    Twice {
        /// The thing.
        what: String,
    },
}

/// A point in a sentence.
fn shown([x, y, z]: [f64; 3]) -> String {
    format!("({x:.2}, {y:.2}, {z:.2})")
}

impl fmt::Display for ConditionChangeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoDoor { at } => write!(
                f,
                "no door has its hinge within {HINGE_WITHIN_M} m of {}: take a point from the list of the site's doors",
                shown(*at)
            ),
            Self::NoLamp { at, within_m } => write!(
                f,
                "no lamp is within {within_m} m of {}: take a point from the list of the site's lamps",
                shown(*at)
            ),
            Self::NoGauge { tag, known } if known.is_empty() => write!(
                f,
                "the site has no gauges, so none of the tag \"{}\": leave the change out",
                legible(tag, MAX_SHOWN_NAME_CHARS)
            ),
            Self::NoGauge { tag, known } => write!(
                f,
                "no gauge has the tag \"{}\": take one of {}",
                legible(tag, MAX_SHOWN_NAME_CHARS),
                legible(&known.join(", "), MAX_SHOWN_CHARS)
            ),
            Self::NoSurface { at } => write!(
                f,
                "the leak at {} is on no surface: put a puddle on a floor, and any other leak on a wall, a pipe or a machine",
                shown(*at)
            ),
            Self::OutOfRange { what, limits: [least, most] } => {
                write!(f, "{what} is not from {least} to {most}: write a number between them")
            }
            Self::Twice { what } => write!(
                f,
                "{} is changed twice: leave one of the changes out",
                legible(what, MAX_SHOWN_NAME_CHARS)
            ),
        }
    }
}

impl std::error::Error for ConditionChangeError {}
