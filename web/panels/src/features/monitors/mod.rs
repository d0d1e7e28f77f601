//! Monitors: conditions that are watched, such as a low battery, and what happens while they hold.

mod form;
#[cfg(test)]
mod tests;
mod texts;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::name_field::NameField;
use crate::number_field::TypedNumber;
use crate::{icon, screens, widgets};
use client_model::{ClientCommand, SiteEdit};
use egui::Ui;
use site_model::{Monitor, MonitorId, ObjectId, Site};

/// The tab of monitors.
const MONITORS: Tab = Tab { screen: screens::SETTINGS, name: texts::TAB, scrolls: true, row_spacing: 8.0 };

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct MonitorsPanel {
    /// The monitor whose form is unfolded.
    open: Option<MonitorId>,
    name: NameField,
    typed: TypedNumber,
}

impl FeaturePanel for MonitorsPanel {
    fn tabs(&self) -> &'static [Tab] {
        &[MONITORS]
    }

    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let (model, tokens) = (cx.model, cx.tokens);
        widgets::head(ui, tokens, texts::HEAD);
        let Some(site) = model.site.site() else { return widgets::remark(ui, tokens, texts::LOADING) };
        widgets::remark(ui, tokens, texts::REMARK);
        for (monitor, is_built_in) in model.site.monitors() {
            let is_open = self.open == Some(monitor.id);
            let name = texts::monitor(&monitor.name);
            let row = texts::row(&monitor);
            if Button::new(&name).text(&row).on(is_open).wide(ui).left().show(ui, tokens).clicked() {
                self.open = (!is_open).then_some(monitor.id);
            }
            if is_open {
                widgets::tinted_box(ui, tokens, tokens.accent, |ui| {
                    self.show_monitor(ui, cx, site, &monitor, is_built_in);
                });
            }
        }
        if Button::new(texts::ADD).icon(icon::PLUS).wide(ui).show(ui, tokens).clicked() {
            let (monitor, edit) = model.site.adding_monitor();
            self.open = Some(monitor);
            cx.commands.push(ClientCommand::EditSite(edit));
        }
    }
}

impl MonitorsPanel {
    fn show_monitor(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        site: &Site,
        monitor: &Monitor,
        is_built_in: bool,
    ) {
        let (model, tokens) = (cx.model, cx.tokens);
        widgets::sentence(ui, tokens, &texts::summary(site, monitor));
        let mut changed = monitor.clone();
        let object = ObjectId::Monitor(monitor.id);
        if let Some(name) = self.name.show(ui, cx, &texts::NAME_FIELD, object, &monitor.name) {
            changed.name = name;
        }
        if Button::new(texts::WATCHED).on(monitor.is_enabled).wide(ui).show(ui, tokens).clicked() {
            changed.is_enabled = !monitor.is_enabled;
        }
        form::show(ui, cx, &mut self.typed, site, monitor, &mut changed);
        push(cx, model.site.changing_monitor(monitor.id, |monitor| *monitor = changed));
        let is_of_site = site.get(object).is_some();
        let (name, short, sign, kind) = if is_built_in {
            (texts::reset(&monitor.name), texts::RESET_SHORT, icon::ARROW_COUNTER_CLOCKWISE, Kind::Plain)
        } else {
            (texts::delete(&monitor.name), texts::DELETE_SHORT, icon::TRASH, Kind::Danger)
        };
        let remove = Button::new(&name).text(short).icon(sign).kind(kind).enabled(is_of_site);
        if remove.wide(ui).show(ui, tokens).clicked() {
            push(cx, model.site.removing_monitor(monitor.id));
        }
    }
}

/// Emits an edit, unless it changes nothing.
fn push(cx: &mut PanelContext<'_>, edit: SiteEdit) {
    if edit != SiteEdit::default() {
        cx.commands.push(ClientCommand::EditSite(edit));
    }
}
