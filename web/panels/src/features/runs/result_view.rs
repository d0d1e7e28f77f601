//! What can be looked at of a run: its pictures and spectra, in the order of their tasks.

use super::look;
use client_model::ResultFileKind;
use client_model::{RunContent, StoredResult};
use site_model::{ActionReport, MissionId, ReportFile, Site};

/// A picture or a spectrum.
#[derive(Clone, Debug)]
pub(super) struct ResultView {
    /// Name of the place.
    pub(super) title: String,
    /// What was done.
    pub(super) action: String,
    /// The result that it belongs to.
    pub(super) result: StoredResult,
    pub(super) report: ActionReport,
    /// The file that is drawn.
    pub(super) file: ReportFile,
    pub(super) kind: ResultFileKind,
}

impl ResultView {
    /// What can be looked at of a result; none if it has neither a picture nor a spectrum.
    pub(super) fn of(title: &str, action: &str, result: &StoredResult) -> Option<Self> {
        let report = result.report()?;
        let (file, kind) = viewable(&report)?;
        let (title, action) = (title.to_owned(), action.to_owned());
        Some(Self { title, action, result: result.clone(), report, file, kind })
    }
}

/// The file that is drawn of a report. Temperatures come before their picture in colours, because they can be read.
pub(crate) fn viewable(report: &ActionReport) -> Option<(ReportFile, ResultFileKind)> {
    let named = |name: &str| report.files.iter().find(|file| file.name == name);
    let picture = || report.files.iter().find(|file| file.media_type.starts_with("image/"));
    let found = named("temperatures_centikelvin.png")
        .map(|file| (file, ResultFileKind::Temperatures))
        .or_else(|| named("spectrum.json").map(|file| (file, ResultFileKind::Spectrum)))
        .or_else(|| picture().map(|file| (file, ResultFileKind::Picture)))?;
    Some((found.0.clone(), found.1))
}

/// All of a run.
pub(super) fn result_views(site: &Site, mission: MissionId, content: &RunContent) -> Vec<ResultView> {
    let of_attempt = |attempt| {
        let task = look::status_of(attempt);
        let (title, action) = (look::attempt_name(site, mission, attempt), look::action_name(&task));
        content.results_of(attempt).filter_map(move |result| ResultView::of(&title, &action, result))
    };
    content.last_attempts().flat_map(of_attempt).collect()
}
