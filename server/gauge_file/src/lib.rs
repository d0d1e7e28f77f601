//! The JSON file that describes gauges: what was found once in the pictures of their cameras. `autoinspect gauge --help` shows its fields.

use gauges::{Dial, DialMarks};
use serde::{Deserialize, Serialize};
use site_model::{DialDirection, GaugeDial};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use vocab::{MAX_SHOWN_NAME_CHARS, legible};

/// Name of the gauge of an inspection point in a file that describes it alone.
const GAUGE_OF_POINT: &str = "gauge";

/// Longest list of names, or reason of the JSON reader, that a sentence shows, characters.
const MAX_SHOWN_CHARS: usize = 400;

/// Why a file has no gauge to read. The sentences go on after the name of the file.
#[derive(Debug, thiserror::Error)]
pub enum GaugeFileError {
    /// It is no such file.
    #[error("could not be read: {}", legible(&.0.to_string(), MAX_SHOWN_CHARS))]
    NotRead(serde_json::Error),
    /// It describes nothing.
    #[error("describes no gauges; `autoinspect gauge --help` shows what stands in it")]
    Empty,
    /// It describes several, and none was chosen.
    #[error("describes several gauges; choose one with --name: {}", legible(known, MAX_SHOWN_CHARS))]
    Several {
        /// All names.
        known: String,
    },
    /// It does not describe this one.
    #[error(
        "describes no gauge '{}'; it has: {}",
        legible(name, MAX_SHOWN_NAME_CHARS),
        legible(known, MAX_SHOWN_CHARS)
    )]
    Unknown {
        /// The name that was asked for.
        name: String,
        /// All names.
        known: String,
    },
    /// The description is not complete.
    #[error("does not describe the whole of gauge '{}': {lack}", legible(name, MAX_SHOWN_NAME_CHARS))]
    Incomplete {
        /// Its name.
        name: String,
        /// What it lacks.
        lack: Lack,
    },
}

/// What the description of a gauge lacks.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Lack {
    /// The lower end of its scale.
    #[error(
        "it has no zero_tick, and no radius_px with a zero_angle_deg; give the pixel of the lower end of the scale"
    )]
    Zero,
    /// The upper end of a scale of less than a turn.
    #[error("full_turn is false, and there is no end_tick; give the pixel of the upper end of the scale")]
    End,
    /// A direction that is one.
    #[error("its direction is '{}'; write clockwise or counterclockwise", legible(.0, MAX_SHOWN_NAME_CHARS))]
    Direction(String),
}

/// A gauge in the pictures of a camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Gauge {
    /// Its name in the file.
    pub name: String,
    /// As a circle in the picture.
    pub dial: Dial,
    /// The marks of a dial that may be seen from the side.
    pub marks: Option<DialMarks>,
    /// Unit of its values.
    pub unit: Option<String>,
    /// Width and height of the pictures in which it was described.
    pub image_size_px: Option<[usize; 2]>,
}

#[derive(Debug, Serialize, Deserialize)]
struct DialFile {
    dials: BTreeMap<String, DialEntry>,
}

/// An entry of the file. Pixels from the top left, degrees clockwise from up.
#[derive(Debug, Default, Serialize, Deserialize)]
struct DialEntry {
    centre: [f64; 2],
    range: [f64; 2],
    #[serde(alias = "start_tick", alias = "min_tick")]
    zero_tick: Option<[f64; 2]>,
    #[serde(alias = "middle_tick")]
    mid_tick: Option<[f64; 2]>,
    #[serde(alias = "max_tick", alias = "full_tick")]
    end_tick: Option<[f64; 2]>,
    #[serde(alias = "start_angle_deg", alias = "min_angle_deg")]
    zero_angle_deg: Option<f64>,
    #[serde(alias = "max_angle_deg", alias = "full_angle_deg")]
    end_angle_deg: Option<f64>,
    radius_px: Option<f64>,
    needle_axis: Option<[f64; 2]>,
    direction: Option<String>,
    full_turn: Option<bool>,
    unit: Option<String>,
    image_size: Option<[usize; 2]>,
}

/// The gauge of this name in the text of a file, or its only one.
///
/// # Errors
/// When the text is no such file, or the gauge is not described in it.
pub fn parse(text: &str, name: Option<&str>) -> Result<Gauge, GaugeFileError> {
    let file: DialFile = serde_json::from_str(text).map_err(GaugeFileError::NotRead)?;
    let known = file.dials.keys().cloned().collect::<Vec<_>>().join(", ");
    let name = match name {
        Some(name) => name.to_owned(),
        None if file.dials.len() > 1 => return Err(GaugeFileError::Several { known }),
        None => known.clone(),
    };
    let Some(entry) = file.dials.get(&name) else {
        return Err(match file.dials.is_empty() {
            true => GaugeFileError::Empty,
            false => GaugeFileError::Unknown { name, known },
        });
    };
    let dial = match dial(entry) {
        Ok(dial) => dial,
        Err(lack) => return Err(GaugeFileError::Incomplete { name, lack }),
    };
    let marks =
        entry.zero_tick.zip(entry.mid_tick).zip(entry.end_tick).map(|((start_px, middle_px), end_px)| {
            DialMarks { centre_px: dial.axis_px, start_px, middle_px, end_px, range: dial.range }
        });
    Ok(Gauge { name, dial, marks, unit: entry.unit.clone(), image_size_px: entry.image_size })
}

