//! Changes of a site as a JSON file: a script for the simulator, and the truth for scorers of what it changed.

use crate::error::SiteFileError;
use crate::texts;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use sim::{ConditionChange, Leak, Liquid, LooseObject, ObjectChange, SimulatedSite};
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;
use vocab::Vec3;

/// The newest version of the file that is read and written.
const VERSION: u32 = 1;
/// Most bytes of a file that is read.
const MAX_BYTES: u64 = 1 << 20;
/// Most changes of a file.
const MAX_CHANGES: usize = 1000;
/// Least and greatest length of a side of an object that is put, metres.
const SIDE_M: [f64; 2] = [0.01, 20.0];
/// Greatest coordinate, metres.
const MAX_COORDINATE_M: f64 = 10_000.0;

/// What is changed at a site.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SiteChanges {
    /// Objects that stand there besides.
    pub objects: Vec<LooseObject>,
    /// What is not in its usual condition.
    pub conditions: Vec<ConditionChange>,
}

/// The file.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Document {
    version: u32,
    changes: Vec<Entry>,
}

/// The version alone, so that a newer file is recognised before its unknown fields are.
#[derive(Deserialize)]
struct Version {
    version: u32,
}

/// A change. Positions are in the site frame, metres.
#[derive(Deserialize, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
enum Entry {
    Door {
        hinge_m: [f64; 3],
        turn_deg: f64,
    },
    Leak {
        at_m: [f64; 3],
        radius_m: f64,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        liquid: Option<LiquidName>,
        #[serde(default)]
        warmer_k: f64,
    },
    GaugeDrift {
        tag: String,
        per_day: f64,
        #[serde(default)]
        begun_days_ago: f64,
    },
    GaugeStuck {
        tag: String,
        value: f64,
    },
    LampOut {
        at_m: [f64; 3],
    },
    ObjectPut {
        foot_m: [f64; 3],
        size_m: [f64; 3],
        #[serde(default)]
        heading_deg: f64,
        material: String,
    },
}

#[derive(Clone, Copy, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
enum LiquidName {
    Water,
    Oil,
}

impl SiteChanges {
    /// Reads a file.
    ///
    /// # Errors
    /// When it is missing, damaged, of a newer version, or has a field or a kind of change that is not known.
    pub fn read(file: &Path) -> Result<Self, SiteFileError> {
        let failed = |error: &dyn std::fmt::Display| SiteFileError::new(file, texts::not_read(error));
        let mut bytes = Vec::new();
        let opened = File::open(file).map_err(|error| failed(&error))?;
        opened.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(|error| failed(&error))?;
        Self::parse(&bytes).map_err(|reason| SiteFileError::new(file, reason))
    }

    /// Reads the content of a file.
    ///
    /// # Errors
    /// As [`Self::read`]: a sentence without the name of the file.
    pub fn parse(bytes: &[u8]) -> Result<Self, String> {
        if bytes.len() as u64 > MAX_BYTES {
            return Err(texts::too_many_changes(MAX_CHANGES));
        }
        let Version { version } = serde_json::from_slice(bytes).map_err(|error| texts::bad_json(&error))?;
        if version != VERSION {
            return Err(texts::other_version(version, VERSION));
        }
        let document: Document = serde_json::from_slice(bytes).map_err(|error| texts::bad_json(&error))?;
        if document.changes.len() > MAX_CHANGES {
            return Err(texts::too_many_changes(MAX_CHANGES));
        }
        let mut changes = Self::default();
        for (index, entry) in document.changes.into_iter().enumerate() {
            changes.add(entry).map_err(|reason| texts::in_change(index + 1, &reason))?;
        }
        Ok(changes)
    }

