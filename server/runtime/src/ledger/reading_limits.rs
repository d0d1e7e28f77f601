//! What is wrong with the readings of a result, as soon as it is stored: people are told at once, wherever they look.

use crate::texts;
use api::StoredResult;
use serde::Deserialize;
use serde_json::Value;
use site_model::{ActionReport, InspectionPoint, InspectionPointId, Site};

/// What the body of a result says of its place and of what was found.
#[derive(Deserialize)]
struct Details {
    #[serde(default)]
    inspection_point: Option<InspectionPointId>,
    #[serde(default)]
    value: Value,
}

/// A result with the inspection point that it is of.
pub(super) struct PointReport<'a> {
    pub point: &'a InspectionPoint,
    pub report: ActionReport,
}

impl<'a> PointReport<'a> {
    /// None if the site has no such point, or the result has another form: it has no readings then.
    pub fn of(result: &StoredResult, site: &'a Site) -> Option<Self> {
        let details: Details = serde_json::from_str(&result.body).ok()?;
        let point = site.inspection_point(details.inspection_point?)?;
        Some(Self { point, report: serde_json::from_value(details.value).ok()? })
    }

    /// Why the gauge was not read, a sentence; none if it was, or there is none.
    pub fn gauge_problem(&self) -> Option<&str> {
        self.report.gauge.as_ref()?.problem.as_deref()
    }

    /// A sentence for each reading outside the limits of the inspection point, and for a gauge that was not read. Linear in the readings.
    pub fn warnings(&self) -> Vec<String> {
        let name = &self.point.name;
        let outside = self.report.readings.iter().filter_map(|reading| {
            let outside = self.point.limits.as_ref()?.outside(reading)?;
            Some(texts::outside_limits(name, reading, outside))
        });
        let not_read = self.gauge_problem().map(|problem| texts::of_point(name, problem));
        outside.chain(not_read).collect()
    }
}
