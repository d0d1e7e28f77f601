//! When missions run: the week as a grid or a list, the missions that can be dragged into it, and the schedule that is open.

mod agenda;
mod drag;
mod fields;
mod form;
mod grid;
mod list;
mod next_run;
mod occurrence;
mod plan_cache;
mod question;
mod recurrence_form;
mod state;
#[cfg(test)]
mod tests;
mod texts;
mod week;
mod week_paint;
mod when_texts;

pub(crate) use fields::{parse_date, parse_time};
pub(crate) use next_run::next_run_status;
pub(crate) use state::SchedulePanel;
pub(crate) use when_texts::time as shown_time;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::theme::{self, Weight, font};
use crate::{Width, icon, layout, screens, widgets};
use client_model::ClientCommand;
use egui::{Context, Key, Ui};
use missions::{date_of, day_number};
use plan_cache::CachedPlan;
use state::PlanView;

/// The tab of schedules.
const SCHEDULE: Tab = Tab { screen: screens::SCHEDULE, name: texts::TAB, scrolls: true, row_spacing: 8.0 };

impl FeaturePanel for SchedulePanel {
    fn update(&mut self, ctx: &Context, cx: &mut PanelContext<'_>) {
        self.next_run.update(cx);
        if cx.screen() != screens::SCHEDULE {
            self.drag = None;
            self.question = None;
            return;
        }
        if let Some(site) = cx.model.site.site() {
            let revision = cx.model.site.revision();
            CachedPlan::update(&mut self.plan, site, revision, cx.clock, cx.model.schedule.week());
        }
        if self.drag.is_some() && ctx.input(|input| input.key_pressed(Key::Escape)) {
            self.drag = None;
        }
    }

    fn show_card(&mut self, ctx: &Context, cx: &mut PanelContext<'_>) {
        if cx.screen() != screens::SCHEDULE || cx.is_covered_by_sheet() {
            return;
        }
        // Whether or not Escape has just ended a drag, it was meant for that.
        cx.frame.is_escape_consumed |= self.drag.is_some();
        let (tokens, rect) = (cx.tokens, cx.layout.free);
        layout::card(ctx, tokens, texts::CARD, rect, |ui| self.show_plan(ui, cx));
        self.show_question(ctx, cx);
    }

    fn tabs(&self) -> &'static [Tab] {
        &[SCHEDULE]
    }

    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let Some(plan) = self.plan.take() else { return widgets::remark(ui, cx.tokens, texts::LOADING) };
        if let Some(site) = cx.model.site.site() {
            let open = cx.model.schedule.selection().filter(|open| site.schedule(open.schedule).is_some());
            match open {
                Some(open) => self.show_form(ui, cx, &plan, site, open),
                None => self.show_lists(ui, cx, &plan, site),
            }
        }
        self.plan = Some(plan);
    }
}

impl SchedulePanel {
    fn show_plan(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let Some(plan) = self.plan.take() else { return widgets::remark(ui, cx.tokens, texts::LOADING) };
        if let Some(site) = cx.model.site.site() {
            self.show_head(ui, cx, &plan);
            // Seven days side by side need a window that is not narrow.
            let view = if cx.layout.width == Width::Narrow { PlanView::Agenda } else { self.view };
            match view {
                PlanView::Week => self.show_week(ui, cx, &plan, site),
                PlanView::Agenda => self.show_agenda(ui, cx, &plan, site),
            }
        }
        self.plan = Some(plan);
    }

    /// The row above grid and list: which week, how it is shown, and the time.
    fn show_head(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, plan: &CachedPlan) {
        let tokens = cx.tokens;
        ui.horizontal(|ui| {
            if self.view == PlanView::Week && cx.layout.width != Width::Narrow {
                show_weeks(ui, cx, plan);
            }
            show_undo(ui, cx);
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let views = [(texts::AGENDA, PlanView::Agenda), (texts::WEEK, PlanView::Week)];
                for (name, view) in views.into_iter().filter(|_| cx.layout.width != Width::Narrow) {
                    let button = Button::new(name).on(self.view == view).size(80.0, theme::TOUCH).slim();
                    if button.show(ui, tokens).clicked() {
                        self.view = view;
                    }
                }
                show_clocks(ui, cx, plan);
            });
        });
        if !plan.is_zone_known {
            widgets::tinted_box(ui, tokens, tokens.warn, |ui| {
                widgets::sentence(ui, tokens, &texts::unknown_zone(&plan.zone_name));
            });
        }
    }
}

/// The buttons that show another week, and which one is shown.
fn show_weeks(ui: &mut Ui, cx: &mut PanelContext<'_>, plan: &CachedPlan) {
    let tokens = cx.tokens;
    let monday = day_number(plan.week);
    for (name, sign, days) in
        [(texts::EARLIER_WEEK, icon::CARET_LEFT, -7), (texts::LATER_WEEK, icon::CARET_RIGHT, 7)]
    {
        if Button::icon_only(name, sign).kind(Kind::Quiet).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::ShowWeek(Some(date_of(monday + days))));
        }
    }
    if Button::new(texts::THIS_WEEK).slim().size(88.0, theme::TOUCH).show(ui, tokens).clicked() {
        cx.commands.push(ClientCommand::ShowWeek(None));
    }
    let range = texts::week(plan.week, plan.day(6));
    let text = egui::RichText::new(range).font(font(theme::HEAD, Weight::SemiBold)).color(tokens.text);
    if cx.layout.width != Width::Narrow {
        ui.add(egui::Label::new(text).truncate());
    }
}

/// The buttons of undo and redo.
fn show_undo(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    for (name, sign, is_possible, command) in [
        (texts::UNDO, icon::ARROW_BEND_UP_LEFT, cx.model.site.can_undo(), ClientCommand::Undo),
        (texts::REDO, icon::ARROW_BEND_UP_RIGHT, cx.model.site.can_redo(), ClientCommand::Redo),
    ] {
        let button = Button::icon_only(name, sign).kind(Kind::Quiet).enabled(is_possible);
        if button.show(ui, cx.tokens).clicked() {
            cx.commands.push(command);
        }
    }
}

/// The time at the site, and the operator's where it differs. From right to left.
fn show_clocks(ui: &mut Ui, cx: &PanelContext<'_>, plan: &CachedPlan) {
    if cx.layout.width == Width::Narrow {
        return;
    }
    let tokens = cx.tokens;
    let show = |ui: &mut Ui, name: &str, zone: &missions::SiteZone, zone_name: &str| {
        let value = texts::clock(zone.to_local(plan.now), zone_name);
        let name_part = (name, theme::SMALL, Weight::Regular, tokens.dim);
        let short = texts::time(zone.to_local(plan.now).time);
        let shown = if cx.layout.width == Width::Wide { value.as_str() } else { short.as_str() };
        let value_part = (shown, theme::SMALL, Weight::Medium, tokens.text);
        widgets::status_line(ui, name, &value, &[name_part, value_part]);
    };
    ui.spacing_mut().item_spacing.x = 12.0;
    if let Some(yours) = &plan.your_zone {
        show(ui, texts::YOUR_TIME, yours, &plan.your_zone_name);
    }
    show(ui, texts::SITE_TIME, &plan.zone, &plan.zone_name);
}
