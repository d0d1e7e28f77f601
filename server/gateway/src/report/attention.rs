//! What needs attention, before all else: open alerts, readings outside their limits, tasks that were not done, and changes of the scene.

use super::context::ReportContext;
use super::findings::{BoundedList, Findings, changes_found, open_alerts};
use super::html::Html;
use super::rows::RunRow;
use super::table::{Cell, Column, Table};
use super::{format, texts};
use site_model::{Alert, AlertSeverity};
use std::io;
use vocab::legible;

/// A run with what the first look has found.
pub(super) struct RunWithFindings {
    pub(super) run: RunRow,
    pub(super) findings: Findings,
}

/// The section of what needs attention of these runs. `is_period`: whether the report is of several, so that each row names its run.
pub(super) fn write_attention(
    html: &mut Html<'_>,
    cx: &ReportContext,
    runs: &[RunWithFindings],
    is_period: bool,
) -> io::Result<()> {
    html.element("h2", "", texts::ATTENTION_HEAD)?;
    let ended: Vec<_> = runs.iter().map(|entry| entry.run.ended).collect();
    let alerts = open_alerts(cx, &ended);
    if alerts.entries.is_empty() && runs.iter().all(|entry| entry.findings.is_empty()) {
        return html.element("p", "", texts::NO_ATTENTION);
    }
    write_alerts(html, cx, &alerts)?;
    write_readings(html, cx, runs, is_period)?;
    write_gauges(html, cx, runs, is_period)?;
    write_not_done(html, cx, runs, is_period)?;
    write_changes(html, cx, runs, is_period)
}

/// The columns of a table, after that of the run in a report of several.
fn columns(is_period: bool, rest: &[Column]) -> Vec<Column> {
    let run = is_period.then_some((texts::RUN, "t"));
    run.into_iter().chain(rest.iter().copied()).collect()
}

/// Writes a row, after the cell of the run in a report of several.
fn write_row(
    table: &mut Table<'_, '_>,
    cx: &ReportContext,
    (number, entry): (usize, &RunWithFindings),
    is_period: bool,
    rest: Vec<Cell<'_>>,
) -> io::Result<()> {
    let began = format::short_date_and_time(cx.local(entry.run.at()));
    let run = is_period.then_some(Cell::Run(number, &began));
    let cells: Vec<Cell<'_>> = run.into_iter().chain(rest).collect();
    table.row(&cells)
}

fn write_more(html: &mut Html<'_>, more: usize) -> io::Result<()> {
    if more == 0 { Ok(()) } else { html.element("p", "note", &texts::more(more)) }
}

/// The alerts of the site, as they were when the report was made. They are of no one run.
fn write_alerts(html: &mut Html<'_>, cx: &ReportContext, alerts: &BoundedList<&Alert>) -> io::Result<()> {
    if alerts.entries.is_empty() {
        return Ok(());
    }
    html.element("h4", "", texts::ALERTS_HEAD)?;
    let columns = [
        (texts::SEVERITY, "t"),
        (texts::PLACE, ""),
        (texts::ALERT, ""),
        (texts::RAISED, "t"),
        (texts::STATE, "t"),
        (texts::OWNER, ""),
        (texts::WORK_ORDER, ""),
    ];
    let mut table = Table::begin(html, "", &columns)?;
    for alert in &alerts.entries {
        let severity = texts::alert_severity(alert.severity);
        let severity = match alert.severity {
            AlertSeverity::Information => Cell::Text(severity),
            AlertSeverity::Warning | AlertSeverity::Critical => Cell::Alert(severity),
        };
        let (place, what) = (cx.alert_place(alert), texts::alert(alert));
        let raised = texts::alert_raised(
            &format::short_date_and_time(cx.local(alert.last_raised)),
            alert.times_raised,
        );
        let state = texts::alert_state(alert);
        let [owner, work_order] =
            [&alert.owner, &alert.work_order].map(|text| legible(text, texts::MAX_SENTENCE_CHARS));
        table.row(&[
            severity,
            Cell::Text(&place),
            Cell::Text(&what),
            Cell::Text(&raised),
            Cell::Text(&state),
            Cell::Text(&owner),
            Cell::Text(&work_order),
        ])?;
    }
    table.end()?;
    write_more(html, alerts.more)
}

