//! The history of an inspection point: a time line of its results, the two that are compared, the gauge in its photos, its readings over time, and all of it as a table.

mod alignment;
mod chooser;
mod chosen;
mod compare;
mod gauge_draft;
mod gauge_editor;
mod plot;
mod readings;
mod side;
mod strip;
#[cfg(test)]
mod tests;
mod texts;
mod time_axis;

use crate::button::Button;
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::{icon, screens, widgets};
use client_model::{ClientCommand, PointHistoryCommand};
use compare::Comparison;
use egui::{Context, Ui};
use gauge_editor::GaugeEditor;
use strip::{Strip, ask};

/// The tab of the history of a point.
const POINTS: Tab = Tab { screen: screens::RUNS, name: texts::TAB, scrolls: true, row_spacing: 8.0 };

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct PointHistoryPanel {
    /// How often a history was opened when this panel looked last.
    opened: u64,
    strip: Strip,
    comparison: Comparison,
    gauge: GaugeEditor,
}

impl FeaturePanel for PointHistoryPanel {
    fn update(&mut self, _ctx: &Context, cx: &mut PanelContext<'_>) {
        let opened = cx.model.point_history.opened();
        if std::mem::replace(&mut self.opened, opened) != opened {
            cx.frame.open_tab(POINTS);
            if cx.screen() != screens::RUNS {
                cx.commands.push(ClientCommand::ShowScreen(screens::RUNS));
            }
        }
        self.comparison.update(cx);
        self.gauge.update(cx);
    }

    fn cancel(&mut self, _cx: &mut PanelContext<'_>) -> bool {
        self.gauge.close() || self.comparison.close()
    }

    fn show_card(&mut self, ctx: &Context, cx: &mut PanelContext<'_>) {
        if let Some(zone) = cx.model.point_history.zone() {
            self.comparison.show(ctx, cx, zone);
        }
        self.gauge.show(ctx, cx);
    }

    fn tabs(&self) -> &'static [Tab] {
        &[POINTS]
    }

    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let (model, tokens) = (cx.model, cx.tokens);
        widgets::section_head(ui, tokens, texts::HEAD);
        let Some(site) = model.site.site() else { return widgets::remark(ui, tokens, texts::LOADING) };
        chooser::show(ui, cx, site);
        let history = &model.point_history;
        let (Some(_), Some(zone)) = (history.point(), history.zone()) else { return };
        show_problem(ui, cx);
        if history.results().is_empty() {
            let sentence = if history.is_fetching() { texts::FETCHING } else { texts::EMPTY };
            if history.problem().is_none() {
                widgets::remark(ui, tokens, sentence);
            }
            return;
        }
        widgets::choice(ui, tokens, &texts::SPANS, history.span(), |span| {
            ask(cx, PointHistoryCommand::ShowSpan(span));
        });
        self.strip.show(ui, cx, zone, "card");
        widgets::remark(ui, tokens, &texts::extent(history.results().len(), history.is_whole()));
        chosen::show(ui, cx, zone, &mut self.comparison);
        gauge_editor::show_section(ui, cx, &mut self.gauge);
        readings::show(ui, cx, zone);
        widgets::remark(ui, tokens, texts::STRIP_REMARK);
        show_export(ui, cx);
    }
}

/// Why results could not be fetched, with the button that tries again.
fn show_problem(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let Some(sentence) = cx.model.point_history.problem() else { return };
    let tokens = cx.tokens;
    widgets::tinted_box(ui, tokens, tokens.warn, |ui| {
        widgets::sentence(ui, tokens, sentence);
        if Button::new(texts::RETRY).icon(icon::ARROW_COUNTER_CLOCKWISE).wide(ui).show(ui, tokens).clicked() {
            ask(cx, PointHistoryCommand::Retry);
        }
    });
}

/// The button that saves everything, and how far that is.
fn show_export(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let (history, tokens) = (&cx.model.point_history, cx.tokens);
    if !history.is_exporting() {
        let save = Button::new(texts::EXPORT).icon(icon::DOWNLOAD_SIMPLE).hint(texts::EXPORT_HINT);
        if save.wide(ui).show(ui, tokens).clicked() {
            ask(cx, PointHistoryCommand::Export);
        }
        return;
    }
    widgets::remark(ui, tokens, &texts::fetched(history.results().len()));
    if Button::new(texts::CANCEL_EXPORT).icon(icon::X).wide(ui).show(ui, tokens).clicked() {
        ask(cx, PointHistoryCommand::CancelExport);
    }
}
