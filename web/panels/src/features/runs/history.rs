//! Runs that have ended, and slots of schedules that had none.

use super::filter::Filter;
use super::lightbox::Lightbox;
use super::look::StateStyle;
use super::results::{TaskOfRun, show_results};
use super::rows::{ResultRow, show_row};
use super::{look, texts};
use crate::button::Button;
use crate::feature_panel::PanelContext;
use crate::widgets;
use crate::{format, icon, screens, theme};
use client_model::{ClientCommand, PastRun, RunContent, ScheduleSelection, StoredSlot};
use egui::{Id, Ui};
use missions::SiteZone;
use site_model::{RunId, Site, SkipReason, Utc};

/// Parts of the room for the buttons of the archive, the report and the MCAP file. Chosen: as their texts need.
const FILE_SHARES: [f32; 3] = [0.4, 0.31, 0.29];
/// Nanoseconds of seven days.
const WEEK_NS: i64 = 7 * 24 * 3_600_000_000_000;

/// What is shown of ended runs.
#[derive(Debug, Default)]
pub(super) struct RunHistory {
    filter: Filter,
    open: Option<RunId>,
}

/// An entry of the list.
enum Entry<'a> {
    Run(PastRun<'a>),
    Slot(&'a StoredSlot, SkipReason),
}

impl RunHistory {
    /// Shows the list.
    pub(super) fn show(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, lightbox: &mut Lightbox) {
        let (model, tokens) = (cx.model, cx.tokens);
        let Some(site) = model.site.site() else { return widgets::remark(ui, tokens, texts::LOADING) };
        let zone = site.settings().map_or("UTC", |settings| settings.time_zone.as_str());
        let zone = SiteZone::new(zone).unwrap_or_else(|_| SiteZone::utc());
        self.filter.show(ui, cx, site, &zone);
        if self.filter.has_runs() {
            show_week_report(ui, cx);
        }
        let entries = self.entries(cx, site, &zone);
        if let Some(sentence) = model.runs.list_problem() {
            widgets::tinted_box(ui, tokens, tokens.warn, |ui| widgets::sentence(ui, tokens, sentence));
        } else if entries.is_empty() && !model.runs.is_listed() {
            widgets::remark(ui, tokens, texts::FETCHING_LIST);
        } else if entries.is_empty() {
            widgets::remark(ui, tokens, texts::NO_PAST_RUNS);
        }
        for entry in entries {
            match entry {
                Entry::Run(run) => self.show_run(ui, cx, site, &zone, &run, lightbox),
                Entry::Slot(slot, reason) => show_slot(ui, cx, site, &zone, slot, reason),
            }
        }
        if self.filter.has_runs()
            && model.runs.has_older()
            && Button::new(texts::OLDER).wide(ui).show(ui, tokens).clicked()
        {
            cx.commands.push(ClientCommand::ListOlderRuns);
        }
    }

    /// Shows the run that has ended last, where nothing else is shown.
    pub(super) fn show_last(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, lightbox: &mut Lightbox) {
        let Some(site) = cx.model.site.site() else { return };
        let zone = site.settings().map_or("UTC", |settings| settings.time_zone.as_str());
        let zone = SiteZone::new(zone).unwrap_or_else(|_| SiteZone::utc());
        let last = self.entries(cx, site, &zone).into_iter().find_map(|entry| match entry {
            Entry::Run(run) => Some(run),
            Entry::Slot(..) => None,
        });
        if let Some(last) = last {
            widgets::section_head(ui, cx.tokens, texts::LAST_HEAD);
            self.show_run(ui, cx, site, &zone, &last, lightbox);
        }
    }

    /// Runs and slots that are listed, the newest first.
    fn entries<'a>(&self, cx: &PanelContext<'a>, site: &Site, zone: &SiteZone) -> Vec<Entry<'a>> {
        let runs = &cx.model.runs;
        let listed: Vec<PastRun<'a>> = runs.past().filter(|_| self.filter.has_runs()).collect();
        // Slots before the oldest run that is listed belong to a later page.
        let oldest = listed.iter().filter_map(|run| run.began).min().filter(|_| runs.has_older());
        let query = self.filter.query(zone);
        let skipped = runs.decided_slots().iter().filter_map(|slot| {
            let mission = site.schedule(slot.schedule).map(|schedule| schedule.mission);
            let is_listed = self.filter.has_slot(&query, mission, slot.due)
                && oldest.is_none_or(|oldest| slot.due >= oldest);
            Some(Entry::Slot(slot, slot.skipped().filter(|_| is_listed)?))
        });
        let mut entries: Vec<Entry<'a>> = listed.into_iter().map(Entry::Run).chain(skipped).collect();
        // One that has just ended, and of which the time is not known yet, is the newest.
        let time = |entry: &Entry<'_>| match entry {
            Entry::Run(run) => run.began.unwrap_or(Utc(i64::MAX)),
            Entry::Slot(slot, _) => slot.due,
        };
        entries.sort_by_key(|entry| std::cmp::Reverse(time(entry)));
        entries
    }

    fn show_run(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        site: &Site,
        zone: &SiteZone,
        run: &PastRun<'_>,
        lightbox: &mut Lightbox,
    ) {
        let tokens = cx.tokens;
        let title = look::mission_name(cx.model, run.mission);
        let outcome = texts::run_state(run.outcome);
        let facts = texts::past_facts(site, run, run.began.map(|began| zone.to_local(began)));
        let name = texts::past_row(&title, outcome, &facts);
        let is_open = self.open == Some(run.run);
        let row = ResultRow {
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
            Some(Ok(content)) => show_content(ui, cx, site, run, content, lightbox),
            Some(Err(sentence)) => widgets::tinted_box(ui, tokens, tokens.warn, |ui| {
                widgets::sentence(ui, tokens, sentence);
            }),
            None => widgets::remark(ui, tokens, texts::FETCHING),
        }
        show_files(ui, cx, run.run);
    }
}

