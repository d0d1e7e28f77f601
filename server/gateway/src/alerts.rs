//! Alerts of inspection over HTTP: filtered, as JSON in pages or as CSV. One of them is read and edited as any object of the site.

use crate::app::App;
use crate::documents::Answer;
use crate::json_response::json;
use crate::problem::ProblemResponse;
use crate::runs::utc;
use crate::schemas::ProblemDocument;
use crate::site::schemas::{ObjectListDocument, VersionedDocument};
use crate::site::{document, site};
use crate::texts;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::header;
use axum::response::IntoResponse;
use serde::Deserialize;
use site_model::{
    Alert, AlertCause, AlertId, AlertSeverity, AlertState, InspectionPointId, Object, OutsideLimits, Site,
    Utc, Versioned,
};
use std::cmp::Reverse;
use std::sync::Arc;
use vocab::csv_field;

/// Parameters of alerts as a file.
#[derive(Clone, Copy, Debug)]
struct AlertFileConfig {
    /// Alerts of one CSV file at most. Chosen: twice what the platform keeps, unless as many are open; a few megabytes, which a spreadsheet opens.
    max_alerts: u32,
}

const CONFIG: AlertFileConfig = AlertFileConfig { max_alerts: 10_000 };

/// Which alerts are wanted.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct AlertFilter {
    limit: Option<u32>,
    after: Option<String>,
    severity: Option<AlertSeverity>,
    state: Option<StateName>,
    cause: Option<CauseName>,
    owner: Option<String>,
    point: Option<InspectionPointId>,
    from_ns: Option<i64>,
    #[serde(default)]
    format: Format,
}

/// States without who and when.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
enum StateName {
    Open,
    Acknowledged,
    Closed,
}

/// Causes without their details.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
enum CauseName {
    OutsideLimits,
    GaugeNotRead,
    TaskFailed,
    SceneChange,
    ByHand,
}

/// How alerts are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Format {
    #[default]
    Json,
    Csv,
}

impl StateName {
    fn is_of(self, state: &AlertState) -> bool {
        match self {
            Self::Open => matches!(state, AlertState::Open),
            Self::Acknowledged => matches!(state, AlertState::Acknowledged { .. }),
            Self::Closed => state.is_closed(),
        }
    }
}

impl CauseName {
    fn is_of(self, cause: &AlertCause) -> bool {
        match self {
            Self::OutsideLimits => matches!(cause, AlertCause::OutsideLimits { .. }),
            Self::GaugeNotRead => matches!(cause, AlertCause::GaugeNotRead { .. }),
            Self::TaskFailed => matches!(cause, AlertCause::TaskFailed { .. }),
            Self::SceneChange => matches!(cause, AlertCause::SceneChange(_)),
            Self::ByHand => matches!(cause, AlertCause::ByHand { .. }),
        }
    }
}

impl AlertFilter {
    fn admits(&self, alert: &Alert) -> bool {
        self.severity.is_none_or(|severity| alert.severity == severity)
            && self.state.is_none_or(|state| state.is_of(&alert.state))
            && self.cause.is_none_or(|cause| cause.is_of(&alert.cause))
            && self.owner.as_ref().is_none_or(|owner| alert.owner == *owner)
            && self.point.is_none_or(|point| alert.cause.point() == Some(point))
            && self.from_ns.is_none_or(|from_ns| alert.last_raised.0 >= from_ns)
    }
}

/// Place in the list: those raised last come first.
type Position = (Reverse<Utc>, AlertId);

fn position(alert: &Alert) -> Position {
    (Reverse(alert.last_raised), alert.id)
}

/// The position that `next` of a page names.
fn parse_position(text: &str) -> Option<Position> {
    let (last_raised, id) = text.split_once('.')?;
    Some((Reverse(Utc(last_raised.parse().ok()?)), id.parse().ok()?))
}

