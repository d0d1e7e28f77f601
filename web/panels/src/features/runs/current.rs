//! The run under way: how far it is, the question that it asks, its tasks, and what can be asked of it; then the queue.

use super::lightbox::Lightbox;
use super::result_view::ResultView;
use super::results::{TaskOfRun, show_results};
use super::rows::{ResultRow, show_row};
use super::{look, texts};
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::theme::{self, Weight, font};
use crate::{format, icon, screens, widgets};
use client_model::{ClientCommand, RunEstimate};
use egui::{Id, Ui};
use site_model::{
    FailureStep, MissionCommandKind, QuestionAnswer, RunId, RunState, RunStatus, Site, TaskId, TaskState,
    TaskStatus,
};

/// What is shown of the run under way.
#[derive(Debug, Default)]
pub(super) struct CurrentRun {
    /// The task whose buttons are shown.
    open_task: Option<TaskId>,
    /// The run that shall be aborted, until that is confirmed.
    aborting: Option<RunId>,
}

impl CurrentRun {
    /// Takes back what is not confirmed. Returns whether there was anything.
    pub(super) fn cancel(&mut self) -> bool {
        self.aborting.take().is_some()
    }

    /// Shows the run, or how one is started.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        estimate: Option<&RunEstimate>,
        lightbox: &mut Lightbox,
    ) {
        let Some(status) = cx.model.runs.status() else {
            return widgets::remark(ui, cx.tokens, texts::LOADING);
        };
        let Some(site) = cx.model.site.site() else { return widgets::remark(ui, cx.tokens, texts::LOADING) };
        if let Some(monitor) = status.blocked_by {
            let monitor = site.monitors().find(|it| it.id == monitor).map(|it| it.name.as_str());
            let sentence = texts::blocked(monitor.unwrap_or(texts::DELETED_MONITOR));
            widgets::tinted_box(ui, cx.tokens, cx.tokens.warn, |ui| {
                widgets::sentence(ui, cx.tokens, &sentence);
            });
        }
        match cx.model.runs.current() {
            Some(run) => self.show_run(ui, cx, site, run, estimate, lightbox),
            None => show_start(ui, cx, site),
        }
        show_queue(ui, cx, site);
    }

    fn show_run(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        site: &Site,
        run: &RunStatus,
        estimate: Option<&RunEstimate>,
        lightbox: &mut Lightbox,
    ) {
        let tokens = cx.tokens;
        show_head(ui, cx, run, estimate);
        if let Some(task) = run.question.and_then(|asked| run.tasks.iter().find(|task| task.task == asked)) {
            show_question(ui, cx, site, run, task);
        }
        self.show_buttons(ui, cx, run);
        for (step, task) in (0..).zip(&run.tasks) {
            self.show_task(ui, cx, site, run, task, estimate);
            show_results_of(ui, cx, site, run, (step, task), lightbox);
        }
        if run.tasks.is_empty() {
            widgets::remark(ui, tokens, texts::NO_TASKS);
        }
    }

    /// Pause or resume, skip, cancel, abort.
    fn show_buttons(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, run: &RunStatus) {
        let tokens = cx.tokens;
        if self.aborting.is_some_and(|aborting| aborting == run.run) {
            cx.frame.is_escape_consumed = true;
            return self.show_confirmation(ui, cx, run.run);
        }
        let width = (0.5 * (ui.available_width() - 8.0)).floor();
        let is_ending = run.state == RunState::Ending;
        let active = run.tasks.iter().find(|task| is_active(task.state));
        let is_waiting = matches!(run.state, RunState::Paused | RunState::Suspended);
        let (name, sign, kind) = if is_waiting {
            (texts::RESUME, icon::PLAY, MissionCommandKind::Resume(run.run))
        } else {
            (texts::PAUSE, icon::PAUSE, MissionCommandKind::Pause(run.run))
        };
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 8.0;
            let pause = Button::new(name).icon(sign).kind(Kind::Primary).enabled(!is_ending);
            if pause.size(width, theme::TOUCH).slim().show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::Run(kind));
            }
            let skip = Button::new(texts::SKIP_TASK).icon(icon::SKIP_FORWARD);
            let skip = skip.enabled(active.is_some() && !is_ending).size(width, theme::TOUCH).slim();
            if skip.show(ui, tokens).clicked()
                && let Some(task) = active
            {
                cx.commands.push(ClientCommand::Run(MissionCommandKind::SkipTask(run.run, task.task)));
            }
        });
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 8.0;
            let cancel = Button::new(texts::CANCEL).hint(texts::CANCEL_HINT).enabled(!is_ending);
            if cancel.size(width, theme::TOUCH).slim().show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::Run(MissionCommandKind::Cancel(run.run)));
            }
            let abort = Button::new(texts::ABORT).kind(Kind::Danger).hint(texts::ABORT_HINT);
            if abort.size(width, theme::TOUCH).slim().show(ui, tokens).clicked() {
                self.aborting = Some(run.run);
            }
        });
    }

    fn show_confirmation(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, run: RunId) {
        let tokens = cx.tokens;
        widgets::tinted_box(ui, tokens, tokens.bad, |ui| {
            widgets::sentence(ui, tokens, texts::ABORT_QUESTION);
            if Button::new(texts::ABORT_NOW).kind(Kind::Danger).wide(ui).show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::Run(MissionCommandKind::Abort(run)));
                self.aborting = None;
            }
            if Button::new(texts::GO_ON).wide(ui).show(ui, tokens).clicked() {
                self.aborting = None;
            }
        });
    }

    fn show_task(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        site: &Site,
        run: &RunStatus,
        task: &TaskStatus,
        estimate: Option<&RunEstimate>,
    ) {
        let tokens = cx.tokens;
        let title = look::task_name(site, run.mission, task);
        let facts = texts::task_facts(&look::action_name(task), task);
        let state = texts::task_state(task.state);
        let time = task_time(cx, task, estimate);
        let name = texts::task_row(&title, state);
        let is_selected = self.open_task == Some(task.task);
        let row = ResultRow {
            name: &name,
            title: &title,
            facts: &facts,
            state,
            time: &time,
            look: look::of_task(tokens, task.state),
            is_selected,
        };
        let response = show_row(ui, tokens, Id::unique(("task of run", run.run.0, task.task.0)), &row);
        if response.on_hover_text(&facts).clicked() {
            self.open_task = (!is_selected).then_some(task.task);
        }
        if is_selected {
            show_task_buttons(ui, cx, run, task, &title);
        }
    }
}