/// The text of a file with one gauge, that of an inspection point.
///
/// # Errors
/// When it cannot become JSON; plain data always can.
pub fn description_of(dial: &GaugeDial) -> Result<String, serde_json::Error> {
    let entry = DialEntry {
        centre: dial.centre_px,
        range: dial.range,
        zero_tick: Some(dial.start_px),
        mid_tick: dial.middle_px,
        end_tick: dial.end_px,
        direction: Some(match dial.direction {
            DialDirection::Clockwise => "clockwise".to_owned(),
            DialDirection::Counterclockwise => "counterclockwise".to_owned(),
        }),
        full_turn: Some(dial.end_px.is_none()),
        unit: Some(dial.unit.clone()),
        image_size: Some(dial.size_px.map(|side| side as usize)),
        ..DialEntry::default()
    };
    serde_json::to_string(&DialFile { dials: BTreeMap::from([(GAUGE_OF_POINT.to_owned(), entry)]) })
}

/// The dial of an entry, or what it lacks.
fn dial(entry: &DialEntry) -> Result<Dial, Lack> {
    let centre_px = entry.centre;
    let direction_rad = |angle_deg: Option<f64>, tick: Option<[f64; 2]>| {
        angle_deg.map(f64::to_radians).or_else(|| tick.map(|tick| Dial::direction_rad(centre_px, tick)))
    };
    let tick_radius_px = entry.zero_tick.map(|[x, y]| (x - centre_px[0]).hypot(y - centre_px[1]));
    let start_rad = direction_rad(entry.zero_angle_deg, entry.zero_tick);
    let (Some(radius_px), Some(start_rad)) = (entry.radius_px.or(tick_radius_px), start_rad) else {
        return Err(Lack::Zero);
    };
    let sign = match entry.direction.as_deref() {
        None | Some("clockwise") => 1.0,
        Some("counterclockwise" | "anticlockwise" | "counter-clockwise") => -1.0,
        Some(other) => return Err(Lack::Direction(other.to_owned())),
    };
    let end_rad = direction_rad(entry.end_angle_deg, entry.end_tick);
    let span_rad = match (entry.full_turn, end_rad) {
        (Some(true), _) | (None, None) => TAU,
        (Some(false), None) => return Err(Lack::End),
        (_, Some(end_rad)) => ((end_rad - start_rad) * sign).rem_euclid(TAU),
    };
    let axis_px = entry.needle_axis.unwrap_or(centre_px);
    Ok(Dial { centre_px, axis_px, radius_px, start_rad, sweep_rad: sign * span_rad, range: entry.range })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dial_of(text: &str) -> Result<Dial, Lack> {
        dial(&serde_json::from_str(text).expect("an entry"))
    }

    #[test]
    fn ends_of_a_scale_are_ticks_or_angles() {
        let full =
            dial_of(r#"{"centre": [50, 50], "range": [0, 10], "zero_tick": [50, 10]}"#).expect("a dial");
        assert_eq!((full.radius_px, full.start_rad, full.sweep_rad), (40.0, 0.0, TAU));
        let part = dial_of(
            r#"{"centre": [50, 50], "range": [0, 6], "zero_tick": [20, 80], "end_tick": [80, 80], "full_turn": false}"#,
        )
        .expect("a dial");
        assert!((part.start_rad.to_degrees() + 135.0).abs() < 1e-9);
        assert!((part.sweep_rad.to_degrees() - 270.0).abs() < 1e-9);
        let back = dial_of(
            r#"{"centre": [50, 50], "range": [0, 6], "radius_px": 30, "zero_angle_deg": 90, "end_angle_deg": -90,
                "direction": "counterclockwise", "needle_axis": [51, 52]}"#,
        )
        .expect("a dial");
        assert!((back.sweep_rad.to_degrees() + 180.0).abs() < 1e-9);
        assert_eq!(back.axis_px, [51.0, 52.0]);
    }

    #[test]
    fn what_is_missing_is_named() {
        assert_eq!(dial_of(r#"{"centre": [50, 50], "range": [0, 10]}"#), Err(Lack::Zero));
        let no_end = r#"{"centre": [50, 50], "range": [0, 10], "zero_tick": [50, 10], "full_turn": false}"#;
        assert_eq!(dial_of(no_end), Err(Lack::End));
        let odd = r#"{"centre": [50, 50], "range": [0, 10], "zero_tick": [50, 10], "direction": "up"}"#;
        assert_eq!(dial_of(odd), Err(Lack::Direction("up".to_owned())));
    }
}