/// The buttons that fetch files of a run.
fn show_files(ui: &mut Ui, cx: &PanelContext<'_>, run: RunId) {
    let files = [
        (texts::DOWNLOAD, icon::DOWNLOAD_SIMPLE, api::paths::RUN_DOWNLOAD_PATH),
        (texts::REPORT, icon::LIST_CHECKS, api::paths::RUN_REPORT_PATH),
        (texts::MCAP, icon::DOWNLOAD_SIMPLE, api::paths::RUN_MCAP_PATH),
    ];
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        let room = ui.available_width() - 16.0;
        for ((file, icon, path), share) in files.into_iter().zip(FILE_SHARES) {
            let button = Button::new(file.name).text(file.short).icon(icon).hint(file.hint);
            if button.size((share * room).floor(), theme::TOUCH).slim().show(ui, cx.tokens).clicked() {
                fetch_file(ui, path.replace("{run}", &run.to_string()));
            }
        }
    });
}

/// The button that fetches the report of all runs of the last seven days.
fn show_week_report(ui: &mut Ui, cx: &PanelContext<'_>) {
    let report = Button::new(texts::WEEK_REPORT).icon(icon::LIST_CHECKS).hint(texts::REPORT_HINT);
    if report.wide(ui).show(ui, cx.tokens).clicked() {
        let to_ns = cx.clock.utc.0;
        let from_ns = to_ns.saturating_sub(WEEK_NS);
        fetch_file(ui, format!("{}?from_ns={from_ns}&to_ns={to_ns}", api::paths::REPORT_PATH));
    }
}

/// Fetches a file in a tab of its own, which the browser closes again, so that an error does not replace this page.
fn fetch_file(ui: &Ui, address: String) {
    ui.ctx().open_url(egui::OpenUrl::new_tab(address));
}

/// A slot of a schedule that had no run, and why. A press shows it on the Schedule screen.
fn show_slot(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    site: &Site,
    zone: &SiteZone,
    slot: &StoredSlot,
    reason: SkipReason,
) {
    let schedule = site.schedule(slot.schedule);
    let mission = schedule.map(|schedule| look::mission_name(cx.model, schedule.mission));
    let title = mission.unwrap_or_else(|| texts::DELETED_MISSION.to_owned());
    let at = slot.slot().unwrap_or_else(|| zone.to_local(slot.due));
    let name = schedule.map_or(texts::DELETED_SCHEDULE, |schedule| schedule.name.as_str());
    let count = slot.details.count.unwrap_or(1);
    let facts = texts::skipped_facts(Some(at), name, &texts::skip_reason(site, reason), count);
    let state = if reason == SkipReason::Missed { texts::MISSED } else { texts::SKIPPED };
    let row = ResultRow {
        name: &texts::past_row(&title, state, &facts),
        title: &title,
        facts: &facts,
        state,
        time: "",
        look: StateStyle { colour: cx.tokens.warn, sign: icon::SKIP_FORWARD, is_filled: false },
        is_selected: false,
    };
    let id = Id::unique(("skipped slot", slot.schedule.0, slot.due.0));
    if show_row(ui, cx.tokens, id, &row).on_hover_text(&facts).clicked() && schedule.is_some() {
        let selection = ScheduleSelection { schedule: slot.schedule, slot: Some(at) };
        cx.commands.push(ClientCommand::ShowScreen(screens::SCHEDULE));
        cx.commands.push(ClientCommand::ShowWeek(Some(at.date)));
        cx.commands.push(ClientCommand::SelectSchedule(Some(selection)));
    }
}

/// The last attempt of each task, and the actions on the way, with what was gathered.
fn show_content(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    site: &Site,
    run: &PastRun<'_>,
    content: &RunContent,
    lightbox: &mut Lightbox,
) {
    let tokens = cx.tokens;
    if content.attempts.is_empty() {
        widgets::remark(ui, tokens, texts::NO_ATTEMPTS);
    }
    for attempt in content.last_attempts() {
        let task = look::status_of(attempt);
        let title = look::attempt_name(site, run.mission, attempt);
        let state = texts::task_state(task.state);
        let duration_s = attempt.done.map(|done| (done.0 - attempt.intended.0) as f64 * 1e-9);
        let action = look::action_name(&task);
        let facts = texts::task_facts(&action, &task);
        let row = ResultRow {
            name: &texts::task_row(&title, state),
            title: &title,
            facts: &facts,
            state,
            time: &duration_s.map(format::elapsed).unwrap_or_default(),
            look: look::of_task(tokens, task.state),
            is_selected: false,
        };
        show_row(ui, tokens, Id::unique(("past task", run.run.0, attempt.step)), &row);
        let task = TaskOfRun { run: run.run, mission: run.mission, title: &title, action: &action };
        show_results(ui, cx, &task, content.results_of(attempt), lightbox);
    }
}