/// What the last attempt of a task has gathered. It is shown as soon as the robot has stored it.
fn show_results_of(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    site: &Site,
    run: &RunStatus,
    (step, task): (u32, &TaskStatus),
    lightbox: &mut Lightbox,
) {
    let Some(Ok(content)) = cx.model.runs.content(run.run) else { return };
    let (title, action) = (look::task_name(site, run.mission, task), look::action_name(task));
    let task_of_run = TaskOfRun { run: run.run, mission: run.mission, title: &title, action: &action };
    let results = content.results.iter();
    let results = results.filter(|result| result.step == step && result.attempt == task.attempt);
    show_results(ui, cx, &task_of_run, results, lightbox);
}

/// The run in short, for a card of several features: how far it is, what the robot is busy with, and what it has seen last.
pub(super) fn show_summary(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    run: &RunStatus,
    estimate: Option<&RunEstimate>,
    lightbox: &mut Lightbox,
) {
    let tokens = cx.tokens;
    show_head(ui, cx, run, estimate);
    let active = run.tasks.iter().find(|task| is_active(task.state));
    if let (Some(task), Some(site)) = (active, cx.model.site.site()) {
        let title = look::task_name(site, run.mission, task);
        let facts = texts::task_facts(&look::action_name(task), task);
        let state = texts::task_state(task.state);
        let row = ResultRow {
            name: &texts::task_row(&title, state),
            title: &title,
            facts: &facts,
            state,
            time: &task_time(cx, task, estimate),
            look: look::of_task(tokens, task.state),
            is_selected: false,
        };
        if show_row(ui, tokens, Id::unique(("active task", run.run.0)), &row).clicked() {
            cx.commands.push(ClientCommand::ShowScreen(screens::RUNS));
        }
    }
    if let Some(site) = cx.model.site.site() {
        show_newest(ui, cx, site, run, lightbox);
    }
    if Button::new(texts::SHOW_RUN).wide(ui).show(ui, tokens).clicked() {
        cx.commands.push(ClientCommand::ShowScreen(screens::RUNS));
    }
    ui.add_space(8.0);
    widgets::rule(ui, tokens);
}

