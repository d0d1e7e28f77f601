//! Alerts of inspection: a list of what a person has to look at, and what is done about it.

#[cfg(test)]
mod tests;
mod texts;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::name_field::NameField;
use crate::select::show_caption;
use crate::theme::Tokens;
use crate::widgets::{self, fact};
use crate::{format, icon, screens, theme};
use client_model::{CameraMove, ClientCommand, PointHistoryCommand, Selection, SiteEdit};
use egui::{Color32, Rect, Ui, vec2};
use site_model::{Alert, AlertId, AlertSeverity, AlertState, Object, ObjectId, Site, Utc};
use vocab::Stamp;

/// The tab of alerts.
const ALERTS: Tab = Tab { screen: screens::RUNS, name: texts::TAB, scrolls: true, row_spacing: 8.0 };
/// Alerts that are listed at once.
const MAX_ROWS: usize = 100;

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct AlertsPanel {
    /// The filter by state, by its place in the texts.
    state: usize,
    /// The alert that is unfolded.
    open: Option<AlertId>,
    owner: NameField,
    work_order: NameField,
    comment: NameField,
    remark: NameField,
}

impl FeaturePanel for AlertsPanel {
    fn tabs(&self) -> &'static [Tab] {
        &[ALERTS]
    }

    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let tokens = cx.tokens;
        widgets::section_head(ui, tokens, texts::HEAD);
        let Some(site) = cx.model.site.site() else { return };
        for states in texts::STATES.chunks(2) {
            widgets::choice(ui, tokens, states, self.state, |on| self.state = on);
        }
        self.offer_to_raise(ui, cx, site);
        let mut alerts = cx.model.site.alerts();
        alerts.retain(|alert| self.open == Some(alert.id) || self.admits(alert));
        if alerts.is_empty() {
            widgets::remark(ui, tokens, texts::EMPTY);
        }
        for alert in alerts.into_iter().take(MAX_ROWS) {
            ui.push_id(alert.id, |ui| self.show_row(ui, cx, site, alert));
        }
    }
}

impl AlertsPanel {
    fn admits(&self, alert: &Alert) -> bool {
        match self.state {
            0 => alert.state == AlertState::Open,
            1 => matches!(alert.state, AlertState::Acknowledged { .. }),
            2 => alert.state.is_closed(),
            _ => true,
        }
    }

    /// The button that raises an alert, at the inspection point that is selected or whose history is open.
    fn offer_to_raise(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site) {
        let selected = match cx.model.selection() {
            Some(Selection::InspectionPoint(point)) => Some(point),
            _ => cx.model.point_history.point(),
        };
        let point = selected.and_then(|point| site.inspection_point(point));
        let name = texts::raise(point.map(|point| point.name.as_str()));
        if Button::new(&name).icon(icon::PLUS).wide(ui).left().show(ui, cx.tokens).clicked() {
            let (alert, edit) = cx.model.site.raising_alert(point.map(|point| point.id), cx.clock.utc);
            self.open = Some(alert);
            cx.commands.push(ClientCommand::EditSite(edit));
        }
    }

    fn show_row(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, alert: &Alert) {
        let tokens = cx.tokens;
        let is_open = self.open == Some(alert.id);
        let row = texts::row(alert, site, age_s(alert, cx.clock.utc));
        let response = Button::new(&row).on(is_open).wide(ui).left().show(ui, tokens);
        let colour = colour(alert.severity, tokens);
        let edge = Rect::from_min_size(response.rect.min, vec2(4.0, response.rect.height()));
        ui.painter().rect_filled(edge, 2, colour);
        if response.clicked() {
            self.open = (!is_open).then_some(alert.id);
        }
        widgets::remark(ui, tokens, &texts::what(alert));
        widgets::remark(ui, tokens, &texts::who(alert));
        if is_open {
            widgets::tinted_box(ui, tokens, colour, |ui| self.show_alert(ui, cx, alert));
        }
    }

