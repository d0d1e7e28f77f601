//! Runs of missions: the one under way with its tasks, the queue, and those that have ended.

mod current;
mod filter;
mod history;
mod lightbox;
mod look;
mod pane;
mod picture_paint;
mod picture_view;
mod picture_warp;
mod result_view;
mod results;
mod rows;
mod spectrum;
#[cfg(test)]
mod tests;
mod texts;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::features::tabs;
use crate::message::show_message;
use crate::{icon, screens};
use client_model::{ClientCommand, RunEstimate, estimate_run};
use current::CurrentRun;
use egui::{Context, Ui};
use history::RunHistory;
use lightbox::Lightbox;
use site_model::RunId;

pub(crate) use pane::{
    CommonAxes, Pane, ReadNeedle, follow, halves, paint_ground, paint_pane, show_caption, show_pane,
    split_caption,
};
pub(crate) use picture_paint::show_note;
pub(crate) use picture_view::{PictureView, place_of_px, px_at};
pub(crate) use picture_warp::ChangeFrames;
pub(crate) use result_view::viewable;
pub(crate) use results::paint_file;
pub(crate) use texts::{date_and_time, difference, outside, reading, reading_name, skip_reason};

/// The tab of the run under way.
const CURRENT: Tab = Tab { screen: screens::RUNS, name: texts::CURRENT_TAB, scrolls: true, row_spacing: 8.0 };
/// The tab of runs that have ended.
const HISTORY: Tab = Tab { screen: screens::RUNS, name: texts::HISTORY_TAB, scrolls: true, row_spacing: 8.0 };

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct RunsPanel {
    current: CurrentRun,
    history: RunHistory,
    lightbox: Lightbox,
    /// What the run under way takes, with the run, the revision of the site and the number of blocked edges that it was computed for.
    estimate: Option<((RunId, u64, usize), Option<RunEstimate>)>,
}

impl FeaturePanel for RunsPanel {
    fn update(&mut self, ctx: &Context, cx: &mut PanelContext<'_>) {
        self.lightbox.update(ctx, cx);
        let model = cx.model;
        let (Some(run), Some(site)) = (model.runs.current(), model.site.site()) else { return };
        let now = model.connection().clock().stamp_at(model.now());
        let computed_for = (run.run, model.site.revision(), model.site.blocks_now(now).len());
        if self.estimate.as_ref().is_none_or(|(of, _)| *of != computed_for) {
            self.estimate = Some((computed_for, estimate_run(site, run, now)));
        }
    }

    fn cancel(&mut self, _cx: &mut PanelContext<'_>) -> bool {
        self.lightbox.close() || self.current.cancel()
    }

    fn show_card(&mut self, ctx: &Context, cx: &mut PanelContext<'_>) {
        self.lightbox.show(ctx, cx);
    }

    /// A question is asked on every screen, because the run waits for its answer.
    fn show_messages(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let model = cx.model;
        let Some(run) = model.runs.current().filter(|run| run.question.is_some()) else { return };
        if cx.screen() == screens::RUNS {
            return;
        }
        let sentence = texts::question_elsewhere(&look::mission_name(model, run.mission));
        let (tokens, commands) = (cx.tokens, &mut *cx.commands);
        show_message(ui, tokens, tokens.warn, icon::QUESTION, &sentence, |ui| {
            if Button::new(texts::ANSWER).kind(Kind::Primary).show(ui, tokens).clicked() {
                commands.push(ClientCommand::ShowScreen(screens::RUNS));
            }
        });
    }

    fn tabs(&self) -> &'static [Tab] {
        &[tabs::ROBOT, CURRENT, HISTORY]
    }

    fn show_section(&mut self, tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        if tab == HISTORY {
            return self.history.show(ui, cx, &mut self.lightbox);
        }
        let run = cx.model.runs.current();
        let of_run = self.estimate.as_ref().filter(|((of, ..), _)| run.is_some_and(|run| run.run == *of));
        let estimate = of_run.and_then(|(.., estimate)| estimate.as_ref());
        match run {
            Some(run) if tab == tabs::ROBOT => {
                current::show_summary(ui, cx, run, estimate, &mut self.lightbox)
            }
            None if tab == tabs::ROBOT => {}
            Some(_) => self.current.show(ui, cx, estimate, &mut self.lightbox),
            None => {
                self.current.show(ui, cx, estimate, &mut self.lightbox);
                self.history.show_last(ui, cx, &mut self.lightbox);
            }
        }
    }
}