/// The newest picture or spectrum of the run, with its age. A press shows it large.
fn show_newest(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    site: &Site,
    run: &RunStatus,
    lightbox: &mut Lightbox,
) {
    let Some(Ok(content)) = cx.model.runs.content(run.run) else { return };
    let newest = content.results.iter().rev().find_map(|result| {
        let task = run.tasks.get(usize::try_from(result.step).ok()?)?;
        ResultView::of("", "", result).map(|_| (result, task))
    });
    let Some((result, task)) = newest else { return };
    let (title, action) = (look::task_name(site, run.mission, task), look::action_name(task));
    let age_s = cx.clock.utc.0.saturating_sub(result.at.0) as f64 * 1e-9;
    let of_run = TaskOfRun { run: run.run, mission: run.mission, title: &title, action: &action };
    widgets::remark(ui, cx.tokens, &texts::newest(&title, &action, age_s.max(0.0)));
    show_results(ui, cx, &of_run, std::iter::once(result), lightbox);
    if lightbox.is_open() {
        cx.commands.push(ClientCommand::ShowScreen(screens::RUNS));
    }
}

/// Whether the robot is busy with a task in this state.
fn is_active(state: TaskState) -> bool {
    matches!(state, TaskState::Navigating | TaskState::Running | TaskState::Paused | TaskState::Retriable)
}

/// Name, state, progress, and the time that is left.
fn show_head(ui: &mut Ui, cx: &PanelContext<'_>, run: &RunStatus, estimate: Option<&RunEstimate>) {
    let tokens = cx.tokens;
    let name = look::mission_name(cx.model, run.mission);
    let text = egui::RichText::new(&name).font(font(theme::LARGE, Weight::SemiBold)).color(tokens.text);
    ui.add(egui::Label::new(text).truncate());
    let done = run.tasks.iter().filter(|task| task.state.is_outcome()).count();
    let remaining_s = estimate.map(|estimate| estimate.remaining_s(run, cx.model.runs.route()));
    let remaining_s = remaining_s.filter(|_| run.state != RunState::Ending);
    let progress = texts::progress(done, run.tasks.len(), remaining_s);
    let state_look = look::of_run(tokens, run.state);
    widgets::status_line(
        ui,
        texts::PROGRESS,
        &progress,
        &[
            (state_look.sign, theme::ICON, Weight::Regular, state_look.colour),
            (texts::run_state(run.state), theme::BODY, Weight::Medium, state_look.colour),
            (&progress, theme::BODY, Weight::Regular, tokens.text),
        ],
    );
    widgets::progress_bar(ui, tokens, done as f32 / run.tasks.len().max(1) as f32);
    if let Some(sentence) = texts::run_sentence(run) {
        widgets::remark(ui, tokens, sentence);
    }
    if let Some(wait) = cx.model.runs.route().route.as_ref().and_then(|route| route.waits_for.as_ref()) {
        widgets::remark(ui, tokens, &texts::route_wait(wait));
    }
}

/// The time that a task took or takes.
fn task_time(cx: &PanelContext<'_>, task: &TaskStatus, estimate: Option<&RunEstimate>) -> String {
    let route = &cx.model.runs.route().route;
    match (task.state, route) {
        (TaskState::Navigating, Some(route)) => texts::navigating(route.remaining_m, route.remaining_s),
        (state, _) if state.is_outcome() => String::new(),
        _ => estimate
            .and_then(|estimate| estimate.tasks_s.get(&task.task))
            .map_or_else(String::new, |time_s| format::elapsed(*time_s)),
    }
}