/// The alerts, those that were raised last first.
#[utoipa::path(get, path = api::paths::ALERTS_PATH, tag = "site", operation_id = "listAlerts",
    params(
        ("limit" = Option<u32>, Query, description = "Alerts wanted; 100 at most, and if left out. As CSV 10,000 at most, and if left out"),
        ("after" = Option<String>, Query, description = "Only alerts after this one: `next` of the page before"),
        ("severity" = Option<String>, Query, description = "Only those of this severity: information, warning or critical"),
        ("state" = Option<String>, Query, description = "Only those in this state: open, acknowledged or closed"),
        ("cause" = Option<String>, Query, description = "Only those of this cause: outside_limits, gauge_not_read, task_failed, scene_change or by_hand"),
        ("owner" = Option<String>, Query, description = "Only those of this owner; empty: those of nobody"),
        ("point" = Option<String>, Query, format = Uuid, description = "Only those at this inspection point"),
        ("from_ns" = Option<i64>, Query, description = "Only those that were raised at this time or later, nanoseconds since 1970 UTC"),
        ("format" = Option<String>, Query, description = "`csv`: a table instead of JSON"),
    ),
    responses(
    (status = 200, body = ObjectListDocument, description = "A page of alerts with their revisions"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "A parameter is malformed"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core has not sent the site yet"),
))]
pub(crate) async fn list(
    State(app): State<Arc<App>>,
    query: Result<Query<AlertFilter>, QueryRejection>,
) -> Answer {
    let malformed = |detail: &str| ProblemResponse::malformed(texts::query_malformed(detail));
    let Query(filter) = query.map_err(|rejection| malformed(&rejection.body_text()))?;
    let after = match filter.after.as_deref() {
        None => None,
        Some(text) => Some(parse_position(text).ok_or_else(|| malformed(texts::AFTER_NO_ALERT))?),
    };
    let is_csv = filter.format == Format::Csv;
    let most = if is_csv { CONFIG.max_alerts } else { api::MAX_PAGE };
    let limit = filter.limit.unwrap_or(most).clamp(1, most) as usize;
    let state = site(&app)?;
    let wanted = state.site.objects().filter_map(|versioned| match &versioned.object {
        Object::Alert(alert) if filter.admits(alert) => Some((alert, versioned)),
        _ => None,
    });
    let mut wanted: Vec<(&Alert, &Versioned)> =
        wanted.filter(|(alert, _)| after.is_none_or(|after| position(alert) > after)).collect();
    wanted.sort_by_key(|(alert, _)| position(alert));
    let is_more = wanted.len() > limit;
    wanted.truncate(limit);
    if is_csv {
        let head = [
            (header::CONTENT_TYPE, "text/csv; charset=utf-8"),
            (header::CACHE_CONTROL, "no-store"),
            (header::CONTENT_DISPOSITION, "attachment; filename=\"alerts.csv\""),
        ];
        return Ok((head, csv(&state.site, wanted.iter().map(|(alert, _)| *alert))).into_response());
    }
    let next = wanted.last().filter(|_| is_more);
    let next = next.map(|(alert, _)| format!("{}.{}", alert.last_raised.0, alert.id));
    let items = wanted.into_iter().map(|(_, versioned)| VersionedDocument {
        revision: versioned.revision.0,
        object: document(&versioned.object),
        history: None,
    });
    Ok(json(ObjectListDocument { revision: state.revision, items: items.collect(), next }))
}

/// Names of the columns.
const COLUMNS: &str = "id,severity,state,cause,place,reading,value,unit,limit,reason,first_raised,last_raised,times_raised,recovered,owner,work_order,comment,decided_by,decided,remark";

fn csv<'a>(site: &Site, alerts: impl Iterator<Item = &'a Alert>) -> String {
    let mut text = format!("{COLUMNS}\r\n");
    for alert in alerts {
        text.push_str(&row(site, alert));
    }
    text
}

