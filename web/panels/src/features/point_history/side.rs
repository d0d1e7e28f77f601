//! One of the two results that are compared: what is drawn of it, and its facts in words.

use super::texts;
use crate::feature_panel::PanelContext;
use crate::features::runs::{Pane, ReadNeedle, viewable};
use client_model::{Model, PointResult};
use missions::SiteZone;
use site_model::RunId;

/// A result with its letter.
pub(super) struct Side<'a> {
    pub(super) letter: &'static str,
    pub(super) result: &'a PointResult,
}

/// The earlier and the later result that are compared; none where there is no such result.
pub(super) fn sides(model: &Model) -> [Option<Side<'_>>; 2] {
    let history = &model.point_history;
    [
        history.earlier().map(|result| Side { letter: texts::EARLIER_LETTER, result }),
        history.later().map(|result| Side { letter: texts::LATER_LETTER, result }),
    ]
}

impl Side<'_> {
    /// What is drawn of it; none if it has neither a picture nor a spectrum.
    pub(super) fn pane(&self, cx: &PanelContext<'_>, zone: &SiteZone) -> Option<Pane> {
        let report = self.result.report.as_ref()?;
        let (file, kind) = viewable(report)?;
        Some(Pane {
            file,
            kind,
            caption: self.caption(cx, zone),
            needle: ReadNeedle::of(report),
            aligned: None,
            changes: None,
        })
    }

    /// Letter, time and age.
    pub(super) fn caption(&self, cx: &PanelContext<'_>, zone: &SiteZone) -> String {
        let age_s = cx.clock.utc.0.saturating_sub(self.result.at.0) as f64 * 1e-9;
        texts::caption(self.letter, zone.to_local(self.result.at), age_s)
    }

    /// Its run and how far the pose is to be trusted.
    pub(super) fn facts(&self, cx: &PanelContext<'_>, zone: &SiteZone) -> String {
        let place = self.result.report.as_ref().and_then(|report| report.place.as_ref());
        texts::facts(&run_name(cx.model, self.result.run, zone), place)
    }
}

/// Name of a run: its mission and when it began, if it is under way or listed.
fn run_name(model: &Model, run: RunId, zone: &SiteZone) -> String {
    let current = model.runs.current().filter(|current| current.run == run);
    let current = current.map(|current| (current.mission, current.began));
    let listed = || model.runs.past().find(|past| past.run == run).map(|past| (past.mission, past.began));
    let Some((mission, began)) = current.or_else(listed) else { return texts::run(run) };
    let mission = model.site.site().and_then(|site| site.mission(mission));
    let name = mission.map_or_else(|| texts::run(run), |mission| mission.name.clone());
    texts::run_of(&name, began.map(|began| zone.to_local(began)))
}