    fn show_alert(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, alert: &Alert) {
        let tokens = cx.tokens;
        let date = |at: Utc| format::date(Stamp::from_nanos(at.0), cx.utc_offset_s);
        fact(ui, tokens, texts::STATE, &texts::state(&alert.state));
        if let AlertState::Closed { remark, .. } = &alert.state {
            widgets::sentence(ui, tokens, remark);
        }
        fact(ui, tokens, texts::RAISED, &date(alert.first_raised));
        fact(ui, tokens, texts::TIMES, &format::count(alert.times_raised.into()));
        if let Some(at) = alert.recovered {
            fact(ui, tokens, texts::RECOVERED, &date(at));
        }
        show_where(ui, cx, alert);
        let (me, at, object) = (cx.model.operator_name(), cx.clock.utc, ObjectId::Alert(alert.id));
        let mut decided = alert.clone();
        widgets::choice(ui, tokens, &texts::SEVERITIES, alert.severity, |severity| {
            decided.severity = severity;
        });
        if alert.state == AlertState::Open {
            let button = Button::new(texts::ACKNOWLEDGE).icon(icon::CHECK).kind(Kind::Primary);
            if button.wide(ui).show(ui, tokens).clicked() {
                decided.state = AlertState::Acknowledged { by: me.clone(), at };
            }
        } else if Button::new(texts::REOPEN).icon(icon::FLAG).wide(ui).show(ui, tokens).clicked() {
            decided.state = AlertState::Open;
        }
        if alert.owner != me && Button::new(texts::MINE).icon(icon::USER).wide(ui).show(ui, tokens).clicked()
        {
            decided.owner.clone_from(&me);
        }
        show_caption(ui, tokens, texts::OWNER_FIELD.field);
        if let Some(owner) = self.owner.show_line(ui, cx, &texts::OWNER_FIELD, object, &alert.owner) {
            decided.owner = owner;
        }
        let fields = [
            (&mut self.work_order, &texts::WORK_ORDER_FIELD, &mut decided.work_order),
            (&mut self.comment, &texts::COMMENT_FIELD, &mut decided.comment),
        ];
        for (field, texts, text) in fields {
            show_caption(ui, tokens, texts.field);
            if let Some(given) = field.show_paragraph(ui, cx, texts, object, text) {
                *text = given;
            }
        }
        if !alert.state.is_closed() {
            show_caption(ui, tokens, texts::REMARK_FIELD.field);
            if let Some(remark) = self.remark.show_paragraph(ui, cx, &texts::REMARK_FIELD, object, "") {
                decided.state = AlertState::Closed { by: me, at, remark };
            }
        }
        if decided != *alert {
            let put = vec![Object::Alert(decided)];
            cx.commands.push(ClientCommand::EditSite(SiteEdit { put, removed: Vec::new() }));
        }
    }
}

/// The buttons that lead to the place of an alert and to the history of its inspection point, if it has them.
fn show_where(ui: &mut Ui, cx: &mut PanelContext<'_>, alert: &Alert) {
    let tokens = cx.tokens;
    let (point, place) = cx.model.site.place_of_alert(alert);
    if point.is_none() && place.is_none() {
        return;
    }
    ui.horizontal(|ui| {
        let gap = ui.spacing().item_spacing.x;
        let width = ((ui.available_width() - gap) / 2.0).floor();
        let button = |name, text, icon| Button::new(name).text(text).icon(icon).size(width, theme::TOUCH);
        if let Some(place) = place
            && button(texts::SHOW, texts::SHOW_SHORT, icon::EYE).show(ui, tokens).clicked()
        {
            cx.commands.push(ClientCommand::MoveCamera(CameraMove::Point(place)));
        }
        if let Some(point) = point
            && button(texts::HISTORY, texts::HISTORY_SHORT, icon::CLOCK).show(ui, tokens).clicked()
        {
            cx.commands.push(ClientCommand::PointHistory(PointHistoryCommand::Open(point)));
        }
    });
}

fn colour(severity: AlertSeverity, tokens: &Tokens) -> Color32 {
    match severity {
        AlertSeverity::Information => tokens.accent,
        AlertSeverity::Warning => tokens.warn,
        AlertSeverity::Critical => tokens.bad,
    }
}

/// Seconds since an alert was raised last.
fn age_s(alert: &Alert, now: Utc) -> f64 {
    (now.0 - alert.last_raised.0) as f64 / 1e9
}