/// What can be asked of a task.
fn show_task_buttons(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    run: &RunStatus,
    task: &TaskStatus,
    title: &str,
) {
    let tokens = cx.tokens;
    if let Some(failure) = &task.failure {
        widgets::sentence(ui, tokens, &missions::task_failure(failure));
    }
    let (name, text, sign, kind) = if task.state.is_outcome() {
        let kind = MissionCommandKind::RedoTask(run.run, task.task);
        (texts::redo_named(title), texts::REDO_TASK, icon::ARROW_COUNTER_CLOCKWISE, kind)
    } else {
        let kind = MissionCommandKind::SkipTask(run.run, task.task);
        (texts::skip_named(title), texts::SKIP_TASK, icon::SKIP_FORWARD, kind)
    };
    let button = Button::new(&name).text(text).icon(sign).enabled(run.state != RunState::Ending);
    if button.wide(ui).show(ui, tokens).clicked() {
        cx.commands.push(ClientCommand::Run(kind));
    }
}

/// The question what becomes of a task.
fn show_question(ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, run: &RunStatus, task: &TaskStatus) {
    let tokens = cx.tokens;
    let title = look::task_name(site, run.mission, task);
    let failure = task.failure.as_ref().map(missions::task_failure).unwrap_or_default();
    let listed = site
        .mission(run.mission)
        .and_then(|mission| mission.tasks.iter().find(|listed| listed.id == task.task));
    let policies = listed.map(|listed| [listed.on_unreachable.then, listed.on_action_failure.then]);
    let limit = policies.into_iter().flatten().find_map(|then| match then {
        FailureStep::Ask { time_limit, default } => Some((time_limit.secs_f64(), default)),
        _ => None,
    });
    widgets::tinted_box(ui, tokens, tokens.warn, |ui| {
        widgets::sentence(ui, tokens, &texts::question(&title, &failure));
        if let Some((limit_s, default)) = limit {
            widgets::remark(ui, tokens, &texts::question_limit(limit_s, default));
        }
        for (name, answer) in [
            (texts::TRY_AGAIN, QuestionAnswer::TryAgain),
            (texts::SKIP_IT, QuestionAnswer::Skip),
            (texts::END_AT_DOCK, QuestionAnswer::EndAtDock),
            (texts::END_HERE, QuestionAnswer::EndHere),
        ] {
            let kind = if answer == QuestionAnswer::TryAgain { Kind::Primary } else { Kind::Plain };
            if Button::new(name).kind(kind).wide(ui).show(ui, tokens).clicked() {
                let asked = MissionCommandKind::Answer(run.run, task.task, answer);
                cx.commands.push(ClientCommand::Run(asked));
            }
        }
    });
}

/// What to do while nothing runs.
fn show_start(ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site) {
    let tokens = cx.tokens;
    widgets::head(ui, tokens, texts::NOTHING_HEAD);
    if site.missions().next().is_none() {
        return widgets::sentence(ui, tokens, texts::NO_MISSIONS);
    }
    widgets::sentence(ui, tokens, texts::NOTHING_RUNS);
    for mission in site.missions() {
        let name = texts::start(&mission.name);
        let start = Button::new(&name).icon(icon::PLAY).left().enabled(!mission.tasks.is_empty());
        if start.wide(ui).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::StartMission { mission: mission.id, is_queued: false });
        }
    }
}

/// Runs that wait for their turn.
fn show_queue(ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site) {
    let tokens = cx.tokens;
    let waiting: Vec<&RunStatus> = cx.model.runs.queue().collect();
    if waiting.is_empty() {
        return;
    }
    widgets::section_head(ui, tokens, texts::QUEUE_HEAD);
    for run in waiting {
        let mission = look::mission_name(cx.model, run.mission);
        let cause = texts::cause(site, &run.cause);
        let name = texts::remove_from_queue(&mission);
        ui.horizontal(|ui| {
            let room = ui.available_width() - theme::TOUCH - 8.0;
            ui.vertical(|ui| {
                ui.set_width(room);
                ui.spacing_mut().item_spacing.y = 2.0;
                let text = egui::RichText::new(&mission).font(font(theme::BODY, Weight::Medium));
                ui.add(egui::Label::new(text.color(tokens.text)).truncate());
                widgets::remark(ui, tokens, &cause);
            });
            let button = Button::icon_only(&name, icon::X).kind(Kind::Quiet);
            if button.show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::Run(MissionCommandKind::Cancel(run.run)));
            }
        });
    }
}
