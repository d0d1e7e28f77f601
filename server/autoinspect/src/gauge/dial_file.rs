//! Reads the description of gauges: what was found once in the pictures of their cameras.

use super::texts;
use crate::failure::Failure;
use gauges::{Dial, DialMarks};
use serde::{Deserialize, Serialize};
use site_model::{DialDirection, GaugeDial};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;
use std::{fs, io};

/// Name of the gauge of an inspection point in a file that describes it alone.
const GAUGE_OF_POINT: &str = "gauge";

/// A gauge in the pictures of a camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Gauge {
    pub name: String,
    /// As a circle in the picture.
    pub dial: Dial,
    /// The marks of a dial that may be seen from the side.
    pub marks: Option<DialMarks>,
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

/// The gauge of this name in a file, or its only one.
pub fn read(path: &Path, name: Option<&str>) -> Result<Gauge, Failure> {
    let text =
        if path == Path::new("-") { io::read_to_string(io::stdin()) } else { fs::read_to_string(path) };
    let text = text.map_err(|error| Failure::unreadable(path, error))?;
    let file: DialFile = serde_json::from_str(&text).map_err(|error| Failure::unreadable(path, error))?;
    let known = file.dials.keys().cloned().collect::<Vec<_>>().join(", ");
    let name = match name {
        Some(name) => name.to_owned(),
        None if file.dials.len() > 1 => return Err(Failure::usage(texts::which_gauge(path, &known))),
        None => known.clone(),
    };
    let Some(entry) = file.dials.get(&name) else {
        let sentence =
            if known.is_empty() { texts::no_gauges(path) } else { texts::unknown_gauge(path, &name, &known) };
        return Err(Failure::usage(sentence));
    };
    let dial = dial(entry).map_err(|reason| Failure::usage(texts::no_dial(path, &name, &reason)))?;
    let marks =
        entry.zero_tick.zip(entry.mid_tick).zip(entry.end_tick).map(|((start_px, middle_px), end_px)| {
            DialMarks { centre_px: dial.axis_px, start_px, middle_px, end_px, range: dial.range }
        });
    Ok(Gauge { name, dial, marks, unit: entry.unit.clone(), image_size_px: entry.image_size })
}

/// A file with one gauge, that of an inspection point.
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
fn dial(entry: &DialEntry) -> Result<Dial, String> {
    let centre_px = entry.centre;
    let direction_rad = |angle_deg: Option<f64>, tick: Option<[f64; 2]>| {
        angle_deg.map(f64::to_radians).or_else(|| tick.map(|tick| Dial::direction_rad(centre_px, tick)))
    };
    let tick_radius_px = entry.zero_tick.map(|[x, y]| (x - centre_px[0]).hypot(y - centre_px[1]));
    let start_rad = direction_rad(entry.zero_angle_deg, entry.zero_tick);
    let (Some(radius_px), Some(start_rad)) = (entry.radius_px.or(tick_radius_px), start_rad) else {
        return Err(texts::NO_ZERO.to_owned());
    };
    let sign = match entry.direction.as_deref() {
        None | Some("clockwise") => 1.0,
        Some("counterclockwise" | "anticlockwise" | "counter-clockwise") => -1.0,
        Some(other) => return Err(texts::unknown_direction(other)),
    };
    let end_rad = direction_rad(entry.end_angle_deg, entry.end_tick);
    let span_rad = match (entry.full_turn, end_rad) {
        (Some(true), _) | (None, None) => TAU,
        (Some(false), None) => return Err(texts::NO_END.to_owned()),
        (_, Some(end_rad)) => ((end_rad - start_rad) * sign).rem_euclid(TAU),
    };
    let axis_px = entry.needle_axis.unwrap_or(centre_px);
    Ok(Dial { centre_px, axis_px, radius_px, start_rad, sweep_rad: sign * span_rad, range: entry.range })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dial_of(text: &str) -> Result<Dial, String> {
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
        assert_eq!(dial_of(r#"{"centre": [50, 50], "range": [0, 10]}"#), Err(texts::NO_ZERO.to_owned()));
        let no_end = r#"{"centre": [50, 50], "range": [0, 10], "zero_tick": [50, 10], "full_turn": false}"#;
        assert_eq!(dial_of(no_end), Err(texts::NO_END.to_owned()));
        let odd = r#"{"centre": [50, 50], "range": [0, 10], "zero_tick": [50, 10], "direction": "up"}"#;
        assert_eq!(dial_of(odd), Err(texts::unknown_direction("up")));
    }
}