fn write_readings(
    html: &mut Html<'_>,
    cx: &ReportContext,
    runs: &[RunWithFindings],
    is_period: bool,
) -> io::Result<()> {
    if runs.iter().all(|entry| entry.findings.readings.entries.is_empty()) {
        return Ok(());
    }
    html.element("h4", "", texts::READINGS_HEAD)?;
    let columns = columns(
        is_period,
        &[
            (texts::PLACE, ""),
            (texts::READING, ""),
            (texts::VALUE, "n"),
            (texts::UNIT, "t"),
            (texts::OUTSIDE, "t"),
            (texts::TIME, "t"),
        ],
    );
    let mut table = Table::begin(html, "", &columns)?;
    for (number, entry) in runs.iter().enumerate() {
        for found in &entry.findings.readings.entries {
            let reading = &found.reading;
            let value =
                format::decimal(reading.value, format::decimals(reading.value, reading.standard_deviation));
            let (name, outside) = (texts::reading_name(&reading.name), texts::outside(found.outside));
            let at = format::time(cx.local(found.at));
            let cells = vec![
                Cell::Text(&found.place),
                Cell::Text(&name),
                Cell::Alert(&value),
                Cell::Text(&reading.unit),
                Cell::Alert(&outside),
                Cell::Text(&at),
            ];
            write_row(&mut table, cx, (number, entry), is_period, cells)?;
        }
    }
    table.end()?;
    write_more(html, runs.iter().map(|entry| entry.findings.readings.more).sum())
}

fn write_gauges(
    html: &mut Html<'_>,
    cx: &ReportContext,
    runs: &[RunWithFindings],
    is_period: bool,
) -> io::Result<()> {
    if runs.iter().all(|entry| entry.findings.gauges.entries.is_empty()) {
        return Ok(());
    }
    html.element("h4", "", texts::GAUGES_HEAD)?;
    let columns = columns(is_period, &[(texts::PLACE, ""), (texts::REASON, ""), (texts::TIME, "t")]);
    let mut table = Table::begin(html, "", &columns)?;
    for (number, entry) in runs.iter().enumerate() {
        for gauge in &entry.findings.gauges.entries {
            let at = format::time(cx.local(gauge.at));
            let cells = vec![Cell::Text(&gauge.place), Cell::Text(&gauge.reason), Cell::Text(&at)];
            write_row(&mut table, cx, (number, entry), is_period, cells)?;
        }
    }
    table.end()?;
    write_more(html, runs.iter().map(|entry| entry.findings.gauges.more).sum())
}

fn write_not_done(
    html: &mut Html<'_>,
    cx: &ReportContext,
    runs: &[RunWithFindings],
    is_period: bool,
) -> io::Result<()> {
    if runs.iter().all(|entry| entry.findings.not_done.entries.is_empty()) {
        return Ok(());
    }
    html.element("h4", "", texts::NOT_DONE_HEAD)?;
    let columns = columns(
        is_period,
        &[
            (texts::PLACE, ""),
            (texts::ACTION, ""),
            (texts::STATE, "t"),
            (texts::REASON, ""),
            (texts::TIME, "t"),
        ],
    );
    let mut table = Table::begin(html, "", &columns)?;
    for (number, entry) in runs.iter().enumerate() {
        for task in &entry.findings.not_done.entries {
            let at = format::time(cx.local(task.at));
            let cells = vec![
                Cell::Text(&task.place),
                Cell::Text(&task.action),
                Cell::Alert(task.state),
                Cell::Text(&task.reason),
                Cell::Text(&at),
            ];
            write_row(&mut table, cx, (number, entry), is_period, cells)?;
        }
    }
    table.end()?;
    write_more(html, runs.iter().map(|entry| entry.findings.not_done.more).sum())
}

fn write_changes(
    html: &mut Html<'_>,
    cx: &ReportContext,
    runs: &[RunWithFindings],
    is_period: bool,
) -> io::Result<()> {
    if runs.iter().all(|entry| entry.findings.counts.changes == 0) {
        return Ok(());
    }
    html.element("h4", "", texts::CHANGES_HEAD)?;
    let columns = columns(
        is_period,
        &[(texts::KIND, "t"), (texts::SIZE, "t"), (texts::PLACE, ""), (texts::REVIEW, "")],
    );
    let mut table = Table::begin(html, "", &columns)?;
    for (number, entry) in runs.iter().enumerate() {
        for change in changes_found(cx, &entry.run) {
            let (kind, size) = (texts::change_kind(change), texts::change_size(change));
            let (place, review) = (cx.change_place(change), texts::review(&change.review));
            let cells = vec![Cell::Text(&kind), Cell::Text(&size), Cell::Text(&place), Cell::Text(&review)];
            write_row(&mut table, cx, (number, entry), is_period, cells)?;
        }
    }
    table.end()
}
