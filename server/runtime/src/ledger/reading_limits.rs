//! What is wrong with the readings of a result, as soon as it is stored: people are told at once, wherever they look.

use crate::texts;
use api::StoredResult;
use serde::Deserialize;
use serde_json::Value;
use site_model::{ActionReport, InspectionPointId, Site};

/// What the body of a result says of its place and of what was found.
#[derive(Deserialize)]
struct Details {
    #[serde(default)]
    inspection_point: Option<InspectionPointId>,
    #[serde(default)]
    value: Value,
}

/// A sentence for each reading outside the limits of its inspection point, and for a gauge that was not read. Linear in the readings.
pub(super) fn warnings(result: &StoredResult, site: &Site) -> Vec<String> {
    let Ok(details) = serde_json::from_str::<Details>(&result.body) else { return Vec::new() };
    let point = details.inspection_point.and_then(|point| site.inspection_point(point));
    // Results of other forms have no readings.
    let report = serde_json::from_value::<ActionReport>(details.value).ok();
    let (Some(point), Some(report)) = (point, report) else { return Vec::new() };
    let outside = report.readings.iter().filter_map(|reading| {
        let outside = point.limits.as_ref()?.outside(reading)?;
        Some(texts::outside_limits(&point.name, reading, outside))
    });
    let not_read = report.gauge.iter().filter_map(|gauge| {
        let problem = gauge.problem.as_ref()?;
        Some(texts::of_point(&point.name, problem))
    });
    outside.chain(not_read).collect()
}
