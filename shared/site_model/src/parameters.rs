//! Parameters of actions: what JSON can say, without null. They are described by the action's JSON Schema.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::cell::Cell;
use std::collections::BTreeMap;

/// Lists and maps within each other at most. More are refused when they are read, because each level takes stack.
const MAX_DEPTH: u32 = 32;

/// Parameters by name.
pub type Parameters = BTreeMap<String, Parameter>;

/// One value.
///
/// In JSON it is the plain value (`60`, `"front"`, `[1, 2]`). In binary formats, which do not describe themselves, it carries its type.
#[derive(Clone, Debug, PartialEq)]
pub enum Parameter {
    /// Yes or no.
    Bool(bool),
    /// A whole number.
    Integer(i64),
    /// Any other number.
    Number(f64),
    /// Text.
    Text(String),
    /// Several values.
    List(Vec<Parameter>),
    /// Several named values.
    Map(Parameters),
}

/// The form in JSON.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Parameter", untagged)]
enum Plain {
    Bool(bool),
    Integer(i64),
    Number(f64),
    Text(String),
    List(Vec<Parameter>),
    Map(Parameters),
}

/// The form in binary formats.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Parameter")]
enum Tagged {
    Bool(bool),
    Integer(i64),
    Number(f64),
    Text(String),
    List(Vec<Parameter>),
    Map(Parameters),
}

impl Serialize for Parameter {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match serializer.is_human_readable() {
            true => Plain::serialize(self, serializer),
            false => Tagged::serialize(self, serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Parameter {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let _level = Level::enter().ok_or_else(|| D::Error::custom("parameters are nested too deep"))?;
        match deserializer.is_human_readable() {
            true => Plain::deserialize(deserializer),
            false => Tagged::deserialize(deserializer),
        }
    }
}

thread_local! {
    /// Parameters within each other that this thread reads.
    static DEPTH: Cell<u32> = const { Cell::new(0) };
}

/// A level of nesting, left when dropped.
struct Level;

impl Level {
    fn enter() -> Option<Self> {
        let depth = DEPTH.get();
        (depth < MAX_DEPTH).then(|| {
            DEPTH.set(depth + 1);
            Self
        })
    }
}

impl Drop for Level {
    fn drop(&mut self) {
        DEPTH.set(DEPTH.get() - 1);
    }
}
