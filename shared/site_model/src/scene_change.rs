//! What has changed in the scene between two visits.

use crate::{PhysicalObject, RunId, SceneChangeId, ShapeDescriptor, Utc};
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI};
use vocab::{BlobHash, MapId, Vec3};

/// An object that appeared, was removed or was moved between two visits, and what people say of it. The robot puts it after a mission. The same change that is found again later
/// is the same object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneChange {
    /// Its id.
    pub id: SceneChangeId,
    /// The map in whose frame the places are.
    pub map: MapId,
    /// What became of the object.
    pub kind: SceneChangeKind,
    /// Where it is, or was if it is gone.
    pub place: OrientedBox,
    /// Points of it that were seen last.
    pub points: u32,
    /// Probability that it changed, 0 to 1 (docs/maths/changes.md).
    pub confidence: f64,
    /// What the visit that found it last was compared with.
    pub before: EarlierVisit,
    /// The run that found it last.
    pub after: RunId,
    /// When the run that found it first had ended.
    pub first_seen: Utc,
    /// When the run that found it last had ended.
    pub last_seen: Utc,
    /// Comparisons that found it.
    pub times_seen: u32,
    /// What people have decided of it.
    #[serde(default)]
    pub review: ReviewState,
    /// What people say of it.
    #[serde(default)]
    pub comment: String,
    /// Clouds of the comparison that found it last; none if the disk had no room.
    #[serde(default)]
    pub clouds: Option<SceneChangeClouds>,
    /// Which thing it is of; none if nobody said so.
    #[serde(default)]
    pub physical_object: Option<PhysicalObject>,
    /// Its shape, as it was seen last; none of too few points.
    #[serde(default)]
    pub descriptor: Option<ShapeDescriptor>,
}

/// What became of an object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SceneChangeKind {
    /// It is there after, and was not before.
    Appeared,
    /// It was there before, and is not after.
    Removed,
    /// It was there, and is elsewhere after.
    Moved {
        /// Where it was.
        from: OrientedBox,
    },
}

impl SceneChangeKind {
    /// Its name in JSON, such as `appeared`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Appeared => "appeared",
            Self::Removed => "removed",
            Self::Moved { .. } => "moved",
        }
    }
}

/// How an object that was moved stands otherwise than before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Movement {
    /// Its middle is elsewhere.
    Shifted {
        /// By this distance, metres.
        distance_m: f64,
    },
    /// It was turned where it stands.
    Turned {
        /// By this angle, radians, in either direction. A box looks the same after half a turn, and one whose sides are about as long after a quarter of it: the least angle that explains how it looks.
        turn_rad: f64,
    },
}

impl Movement {
    /// What is shifted by less may only have been turned, metres: the middle of a box that is seen from two sides is as exact.
    const LEAST_SHIFT_M: f64 = 0.1;
    /// What is turned by less was not turned, radians: three times the error of the heading of a box that is well seen.
    const LEAST_TURN_RAD: f64 = 0.17;
    /// Sides that differ by less are about as long, metres.
    const SAME_SIDE_M: f64 = 0.075;

    /// That from one place to another.
    pub fn between(from: &OrientedBox, to: &OrientedBox) -> Self {
        let (a, b) = (from.centre_m, to.centre_m);
        let distance_m = (a.x - b.x).hypot(a.y - b.y).hypot(a.z - b.z);
        let [length, width, _] = to.size_m;
        let period_rad = if (length - width).abs() <= Self::SAME_SIDE_M { FRAC_PI_2 } else { PI };
        let turn_rad = (to.yaw_rad - from.yaw_rad).rem_euclid(period_rad);
        let turn_rad = turn_rad.min(period_rad - turn_rad);
        if distance_m < Self::LEAST_SHIFT_M && turn_rad >= Self::LEAST_TURN_RAD {
            Self::Turned { turn_rad }
        } else {
            Self::Shifted { distance_m }
        }
    }
}

/// A box with a heading that stands upright, in the frame of a map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OrientedBox {
    /// Its middle, metres.
    pub centre_m: Vec3,
    /// Length along the heading, width and height, metres.
    pub size_m: [f64; 3],
    /// Heading of its length, radians, anticlockwise from the first axis of the map.
    pub yaw_rad: f64,
}

impl OrientedBox {
    /// Its longest side, metres.
    pub fn longest_side_m(&self) -> f64 {
        self.size_m.into_iter().fold(0.0, f64::max)
    }
}

/// What a visit is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EarlierVisit {
    /// What was last seen of each place on earlier runs: this is the newest of them.
    Run(RunId),
    /// The map.
    Map(MapId),
}

/// What people have decided of a change.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReviewState {
    /// Nobody has looked at it yet.
    #[default]
    New,
    /// It was seen, and counts.
    Acknowledged,
    /// It does not matter.
    Dismissed {
        /// Why.
        reason: String,
    },
    /// It is to be looked at again.
    Watched,
    /// It is how the scene is now: a version of the map shows it.
    Normal {
        /// That version.
        map: MapId,
    },
    /// It comes and goes, as the platform has seen: the thing was put and taken, or moved to and fro, several times.
    Routine,
}

impl ReviewState {
    /// Its name in JSON, such as `acknowledged`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::New => "new",
            Self::Acknowledged => "acknowledged",
            Self::Dismissed { .. } => "dismissed",
            Self::Watched => "watched",
            Self::Normal { .. } => "normal",
            Self::Routine => "routine",
        }
    }

    /// Whether nobody has to see it any more: it does not matter, is how the scene is, or comes and goes.
    pub fn is_settled(&self) -> bool {
        match self {
            Self::Dismissed { .. } | Self::Normal { .. } | Self::Routine => true,
            Self::New | Self::Acknowledged | Self::Watched => false,
        }
    }
}

/// Clouds of a comparison: PLY files in the frame of the map, under `/api/v1/blobs/{hash}`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SceneChangeClouds {
    /// The object.
    pub object: BlobHash,
    /// All objects of the comparison.
    pub changed: BlobHash,
    /// What both visits saw.
    pub unchanged: BlobHash,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stays_at_its_place_was_turned_and_what_looks_the_same_was_not() {
        let at = |x: f64, size_m: [f64; 3], yaw_deg: f64| OrientedBox {
            centre_m: Vec3 { x, y: 1.0, z: 0.5 },
            size_m,
            yaw_rad: yaw_deg.to_radians(),
        };
        let (long, square) = ([0.8, 0.4, 1.0], [0.42, 0.4, 1.0]);
        let turn_deg = |from: OrientedBox, to: OrientedBox| match Movement::between(&from, &to) {
            Movement::Turned { turn_rad } => Some(turn_rad.to_degrees().round()),
            Movement::Shifted { .. } => None,
        };
        assert_eq!(turn_deg(at(2.0, long, 10.0), at(2.05, long, 44.0)), Some(34.0));
        assert_eq!(turn_deg(at(2.0, long, 170.0), at(2.0, long, 10.0)), Some(20.0));
        assert_eq!(turn_deg(at(2.0, long, 0.0), at(2.0, long, 90.0)), Some(90.0));
        assert_eq!(turn_deg(at(2.0, square, 0.0), at(2.0, square, 63.0)), Some(27.0));
        assert_eq!(turn_deg(at(2.0, square, 0.0), at(2.0, square, 90.0)), None);
        let moved = Movement::between(&at(2.0, long, 0.0), &at(3.5, long, 44.0));
        assert_eq!(moved, Movement::Shifted { distance_m: 1.5 });
    }
}
