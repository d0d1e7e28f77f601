//! Names of what a run is about: for people, and for files.

use api::StoredRun;
use jiff::Timestamp;
use serde_json::Value;
use site_model::{InspectionPointId, NodeId, Site};

/// Name of the place of a result: of its inspection point, or else of its node; none if the site has neither.
pub(super) fn place_name<'a>(site: &'a Site, details: &Value) -> Option<&'a str> {
    let id = |field: &str| details.get(field).and_then(Value::as_str);
    let point = id("inspection_point").and_then(|id| id.parse::<InspectionPointId>().ok());
    let point = point.and_then(|point| Some(site.inspection_point(point)?.name.as_str()));
    let node = || id("node").and_then(|id| id.parse::<NodeId>().ok());
    let node = || node().and_then(|node| Some(site.node(node)?.name.as_str()));
    point.or_else(node)
}

/// Name of a file of a run, without its ending: the mission and when it was asked for, of ASCII letters, digits, `-` and `_`.
pub(crate) fn run_file_name(run: &StoredRun, site: Option<&Site>) -> String {
    let mission = site.and_then(|site| Some(site.mission(run.mission)?.name.as_str()));
    let asked = utc(run.began.nanos());
    // `2026-11-24T11:00:00.5Z` without what a file system may reject.
    let minute: String = asked.chars().take(16).filter(|c| *c != ':').collect();
    format!("{}_{minute}", file_name(mission.unwrap_or("run")))
}

/// `2026-11-24T11:00:00.5Z`.
pub(crate) fn utc(nanos: i64) -> String {
    Timestamp::from_nanosecond(nanos.into()).map(|at| at.to_string()).unwrap_or_default()
}

/// A name that every file system takes: ASCII letters, digits, `.`, `-` and `_`.
pub(super) fn file_name(name: &str) -> String {
    let safe = |c: char| if c.is_ascii_alphanumeric() || matches!(c, '.' | '-') { c } else { '_' };
    let name: String = name.chars().take(60).map(safe).collect();
    let name = name.trim_matches(['.', '_']);
    if name.is_empty() { "unnamed".to_owned() } else { name.to_owned() }
}
