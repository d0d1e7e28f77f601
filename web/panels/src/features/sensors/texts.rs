//! Texts of the sensors, by key.

use api::{Finding, Severity};

pub(super) const HEAD: &str = "Sensors";
pub(super) const NO_REPORT: &str = "No sensor has reported yet.";
pub(super) const SILENT: &str = "silent";

/// A finding in one line, for screen readers.
pub(super) fn finding(finding: &Finding) -> String {
    format!("{}: {} {}", severity(finding.severity), finding.what, finding.remedy)
}

fn severity(severity: Severity) -> &'static str {
    match severity {
        Severity::Info => "Note",
        Severity::Warning => "Warning",
        Severity::Error => "Error",
    }
}
