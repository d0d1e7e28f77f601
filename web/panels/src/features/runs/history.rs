//! Runs that have ended.

use super::filter::Filter;
use super::rows::{Row, show_row};
use super::{look, texts};
use crate::feature_panel::PanelContext;
use crate::widgets;
use client_model::PastRun;
use egui::{Id, Ui};
use missions::SiteZone;
use site_model::{RunId, Site};

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

    fn show_run(&mut self, ui: &mut Ui, cx: &PanelContext<'_>, site: &Site, run: &PastRun<'_>) {
        let tokens = cx.tokens;
        let title = look::mission_name(cx.model, run.mission);
        let outcome = texts::run_state(run.outcome);
        let began = run.report.and_then(|report| report.began).map(|began| {
            let zone = site.settings().map_or("UTC", |settings| settings.time_zone.as_str());
            SiteZone::new(zone).unwrap_or_else(|_| SiteZone::utc()).to_local(began)
        });
        let facts = texts::past_facts(site, run.report, began);
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
        }
        if !is_open {
            return;
        }
        match run.report {
            None => widgets::remark(ui, tokens, texts::NOT_SEEN),
            Some(report) => {
                for task in &report.tasks {
                    let title = look::task_name(site, report, task);
                    let state = texts::task_state(task.state);
                    let name = texts::task_row(&title, state);
                    let facts = texts::task_facts(&look::action_name(task), task);
                    let row = Row {
                        name: &name,
                        title: &title,
                        facts: &facts,
                        state,
                        time: "",
                        look: look::of_task(tokens, task.state),
                        is_selected: false,
                    };
                    show_row(ui, tokens, Id::unique(("past task", run.run.0, task.task.0)), &row)
                        .on_hover_text(&facts);
                }
            }
        }
    }
}