    /// Writes a file, which can be read again as a script of the same changes.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, file: &Path) -> Result<(), SiteFileError> {
        let failed = |error: &dyn std::fmt::Display| SiteFileError::new(file, texts::not_written(error));
        let text = self.to_text().map_err(|error| failed(&error))?;
        fs::write(file, text).map_err(|error| failed(&error))
    }

    /// The content of a file.
    ///
    /// # Errors
    /// When it cannot become JSON; plain data always can.
    pub fn to_text(&self) -> Result<String, serde_json::Error> {
        let objects = self.objects.iter().map(Entry::of_object);
        let changes = objects.chain(self.conditions.iter().map(Entry::of_condition)).collect();
        Ok(serde_json::to_string_pretty(&Document { version: VERSION, changes })? + "\n")
    }

    /// The site after these changes.
    ///
    /// # Errors
    /// A sentence, when a change names nothing that the site has.
    pub fn apply(&self, site: &SimulatedSite) -> Result<SimulatedSite, String> {
        let put: Vec<ObjectChange> = self.objects.iter().copied().map(ObjectChange::Put).collect();
        let site = if put.is_empty() { site.clone() } else { site.with_changes(&put) };
        site.with_condition_changes(&self.conditions).map_err(|error| error.to_string())
    }

    /// All loose objects of a site, and what is not in its usual condition there.
    pub fn of(site: &SimulatedSite) -> Self {
        Self { objects: site.loose_objects().to_vec(), conditions: site.condition_changes().to_vec() }
    }

    fn add(&mut self, entry: Entry) -> Result<(), String> {
        self.conditions.push(match entry {
            Entry::Door { hinge_m, turn_deg } => {
                ConditionChange::DoorTurned { hinge: point(hinge_m)?, turn_rad: turn_deg.to_radians() }
            }
            Entry::Leak { at_m, radius_m, liquid, warmer_k } => ConditionChange::Leak(Leak {
                place: point(at_m)?,
                radius_m,
                liquid: liquid.map(|name| match name {
                    LiquidName::Water => Liquid::Water,
                    LiquidName::Oil => Liquid::Oil,
                }),
                warmer_k,
            }),
            Entry::GaugeDrift { tag, per_day, begun_days_ago } => {
                ConditionChange::GaugeDrifts { tag, per_day, begun_days_ago }
            }
            Entry::GaugeStuck { tag, value } => ConditionChange::GaugeStuck { tag, value },
            Entry::LampOut { at_m } => ConditionChange::LampOut { lamp: point(at_m)? },
            Entry::ObjectPut { foot_m, size_m, heading_deg, material } => {
                point(foot_m)?;
                if !size_m.iter().all(|side| (SIDE_M[0]..=SIDE_M[1]).contains(side)) {
                    return Err(texts::bad_side(SIDE_M));
                }
                let material = material.parse().map_err(|error| format!("{error}"))?;
                let yaw_rad = (heading_deg % 360.0).to_radians();
                self.objects.push(LooseObject { foot: Vector3::from(foot_m), size_m, yaw_rad, material });
                return Ok(());
            }
        });
        Ok(())
    }
}

impl Entry {
    fn of_object(object: &LooseObject) -> Self {
        Self::ObjectPut {
            foot_m: object.foot.into(),
            size_m: object.size_m,
            heading_deg: object.yaw_rad.to_degrees(),
            material: object.material.name().to_owned(),
        }
    }

    fn of_condition(change: &ConditionChange) -> Self {
        match change.clone() {
            ConditionChange::DoorTurned { hinge, turn_rad } => {
                Self::Door { hinge_m: hinge.to_array(), turn_deg: turn_rad.to_degrees() }
            }
            ConditionChange::Leak(Leak { place, radius_m, liquid, warmer_k }) => Self::Leak {
                at_m: place.to_array(),
                radius_m,
                liquid: liquid.map(|liquid| match liquid {
                    Liquid::Water => LiquidName::Water,
                    Liquid::Oil => LiquidName::Oil,
                }),
                warmer_k,
            },
            ConditionChange::GaugeDrifts { tag, per_day, begun_days_ago } => {
                Self::GaugeDrift { tag, per_day, begun_days_ago }
            }
            ConditionChange::GaugeStuck { tag, value } => Self::GaugeStuck { tag, value },
            ConditionChange::LampOut { lamp } => Self::LampOut { at_m: lamp.to_array() },
        }
    }
}

/// A point of the site.
fn point(at: [f64; 3]) -> Result<Vec3, String> {
    let is_near = at.iter().all(|c| c.abs() <= MAX_COORDINATE_M);
    let [x, y, z] = at;
    if is_near { Ok(Vec3::new(x, y, z)) } else { Err(texts::far_point(MAX_COORDINATE_M)) }
}
