//! A history as a table: comma-separated values (RFC 4180), one row for each reading.

use super::results::PointResult;
use super::series::{ReadingSeries, SeriesValue};
use crate::features::site::yaw_of;
use missions::SiteZone;
use site_model::{LocalDateTime, ReportPlace, Utc};
use std::collections::BTreeMap;
use vocab::csv_field;

/// Heads of the columns. Times are ISO 8601. `position_deviation_m` is the standard deviation of the position in the plane.
const HEADS: &str = "utc,site_time,site_time_zone,result,run,attempt,action,reading,value,standard_deviation,unit,judgement,\
                     map,x_m,y_m,z_m,yaw_rad,position_deviation_m,pose_quality,files";

/// Longest name of a point in the name of a file, characters.
const MAX_NAME_CHARS: usize = 60;

/// Name of the file for the history of a point: what every file system takes.
pub(super) fn file_name(point: &str) -> String {
    let safe = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
    let name: String = point.chars().take(MAX_NAME_CHARS).map(safe).collect();
    let name = name.trim_matches('_');
    format!("history_{}.csv", if name.is_empty() { "point" } else { name })
}

/// All results, the oldest first. One without readings has one row. `zone`: of the site, with its name.
pub(super) fn table(results: &[PointResult], series: &[ReadingSeries], zone: &(String, SiteZone)) -> String {
    let mut readings: BTreeMap<u64, Vec<(&ReadingSeries, &SeriesValue)>> = BTreeMap::new();
    for of_one in series {
        for value in &of_one.values {
            readings.entry(value.result).or_default().push((of_one, value));
        }
    }
    let mut text = format!("{HEADS}\r\n");
    for result in results {
        let before = fields_of_result(result, zone);
        let after = fields_of_place(result);
        let of_result = readings.get(&result.number).map(|of_result| of_result.iter().map(fields_of_reading));
        let rows: Vec<[String; 5]> = of_result.map_or_else(|| vec![Default::default()], Iterator::collect);
        for reading in rows {
            let fields = before.iter().chain(&reading).chain(&after);
            text.push_str(&fields.map(String::as_str).collect::<Vec<_>>().join(","));
            text.push_str("\r\n");
        }
    }
    text
}

fn fields_of_result(result: &PointResult, (name, zone): &(String, SiteZone)) -> [String; 7] {
    [
        format!("{}Z", iso(SiteZone::utc().to_local(result.at), result.at)),
        format!("{}{}", iso(zone.to_local(result.at), result.at), offset(zone.offset_minutes(result.at))),
        csv_field(name),
        result.number.to_string(),
        result.run.to_string(),
        result.attempt.to_string(),
        csv_field(&result.kind),
    ]
}

fn fields_of_reading((series, value): &(&ReadingSeries, &SeriesValue)) -> [String; 5] {
    let judgement = match (value.outside, value.is_anomaly) {
        (Some(_), _) => "outside_limits",
        (None, true) => "unusual",
        (None, false) => "",
    };
    [
        csv_field(&series.name),
        value.value.to_string(),
        value.standard_deviation.map(|deviation| deviation.to_string()).unwrap_or_default(),
        csv_field(&series.unit),
        judgement.to_owned(),
    ]
}

fn fields_of_place(result: &PointResult) -> [String; 8] {
    let report = result.report.as_ref();
    let files = report.iter().flat_map(|report| &report.files);
    let files: Vec<String> = files.map(|file| format!("{}={}", file.name, file.blob)).collect();
    let mut fields: [String; 8] = Default::default();
    if let Some(place) = report.and_then(|report| report.place) {
        let position = place.map_from_base.position;
        fields[0] = place.map.map(|map| map.to_string()).unwrap_or_default();
        fields[1] = format!("{:.4}", position.x);
        fields[2] = format!("{:.4}", position.y);
        fields[3] = format!("{:.4}", position.z);
        fields[4] = format!("{:.5}", yaw_of(&place.map_from_base.orientation));
        fields[5] = format!("{:.4}", position_deviation_m(&place));
        // The word of the wire format.
        let quality = serde_json::to_value(place.quality).ok();
        fields[6] = quality.as_ref().and_then(serde_json::Value::as_str).unwrap_or_default().to_owned();
    }
    fields[7] = csv_field(&files.join(" "));
    fields
}

/// Standard deviation of the position in the plane, metres.
fn position_deviation_m(place: &ReportPlace) -> f64 {
    let rows = place.covariance.0;
    (rows[3][3] + rows[4][4]).max(0.0).sqrt()
}

/// `2026-11-24T11:00:05.120`.
fn iso(local: LocalDateTime, at: Utc) -> String {
    let LocalDateTime { date, time } = local;
    let ms = at.0.div_euclid(1_000_000).rem_euclid(60_000);
    format!(
        "{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}",
        date.year,
        date.month,
        date.day,
        time.hour,
        time.minute,
        ms / 1_000,
        ms % 1_000
    )
}

/// `+01:00`.
fn offset(minutes: i64) -> String {
    let sign = if minutes < 0 { '-' } else { '+' };
    format!("{sign}{:02}:{:02}", minutes.abs() / 60, minutes.abs() % 60)
}
