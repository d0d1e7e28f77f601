//! The report of one run.

use super::attention::{RunWithFindings, write_attention};
use super::context::ReportContext;
use super::findings::Findings;
use super::html::Html;
use super::rows::RunRow;
use super::tasks::{Pictures, RunTasks};
use super::{format, head, page, texts};
use crate::runs::CoreQueries;
use std::io::{self, Write};

/// Writes the report.
///
/// # Errors
/// When the core, the disk or whoever reads the report fails.
pub(super) fn write_run_report(
    cx: &ReportContext,
    core: &dyn CoreQueries,
    run: RunRow,
    mut sink: impl Write,
) -> io::Result<()> {
    let findings = Findings::read(cx, core, &run)?;
    let runs = [RunWithFindings { run, findings }];
    let [RunWithFindings { run, findings }] = &runs;
    let (site, mission) = (cx.site_name(), cx.mission_name(run.mission));
    let html = &mut Html::new(&mut sink);
    page::begin(html, &texts::title(&site, &mission, &format::date_and_time(cx.local(run.at()))))?;
    html.markup("<header>\n")?;
    html.element("p", "kicker", &texts::kicker(&site, texts::OF_RUN))?;
    html.element("h1", "", &mission)?;
    html.element("p", head::outcome_class(run), head::outcome(run))?;
    head::write_facts(html, cx, run, true)?;
    head::write_counts(html, &findings.counts, None)?;
    html.markup("</header>\n")?;
    write_attention(html, cx, &runs, false)?;
    html.element("h2", "", texts::TASKS_HEAD)?;
    RunTasks { cx, core, run, findings, pictures: Pictures::All }.write(html)?;
    let ids = [(texts::RUN_ID, run.run.to_string()), (texts::MISSION_ID, run.mission.to_string())];
    page::end(html, cx, &ids.each_ref().map(|(name, id)| (*name, id.as_str())))?;
    sink.flush()
}
