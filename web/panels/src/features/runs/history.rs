//! Runs that have ended.

use super::filter::Filter;
use super::rows::{Row, show_row};
use super::{look, texts};
use crate::button::Button;
use crate::feature_panel::PanelContext;
use crate::widgets::{self, fact};
use crate::{format, icon};
use client_model::{ClientCommand, PastRun, RunContent, StoredResult};
use egui::{Id, Ui};
use missions::SiteZone;
use site_model::{ActionReport, RunId, Site, TaskStatus};

/// What is shown of ended runs.
#[derive(Debug, Default)]
pub(super) struct History {
    filter: Filter,
    open: Option<RunId>,
}

impl History {
    /// Shows the list.
    pub(super) fn show(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let (model, tokens) = (cx.model, cx.tokens);
        let Some(site) = model.site.site() else { return widgets::remark(ui, tokens, texts::LOADING) };
        let mut filter = self.filter;
        widgets::choice(ui, tokens, &texts::FILTERS, filter, |chosen| filter = chosen);
        self.filter = filter;
        let runs: Vec<PastRun<'_>> =
            model.runs.past().filter(|run| filter.lets_through(run.outcome)).collect();
        if runs.is_empty() {
            widgets::remark(ui, tokens, texts::NO_PAST_RUNS);
        }
        for run in runs {
            self.show_run(ui, cx, site, &run);
        }
    }

    fn show_run(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, run: &PastRun<'_>) {
        let tokens = cx.tokens;
        let title = look::mission_name(cx.model, run.mission);
        let outcome = texts::run_state(run.outcome);
        let zone = site.settings().map_or("UTC", |settings| settings.time_zone.as_str());
        let zone = SiteZone::new(zone).unwrap_or_else(|_| SiteZone::utc());
        let facts = texts::past_facts(site, run, run.began.map(|began| zone.to_local(began)));
        let name = texts::past_row(&title, outcome, &facts);
        let is_open = self.open == Some(run.run);
        let row = Row {
            name: &name,
            title: &title,
            facts: &facts,
            state: outcome,
            time: "",
            look: look::of_run(tokens, run.outcome),
            is_selected: is_open,
        };
        if show_row(ui, tokens, Id::unique(("past run", run.run.0)), &row).clicked() {
            self.open = (!is_open).then_some(run.run);
            if !is_open {
                cx.commands.push(ClientCommand::OpenRun(run.run));
            }
        }
        if !is_open {
            return;
        }
        match cx.model.runs.content(run.run) {
            Some(Ok(content)) => show_content(ui, cx, site, run, content),
            Some(Err(sentence)) => widgets::tinted_box(ui, tokens, tokens.warn, |ui| {
                widgets::sentence(ui, tokens, sentence);
            }),
            None => widgets::remark(ui, tokens, texts::FETCHING),
        }
    }
}

/// The last attempt of each task, with what was gathered.
fn show_content(ui: &mut Ui, cx: &PanelContext<'_>, site: &Site, run: &PastRun<'_>, content: &RunContent) {
    let tokens = cx.tokens;
    if content.attempts.is_empty() {
        widgets::remark(ui, tokens, texts::NO_ATTEMPTS);
    }
    for attempt in content.last_attempts() {
        let task = TaskStatus {
            task: attempt.details.task,
            node: attempt.details.node,
            action: attempt.details.action.clone(),
            state: attempt.state,
            attempt: attempt.attempt,
            failure: None,
        };
        let title = look::task_name(site, run.mission, &task);
        let state = texts::task_state(task.state);
        let took_s = attempt.done.map(|done| (done.0 - attempt.intended.0) as f64 * 1e-9);
        let facts = texts::task_facts(&look::action_name(&task), &task);
        let row = Row {
            name: &texts::task_row(&title, state),
            title: &title,
            facts: &facts,
            state,
            time: &took_s.map(format::elapsed).unwrap_or_default(),
            look: look::of_task(tokens, task.state),
            is_selected: false,
        };
        show_row(ui, tokens, Id::unique(("past task", run.run.0, task.task.0)), &row);
        for report in content.results_of(attempt).filter_map(StoredResult::report) {
            show_report(ui, cx, &title, &report);
        }
    }
}

/// Readings with their units, and files, each of which opens in a tab of its own.
fn show_report(ui: &mut Ui, cx: &PanelContext<'_>, title: &str, report: &ActionReport) {
    let tokens = cx.tokens;
    for reading in &report.readings {
        fact(ui, tokens, &texts::reading_name(&reading.name), &texts::reading(reading));
    }
    for file in &report.files {
        let name = texts::open_file(&file.name, title);
        let text = texts::file(&file.name, file.bytes);
        if Button::new(&name).text(&text).icon(icon::EYE).left().wide(ui).show(ui, tokens).clicked() {
            let address = api::paths::BLOB_PATH.replace("{hash}", &file.blob.to_string());
            ui.ctx().open_url(egui::OpenUrl::new_tab(address));
        }
    }
}