fn row(site: &Site, alert: &Alert) -> String {
    let place = alert.cause.point().and_then(|point| site.inspection_point(point));
    let place = place.map_or("", |point| &point.name);
    let (mut reading, mut value, mut unit, mut limit, mut reason) =
        ("", String::new(), "", String::new(), "");
    match &alert.cause {
        AlertCause::OutsideLimits { reading: outside, .. } => {
            let (OutsideLimits::Below(bound) | OutsideLimits::Above(bound)) = outside.outside;
            (reading, value, unit) = (&outside.name, outside.value.to_string(), &outside.unit);
            limit = bound.to_string();
        }
        AlertCause::GaugeNotRead { reason: why, .. } | AlertCause::TaskFailed { reason: why, .. } => {
            reason = why
        }
        AlertCause::SceneChange(_) | AlertCause::ByHand { .. } => {}
    }
    let (by, decided, remark) = match &alert.state {
        AlertState::Open => ("", None, ""),
        AlertState::Acknowledged { by, at } => (by.as_str(), Some(*at), ""),
        AlertState::Closed { by, at, remark } => (by.as_str(), Some(*at), remark.as_str()),
    };
    let time = |at: Option<Utc>| at.map(|at| utc(at.0)).unwrap_or_default();
    let fields = [
        alert.id.to_string(),
        alert.severity.name().to_owned(),
        alert.state.name().to_owned(),
        alert.cause.name().to_owned(),
        csv_field(place),
        csv_field(reading),
        value,
        csv_field(unit),
        limit,
        csv_field(reason),
        time(Some(alert.first_raised)),
        time(Some(alert.last_raised)),
        alert.times_raised.to_string(),
        time(alert.recovered),
        csv_field(&alert.owner),
        csv_field(&alert.work_order),
        csv_field(&alert.comment),
        csv_field(by),
        time(decided),
        csv_field(remark),
    ];
    format!("{}\r\n", fields.join(","))
}

#[cfg(test)]
mod tests {
    use super::*;
    use site_model::{OutsideReading, RunId};
    use uuid::Uuid;

    fn alert() -> Alert {
        let reading = OutsideReading {
            name: "=cmd".to_owned(),
            value: -3.5,
            unit: "°C".to_owned(),
            outside: OutsideLimits::Below(-2.0),
        };
        let point = InspectionPointId(Uuid::from_u128(5));
        Alert {
            id: AlertId(Uuid::from_u128(7)),
            severity: AlertSeverity::Warning,
            state: AlertState::Closed { by: "Ada".to_owned(), at: Utc(0), remark: "+1".to_owned() },
            cause: AlertCause::OutsideLimits { point, run: RunId(Uuid::from_u128(3)), result: 9, reading },
            owner: "@Ada".to_owned(),
            work_order: "-replace \"it\"".to_owned(),
            comment: String::new(),
            first_raised: Utc(0),
            last_raised: Utc(1_000_000_000),
            times_raised: 2,
            recovered: None,
        }
    }

    #[test]
    fn a_table_has_a_field_for_each_column_and_no_formula() {
        let row = row(&Site::default(), &alert());
        assert_eq!(COLUMNS.split(',').count(), row.split(',').count());
        assert_eq!(
            row,
            "00000000-0000-0000-0000-000000000007,warning,closed,outside_limits,\"\",\"'=cmd\",-3.5,\"°C\",-2,\"\",1970-01-01T00:00:00Z,\
             1970-01-01T00:00:01Z,2,,\"'@Ada\",\"'-replace \"\"it\"\"\",\"\",\"Ada\",1970-01-01T00:00:00Z,\"'+1\"\r\n"
        );
    }

    #[test]
    fn alerts_are_filtered_by_all_that_people_ask_for() {
        let admits = |query: &str| {
            let uri = format!("/?{query}").parse().expect("a path");
            let Query(filter) = Query::<AlertFilter>::try_from_uri(&uri).expect("understood");
            filter.admits(&alert())
        };
        for query in [
            "",
            "severity=warning&state=closed&cause=outside_limits&owner=@Ada",
            "point=00000000-0000-0000-0000-000000000005&from_ns=1000000000",
        ] {
            assert!(admits(query), "{query}");
        }
        for query in [
            "severity=critical",
            "state=open",
            "state=acknowledged",
            "cause=by_hand",
            "owner=",
            "point=00000000-0000-0000-0000-000000000006",
            "from_ns=1000000001",
        ] {
            assert!(!admits(query), "{query}");
        }
        let unknown = "/?severity=bad".parse().expect("a path");
        assert!(Query::<AlertFilter>::try_from_uri(&unknown).is_err());
    }

    #[test]
    fn a_position_is_read_as_the_page_names_it_and_newer_alerts_come_first() {
        let id = AlertId(Uuid::from_u128(7));
        assert_eq!(parse_position(&format!("-5.{id}")), Some((Reverse(Utc(-5)), id)));
        for text in ["", "5", "5.", "x.y", "5.7"] {
            assert_eq!(parse_position(text), None, "{text}");
        }
        assert!((Reverse(Utc(9)), id) < (Reverse(Utc(8)), id));
    }
}
