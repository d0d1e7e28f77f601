//! Things over many comparisons, in the result of `autoinspect changes`.

use super::place::Place;
use object_identity::Descriptor;
use serde::{Deserialize, Serialize};
use site_model::ObjectStay;

/// A thing that comparisons have found changed.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct KnownThing {
    /// Number from 1.
    pub id: usize,
    /// Where it was, the earliest first.
    pub history: Vec<Stay>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub descriptor: Option<PlainDescriptor>,
}

/// That a thing was at a place.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Stay {
    #[serde(flatten)]
    pub place: Place,
    /// Number of the comparison that saw it there first; left out: it was there before the first one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<u32>,
    /// Number of the comparison that saw it there no more; left out: it is there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<u32>,
    /// Probability that it was the same thing as before.
    pub probability: f64,
}

/// A descriptor: only those of one name can be compared.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PlainDescriptor {
    pub name: String,
    pub values: Vec<i8>,
}

impl PlainDescriptor {
    pub fn new(descriptor: &Descriptor) -> Self {
        Self { name: descriptor.name.clone(), values: descriptor.values.clone() }
    }

    pub fn descriptor(&self) -> Descriptor {
        Descriptor { name: self.name.clone(), values: self.values.clone() }
    }
}

/// Which thing an object is.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ThingOfObject {
    pub id: usize,
    /// Probability that it is that thing, and of a moved one that it was at both places.
    pub probability: f64,
    pub history: Vec<Stay>,
}

impl Stay {
    pub fn new(stay: &ObjectStay<u32>) -> Self {
        let ObjectStay { place, from, until, probability } = *stay;
        Self { place: Place::of_box(&place), from, until, probability }
    }

    pub fn stay(&self) -> ObjectStay<u32> {
        let Self { place, from, until, probability } = *self;
        ObjectStay { place: place.oriented_box(), from, until, probability }
    }
}
