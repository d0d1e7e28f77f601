//! The result of `autoinspect changes` as JSON and as text.

use super::place::Place;
use super::thing::{KnownThing, PlainDescriptor, ThingOfObject};
use crate::failure::Failure;
use crate::texts;
use changes::{Change, Changes, ObservedChange};
use geometry::Isometry;
use serde::{Deserialize, Serialize};
use site_model::{SceneChange, SceneChangeKind};
use std::fs;
use std::path::Path;

/// What changed, in the frame of the map of both visits.
#[derive(Debug, Serialize, Deserialize)]
pub struct Document {
    pub objects: Vec<Object>,
    /// Number of this comparison, from 1: one more than that of the one that it follows.
    #[serde(default)]
    pub comparison: u32,
    /// All things that this comparison and those before it have found changed.
    #[serde(default)]
    pub known: Vec<KnownThing>,
}

/// An object. Lengths are metres, angles radians.
#[derive(Debug, Serialize, Deserialize)]
pub struct Object {
    /// Number from 1, the objects with most points first.
    pub id: usize,
    pub kind: Kind,
    #[serde(flatten)]
    pub place: Place,
    pub points: usize,
    pub confidence: f64,
    /// Where it was before it was moved.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<Place>,
    /// Of a moved one, the probability that one thing was at both places.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub move_probability: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub descriptor: Option<PlainDescriptor>,
    /// Which thing it is, and where that was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub physical_object: Option<ThingOfObject>,
}

/// What became of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    Appeared,
    Removed,
    Moved,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Appeared => "appeared",
            Self::Removed => "removed",
            Self::Moved => "moved",
        }
    }
}

impl Document {
    /// Reads a document.
    ///
    /// # Errors
    /// When the file cannot be read or is none.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let text = fs::read(path)
            .map_err(|error| Failure::usage(texts::could_not_be_read(path, &error.to_string())))?;
        serde_json::from_slice(&text).map_err(|error| Failure::usage(texts::unreadable_input(path, &error)))
    }

    /// The document of changes of a site.
    pub fn of_scene(changes: &[SceneChange]) -> Self {
        let object = |(id, change): (usize, &SceneChange)| {
            let (kind, from) = match change.kind {
                SceneChangeKind::Appeared => (Kind::Appeared, None),
                SceneChangeKind::Removed => (Kind::Removed, None),
                SceneChangeKind::Moved { from } => (Kind::Moved, Some(Place::of_box(&from))),
            };
            let (place, points) = (Place::of_box(&change.place), change.points as usize);
            Object {
                id,
                kind,
                place,
                points,
                confidence: change.confidence,
                from,
                move_probability: None,
                descriptor: None,
                physical_object: None,
            }
        };
        Self { objects: (1..).zip(changes).map(object).collect(), comparison: 1, known: Vec::new() }
    }

    /// Its changes.
    pub fn observed(&self) -> Vec<ObservedChange> {
        let observed = |object: &Object| {
            let change = match (object.kind, &object.from) {
                (Kind::Appeared, _) => Change::Appeared,
                (Kind::Moved, Some(from)) => Change::Moved { from: from.upright_box() },
                (Kind::Removed | Kind::Moved, _) => Change::Removed,
            };
            ObservedChange { change, place: object.place.upright_box() }
        };
        self.objects.iter().map(observed).collect()
    }

    /// The document of changes, in their own frame.
    pub fn new(changes: &Changes) -> Self {
        Self::in_frame(changes, &Isometry::identity())
    }

    /// The document of changes in another frame than that of their boxes.
    pub fn in_frame(changes: &Changes, frame_from_boxes: &Isometry) -> Self {
        let object = |(id, object): (usize, &changes::ChangedObject)| {
            let (kind, from) = match &object.change {
                Change::Appeared => (Kind::Appeared, None),
                Change::Removed => (Kind::Removed, None),
                Change::Moved { from } => (Kind::Moved, Some(Place::new(from, frame_from_boxes))),
            };
            Object {
                id,
                kind,
                place: Place::new(&object.place, frame_from_boxes),
                points: object.points.len(),
                confidence: object.confidence,
                from,
                move_probability: object.move_probability,
                descriptor: object.descriptor.as_ref().map(PlainDescriptor::new),
                physical_object: None,
            }
        };
        Self { objects: (1..).zip(&changes.objects).map(object).collect(), comparison: 1, known: Vec::new() }
    }

    /// A line for each object.
    pub fn describe(&self) -> String {
        if self.objects.is_empty() {
            return texts::NOTHING_CHANGED.to_owned();
        }
        let line = |object: &Object| {
            let place = &object.place;
            texts::changed_object(
                object.kind.name(),
                place.centre_m,
                place.size_m,
                object.from.as_ref().map(|from| from.centre_m),
            )
        };
        self.objects.iter().map(line).collect::<Vec<_>>().join("\n")
    }
}
